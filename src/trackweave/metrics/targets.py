"""Each target's own record: how long it was followed, how well and by whom."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.metrics.moments import Moments, usual_gap
from trackweave.metrics.pairing import Pairs, changes

__all__ = ["MOSTLY_LOST", "MOSTLY_TRACKED", "PARTLY_TRACKED", "TargetRecord", "target_records"]

MOSTLY_TRACKED, PARTLY_TRACKED, MOSTLY_LOST = "mostly tracked", "partly tracked", "mostly lost"
TRACKED_SHARE, LOST_SHARE = 0.8, 0.2


@dataclass(frozen=True, slots=True)
class TargetRecord:
    """How one target was followed.

    ``time_present`` is how long the truth knows where it is [s]: the intervals between its
    positions, but for those in which it was away, longer than 1.5 times the truth's usual
    interval; ``time_tracked`` the part of it in which it was followed at both ends of an interval.
    ``covered`` is the share of its positions that are paired with a track, ``rmse`` the root of
    the mean squared distance of its tracks [m], None where it was never followed. ``completeness``
    is "mostly tracked" from a share of 0.8 up, "mostly lost" below 0.2, else "partly tracked". A
    switch is another track than the one that it had last, a fragmentation an interruption after
    which it is found again. ``tracks`` are in the order in which they first followed it.
    """

    target: str
    first_time: float
    last_time: float
    time_present: float
    time_tracked: float
    positions: int
    tracked_positions: int
    covered: float
    completeness: str
    rmse: float | None
    switches: int
    fragmentations: int
    tracks: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return every entry by its name, ready for JSON."""
        return asdict(self) | {"tracks": list(self.tracks)}


def target_records(moments: Moments, pairs: Pairs) -> tuple[TargetRecord, ...]:
    """Return each target's record, in order of their identifiers as text."""
    lives = _Lives(moments, pairs)
    switches, fragmentations = (
        np.bincount(which, minlength=moments.n_targets) for which in changes(pairs)
    )
    bounds = np.searchsorted(pairs.target, np.arange(moments.n_targets + 1))
    return tuple(
        lives.record(
            target,
            _Following(
                pairs.distance[bounds[target] : bounds[target + 1]],
                pairs.track[bounds[target] : bounds[target + 1]],
                int(switches[target]),
                int(fragmentations[target]),
            ),
        )
        for target in range(moments.n_targets)
    )


@dataclass(frozen=True, slots=True)
class _Following:
    """What a target's pairs say."""

    distance: FloatArray
    track: IntArray
    switches: int
    fragmentations: int


class _Lives:
    """The truth's positions by target, then time, and which of them are paired."""

    def __init__(self, moments: Moments, pairs: Pairs) -> None:
        self.moments = moments
        moment = np.repeat(np.arange(len(moments)), np.diff(moments.truth.first))
        order = np.lexsort((moment, moments.truth.identity))
        target, moment = moments.truth.identity[order], moment[order]
        self.time = moments.time[moment]
        self.bounds = np.searchsorted(target, np.arange(moments.n_targets + 1))
        self.paired = np.zeros(target.size, dtype=bool)
        self.paired[self.bounds[pairs.target] + pairs.turn] = True
        self.longest = usual_gap(self.time, target)

    def record(self, target: int, following: _Following) -> TargetRecord:
        rows = slice(self.bounds[target], self.bounds[target + 1])
        time, paired = self.time[rows], self.paired[rows]
        interval = np.diff(time)
        interval[interval > self.longest] = 0.0
        covered = float(paired.mean())
        names = self.moments.track_names
        squared = following.distance**2
        return TargetRecord(
            target=self.moments.target_names[target],
            first_time=float(time[0]),
            last_time=float(time[-1]),
            time_present=float(interval.sum()),
            time_tracked=float(interval[paired[1:] & paired[:-1]].sum()),
            positions=time.size,
            tracked_positions=int(paired.sum()),
            covered=covered,
            completeness=_completeness(covered),
            rmse=float(np.sqrt(squared.mean())) if squared.size else None,
            switches=following.switches,
            fragmentations=following.fragmentations,
            tracks=tuple(names[track] for track in dict.fromkeys(following.track.tolist())),
        )


def _completeness(covered: float) -> str:
    if covered >= TRACKED_SHARE:
        return MOSTLY_TRACKED
    return PARTLY_TRACKED if covered >= LOST_SHARE else MOSTLY_LOST
