"""Whether a run's first tracks contradict the noise that was told, and what is used instead."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from trackweave.arrays import IntArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import digits
from trackweave.keys import show_value
from trackweave.run.diagnostics import Case, Finding
from trackweave.run.diagnostics.scatter import is_noise, scatter_of, without_motion

__all__ = ["CLEAR", "NoiseDoubts", "scaled", "with_scaled"]

# Sensors are judged once so many reports are in tracks, each by so many triples of its own; all
# together where they have them before so many are, and at the end of a run by so many triples.
LINKS, ENOUGH, MOST_LINKS, FEWEST = 400, 150, 3200, 60
SHORT, LONG = 1, 3
# What scatters so many times more than told is looked at again with gates that are wider: those of
# a sigma that is too small leave out the very reports that tell. So much then is a contradiction.
DOUBTFUL, WIDER, CLEAR = 1.3, 2.0, 1.4
MOST_TRIALS = 3
WEIGHT = 50.0

Factors = dict[str, float]
"""How many times as large as told something is, by column; under "" for all of a position."""


@dataclass(frozen=True, slots=True)
class _Verdict:
    """What was told of a sensor's noise, seen along tracks, and used; as in a file."""

    told: Any
    learned: Any
    used: Any
    times: float
    n_tracks: int  # Along which it was seen; 0 where it makes tracks likelier

    @property
    def seen(self) -> str:
        """What shows it, in words."""
        if not self.n_tracks:
            return "tracks are far likelier under"
        return f"along {self.n_tracks} tracks its reports scatter by"


class NoiseDoubts:
    """What was told of sensors' noise, against what the first tracks of a run show.

    A run goes on until its tracks hold some hundred reports of a sensor. Where these scatter about
    as told, it simply goes on. Where they scatter more, it begins again with a noise whose gates
    leave nothing out, and once that has told how much, with what was seen. A noise that was told
    too large is left: it costs hardly anything, and may stand for an extent.
    """

    def __init__(self) -> None:
        self._sigmas: dict[str, Any] = {}
        self._factors: dict[str, Factors] = {}
        self._on_trial: set[str] = set()
        self._trusted: set[str] = set()
        self._verdicts: dict[str, _Verdict] = {}
        self._n_trials = 0
        self._due: float = LINKS

    @property
    def is_settled(self) -> bool:
        """Whether no sensor is left whose noise could still turn out to be otherwise."""
        return self._due == np.inf

    def applied(self, configuration: Configuration) -> Configuration:
        """Return what the next attempt takes: as read, but for the noise that is doubted."""
        if not self._factors:
            return configuration
        sensors = configuration.table("sensors")
        for name, factors in self._factors.items():
            sigma = scaled(self._sigmas[name], factors)
            sensors[name] = {**sensors.get(name, {}), "sigma": sigma}
        return configuration.changed(sensors=sensors)

    def contradict(
        self, reports: ReportTable, settings: Settings, track: IntArray, *, at_end: bool = False
    ) -> bool:
        """Look at the tracks so far; tell whether ``applied`` changed, to begin again."""
        # ``track`` is that of each report as far as it is known, -1 for none; ``at_end`` no more
        # come.
        n_assigned = int(np.count_nonzero(track >= 0))
        if not at_end and n_assigned < self._due:
            return False
        self._due = 2 * n_assigned
        case = Case(reports, settings, track, None)
        least = FEWEST if at_end else ENOUGH
        seen = {case.reports.sensors[i]: _times(case, i, least) for i in self._open(case)}
        if not seen:
            self._due = np.inf
            return False
        shown = {name: times for name, times in seen.items() if times is not None}
        n_tracks = len(case.groups)
        if self._on_trial:
            return self._settle_trial(shown, n_tracks, at_end=at_end)
        if len(shown) < len(seen) and n_assigned < MOST_LINKS and not at_end:
            return False
        for name, times in shown.items():
            self._sigmas[name] = settings.values["sensors"][name]["sigma"]
            is_trusted = next(s for s in settings.sensors if s.name == name).trusts("sigma")
            doubtful = {c: WIDER * t for c, t in times.items() if t >= DOUBTFUL}
            if doubtful and not is_trusted and self._n_trials < MOST_TRIALS:
                self._factors[name] = doubtful
                self._on_trial.add(name)
            else:
                self._enter(name, times, {}, n_tracks)
                if doubtful and is_trusted:
                    self._trusted.add(name)
        if self._on_trial:
            self._n_trials, self._due = self._n_trials + 1, LINKS
        return bool(self._on_trial)

    def overrule(self, settings: Settings, names: Sequence[str], factor: float) -> None:
        """Use so many times the noise told of some sensors, under which tracks are likelier."""
        for name in names:
            told, times = settings.values["sensors"][name]["sigma"], {"": factor}
            self._sigmas[name] = told
            self._enter(name, times, times, 0)

    def _settle_trial(self, shown: Mapping[str, Factors], n_tracks: int, *, at_end: bool) -> bool:
        """Take what tracks show with wide gates, once they show it of all that are on trial."""
        if not at_end and not self._on_trial <= set(shown):
            return False
        for name in self._on_trial:
            wide = self._factors.pop(name)
            if name not in shown:
                self._enter(name, {}, {}, n_tracks)
                continue
            times = {column: wide.get(column, 1.0) * t for column, t in shown[name].items()}
            clear = {column: t for column, t in times.items() if column in wide and t >= CLEAR}
            self._enter(name, times, clear, n_tracks)
        self._on_trial, self._due = set(), LINKS
        return True

    def _enter(self, name: str, times: Factors, clear: Factors, n_tracks: int) -> None:
        """Decide on a sensor: what is clear is used, the rest stays as told."""
        told = self._sigmas[name]
        if clear:
            self._factors[name] = clear
        self._verdicts[name] = _Verdict(
            told, scaled(told, times), scaled(told, clear), max(clear.values(), default=1.0),
            n_tracks,
        )  # fmt: skip

    def _open(self, case: Case) -> Iterator[int]:
        """Yield the sensors whose noise was told and that are not judged yet."""
        for index in case.examined:
            name = case.reports.sensors[index]
            key = f"sensors.{name}.sigma"
            has_own = np.isfinite(case.reports.sigma[case.rows[index]]).any()
            if (
                name not in self._verdicts
                and case.is_told(key)
                and key not in case.settings.confirmed
                and case.tells_place(index)
                and not has_own
            ):
                yield index

    def entered(self, settings: Settings) -> Settings:
        """Return the configuration as used, in which what was learned counts as estimated."""
        learned = {f"sensors.{name}.sigma": "estimated" for name in self._factors}
        return replace(settings, sources={**settings.sources, **learned})

    def findings(self) -> list[Finding]:
        """Return a sentence on each sensor whose noise is contradicted, used as told or not."""
        return [
            Finding(
                "sigma",
                name,
                f"sensor {name}: sigma is told as {show_value(found.told)}, but "
                f"{found.seen} {show_value(found.learned)}{self._what_is_used(name)}",
                weight=WEIGHT + abs(float(np.log(found.times))),
                told=_number(found.told),
                seen=_number(found.learned if name in self._trusted else found.used),
            )
            for name, found in self._verdicts.items()
            if name in self._factors or name in self._trusted
        ]

    def _what_is_used(self, name: str) -> str:
        """Return the rest of a sentence on a sensor's noise."""
        if name in self._trusted:
            return " at least, and more of them lie too far off to be in tracks; it is trusted"
        return (
            f": {show_value(self._verdicts[name].used)} is used; correct it, or give "
            f'trust = ["sigma"] in [sensors.{name}] to keep what is told'
        )

    def as_record(self) -> list[dict[str, Any]]:
        """Return what was told, learned and used of each sensor that was judged."""
        return [
            {
                "key": f"sensors.{name}.sigma",
                "told": found.told,
                "learned": found.learned,
                "used": found.used,
            }
            for name, found in self._verdicts.items()
        ]


