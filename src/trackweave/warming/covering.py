"""Runs that compile kernels, or load them: what a first look reaches, or whatever there is."""

import contextlib
import doctest
import io
import tomllib
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import polars as pl

import trackweave
from trackweave import solvers
from trackweave.association.problem import AssignmentProblem
from trackweave.config.presets import PRESETS
from trackweave.randomness import generator_of
from trackweave.run import track
from trackweave.run.fusing import fuse
from trackweave.run.small_recordings import Recording, recording_of, recording_of_radars
from trackweave.simulation import demo_configuration, demo_scenario, simulate
from trackweave.solvers import METHODS
from trackweave.solvers.warming import warm_up

__all__ = ["PARTS", "Task", "tasks_of"]

Task = tuple[str, Callable[[], object]]
"""What a run is called, and how to run it."""

PARTS = ("first", "all")
"""What ``demo`` and a first ``track`` reach, or all commands, models, solvers and rules."""

KINDS = (
    ("position", 1, 2), ("position", 2, 2), ("position", 1, 3), ("range-azimuth", 1, 2),
    ("range-azimuth", 3, 2), ("range-azimuth-rate", 2, 2), ("range-azimuth-elevation", 2, 3),
    ("range-azimuth-elevation-rate", 1, 3), ("bearing", 3, 2),
)  # fmt: skip
MODELS: Mapping[str, Mapping[str, Any]] = {
    "constant acceleration": {"model": "constant-acceleration"},
    "coordinated turn": {"model": "coordinated-turn"},
    "random walk": {"model": "random-walk"},
    "IMM": {"model": "imm"},
    "unscented": {"model": "coordinated-turn", "filter": "unscented"},
}
OTHERWISE: Mapping[str, Mapping[str, Any]] = {
    "nearest": {"tracker": {"kind": "nearest-neighbour", "pairing": "nearest"}},
    "one to one": {"tracker": {"kind": "nearest-neighbour"}},
    "a best estimate": {"output": {"estimate": "best"}},
    "a deadline": {"search": {"deadline_ms": 1e9}},
    "little room": {"growth": {"max_nodes": 200}},
    "lone reports": {"sensors": {"default": {"scans": False, "scan_period": None}}},
    "heavy tails": {"sensors": {"default": {"tail_share": 0.1}}},
    "plots fused": {"plots": {"fuse": True, "within": 1.0}},
    "plots by equation 1": {
        "plots": {"fuse": True, "within": 1.0, "cost": "equation-1"},
        "sensors": {"default": {"field_of_view": {"max_range_m": 9000.0}}},
    },
}


def tasks_of(part: str) -> list[Task]:
    """Return the runs of a part, by name.

    Parameters
    ----------
    part
        One of ``PARTS``.

    Returns
    -------
    Names and functions to call, in the order in which they are to be called.
    """
    return [*_first(), *(_others() if part == "all" else ())]


def _first() -> Iterator[Task]:
    """Yield what a newcomer runs."""
    yield "demo", _demo
    yield "track, nothing told", lambda: track(_told_nothing(recording_of("position")))


def _others() -> Iterator[Task]:
    """Yield everything else."""
    for kind, n_sensors, dim in KINDS:
        seen = recording_of(kind, n_sensors=n_sensors, dim=dim)
        yield f"track {n_sensors} × {kind}, {dim}-D", partial(track, seen.reports, seen.config)
        for name, motion in MODELS.items():
            yield (
                f"track {n_sensors} × {kind}, {dim}-D, {name}",
                partial(_track_with, seen, {"motion": motion}),
            )
    two = recording_of("position", n_sensors=2)
    for name, keys in OTHERWISE.items():
        yield f"track with {name}", partial(_track_with, two, keys)
    sky = recording_of_radars()
    for name, keys in {"": {}, ", IMM": {"motion": MODELS["IMM"]}}.items():
        yield f"track two turning radars{name}", partial(_track_with, sky, keys)
    yield "track, tags at rest", _at_rest
    yield "track with identities", lambda: track(_with_identities(two))
    for preset in PRESETS:
        yield f"track, preset {preset}", partial(track, two.reports, two.config, preset=preset)
    yield "priors", partial(_with_priors, two)
    for method in METHODS:
        yield f"track, search {method}", partial(_track_with, two, {"search": {"method": method}})
        yield f"solve by {method}", partial(_solve, method)
    yield from _fusions()
    yield "examples of all public names", _examples


