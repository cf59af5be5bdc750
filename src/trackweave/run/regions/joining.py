"""One picture of what regions found: one name for each object, each row by its owner."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.tracks import CONFIRMED, TENTATIVE, TrackTable
from trackweave.run.regions.cutting import Region

__all__ = [
    "SHARE",
    "Found",
    "Key",
    "Span",
    "grouped",
    "joined_rows",
    "owned_tracks",
    "same_objects",
]

SHARE = 0.5
"""Tracks of two regions are one object's if they share at least so much of the reports that
either has where both regions look."""

Key = tuple[int, int]
"""A region, and a track's own number there."""
Span = tuple[float, float]
"""From when until when a track has reports [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """What a region found: its own tracks of the reports that it looked at."""

    region: Region
    number: int
    rows: IntArray  # The numbers of its reports, ascending
    track: IntArray  # Of each, -1 for none
    tracks: TrackTable


def same_objects(parts: Sequence[Found], time: FloatArray) -> list[list[Key]]:
    """Return which tracks of different regions are of one object, each track once.

    ``time`` is that of every report [s]. Pairs are joined from those that share most reports
    down; two tracks of one region are never of one object while both have reports. A report is
    of one track in a region, so that true pairs hardly compete, and pairs chain over borders.

    Returns
    -------
    The tracks of each object.
    """
    spans = {key: span for part in parts for key, span in _spans(part, time).items()}
    pairs = [pair for n, one in enumerate(parts) for two in parts[n + 1 :]
             for pair in _pairs(one, two)]  # fmt: skip
    group = grouped(pairs, spans)
    return [members for key, members in group.items() if members[0] == key]


def grouped(
    pairs: Iterable[tuple[int, Key, Key]], spans: Mapping[Key, Span]
) -> dict[Key, list[Key]]:
    """Return with which others each track is of one object.

    ``pairs`` are those that share enough reports, and how many; ``spans`` are of all tracks.

    Returns
    -------
    A list for each track, the same one for all of an object.
    """
    group = {key: [key] for key in spans}
    for _, one, two in sorted(pairs, key=lambda pair: (-pair[0], pair[1], pair[2])):
        first, second = group[one], group[two]
        if first is second or _at_odds(first, second, spans):
            continue
        first += second
        for key in second:
            group[key] = first
    return group


def _spans(part: Found, time: FloatArray) -> dict[Key, Span]:
    """Return from when until when each track of a region has reports [s]."""
    own = np.flatnonzero(part.track >= 0)
    names, place = np.unique(part.track[own], return_inverse=True)
    begin, end = np.full(names.size, np.inf), np.full(names.size, -np.inf)
    np.minimum.at(begin, place, time[part.rows[own]])
    np.maximum.at(end, place, time[part.rows[own]])
    each = zip(names.tolist(), begin.tolist(), end.tolist(), strict=True)
    return {(part.number, name): (first, last) for name, first, last in each}


def _pairs(one: Found, two: Found) -> list[tuple[int, Key, Key]]:
    """Return the tracks of two regions that share enough reports, and how many they share."""
    _, first, second = np.intersect1d(one.rows, two.rows, True, return_indices=True)
    a, b = one.track[first], two.track[second]
    most_a, most_b = np.bincount(a[a >= 0]), np.bincount(b[b >= 0])
    both = (a >= 0) & (b >= 0)
    if not both.any():
        return []
    pairs, count = np.unique(np.stack([a[both], b[both]], axis=1), axis=0, return_counts=True)
    fewest = np.minimum(most_a[pairs[:, 0]], most_b[pairs[:, 1]])
    enough = count >= SHARE * fewest
    return [
        (shared, (one.number, left), (two.number, right))
        for shared, (left, right) in zip(
            count[enough].tolist(), pairs[enough].tolist(), strict=True
        )
    ]


def _at_odds(first: Sequence[Key], second: Sequence[Key], spans: Mapping[Key, Span]) -> bool:
    """Tell whether a region has tracks in both that have reports at the same time."""
    return any(
        one[0] == two[0] and spans[one][0] <= spans[two][1] and spans[two][0] <= spans[one][1]
        for one in first
        for two in second
    )


def joined_rows(
    parts: Sequence[Found], name: Mapping[Key, int], dim: int
) -> tuple[TrackTable, IntArray]:
    """Return the rows of all objects by time, then name, and the region of each.

    A row is its region's in which it lies. Where each of two regions has an object on the
    other's side, the row that lies less far outside counts; a row outside its region that no
    other region knows does not.

    Returns
    -------
    The rows, and the number of a region for each.
    """
    tables, away, owner = [TrackTable.empty(dim)], [np.empty(0)], [np.empty(0, np.int64)]
    for part in parts:
        own = part.tracks.track.tolist()
        known = np.array([name.get((part.number, each), -1) for each in own], dtype=np.int64)
        tables.append(replace(part.tracks, track=known))
        away.append(part.region.distance(part.tracks.mean[:, :2]))
        owner.append(np.full(len(known), part.number))
    table, outside = TrackTable.concatenate(tables, dim), np.concatenate(away)
    region = np.concatenate(owner)
    order = np.lexsort((region, outside, table.track, table.time))
    order = order[table.track[order] >= 0]
    time, track = table.time[order], table.track[order]
    begins = np.r_[True, (time[1:] != time[:-1]) | (track[1:] != track[:-1])][: order.size]
    first = np.flatnonzero(begins)
    count = np.diff(np.r_[first, order.size])
    kept = order[first[(outside[order[first]] == 0.0) | (count > 1)]]
    return _believed(table.at(kept)), region[kept]


def _believed(table: TrackTable) -> TrackTable:
    """Return rows, in order of time, in which what was once confirmed is not tentative again."""
    # A region has yet to confirm what comes into it; its neighbour has.
    since = np.full(int(table.track.max(initial=0)) + 1, np.inf)
    sure = table.status != TENTATIVE
    np.minimum.at(since, table.track[sure], table.time[sure])
    known = (table.status == TENTATIVE) & (table.time >= since[table.track])
    return replace(table, status=np.where(known, CONFIRMED, table.status))


def owned_tracks(
    parts: Sequence[Found], owner: IntArray, scan: IntArray, name: Mapping[Key, int]
) -> IntArray:
    """Return the name of the object of each report, -1 for none, as its region has it.

    ``owner`` is the region in which each report lies, ``scan`` its scan's number. Where two
    regions have given one object two reports of a scan, the report counts of the region that
    gave it the last one before.

    Returns
    -------
    Names, shape (reports,).
    """
    found = np.full(owner.size, -1, dtype=np.int64)
    for part in parts:
        mine = np.flatnonzero(owner[part.rows] == part.number)
        own = [name.get((part.number, each), -1) for each in part.track[mine].tolist()]
        found[part.rows[mine]] = own
    taken = np.flatnonzero(found >= 0)
    order = taken[np.lexsort((owner[taken], scan[taken], found[taken]))]
    same = (found[order[1:]] == found[order[:-1]]) & (scan[order[1:]] == scan[order[:-1]])
    for place in np.flatnonzero(same).tolist():
        one, two = int(order[place]), int(order[place + 1])
        before = order[:place][found[order[:place]] == found[two]] if place else order[:0]
        is_second = before.size > 0 and owner[before[-1]] == owner[two]
        found[one if is_second else two] = -1
    return found
