"""Which tracks of different regions are of one object, by what was reported so far."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np

from trackweave.arrays import IntArray
from trackweave.run.regions.joining import SHARE, Key, Span, grouped

__all__ = ["Given", "SharedTracks"]

Pair = tuple[Key, Key]


class Given(NamedTuple):
    """Some of a region's reports and the tracks that they are given to, -1 for none."""

    report: IntArray
    track: IntArray


@dataclass(slots=True)
class SharedTracks:
    """Objects as a recording's regions join them, but that only what has come so far counts.

    Names need no counting over regions: each has every so-manieth number for its own tracks. An
    object has that of the track that was there first, so that it keeps it over every border.
    """

    count: int
    """How many regions there are."""
    kept: dict[Key, int] = field(default_factory=dict)
    """Names that were given before there were these regions."""
    newest_kept: int = 0
    shared: dict[Pair, int] = field(default_factory=dict)
    """How many reports two tracks both have, finally."""
    looked: dict[tuple[Key, int], int] = field(default_factory=dict)
    """How many a track has where another region looks as well."""
    spans: dict[Key, Span] = field(default_factory=dict)
    """From when until when each track has reports that are final [s]."""
    born: dict[Key, int] = field(default_factory=dict)
    """The step at which its region first told of each track."""
    objects: dict[Key, int] = field(default_factory=dict)
    """The name of each track that is of one object with another."""
    confirmed: set[int] = field(default_factory=set)
    """Names of objects that some region has once confirmed."""

    def name(self, key: Key) -> int:
        """Return the name of a track's object."""
        return self.objects.get(key) or self._own_name(key)

    def _own_name(self, key: Key) -> int:
        if key in self.kept:
            return self.kept[key]
        region, track = key
        return self.newest_kept + (track - 1) * self.count + region + 1

    def keep(self, region: int, tracks: Sequence[int]) -> None:
        """Keep the names with which tracks of a region set out."""
        self.kept |= {(region, track): track for track in tracks}
        self.newest_kept = max(self.newest_kept, *tracks, 0)

    def settle(self, final: Sequence[Given], time: Mapping[int, float]) -> None:
        """Count what is final, by region; ``time`` is that of each report [s]."""
        shared, looked = self._counted(final)
        self.shared, self.looked = dict(shared), dict(looked)
        self.spans = _spans(final, time, self.spans)

    def join(self, open_: Sequence[Given], time: Mapping[int, float]) -> None:
        """Find what is of one object, with what may still change of reports that are shared."""
        shared, looked = self._counted(open_)
        pairs = [
            (count, one, two)
            for (one, two), count in shared.items()
            if count >= SHARE * min(looked[one, two[0]], looked[two, one[0]])
        ]
        keys = sorted({key for _, one, two in pairs for key in (one, two)})
        known = {key: self.spans[key] for key in keys if key in self.spans}
        spans = _spans(open_, time, known)
        group = grouped(pairs, spans)
        self.objects = {}
        for key in keys:
            first = min(group[key], key=lambda each: (self.born[each], self._own_name(each)))
            self.objects[key] = self._own_name(first)

    def _counted(self, parts: Sequence[Given]) -> tuple[Counter[Pair], Counter[tuple[Key, int]]]:
        """Return how many reports tracks share, and have where another region looks, by now."""
        shared, looked = Counter(self.shared), Counter(self.looked)
        for (i, one), (j, two) in combinations(enumerate(parts), 2):
            _, first, second = np.intersect1d(one.report, two.report, True, return_indices=True)
            tracks = zip(one.track[first].tolist(), two.track[second].tolist(), strict=True)
            for a, b in tracks:
                if a >= 0:
                    looked[(i, a), j] += 1
                if b >= 0:
                    looked[(j, b), i] += 1
                if a >= 0 and b >= 0:
                    shared[(i, a), (j, b)] += 1
        return shared, looked

    def forget(self, alive: Iterable[Key]) -> None:
        """Leave out objects of which no track is alive any more."""
        alive = set(alive)
        names = {self.name(key) for key in alive}
        gone = {
            key for key in {*self.born, *self.spans}
            if key not in alive and self.name(key) not in names
        }  # fmt: skip
        for key in gone:
            self.spans.pop(key, None)
            self.born.pop(key, None)
            self.objects.pop(key, None)
        for pair in [pair for pair in self.shared if pair[0] in gone or pair[1] in gone]:
            del self.shared[pair]
        for one in [one for one in self.looked if one[0] in gone]:
            del self.looked[one]
        self.confirmed &= names


def _spans(
    parts: Sequence[Given], time: Mapping[int, float], known: Mapping[Key, Span]
) -> dict[Key, Span]:
    """Return from when until when tracks have reports [s], with what was known."""
    spans = dict(known)
    for region, part in enumerate(parts):
        for report, track in zip(part.report.tolist(), part.track.tolist(), strict=True):
            if track >= 0:
                first, last = spans.get((region, track), (np.inf, -np.inf))
                at = time[report]
                spans[region, track] = min(first, at), max(last, at)
    return spans
