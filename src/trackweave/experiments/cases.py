"""The runs of a study: each by itself, from what its worker needs to what it measured."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from time import perf_counter, process_time
from typing import Any

import numpy as np

from trackweave.config import Configuration, load_configuration
from trackweave.domain.reports import ReportTable
from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError
from trackweave.experiments.likelihood import log_likelihood
from trackweave.experiments.study_file import LIKELIHOOD, MEASURES, Plan, StudyPlan
from trackweave.experiments.sweeps import Point, merged, nested
from trackweave.keys import show_value, suggest
from trackweave.run.judging import evaluate, truth_on
from trackweave.run.tracking import report_table, track
from trackweave.simulation import Scenario, SimulatedSensor, scenario_of, simulate

__all__ = ["Case", "Job", "carry_out", "cases_of", "jobs_of"]

SURE, QUIET = 0.999, 1e-3
"""A configuration knows no certain detection, and no scan without false alarms."""
_FIELDS = [field.name for field in fields(SimulatedSensor)]


@dataclass(frozen=True, slots=True)
class Case:
    """One run by its names: what is tracked, and how."""

    scenario: str
    scene: Point
    piece: int
    configuration: str
    point: Point
    seed: int


@dataclass(frozen=True, slots=True)
class Job:
    """One run as its worker needs it."""

    reports: Mapping[str, Any] | str
    """Keys of a scenario, or the path of a recording."""
    truth: str | None
    piece: tuple[int, int]
    """Which piece of the recording, from 0, and of how many."""
    values: Mapping[str, Any]
    preset: str | None
    seed: int
    plan: Plan


def cases_of(study: StudyPlan) -> Iterator[Case]:
    """Yield all runs in the order of the tables, seeds the fastest."""
    seeds = range(study.plan.first_seed, study.plan.first_seed + study.plan.seeds)
    for scenario, scene in study.scenes.items():
        for at in scene.sweep.points():
            for piece in range(scene.pieces):
                for name, configuration in study.configurations.items():
                    for point in configuration.sweep.points():
                        for seed in seeds:
                            yield Case(scenario, at, piece, name, point, seed)


def jobs_of(study: StudyPlan, cases: Sequence[Case]) -> list[Job]:
    """Return what workers need, every scenario and configuration checked before the first runs."""
    scenes: dict[str, Mapping[str, Any] | str] = {}
    ways: dict[tuple[str, str], Mapping[str, Any]] = {}
    jobs = []
    for case in cases:
        scene, own = study.scenes[case.scenario], study.configurations[case.configuration]
        at = f"{case.scenario} {_said(case.scene)}"
        if at not in scenes:
            scenes[at] = scene.reports or _scene(study, case)
        told = isinstance(scenes[at], Mapping) and study.plan.tell_sensors
        way = (at if told else "", f"{case.configuration} {_said(case.point)}")
        if way not in ways:
            ways[way] = _values(study, case, scenes[at] if told else None)
        jobs.append(Job(scenes[at], scene.truth, (case.piece, scene.pieces), ways[way],
                        own.preset, case.seed, study.plan))  # fmt: skip
    return jobs


def carry_out(job: Job) -> dict[str, Any]:
    """Track, compare with the truth; return measures, and what they took."""
    wall, cpu = perf_counter(), process_time()
    reports, truth = _material(job)
    configuration = load_configuration(job.values)
    begin = process_time()
    result = track(reports, configuration, preset=job.preset, rng=job.seed)
    spent = process_time() - begin
    found: dict[str, Any] = dict.fromkeys(MEASURES)
    plan = job.plan
    if truth is not None:
        judged = evaluate(
            truth, result, cutoff=plan.cutoff, order=plan.order, max_gap=plan.max_gap,
            window=plan.window,
        ).as_dict()  # fmt: skip
        found |= {name: judged[name] for name in MEASURES if name in judged}
    totals = result.run["totals"]
    found |= {name: totals[name] for name in ("reports", "tracks", "mean_gap")}
    found[LIKELIHOOD] = log_likelihood(result.values)
    took = {"cpu_s": spent, "all_cpu_s": process_time() - cpu, "wall_s": perf_counter() - wall}
    return {
        "measures": {name: _plain(value) for name, value in found.items()},
        "timing": {name: round(value, 4) for name, value in took.items()},
    }


def _plain(value: Any) -> Any:
    """Return a number as JSON has it, None for what is not finite."""
    if value is None:
        return None
    return value if isinstance(value, int) else float(value) if np.isfinite(value) else None


def _material(job: Job) -> tuple[ReportTable, TruthTable | None]:
    configuration = load_configuration(job.values)
    if isinstance(job.reports, Mapping):
        scene = simulate(scenario_of(job.reports, "scenario"), job.seed)
        return _without_noise(scene.reports, configuration), scene.truth
    reports, _ = report_table(job.reports, configuration)
    truth = None if job.truth is None else truth_on(job.truth, reports.frame, "the recording")
    number, count = job.piece
    if count == 1:
        return reports, truth
    ends = np.linspace(reports.time[0], reports.time[-1], count + 1)
    last = np.inf if number == count - 1 else ends[number + 1]
    rows = np.flatnonzero((reports.time >= ends[number]) & (reports.time < last))
    if rows.size == 0:
        raise InvalidInputError(
            f"reports: none from {ends[number]:.15g} to {ends[number + 1]:.15g} s; expected some "
            f"in each of {count} pieces"
        )
    if truth is not None:
        truth = _between(truth, float(ends[number]), float(last))
    return reports.part(rows), truth


def _without_noise(reports: ReportTable, configuration: Configuration) -> ReportTable:
    """Return reports that leave their noise to the configuration, where it says any."""
    # Simulated reports tell their own, which would come first, and no sweep would show.
    told = ["sigma" in configuration.sensor(name) for name in reports.sensors]
    own = np.where(np.array(told)[reports.sensor][:, None], np.nan, reports.sigma)
    return replace(reports, sigma=own)


def _between(truth: TruthTable, first: float, last: float) -> TruthTable:
    own = (truth.time >= first) & (truth.time < last)
    velocity = None if truth.velocity is None else truth.velocity[own]
    return TruthTable.from_columns(
        truth.time[own], truth.target[own], truth.position[own], velocity
    )


def _scene(study: StudyPlan, case: Case) -> Mapping[str, Any]:
    """Return a scenario's keys with a point laid over them, checked."""
    where = f"{study.name}, scenarios.{case.scenario}"
    table = study.scenes[case.scenario].table or {}
    over = nested(case.scene)
    sensors = over.pop("sensors", {})
    every = {key: value for key, value in sensors.items() if key in _FIELDS}
    own = {key: value for key, value in sensors.items() if key not in _FIELDS}
    listed = table.get("sensors", [])
    names = [one.get("name") for one in listed]
    for name in own:
        if name not in names:
            raise InvalidInputError(
                f"{where}.sweep.sensors.{name}: no sensor of the scenario, and no key of one; "
                f"{suggest(name, [*map(str, names), *_FIELDS])}"
            )
    laid = [merged(merged(one, every), own.get(one.get("name"), {})) for one in listed]
    found = {**merged(table, over), "sensors": laid}
    scenario_of(found, f"{where}{_said(case.scene)}")
    return found


