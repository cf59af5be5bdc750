"""STUDY.toml: its tables and keys, each checked before anything runs."""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any

from trackweave.config.presets import preset_values
from trackweave.config.tables import Section, checked
from trackweave.errors import InvalidInputError
from trackweave.experiments.sampling import SAMPLERS
from trackweave.experiments.sweeps import Sweep, merged, sweeps_of
from trackweave.keys import COUNT, POSITIVE, SECONDS, Key, suggest
from trackweave.metrics import Evaluation
from trackweave.toml_file import read_toml

__all__ = [
    "LIKELIHOOD", "MEASURES", "OF_ITSELF", "Configured", "Plan", "Scene", "StudyPlan",
    "StudySection", "Tuning", "read_study",
]  # fmt: skip

_SETTINGS = ("cutoff", "order", "window", "targets")
LIKELIHOOD = "log_likelihood"
"""The measure that needs no truth."""
OF_ITSELF = ("reports", "tracks", "mean_gap", LIKELIHOOD)
"""What is measured of a run by itself."""
MEASURES = (
    *(field.name for field in fields(Evaluation) if field.name not in _SETTINGS),
    *OF_ITSELF,
)  # fmt: skip
"""What is measured of each run: what ``evaluate`` finds where there is truth, and of the run."""
_MEASURE = Key(f"one of {', '.join(MEASURES)}", words=MEASURES)


@dataclass(frozen=True, slots=True)
class Plan:
    """What holds for all runs.

    Parameters
    ----------
    seeds
        Number of seeds; each configuration runs with each, on the same reports.
    first_seed
        The first of them.
    metrics
        Measures that the report shows, the most important first; all are in the tables.
    cutoff
        Of ``evaluate`` [m].
    order
        Of ``evaluate``.
    max_gap
        Of ``evaluate`` [s]; left out, from the tracks' own period.
    window
        Of ``evaluate``: times over which OSPA(2) is taken.
    baseline
        Configuration with which the others are compared; left out, the first.
    tell_sensors
        Whether configurations are told what the simulated sensors are like, where they are silent.
    time_limit
        Wall clock after which a run counts as hung [s]; left out, none.
    """

    seeds: Annotated[int, Key("a whole number from 1 to 1000000", 1, 1_000_000)] = 20
    first_seed: Annotated[int, Key("a whole number ≥ 0", 0, 2**62)] = 0
    metrics: Annotated[
        tuple[Annotated[str, _MEASURE], ...],
        Key(f"a list of some of {', '.join(MEASURES)}", size=(1, 12)),
    ] = ("gospa", "idf1", "switches")
    cutoff: Annotated[float, POSITIVE] = 50.0
    order: Annotated[float, Key("a number from 1 to 100", 1, 100)] = 2.0
    max_gap: Annotated[float | None, SECONDS] = None
    window: Annotated[int, COUNT] = 10
    baseline: Annotated[str | None, Key("the name of a configuration")] = None
    tell_sensors: Annotated[bool, Key()] = False
    time_limit: Annotated[float | None, SECONDS] = None


@dataclass(frozen=True, slots=True)
class Tuning:
    """How ``tune`` searches.

    Parameters
    ----------
    configuration
        The configuration whose swept keys are searched; left out, the only one.
    objective
        The measure to be best in: ``log_likelihood`` of each scan's reports as predicted from the
        scans before, which needs no truth, or any other.
    sampler
        Where there are more points than candidates: ``random`` draws them; ``tpe`` proposes them
        from what those before were worth in the first round (Optuna's estimator).
    candidates
        How many points of the sweep take part.
    keep
        Of so many candidates one goes on to the next round, which has as many times the runs.
    first
        Runs of each candidate in the first round.
    """

    configuration: Annotated[str | None, Key("the name of a configuration")] = None
    objective: Annotated[str, _MEASURE] = LIKELIHOOD
    sampler: Annotated[str, Key("random or tpe", words=SAMPLERS)] = "random"
    candidates: Annotated[int, Key("a whole number from 2 to 10000", 2, 10_000)] = 27
    keep: Annotated[int, Key("a whole number from 2 to 10", 2, 10)] = 3
    first: Annotated[int, COUNT] = 1


class _PlanSection(Section, of=(Plan,)):
    """What holds for all runs."""


class _TuneSection(Section, of=(Tuning,)):
    """How ``tune`` searches."""


