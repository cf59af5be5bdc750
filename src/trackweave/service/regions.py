"""A tracker in regions of the plane: a tracker for each, and one picture of all."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.certificate import Certificate, Status
from trackweave.association.growth_limits import GrowthLimits
from trackweave.config.fill import Settings
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import CONFIRMED, TENTATIVE, TrackTable
from trackweave.errors import InvalidInputError
from trackweave.randomness import generator_for
from trackweave.run.course import tracker_of
from trackweave.run.regions.cutting import part_of
from trackweave.run.regions.joining import Found, Key, joined_rows
from trackweave.service.live_region import NOBODY, House, LiveRegion, Told
from trackweave.service.places import places_of
from trackweave.service.shared_tracks import Given, SharedTracks
from trackweave.service.spec import Spec
from trackweave.solvers.protocol import Solver
from trackweave.trackers.clock_guard import HeldScan
from trackweave.trackers.hypothesis import Assignments, Hypothesis, nothing_final

__all__ = ["RegionsTracker"]


class RegionsTracker:
    """What the service asks of a tracker, by regions that somebody houses.

    Parameters
    ----------
    spec
        With what it runs, and where the plane is cut.
    settings
        The same, complete.
    priors
        Tracks from which to set out, whose names they keep; None for none.
    rng
        From which each region's randomness comes.
    house
        Where regions are.
    """

    def __init__(
        self,
        spec: Spec,
        settings: Settings,
        priors: TrackTable | None,
        rng: np.random.Generator,
        house: House,
    ) -> None:
        assert spec.regions is not None
        self._regions, self._margin = list(spec.regions), spec.margin
        self._sensors = {each.name: each for each in settings.sensors}
        self._shared = SharedTracks(len(self._regions))
        self._owner: dict[int, int] = {}  # Of each report that is not final
        self._time: dict[int, float] = {}
        self._house = house
        seed, states = int(rng.integers(2**62)), []
        for number, region in enumerate(self._regions):
            known = priors
            if priors is not None:
                known = priors.at(region.wider(self._margin).holds(priors.mean[:, :2]))
                self._shared.keep(number, known.track.tolist())
            tracker: Any = tracker_of(
                settings, settings.sensors, spec.dim, priors=known, max_ahead=settings.max_ahead
            )
            states.append(LiveRegion(tracker, generator_for(seed, f"region {number}")).packed())
        house.begin(states)

    def at_rest(self) -> dict[str, Any]:
        """Return what a checkpoint holds: the regions themselves, wherever they are."""
        return {
            **{name: value for name, value in self.__dict__.items() if name != "_house"},
            "_sensors": list(self._sensors.values()),
            "_owner": np.array(list(self._owner.items()), np.int64).reshape(-1, 2),
            "_time": np.array(list(self._time.values())),
            "states": self._house.packed(),
        }  # fmt: skip

    def rise(self, house: House) -> None:
        """Go on after a checkpoint, with the regions that were at rest in somebody's house."""
        rest: dict[str, Any] = self.__dict__
        self._sensors = {each.name: each for each in rest["_sensors"]}
        self._owner = dict(rest["_owner"].tolist())
        self._time = dict(zip(self._owner, rest["_time"].tolist(), strict=True))
        self._house = house
        house.begin(rest.pop("states"))

    def step(
        self, scan: Scan | Sequence[Scan], *, rng: np.random.Generator, tracks: bool = True
    ) -> Hypothesis:
        """Take in scans, as a tracker does; each region has its own randomness."""
        scans = (scan,) if isinstance(scan, Scan) else tuple(scan)
        looks = [self._looks(each) for each in scans]
        told: list[Told] = self._house.ask(
            "step", [(*self._part(k, scans, looks), tracks) for k in range(len(self._regions))]
        )
        self._house.cpu += max(each.cpu for each in told)
        if all(each.hypothesis is None for each in told):
            self._forget(number for each in scans for number in each.report.tolist())
            raise InvalidInputError("no region could take the step")
        self._settle(told)
        rows = self._joined([each.tracks for each in told], is_kept=True) if tracks else None
        if tracks:
            alive = [(k, name) for k, each in enumerate(told)
                     for name in (*each.tracks.track.tolist(), *each.born)]  # fmt: skip
            self._shared.forget(alive)
        undone = [number for each in scans for number in each.report.tolist()
                  if told[self._owner[number]].hypothesis is None]  # fmt: skip
        return self._hypothesis(told, undone, rows)

    def tracks(self) -> TrackTable:
        """Return the live tracks, tentative ones too."""
        return self._joined(self._asked("tracks"))

    def pending(self) -> Assignments:
        """Return the assignments that later scans may amend."""
        return self._named(self._asked("pending"))

    def bound(self, search: Solver, limits: GrowthLimits) -> None:
        """Take another solver and other limits, each region for itself."""
        self._house.ask("bound", [(search, limits)] * len(self._regions))

    def _asked(self, method: str) -> list[Any]:
        return self._house.ask(method, [()] * len(self._regions))

    def _looks(self, scan: Scan) -> NDArray[np.bool_]:
        """Return whether each region looks at each report; note where the reports lie."""
        places: FloatArray | None = places_of(scan, self._sensors[scan.sensor])
        assert places is not None, "such sensors are refused before"
        numbers = scan.report.tolist()
        moments = np.full(len(scan), scan.time) if scan.moments is None else scan.moments
        self._time |= dict(zip(numbers, moments.tolist(), strict=True))
        there = places[:, :2]
        inside = np.array([each.holds(there) for each in self._regions])
        self._owner |= dict(zip(numbers, inside.argmax(axis=0).tolist(), strict=True))
        return np.array([each.wider(self._margin).holds(there) for each in self._regions])

    def _part(
        self, k: int, scans: Sequence[Scan], looks: Sequence[NDArray[np.bool_]]
    ) -> tuple[tuple[Scan, ...], IntArray]:
        """Return what a region is given, and at which of it others look too."""
        parts = tuple(
            part_of(scan, self._sensors[scan.sensor], look[k], scan.report)
            for scan, look in zip(scans, looks, strict=True)
        )
        both = [
            scan.report[look[k] & (look.sum(axis=0) > 1)]
            for scan, look in zip(scans, looks, strict=True)
        ]
        return parts, np.concatenate(both)

    def _settle(self, told: Sequence[Told]) -> None:
        """Take in which reports are whose, and find what is of one object."""
        shared = self._shared
        shared.born |= {(k, track): step for k, each in enumerate(told)
                        for track, step in each.born.items()}  # fmt: skip
        shared.settle([Given(each.report, each.track) for each in _final(told)], self._time)
        shared.join([each.open for each in told], self._time)

    def _joined(self, tables: Sequence[TrackTable], *, is_kept: bool = False) -> TrackTable:
        """Return one row for each object, that of the region in which it lies."""
        name: dict[Key, int] = {(k, track): self._shared.name((k, track))
                for k, table in enumerate(tables) for track in table.track.tolist()}  # fmt: skip
        found = [Found(region, k, NOBODY, NOBODY, tables[k])
                 for k, region in enumerate(self._regions)]  # fmt: skip
        rows, _ = joined_rows(found, name, tables[0].dim)
        sure = self._shared.confirmed
        if is_kept:
            sure |= set(rows.track[rows.status != TENTATIVE].tolist())
        known = (rows.status == TENTATIVE) & np.isin(rows.track, list(sure))
        return replace(rows, status=np.where(known, CONFIRMED, rows.status))

    def _named(self, parts: Sequence[Assignments]) -> Assignments:
        """Return each report with its object's name, as the region in which it lies has it."""
        found: list[tuple[int, int, float]] = []
        for k, part in enumerate(parts):
            rows = zip(part.report.tolist(), part.track.tolist(), part.probability.tolist(),
                       strict=True)  # fmt: skip
            found += [(report, -1 if track < 0 else self._shared.name((k, track)), probability)
                      for report, track, probability in rows
                      if self._owner[report] == k]  # fmt: skip
        report, track, probability = zip(*found, strict=True) if found else ((), (), ())
        return Assignments(
            np.array(report, np.int64), np.array(track, np.int64), np.array(probability)
        )

    def _forget(self, reports: Iterable[int]) -> None:
        """Forget where and when reports were, of which nothing more is to be said."""
        for report in reports:
            self._owner.pop(report, None)
            self._time.pop(report, None)

    def _hypothesis(
        self, told: Sequence[Told], undone: Sequence[int], rows: TrackTable | None
    ) -> Hypothesis:
        """Return what regions say, as one says it; what one could not take counts as late."""
        done = [each.hypothesis for each in told if each.hypothesis is not None]
        final = self._named(_final(told))
        late = sorted({*undone, *(report for each in done for report in each.late)})
        aside = _together([each.set_aside for each in done])
        self._forget([*final.report.tolist(), *late, *(n for scan in aside for n in scan.report)])
        # What regions share counts in each of them: the gap is that of all their problems.
        costs = [each.certificate for each in done]
        whole = Certificate(
            sum(each.cost for each in costs), sum(each.lower_bound for each in costs),
            Status.FEASIBLE,
        )  # fmt: skip
        return replace(
            done[0],
            tracks=TrackTable.empty(2) if rows is None else rows,
            n_tracks=0 if rows is None else len(rows),
            final=final,
            late=tuple(late),
            held=_together([each.held for each in done]),
            set_aside=aside,
            certificate=whole,
            # What one region would have to do again is what counts, as they do it side by side.
            n_sequences=max(each.n_sequences for each in done),
        )


def _final(told: Sequence[Told]) -> list[Assignments]:
    """Return what each region has made final."""
    said = [each.hypothesis for each in told]
    return [nothing_final() if each is None else each.final for each in said]


def _together(parts: Sequence[Sequence[HeldScan]]) -> tuple[HeldScan, ...]:
    """Return scans of which each region has told its own part: all judge times alike."""
    return tuple(
        replace(same[0], report=tuple(sorted({n for scan in same for n in scan.report})))
        for same in zip(*parts, strict=False)
    )
