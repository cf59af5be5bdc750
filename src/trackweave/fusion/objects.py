"""Lasting numbers of objects, and what changed of them."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from trackweave.arrays import IntArray
from trackweave.fusion._statistic import Form, Rings, evaluate_all

__all__ = ["Change", "Evidence", "Renumbering", "described", "renumber"]


@dataclass(frozen=True, slots=True)
class Change:
    """What became of an object.

    It has "begun" of tracks that had none, "ended" with no track left, "merged" with tracks of
    ``others``, or "split" into ``others``; the reason is in words. ``statistic`` is λ of the
    tracks in question together and ``threshold`` what it was compared with; NaN where there is
    none to name.
    """

    kind: Literal["begun", "ended", "merged", "split"]
    object: int
    others: tuple[int, ...]
    reason: str
    statistic: float = float("nan")
    threshold: float = float("nan")


@dataclass(frozen=True, slots=True, eq=False)
class Renumbering:
    """New numbers of live tracks, and which objects changed.

    ``object`` is that of each live track. Objects have ``begun``, are back, or have none left;
    ``merged`` and ``split`` tell of objects which others their tracks came from, or went to. The
    next new object gets ``next_number``.
    """

    object: IntArray
    begun: tuple[int, ...]
    returned: tuple[int, ...]
    ended: tuple[int, ...]
    merged: dict[int, tuple[int, ...]]
    split: dict[int, tuple[int, ...]]
    next_number: int


def renumber(label: IntArray, held: IntArray, before: IntArray, next_number: int) -> Renumbering:
    """Return objects' numbers for groups: each keeps that of most of its tracks, no two one."""
    # ``held`` is the number of the object that each track had before, -1 for none; ``before`` are
    # the objects that had live tracks.
    had = np.flatnonzero(held >= 0)
    pairs, count = np.unique(np.stack([label[had], held[had]], axis=1), axis=0, return_counts=True)
    number = np.full(int(label.max(initial=-1)) + 1, -1, dtype=np.int64)
    taken: set[int] = set()
    # Most tracks first, then the oldest object.
    for place in np.lexsort((pairs[:, 0], pairs[:, 1], -count)):
        group, old = pairs[place].tolist()
        if number[group] < 0 and old not in taken:
            number[group] = old
            taken.add(old)
    new = np.flatnonzero(number < 0)
    number[new] = next_number + np.arange(new.shape[0])
    merged: dict[int, tuple[int, ...]] = {}
    split: dict[int, tuple[int, ...]] = {}
    moved = number[pairs[:, 0]] != pairs[:, 1]
    for group, old in pairs[moved].tolist():
        now = int(number[group])
        if np.count_nonzero(pairs[:, 0] == group) > 1:
            merged[now] = (*merged.get(now, ()), old)
        if np.count_nonzero(pairs[:, 1] == old) > 1:
            split[old] = (*split.get(old, ()), now)
    live = np.unique(held[had])
    return Renumbering(
        object=number[label],
        begun=tuple(number[np.setdiff1d(new, pairs[:, 0])].tolist()),
        returned=tuple(np.setdiff1d(live, before).tolist()),
        ended=tuple(np.setdiff1d(before, live).tolist()),
        merged=merged,
        split=split,
        next_number=next_number + new.shape[0],
    )


class Evidence(NamedTuple):
    """What tells whether tracks fit together.

    ``form`` is the statistic with the threshold for what is held, ``row`` and ``held`` are the
    live tracks' rows and objects until now; ``times`` says how often pairings had to come out.
    """

    rings: Rings
    form: Form
    row: IntArray
    held: IntArray
    times: str

    def of(self, places: IntArray) -> tuple[float, float]:
        """Return the statistic and the threshold of some live tracks together."""
        value, limit = np.empty((2, 1))
        evaluate_all(self.rings, self.form, self.row[places][None], value, limit)
        return float(value[0]), float(limit[0])


def described(new: Renumbering, evidence: Evidence) -> tuple[Change, ...]:
    """Return what became of objects: begun, merged, split, ended."""
    return (
        *(Change("begun", number, (), "no object fits its tracks") for number in new.begun),
        *(Change("begun", number, (), "its tracks are back") for number in new.returned),
        *_merged(new, evidence),
        *_split(new, evidence),
        *(Change("ended", number, (), "none of its tracks is left") for number in new.ended),
    )


def _merged(new: Renumbering, evidence: Evidence) -> Iterator[Change]:
    for number, others in new.merged.items():
        value, limit = evidence.of(np.flatnonzero(new.object == number))
        reason = f"λ = {value:.1f} of the tracks together is within {limit:.1f}{evidence.times}"
        yield Change("merged", number, others, reason, value, limit)


def _split(new: Renumbering, evidence: Evidence) -> Iterator[Change]:
    for number, others in new.split.items():
        value, limit = evidence.of(np.flatnonzero(evidence.held == number))
        reason = f"λ = {value:.1f} of its tracks together exceeds {limit:.1f}"
        if value <= limit:
            reason = f"its tracks fit others better (λ = {value:.1f}, within {limit:.1f})"
        yield Change("split", number, others, f"{reason}{evidence.times}", value, limit)