class _ScenarioSection(Section):
    """Reports to be tracked: a scene that is simulated, or a recording."""

    file: Annotated[
        str, Key("the path of a scenario file"), "A scenario file, simulated with each seed."
    ]
    scene: Annotated[
        dict[str, Any],
        Key("a table with the keys of a scenario file"),
        "The keys of a scenario file.",
    ]
    reports: Annotated[
        str, Key("the path of a file of reports"), "A recording, of any format that is read."
    ]
    truth: Annotated[str, Key("the path of a file of truth"), "Its truth."]
    pieces: Annotated[int, COUNT, "Parts of equal time that are tracked by themselves."]
    sweep: Annotated[dict[str, Any], Key("a table of keys"), "Lists or ranges of values, by key."]

    @staticmethod
    def rule(values: Mapping[str, Any]) -> str | None:
        """Return what was expected where keys do not go together."""
        sources = [key for key in ("file", "scene", "reports") if key in values]
        if len(sources) != 1:
            return "one of file (a scenario file), scene (its keys) and reports (a recording)"
        if "reports" not in values and ("truth" in values or "pieces" in values):
            return "truth and pieces beside reports alone"
        if "reports" in values and "sweep" in values:
            return "no sweep: a recording is as it is"
        return None


class _ConfigurationSection(Section):
    """One way to track."""

    file: Annotated[str, Key("the path of a configuration file"), "A configuration file."]
    preset: Annotated[str, Key("the name of a preset"), "A preset, as of `track --preset`."]
    set: Annotated[
        dict[str, Any],
        Key("a table with the keys of a configuration"),
        "Keys over those of the file.",
    ]
    sweep: Annotated[dict[str, Any], Key("a table of keys"), "Lists or ranges of values, by key."]


class _ScenariosSection(Section, entries=_ScenarioSection):
    """Scenarios by name."""


class _ConfigurationsSection(Section, entries=_ConfigurationSection):
    """Configurations by name."""


class StudySection(Section):
    """Everything that STUDY.toml can say."""

    study: _PlanSection
    scenarios: _ScenariosSection
    configurations: _ConfigurationsSection
    tune: _TuneSection

    @staticmethod
    def rule(values: Mapping[str, Any]) -> str | None:
        """Return what was expected where a table is missing."""
        for name in ("scenarios", "configurations"):
            if not values.get(name):
                return f"at least one table [{name}.NAME]"
        return None


@dataclass(frozen=True, slots=True)
class Scene:
    """Where reports come from: keys of a scenario file with their sweep, or a recording."""

    table: Mapping[str, Any] | None
    sweep: Sweep
    reports: str | None = None
    truth: str | None = None
    pieces: int = 1


@dataclass(frozen=True, slots=True)
class Configured:
    """A configuration: its keys, its preset, and what is swept."""

    values: Mapping[str, Any]
    sweep: Sweep
    preset: str | None = None


@dataclass(frozen=True, slots=True)
class StudyPlan:
    """A study as its file says it."""

    name: str
    plan: Plan
    tuning: Tuning
    scenes: Mapping[str, Scene]
    configurations: Mapping[str, Configured]
    parts: Mapping[str, str]
    """A digest of each part of the file, with the files that it names, by which a directory
    tells its own study from another."""

    def runs(self) -> int:
        """Return how many runs the study has."""
        points = sum(len(each.sweep) * each.pieces for each in self.scenes.values())
        ways = sum(len(each.sweep) for each in self.configurations.values())
        return points * ways * self.plan.seeds

    @property
    def baseline(self) -> str:
        """The configuration with which the others are compared."""
        return self.plan.baseline or next(iter(self.configurations))