def _values(study: StudyPlan, case: Case, scene: Any) -> Mapping[str, Any]:
    """Return a configuration's keys with a point laid over them, checked."""
    own = study.configurations[case.configuration]
    values = merged(own.values, nested(case.point))
    where = f"{study.name}, configurations.{case.configuration}{_said(case.point)}"
    try:
        load_configuration(values)
    except InvalidInputError as err:
        said = str(err).removeprefix("configuration, ")
        raise InvalidInputError(f"{where}, {said}") from err
    if scene is None:
        return values
    return _told(values, scenario_of(scene, "scenario"))


def _told(values: Mapping[str, Any], scenario: Scenario) -> Mapping[str, Any]:
    """Return a configuration that knows the simulated sensors, as far as it is silent itself."""
    own = values.get("sensors", {})
    usual = own.get("default", {})
    tables = {}
    for sensor in scenario.sensors:
        axes = sensor.sigmas(scenario.area.dim)
        table: dict[str, Any] = {
            "sigma": dict(zip("xyz", axes, strict=False)) if len(set(axes)) > 1 else axes[0],
            "detection_probability": min(sensor.detection_probability, SURE),
            "scan_period": sensor.scan_period,
            "position": list(sensor.place(scenario.area.dim)),
        }
        clutter = max(sensor.clutter_per_scan, QUIET)
        if np.isfinite(sensor.max_range):
            table["field_of_view"] = {"max_range_m": sensor.max_range}
            table["clutter_per_scan"] = clutter
        else:
            sides = np.subtract(scenario.area.high, scenario.area.low) + 2 * scenario.area.margin
            table["clutter_density"] = clutter / float(np.prod(sides))
        said = {**usual, **own.get(sensor.name, {})}
        if {"clutter_density", "clutter_per_scan"} & said.keys():
            table = {key: value for key, value in table.items() if "clutter" not in key}
        tables[sensor.name] = {key: value for key, value in table.items() if key not in said}
    return merged({"sensors": tables}, values)


def _said(point: Point) -> str:
    """Return a point as a message shows it."""
    if not point:
        return ""
    told = [".".join(key) + " = " + show_value(value) for key, value in point.items()]
    return f" ({', '.join(told)})"
