"""Every key at its lowest and highest value, and just beyond."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from cli.conftest import Run, write_reports
from trackweave.config import load_configuration
from trackweave.config.schema import tables
from trackweave.errors import InvalidInputError

SCHEMA = tables()[1]
TABLES = {
    "MotionSection": ("motion",),
    "PlotsSection": ("plots",),
    "WindowSection": ("window",),
    "SearchSection": ("search",),
    "LifecycleSection": ("lifecycle",),
    "GrowthSection": ("growth",),
    "OutputSection": ("output",),
    "SensorSection": ("sensors", "default"),
    "FieldOfViewSection": ("sensors", "default", "field_of_view"),
}


# Keys that must stand beside another.
NEEDED = {"phase_deg": {"rotation": "clockwise", "scan_period": 4.0}}


def limited() -> Iterator[Any]:
    """Yield each number's key with its limits."""
    for section, path in TABLES.items():
        for key, value in SCHEMA[section]["properties"].items():
            for kind in value.get("anyOf", [value]):
                if kind.get("type") in {"number", "integer"}:
                    assert {"minimum", "maximum"} <= set(kind), key
                    yield pytest.param((*path, key), kind, id=".".join((*path, key)))


def nested(path: tuple[str, ...], value: float) -> dict[str, Any]:
    """Return a configuration that says one thing, and what it cannot be said without."""
    document: Any = dict(NEEDED.get(path[-1], {}), **{path[-1]: value})
    for key in reversed(path[:-1]):
        document = {key: document}
    assert isinstance(document, dict)
    return document


@pytest.mark.parametrize(("path", "kind"), list(limited()))
def test_every_number_ends_where_the_schema_says(
    path: tuple[str, ...], kind: dict[str, Any]
) -> None:
    low, high = kind["minimum"], kind["maximum"]
    for value in (low, high):
        load_configuration(nested(path, value))
    is_whole = kind["type"] == "integer"
    beyond = (low - 1, high + 1) if is_whole else (math.nextafter(low, -math.inf), high * 1.001)
    for value in beyond:
        with pytest.raises(InvalidInputError, match=path[-1]) as caught:
            load_configuration(nested(path, value))
        assert "; expected " in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "[sensors.default]\nsigma = 1e-9\nclutter_density = 1e-30\n",
        "[sensors.default]\nsigma = 1e9\nclutter_density = 1e30\n",
        "[sensors.default]\nscan_period = 1e-6\ndetection_probability = 1e-12\n",
        "[sensors.default]\nscan_period = 1e9\ndetection_probability = 0.999999999999\n",
        "[sensors.default]\nclutter_per_scan = 1e-9\n[lifecycle]\nnew_target_density = 1e-30\n",
        "[sensors.default]\nclutter_per_scan = 1e9\n[lifecycle]\nnew_target_density = 1e30\n",
        "[motion]\nprocess_noise = 0\nmax_speed = 1e-12\n[lifecycle]\nsurvival = 1e-12\n",
        "[motion]\nprocess_noise = 1e12\nmax_speed = 3e8\n[growth]\nmargin = 1e-9\n",
    ],
)
def test_a_run_at_the_edges_ends_well(text: str, run: Run, tmp_path: Path) -> None:
    reports = write_reports(tmp_path / "r.csv", n_scans=6)
    (tmp_path / "c.toml").write_text(text)
    arguments = ("track", reports, "--config", tmp_path / "c.toml")
    done = run(*arguments, "--out", tmp_path / "out", "--quiet")
    assert done.exit_code in {0, 2}, done.stderr
    assert len(done.stderr.splitlines()) <= 1
    if done.exit_code == 0:
        tracks = tmp_path / "out" / "tracks.csv"
        again = run(*arguments, "--priors", tracks, "--out", tmp_path / "again", "--quiet")
        assert again.exit_code == 0, again.stderr