def read_study(
    source: str | os.PathLike[str] | Mapping[str, Any], *, tuned: bool = False
) -> StudyPlan:
    """Return a study from its file, or from a mapping of the same keys.

    Parameters
    ----------
    source
        The file's path; paths in it count from its folder. Of a mapping they count from where
        the program runs.
    tuned
        Whether the table ``[tune]`` is part of what tells the study from others.

    Returns
    -------
    The study, with the files that it names read, except recordings.

    Raises
    ------
    InvalidInputError
        If a key or a value does not fit, or sweeps contradict what is set.
    """
    if isinstance(source, Mapping):
        name, folder, given = "study", Path(), dict(source)
    elif isinstance(source, str | os.PathLike):
        name, folder = str(source), Path(source).parent
        given = read_toml(Path(source), "a study")
    else:
        raise InvalidInputError(
            f"study: {source!r:.80}; expected the path of a TOML file, or a mapping of its keys"
        )
    values = checked(given, StudySection.as_kind(Key()), name)
    scenes = {
        key: _scene(one, folder, f"{name}, scenarios.{key}")
        for key, one in values["scenarios"].items()
    }
    configurations = {
        key: _configured(one, folder, f"{name}, configurations.{key}")
        for key, one in values["configurations"].items()
    }
    told = values.get("study", {})
    plan = Plan(**{**told, **({"metrics": tuple(told["metrics"])} if "metrics" in told else {})})
    tuning = Tuning(**values.get("tune", {}))
    for table, chosen in (("study.baseline", plan.baseline),
                          ("tune.configuration", tuning.configuration)):  # fmt: skip
        if chosen is not None and chosen not in configurations:
            raise InvalidInputError(
                f"{name}, {table}: {chosen!r:.60}; {suggest(chosen, list(configurations))}"
            )
    if len(set(plan.metrics)) < len(plan.metrics):
        raise InvalidInputError(f"{name}, study.metrics: a measure twice; expected each once")
    # What is shown of the runs, and for how long they are waited for, may change on the way.
    same = replace(plan, metrics=(), baseline=None, time_limit=None)
    parts = {
        "scenarios": _digest(scenes), "configurations": _digest(configurations),
        "study": _digest(same),
    }  # fmt: skip
    if tuned:
        parts["tune"] = _digest(tuning)
    return StudyPlan(name, plan, tuning, scenes, configurations, parts)


def _scene(values: Mapping[str, Any], folder: Path, where: str) -> Scene:
    if "reports" in values:
        files = [folder / values[key] for key in ("reports", "truth") if key in values]
        for file in files:
            if not file.is_file():
                raise InvalidInputError(f"{where}: {file}: no such file; expected a table")
        truth = str(files[1]) if len(files) > 1 else None
        return Scene(None, Sweep({}), str(files[0]), truth, values.get("pieces", 1))
    table = values.get("scene")
    if table is None:
        table = read_toml(folder / values["file"], "a scenario")
    # Scenarios have a value for nearly each key, which the sweep replaces.
    sweep = sweeps_of(values.get("sweep", {}), {}, f"{where}.sweep")
    _require_apart(sweep, f"{where}.sweep")
    return Scene(table, sweep)


def _require_apart(sweep: Sweep, where: str) -> None:
    """Refuse a key that is swept of all sensors and of one, whose values would hide the others."""
    for path in sweep.keys:
        for of_all in sweep.keys:
            # sensors.NAME.KEY beside sensors.KEY, or a key within either.
            own, common = path[2:], of_all[1:]
            shared = min(len(own), len(common))
            if path[0] == of_all[0] == "sensors" and shared and own[:shared] == common[:shared]:
                raise InvalidInputError(
                    f"{where}.{'.'.join(path)}: swept, and so is {'.'.join(of_all)} of all "
                    "sensors; expected one of the two"
                )


def _configured(values: Mapping[str, Any], folder: Path, where: str) -> Configured:
    preset = values.get("preset")
    try:
        preset_values(preset)
    except InvalidInputError as err:
        raise InvalidInputError(f"{where}.{err}") from err
    own = values.get("set", {})
    sweep = sweeps_of(values.get("sweep", {}), own, f"{where}.sweep")
    if "file" not in values:
        return Configured(own, sweep, preset)
    table = read_toml(folder / values["file"], "a configuration")
    return Configured(merged(table, own), sweep, preset)


def _digest(part: Any) -> str:
    """Return a digest of a part and of the recordings that it names."""
    digest = hashlib.sha256(json.dumps(_plain(part), default=str).encode())
    for scene in part.values() if isinstance(part, dict) else ():
        for file in (getattr(scene, "reports", None), getattr(scene, "truth", None)):
            if file is not None:
                digest.update(Path(file).read_bytes())
    return digest.hexdigest()[:16]


def _plain(value: Any) -> Any:
    """Return a value as JSON has it; of a recording, nothing of where it lies."""
    if isinstance(value, Scene):
        return [value.table, _plain(value.sweep), value.reports is None, value.pieces]
    if isinstance(value, Sweep):
        return [[".".join(path), list(values)] for path, values in value.keys.items()]
    if hasattr(type(value), "__dataclass_fields__"):
        return {field.name: _plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    return value
