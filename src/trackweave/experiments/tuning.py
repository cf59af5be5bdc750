"""The best values of a configuration's keys, by successive halving."""

import json
import math
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.engine import engine_of
from trackweave.errors import InvalidInputError
from trackweave.experiments.cases import Case, Job, cases_of, jobs_of
from trackweave.experiments.running import LOG, Log, Progress, record_of, run_jobs
from trackweave.experiments.sampling import Proposals, proposals
from trackweave.experiments.study_file import LIKELIHOOD, StudyPlan, read_study
from trackweave.experiments.studying import place_of, require_few
from trackweave.experiments.sweeps import Point, Sweep, merged, nested
from trackweave.io.encoding import encode_table
from trackweave.randomness import generator_for
from trackweave.studies.judging import mean_of
from trackweave.studies.writing import text_table

__all__ = ["TuningResult", "tune"]

MORE_IS_BETTER = frozenset({
    "covered", "n_found", "mostly_tracked", LIKELIHOOD, "mota", "idf1", "idp", "idr", "hota",
    "deta", "assa", "loca", "right_share", "report_idf1", "report_purity", "report_mota",
})  # fmt: skip
"""Of all other measures, less is."""
COUNTS = frozenset({"n_truth", "n_tracks", "n_times", "reports", "tracks", "partly_tracked"})
"""Of which neither more nor less is better."""
BARE = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True, eq=False, repr=False)
class TuningResult:
    """What a search found.

    Parameters
    ----------
    best
        The best configuration's keys, nested as in a file.
    preset
        Its preset, None for none.
    trials
        A row for each candidate, the best first: its swept keys, its runs, and its mean of the
        objective over them.
    report
        All of it as Markdown.
    told
        What simulated sensors were told in the search where the configuration is silent, by its
        dotted key: each value that some scene has.

    Examples
    --------
    >>> import trackweave as tw
    >>> "best" in tw.TuningResult.__dataclass_fields__
    True
    """

    best: Mapping[str, Any]
    preset: str | None
    trials: pl.DataFrame
    report: str
    told: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"TuningResult: best of {len(self.trials)} candidates, {self.best!r:.200}"

    def files(self) -> dict[str, bytes]:
        """Return the files of a search but for its log and record, by name."""
        head = "" if self.preset is None else f"# beside --preset {self.preset}\n"
        lines = [f"{key} = {value}" for key, value in _lines(self.best)]
        lines = lines or ["# Nothing that was tried is better than the usual values."]
        if self.told:
            # A recording's sensors are told nothing, unless somebody does it here.
            lines += [
                "# By tell_sensors the search told sensors what scenes say. Of others it is",
                "# estimated unless it is said here as well:",
            ]
            lines += [f"# {key} = {' or '.join(values)}" for key, values in self.told.items()]
        return {
            "tuned.toml": f"{head}{chr(10).join(lines)}\n".encode(),
            "trials.csv": encode_table(self.trials, "trials.csv"),
            "report.md": self.report.encode(),
        }


@dataclass(frozen=True, slots=True)
class _Search:
    """Candidates by draws; candidate 0 is the configuration as it is."""

    study: StudyPlan
    sweep: Sweep
    draws: Sequence[Case]
    sampled: Proposals
    points: list[Point] = field(default_factory=lambda: [{}])
    jobs: list[Job] = field(default_factory=list)

    def enter(self, points: Sequence[Point]) -> list[int]:
        """Take candidates, whose configurations are checked; return their numbers."""
        first = len(self.points)
        self.points.extend(points)
        # Candidate 0 has its runs with the first that are taken.
        new = self.points[first if self.jobs else 0 :]
        self.jobs.extend(jobs_of(self.study, [
            replace(draw, point=point) for point in new for draw in self.draws
        ]))  # fmt: skip
        return list(range(first, len(self.points)))

    def runs(self, candidates: Sequence[int], used: int) -> list[int]:
        """Return the numbers of the runs of candidates, and of candidate 0, on some draws."""
        each = len(self.draws)
        return [one * each + draw for one in (0, *candidates) for draw in range(used)]

    def rounds(self) -> list[tuple[int, int]]:
        """Return how many candidates, besides 0, take part in each round, and the draws of it."""
        tuning, found = self.study.tuning, []
        alive = min(tuning.candidates, len(self.sweep))
        used = min(tuning.first, len(self.draws))
        while True:
            found.append((alive, used))
            if used == len(self.draws) or alive == 1:
                return found
            alive = math.ceil(alive / tuning.keep)
            used = min(used * tuning.keep, len(self.draws))