def _demo() -> None:
    scenario = demo_scenario()
    rng = generator_of(1)
    scene = simulate(scenario, rng)
    track(scene.reports, tomllib.loads(demo_configuration(scenario, 1)), rng=rng)


def _told_nothing(recording: Recording) -> pl.DataFrame:
    return recording.reports.drop("sensor")


def _track_with(recording: Recording, keys: Mapping[str, Any]) -> None:
    """Track with further keys; those of ``default`` go to every sensor."""
    config: dict[str, Any] = {name: dict(table) for name, table in recording.config.items()}
    for name, table in keys.items():
        if name == "sensors":
            config[name] = {
                sensor: {**told, **table["default"]} for sensor, told in config[name].items()
            }
        else:
            config[name] = {**config.get(name, {}), **table}
    track(recording.reports, config)


def _at_rest() -> None:
    """Track two tags that lie side by side and report each minute."""
    rng = generator_of(2)
    tags = [
        pl.DataFrame({"time": 60.0 * pl.arange(40, eager=True) + 25.0 * tag})
        .with_columns(x=12.0 * tag + pl.Series(rng.normal(0.0, 5.0, 40)))
        .with_columns(y=pl.Series(rng.normal(0.0, 5.0, 40)))
        for tag in range(2)
    ]
    track(pl.concat(tags), {"sensors": {"default": {"scans": False, "sigma": 5.0}}})


def _with_identities(recording: Recording) -> pl.DataFrame:
    number = pl.int_range(pl.len()) % 5
    return recording.reports.with_columns(
        identity=pl.lit("mmsi ") + number.cast(pl.String), strength=10.0 + number
    )


def _with_priors(recording: Recording) -> None:
    track(recording.reports, recording.config, priors=track(recording.reports).tracks)


def _solve(method: str) -> None:
    warm_up(getattr(solvers, METHODS[method])(), generator_of(0))
    rng = generator_of(1)
    rows = rng.integers(0, 9, (300, 3))
    rows = rows[(rows > 0).sum(axis=1) > 1]
    problem = AssignmentProblem.from_tuples(rows, rng.normal(-5.0, 2.0, len(rows)))
    solvers.solve(problem, getattr(solvers, METHODS[method])(), rng=rng)


def _fusions() -> Iterator[Task]:
    """Yield fusions of two files of tracks, by all methods and statistics."""
    local = {}
    for sensor in range(2):
        seen = recording_of("position", n_sensors=2)
        reports = seen.reports.filter(pl.col("sensor") == f"s{sensor}").drop("sensor")
        local[f"s{sensor}"] = reports
    for name, keys in {
        "": {},
        "convex": {"method": "convex"},
        "covariance intersection": {"method": "covariance-intersection"},
        "information matrix": {"method": "information-matrix"},
        "chains": {"statistic": {"kind": "chain"}},
        "all pairs": {"statistic": {"kind": "all-pairs", "correlation": "cross-covariance"}},
    }.items():
        yield f"fuse {name}".strip(), partial(_fuse, local, {"fusion": keys})


def _fuse(reports: Mapping[str, pl.DataFrame], keys: Mapping[str, Any]) -> None:
    fuse({name: track(table).tracks for name, table in reports.items()}, keys)


def _examples() -> None:
    """Run the examples of all public names, which are all right: tests see to that."""
    finder, runner = doctest.DocTestFinder(recurse=True), doctest.DocTestRunner(verbose=False)
    for name in trackweave.__all__:
        for example in finder.find(getattr(trackweave, name), name, globs={}):
            with contextlib.redirect_stdout(io.StringIO()):
                runner.run(example, out=lambda _: None)