def _times(case: Case, index: int, least: int) -> Factors | None:
    """Return how many times its sigma a sensor's reports scatter; None where too few tell."""
    short, long = (scatter_of(case, index, stride, case.groups) for stride in (SHORT, LONG))
    if min(len(short), len(long)) < least:
        return None
    kind = case.reports.kind_of(index)
    told = case.sensors[index].sigmas(case.reports.dim)[:2] ** 2
    near, far = short.usual() / told, long.usual() / told
    if kind.is_position:
        near, far = near.mean(keepdims=True), far.mean(keepdims=True)
    own = without_motion(short, long, near, far)
    noisy = is_noise(case, index, (short, long), own, near)
    own = np.where(noisy, own, np.minimum(near, 1.0))
    columns = kind.columns(case.reports.dim) if kind.has_range else ("",)
    return {column: float(np.sqrt(square)) for column, square in zip(columns, own, strict=False)}


def scaled(sigma: Any, factors: Factors) -> Any:
    """Return a noise as in a file, so many times as large."""
    if isinstance(sigma, Mapping):
        whole = factors.get("", 1.0)
        return {c: _rounded(value, factors.get(c, whole)) for c, value in sigma.items()}
    return _rounded(sigma, factors.get("", 1.0))


def with_scaled(configuration: Configuration, factors: Mapping[str, float]) -> Configuration:
    """Return a configuration with so many times the noise that it tells of some sensors."""
    sensors = configuration.table("sensors")
    for name, factor in factors.items():
        sigma = scaled(configuration.sensor(name)["sigma"], {"": factor})
        sensors[name] = {**sensors.get(name, {}), "sigma": sigma}
    return configuration.changed(sensors=sensors)


def _rounded(value: float, factor: float) -> float:
    return value if factor == 1.0 else digits(value * factor, 3)


def _number(sigma: Any) -> float:
    """Return the one number of a noise, or that of its first column."""
    return float(next(iter(sigma.values())) if isinstance(sigma, Mapping) else sigma)