def tune(  # noqa: PLR0913 the one function that users call with everything
    source: str | os.PathLike[str] | Mapping[str, Any],
    out: str | os.PathLike[str] | None = None,
    *,
    engine: str = "local",
    workers: int | None = None,
    yes: bool = False,
    progress: Progress | None = None,
) -> TuningResult:
    """Search the swept keys of a configuration for what is best, by successive halving [1]_.

    All candidates are tried on a few draws (seeds or pieces of recordings); the best third, or
    whatever the table ``[tune]`` says, goes on to three times as many draws, and so on. The same
    draws judge all of a round. The configuration without its sweep takes part to the end, and is
    what the best is compared with.

    Parameters
    ----------
    source
        The path of a study file (the reference page "Study files"), or a mapping of its keys.
    out
        A directory for the files of ``trackweave tune``: new, empty, or that of the same search,
        which goes on where it was stopped. None to keep everything in memory.
    engine, workers, yes
        As ``study`` takes them.
    progress
        Called after each run with the number of runs done and of those left in its round.

    Returns
    -------
    The best keys, and every candidate's mean.

    Raises
    ------
    InvalidInputError
        If a key or a value of the study cannot be used, or nothing is swept.
    OutputError
        If the directory holds something else.

    References
    ----------
    .. [1] K. Jamieson, A. Talwalkar, *Non-stochastic best arm identification and hyperparameter
       optimization*, AISTATS 2016.

    Examples
    --------
    >>> import trackweave as tw
    >>> tw.tune({"scenarios": {"one": {}}, "configurations": {"plain": {}}})
    Traceback (most recent call last):
        ...
    trackweave.errors.InvalidInputError: study, scenarios.one: {}; expected one of file (a
    scenario file), scene (its keys) and reports (a recording)
    """
    search = _search(read_study(source, tuned=True))
    rounds = search.rounds()
    require_few(sum((alive + 1) * used for alive, used in rounds), search.study.name, yes=yes)
    # Before anything is written: what is proposed first has to be a configuration.
    alive = search.enter(next(search.sampled))
    place = place_of(search.study, source, out, "tune")
    limit = search.study.plan.time_limit
    with engine_of(engine, workers, time_limit=limit) as pool, Log(search.study, place) as log:

        def scores(candidates: Sequence[int], used: int) -> list[float]:
            run_jobs(search.jobs, search.runs(candidates, used), log, pool, progress)
            return [_means(search, log, one, used)[0] for one in candidates]

        score = _first_round(search, alive, partial(scores, used=rounds[0][1]))
        last = np.ones(len(search.points), dtype=int)
        for number, (count, used) in enumerate(rounds[1:], start=2):
            order = np.argsort(score, kind="stable")[::-1]
            alive = [alive[place] for place in order[:count]]
            last[[0, *alive]] = number
            score = scores(alive, used)
        best = alive[int(np.argsort(score, kind="stable")[-1])]
    found = _result(search, log, best, [rounds[number - 1][1] for number in last])
    if place is not None:
        record = {**record_of(search.study), "complete": True}
        kept = (place.path / LOG).read_bytes()
        place.write({**found.files(), LOG: kept}, record)
    return found


def _search(study: StudyPlan) -> _Search:
    tuning = study.tuning
    if tuning.objective in COUNTS:
        raise InvalidInputError(
            f"{study.name}, tune.objective: {tuning.objective}, of which neither more nor less is "
            f"better; expected another measure, such as {LIKELIHOOD}"
        )
    swept = [name for name, one in study.configurations.items() if one.sweep.keys]
    name = tuning.configuration or (swept[0] if len(swept) == 1 else None)
    if name is None or name not in swept:
        raise InvalidInputError(
            f"{study.name}, tune.configuration: {name or 'left out'}; expected the name of a "
            f"configuration with a sweep: {', '.join(swept) or 'there is none'}"
        )
    whole = study.configurations[name]
    rng = generator_for(study.plan.first_seed, "tune")
    alone = replace(
        study, configurations={name: replace(whole, sweep=replace(whole.sweep, keys={}))}
    )
    draws = list(cases_of(alone))
    if tuning.sampler != "random":
        # What is proposed on the way has to be a configuration as well.
        jobs_of(study, [replace(draws[0], point=point) for point in whole.sweep.values()])
    # Any first few of them are of all scenarios.
    order = rng.permutation(len(draws))
    sampled = proposals(tuning.sampler, whole.sweep, tuning.candidates, rng)
    return _Search(study, whole.sweep, [draws[place] for place in order], sampled)


