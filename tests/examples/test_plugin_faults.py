"""Plug-ins that raise are told by entry point, package and method, never as a fault of ours."""

import textwrap

import polars as pl
import pytest
from typer.testing import CliRunner

import trackweave as tw
from oracles.plugin_site import installed
from trackweave.cli.app import app
from trackweave.config.plugins import plugin_class
from trackweave.errors import InvalidInputError
from trackweave.formats import registry

BROKEN = """
import os
from dataclasses import dataclass
import numpy as np
from oracles.plugins import Place, Straight
from trackweave.formats.format import Format

def fail(method):
    if os.environ.get("BROKEN") == method:
        raise ZeroDivisionError("division by zero\\nof two lines")

@dataclass(frozen=True)
class Moving(Straight):
    def __post_init__(self): fail("__init__")
    def begin(self, *given): fail("begin"); return super().begin(*given)
    def predict(self, *given): fail("predict"); return super().predict(*given)

@dataclass(frozen=True)
class Seeing(Place):
    def expect(self, *given): fail("expect"); return super().expect(*given)
    def difference(self, values, expected): fail("difference"); return values - expected
    def covariance(self, reported):
        fail("covariance"); return reported.sigma[:, :, None] ** 2 * np.eye(2)
    def first_state(self, *given): fail("first_state"); return super().first_state(*given)

@dataclass(frozen=True)
class Solving:
    def __call__(self, problem, **given): fail("__call__"); return None

def write(output):
    fail("writer")
    return {"a.broken": "text"}

def look(head, name):
    fail("recognise")
    return False

WRITER = Format("broken", "Broken", (".broken",), "all", "nothing", look, writer=write)
"""
POINTS = {
    "trackweave.motions": {"moving": "broken_plugins:Moving"},
    "trackweave.measurements": {"seeing": "broken_plugins:Seeing"},
    "trackweave.solvers": {"solving": "broken_plugins:Solving"},
    "trackweave.writers": {"broken": "broken_plugins:WRITER"},
    "trackweave.readers": {"broken": "broken_plugins:WRITER"},
}
TOLD = """
    [motion]
    model = "moving"
    process_noise = 0.1
    max_speed = 60.0
    [sensors.default]
    measurement = "seeing"
    sigma = 5.0
    detection_probability = 0.9
    clutter_density = 1e-8
    scan_period = 4.0
    [lifecycle]
    new_target_density = 1e-8
"""


@pytest.fixture
def site(tmp_path):
    (tmp_path / "broken_plugins.py").write_text(BROKEN)
    rows = [(4.0 * k, 40.0 * k, 7.0) for k in range(6)]
    pl.DataFrame(rows, ["time", "x", "y"], orient="row").write_csv(tmp_path / "reports.csv")
    (tmp_path / "told.toml").write_text(textwrap.dedent(TOLD))
    registry.formats.cache_clear()
    with installed(tmp_path / "site", POINTS, tmp_path):
        yield tmp_path
    registry.formats.cache_clear()


def tracked(site, *further):
    out = ("--config", site / "told.toml", "--out", site / "out")
    return CliRunner().invoke(app, list(map(str, ("track", site / "reports.csv", *out, *further))))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "whose"),
    [
        ("__init__", 'motion "moving" of package some-plugins (broken_plugins:Moving)'),
        ("begin", 'motion "moving" of package some-plugins (broken_plugins:Moving)'),
        ("predict", 'motion "moving" of package some-plugins (broken_plugins:Moving)'),
        ("expect", 'measurement "seeing" of package some-plugins (broken_plugins:Seeing)'),
        ("difference", 'measurement "seeing" of package some-plugins (broken_plugins:Seeing)'),
        ("covariance", 'measurement "seeing" of package some-plugins (broken_plugins:Seeing)'),
        ("first_state", 'measurement "seeing" of package some-plugins (broken_plugins:Seeing)'),
        ("writer", 'writer "broken" of package some-plugins (broken_plugins:WRITER)'),
    ],
)
def test_a_plugin_that_raises_is_named_with_its_package_and_method(
    site, monkeypatch, method, whose
):
    monkeypatch.setenv("BROKEN", method)
    done = tracked(site, *(("--also", "broken") if method == "writer" else ()))
    assert done.exit_code == 2, done.output
    fault = "ZeroDivisionError: division by zero of two lines"
    assert f"{whose}: {method} raised {fault}; the plug-in is at fault" in done.output
    assert "our fault" not in done.output
    assert "Traceback" not in done.output
    assert not (site / "out").exists()


def test_a_reader_that_raises_while_it_looks_is_named(site, monkeypatch):
    monkeypatch.setenv("BROKEN", "recognise")
    with pytest.raises(InvalidInputError, match=r'"broken" of package some-plugins .*recognise'):
        tw.read_reports(site / "reports.csv")


def test_what_is_no_answer_of_a_solver_or_a_writer_is_told(site, monkeypatch):
    done = tracked(site, "--also", "broken")
    assert done.exit_code == 2
    assert "format broken, a plug-in: its writer returned" in done.output
    with (site / "told.toml").open("a") as file:
        file.write('[search]\nmethod = "solving"\n')
    done = tracked(site)
    assert done.exit_code == 2
    assert "solver Solving: __call__ returned None; expected an Answer" in done.output
    monkeypatch.setenv("BROKEN", "__call__")
    done = tracked(site)
    assert done.exit_code == 2
    assert (
        'solver "solving" of package some-plugins (broken_plugins:Solving): __call__ raised'
        in (done.output)
    )


def test_from_python_the_error_is_the_cause_and_a_class_without_entry_point_is_named(site):
    class Own:
        max_speed = 1.0

        def begin(self, position, covariance):
            raise LookupError

        def predict(self, mean, covariance, interval):
            raise AssertionError

    moving = plugin_class("motions", "moving", "motion.model")
    assert moving is not None
    tracker = tw.MultiHypothesisTracker(motion=Own(), sensors=[tw.Sensor("a", sigma=1.0)])
    with pytest.raises(
        InvalidInputError, match=r"^motion .*Own .*: begin raised LookupError;"
    ) as e:
        tracker.step(tw.Scan(0.0, "a", [[1.0, 2.0]]))
    assert isinstance(e.value.__cause__, LookupError)
