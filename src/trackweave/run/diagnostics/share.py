"""Runs in which few reports end in tracks: what was told, against what would be estimated."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from trackweave.config import load_configuration
from trackweave.run.diagnostics.case import Case, Finding
from trackweave.run.diagnostics.told import expected_false, scans_of
from trackweave.run.observing import settle

__all__ = [
    "few_assigned",
    "lies_together",
    "noise_of_rows",
    "single_reports",
    "what_reports_tell",
]

FEW, SOME, FEWEST = 0.5, 0.4, 30
# Where false alarms are told, so many of the other reports are enough.
OF_OBJECTS = 0.5
# A value so many times off what reports seem to tell is worth a sentence; both a noise and a
# speed a thousand times off are a unit.
OFF, OFF_PROCESS = 4.0, 20.0
THOUSAND = (250.0, 4000.0)
OF_SENSOR = {"sigma": "m", "clutter_density": "", "scan_period": "s"}
OF_MOTION = {"max_speed": "m/s", "process_noise": "m²/s³"}
OF_BEGINNINGS = ("new_target_density", "initial_target_density")
WEIGHT, LOUD = 70.0, 65.0
# A noise that reports tell themselves is so many times off; keys that begin and end tracks.
OFF_ROWS, FEWEST_SINGLE = 10.0, 10
OF_LIVES = (*OF_BEGINNINGS, "survival", "delete_after_misses")


def few_assigned(case: Case) -> Iterator[Finding]:
    """Yield that few reports are in tracks, and what to look at."""
    # False alarms explain it only where they are told: estimates of them are what is left over.
    total, assigned = len(case.reports), int(np.count_nonzero(case.track >= 0))
    false = sum(
        expected_false(case, i) * scans_of(case, i)
        for i in case.examined
        if case.is_told(f"sensors.{case.sensors[i].name}.clutter_density")
    )
    # What stands is an echo where that is told.
    at_rest = case.settings.values["lifecycle"].get("at_rest") == "echoes"
    false += sum(
        each[3] * scans_of(case, i)
        for i in case.examined
        if at_rest or case.is_told(f"sensors.{case.sensors[i].name}.echoes")
        for each in case.sensors[i].echoes
    )
    # … or show by themselves, as those that come again do.
    is_seen = any(case.sensors[index].clutter_persistence > 0.0 for index in case.examined)
    is_clutter = assigned > 0 and (is_seen or assigned >= OF_OBJECTS * max(total - false, 0.0))
    if total >= FEWEST and assigned < FEW * total and not is_clutter:
        yield Finding(
            "few assigned",
            None,
            f"only {assigned} of {total} reports are in tracks, and the rest counts as false "
            f"alarms; unless that is so, {_where_to_look(case)}; `trackweave init` writes what "
            "the reports tell by themselves",
            weight=LOUD,
            told=float(total),
            seen=float(assigned),
        )


def _where_to_look(case: Case) -> str:
    """Return what may be wrong, the likeliest first."""
    if np.ptp(case.reports.time) == 0.0:
        return "look at the times: all reports are of one, and tracks take several"
    own = [each for each in OF_BEGINNINGS if case.is_told(f"lifecycle.{each}")]
    told = f"{' and '.join(own)} that are told, then at " if own else ""
    depth, needed = case.settings.window.depth, case.settings.lifecycle.confirm_hits
    if case.is_told("window.depth") and depth < needed:
        told = (
            f"window.depth = {depth}, which holds fewer scans than the {needed} reports by which "
            f"tracks are confirmed, then at {told}"
        )
    return (
        f"look first at {told}sigma, max_speed, clutter and detection_probability, then at "
        "scan_period and field_of_view, and at the sensors' positions, times and units"
    )


def noise_of_rows(case: Case) -> Iterator[Finding]:
    """Yield sensors whose reports tell a noise of their own that is far from what they show."""
    for index in case.examined:
        sensor, rows = case.sensors[index], case.rows[index]
        own = case.reports.sigma[rows]
        key = f"sensors.{sensor.name}.sigma"
        is_learned = case.settings.sources.get(key) == "estimated"
        if not sensor.measurement.is_position or not is_learned or rows.size < FEWEST:
            continue
        if np.isnan(own).any():
            continue
        told, seen = float(np.median(own.max(axis=1))), case.plane_sigma(index)
        ratio = max(told / seen, seen / told)
        if ratio >= OFF_ROWS:
            yield Finding(
                "sigma",
                sensor.name,
                f"sensor {sensor.name}: its reports tell a noise of {told:.3g} m each (sigma_x, "
                f"sigma_y), but by themselves speak of {seen:.3g} m: {ratio:.3g} times "
                f"{'less' if told > seen else 'more'}; correct the columns, which are standard "
                "deviations in metres, or leave them out",
                weight=WEIGHT + float(np.log(ratio)),
                told=told,
                seen=seen,
            )


def single_reports(case: Case) -> Iterator[Finding]:
    """Yield that most tracks hold one report, where beginnings or ends are told."""
    count = np.unique(case.track[case.track >= 0], return_counts=True)[1]
    told = [each for each in OF_LIVES if case.is_told(f"lifecycle.{each}")]
    n_single = int(np.count_nonzero(count == 1))
    if told and n_single >= max(FEWEST_SINGLE, FEW * count.size):
        values = case.settings.values["lifecycle"]
        said = ", ".join(f"{each} = {values[each]:g}" for each in told)
        yield Finding(
            "single reports",
            None,
            f"{n_single} of {count.size} tracks hold one report each; correct {said} in "
            "[lifecycle], or leave it out",
            weight=WEIGHT,
            told=float(count.size),
            seen=float(n_single),
        )


def what_reports_tell(case: Case) -> Iterator[Finding]:
    """Yield what was told far from what would be estimated; few tracks show less."""
    # It estimates anew, which takes a second: only where a run leaves many reports alone.
    assigned = int(np.count_nonzero(case.track >= 0))
    if len(case.reports) < FEWEST or (
        assigned >= SOME * len(case.reports) and not lies_together(case)
    ):
        return
    others = _guessed(case)
    ratios = dict(_ratios(case, others)) if others is not None else {}
    units = list(_of_unit(ratios))
    yield from units
    for key, (told, guess) in ratios.items():
        least = OFF_PROCESS if key.endswith("process_noise") else OFF
        if not units and max(told / guess, guess / told) >= least:
            yield _contradiction(key, told, guess)


def lies_together(case: Case) -> bool:
    """Tell whether all reports lie as close together as the noise told; False if none is told."""
    known = case.position[~np.isnan(case.position[:, 0])]
    if known.shape[0] < FEWEST:
        return False
    extent = float(np.linalg.norm(np.ptp(known, axis=0)))
    sigmas = [
        case.plane_sigma(index)
        for index, sensor in enumerate(case.sensors)
        if case.tells_place(index) and case.is_told(f"sensors.{sensor.name}.sigma")
    ]
    return bool(sigmas) and extent < 3.0 * min(sigmas)


def _guessed(case: Case) -> Mapping[str, Any] | None:
    """Return the values that nobody would have to tell, None where nothing was told."""
    told = [f"sensors.{s.name}.{key}" for s in case.sensors for key in OF_SENSOR]
    told += [f"motion.{key}" for key in OF_MOTION]
    if not any(map(case.is_told, told)):
        return None
    places = {
        s.name: {"position": list(s.position)} for s in case.sensors if s.position is not None
    }
    settings, _ = settle(case.reports, load_configuration({"sensors": places}))
    return settings.values


def _ratios(case: Case, guessed: Mapping[str, Any]) -> Iterator[tuple[str, tuple[float, float]]]:
    """Yield each key that was told, with its value and the one that reports tell."""
    used = case.settings.values
    for key in OF_MOTION:
        is_told = case.is_told(f"motion.{key}") and used["motion"].get(key)
        if is_told and guessed["motion"].get(key):
            yield f"motion.{key}", (float(used["motion"][key]), float(guessed["motion"][key]))
    for sensor in case.sensors:
        own, other = used["sensors"][sensor.name], guessed["sensors"][sensor.name]
        for key in OF_SENSOR:
            name = f"sensors.{sensor.name}.{key}"
            if not case.is_told(name) or not own.get(key) or not other.get(key):
                continue
            if isinstance(own[key], Mapping):
                for column, value in own[key].items():
                    if isinstance(other[key], Mapping) and other[key].get(column) and value:
                        yield f"{name}.{column}", (float(value), float(other[key][column]))
            elif not isinstance(other[key], Mapping):
                yield name, (float(own[key]), float(other[key]))


def _of_unit(ratios: Mapping[str, tuple[float, float]]) -> Iterator[Finding]:
    """Yield a unit that explains both the noise and the speed."""
    noise = [
        told / guess
        for key, (told, guess) in ratios.items()
        if key.endswith((".sigma", ".sigma.x", ".sigma.range_m"))
    ]
    if not noise or "motion.max_speed" not in ratios:
        return
    told, guess = ratios["motion.max_speed"]
    both = np.array([np.median(noise), told / guess])
    for ratio, unit in ((both, "kilometres"), (1 / both, "millimetres")):
        if np.all((ratio >= THOUSAND[0]) & (ratio <= THOUSAND[1])):
            yield Finding(
                unit,
                None,
                f"positions or ranges seem to be in {unit}: sigma and max_speed that are told are "
                f"{both[0]:.3g} and {both[1]:.3g} times what reports show; give them in metres",
                weight=WEIGHT + 30,
                told=told,
                seen=guess,
            )


def _contradiction(key: str, told: float, guess: float) -> Finding:
    table, _, name = key.partition(".")
    sensor = None
    word = name
    if table == "sensors":
        sensor, _, word = name.partition(".")
    cause = "sigma" if word.startswith("sigma") else word
    cause = "clutter" if cause.startswith("clutter") else cause
    units = {**OF_SENSOR, **OF_MOTION}
    unit = f" {units[word]}" if units.get(word) else ""
    ratio = max(told / guess, guess / told)
    change = "correct it, or its unit"
    if word == "max_speed" and guess > told:
        # Few reports are in tracks, and what the rest speaks of may be no object's.
        change = f"false alarms that line up look so too; {change}, only where objects are so fast"
    return Finding(
        cause,
        sensor,
        f"{key} is told as {told:.4g}{unit}, but its reports by themselves speak of "
        f"{guess:.3g}{unit}: {ratio:.3g} times {'less' if told > guess else 'more'}; {change}",
        weight=WEIGHT + float(np.log(ratio)),
        told=told,
        seen=guess,
    )