def _first_round(
    search: _Search, alive: list[int], scores: Callable[[Sequence[int]], list[float]]
) -> list[float]:
    """Return the score of each candidate, those entered that are proposed on the way."""
    score = scores(alive)
    told = score
    while True:
        try:
            new = search.enter(search.sampled.send(told))
        except StopIteration:
            return score
        told = scores(new)
        alive += new
        score = score + told


def _values(search: _Search, log: Log, candidate: int, used: int) -> FloatArray:
    """Return a candidate's objective on the first so many draws, NaN where a run failed."""
    # The log may hold more of an earlier start, which must not count before its round.
    first, name = candidate * len(search.draws), search.study.tuning.objective
    runs = [log.found[first + draw] for draw in range(used)]
    found = [(run.get("measures") or {}).get(name) for run in runs]
    return np.array([math.nan if value is None else value for value in found], dtype=float)


def _means(search: _Search, log: Log, candidate: int, used: int) -> tuple[float, float]:
    """Return a candidate's score, more is better, and the mean that it stands for."""
    mean = float(_values(search, log, candidate, used).mean())
    sign = 1.0 if search.study.tuning.objective in MORE_IS_BETTER else -1.0
    # A candidate that fails somewhere is behind all that do not.
    return (-math.inf if math.isnan(mean) else sign * mean), mean


def _result(search: _Search, log: Log, last: int, used: Sequence[int]) -> TuningResult:
    """Return what the search found; ``used`` is how many draws each candidate had."""
    # The last that is left has to be better than what nothing was changed of, on the same draws.
    shared = used[last]
    best = max(0, last, key=lambda one: (_means(search, log, one, shared)[0], one))
    study, objective = search.study, search.study.tuning.objective
    name = search.draws[0].configuration
    if math.isnan(_means(search, log, best, used[best])[1]):
        errors = {run["error"] for run in log.found.values() if run.get("error")}
        why = next(iter(sorted(errors)), "reports or truth do not tell it")
        raise InvalidInputError(f"{study.name}: no candidate has {objective} ({why})")
    rows = []
    for one, point in enumerate(search.points):
        score, mean = _means(search, log, one, used[one])
        cells = ["" if value is None else json.dumps(value) for value in map(
            point.get, search.points[-1])]  # fmt: skip
        rows.append((one, *cells, used[one], mean, score))
    keys = [".".join(key) for key in search.points[-1]]
    head = ["candidate", *keys, "runs", objective, "score"]
    trials = pl.DataFrame(rows, schema=head, orient="row", strict=False)
    order = [pl.col("candidate") != best, -pl.col("runs"), -pl.col("score"), "candidate"]
    trials = trials.sort(order).drop("score")
    gain = mean_of(_values(search, log, last, shared) - _values(search, log, 0, shared))
    found = f"The best is candidate {best}."
    if best == 0:
        found = f"No candidate is better than candidate 0; the last that was left is {last}."
    report = "\n\n".join([
        "# Search",
        f"{len(search.points) - 1} candidates of {name}, by {objective}, of which "
        f"{'more' if objective in MORE_IS_BETTER else 'less'} is better. Candidate 0 is the "
        "configuration without its sweep.",
        f"{found} From candidate 0 to it, on the same {shared} draws: {gain}. "
        "Those of fewer runs were behind on these; their means do not compare with others'. "
        "The best of many looks better than it is: judge it on draws that the search has not had, "
        "by `trackweave study` with another `first_seed` or recording.",
        text_table(trials.columns, trials.rows()),
    ])  # fmt: skip
    configured = study.configurations[name]
    keys_of = merged(configured.values, nested(search.points[best]))
    told = _told_besides(search, best, keys_of)
    return TuningResult(keys_of, configured.preset, trials, report + "\n", told)


def _told_besides(
    search: _Search, best: int, keys_of: Mapping[str, Any]
) -> dict[str, Sequence[str]]:
    """Return each key that a candidate's runs had beyond its own, with its values as TOML."""
    each, own = len(search.draws), dict(_lines(keys_of))
    found: dict[str, dict[str, None]] = {}
    for job in search.jobs[best * each : (best + 1) * each]:
        for key, value in _lines(job.values):
            if key not in own:
                found.setdefault(key, {})[value] = None
    return {key: tuple(values) for key, values in found.items()}


def _lines(table: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, str]]:
    """Yield each key of nested tables by its dotted name, with its value, as TOML has them."""
    for key, value in table.items():
        name = path + (key if BARE.fullmatch(key) else json.dumps(key))
        if isinstance(value, Mapping):
            yield from _lines(value, f"{name}.")
        elif value is not None:
            yield name, json.dumps(value)
