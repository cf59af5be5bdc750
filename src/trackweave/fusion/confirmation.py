"""Declaring a pairing only when it came out often enough: the N-of-M rule."""

from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np

from trackweave.arrays import IntArray
from trackweave.errors import InvalidInputError
from trackweave.fields import settle

__all__ = ["Confirmation"]

_Pairing = TypeVar("_Pairing", bound=Hashable)


@dataclass(frozen=True, slots=True)
class Confirmation:
    """A pairing is declared when it came out N times in M successive associations [1]_.

    The document names 2/3, 3/4, 4/5 and 6/8.

    Parameters
    ----------
    needed
        N: more than half of ``of``, so that no two pairings of one track can both be declared.
    of
        M, at least 1.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    References
    ----------
    .. [1] Huo, Zhang, Bai, Song, Xiong, 2008, section 2.5.

    Examples
    --------
    >>> import trackweave as tw
    >>> rule = tw.Confirmation.parse("2/3")
    >>> rule
    Confirmation(needed=2, of=3)
    >>> sorted(rule.declared([{("A1", "B7")}, set(), {("A1", "B7"), ("A2", "B4")}]))
    [('A1', 'B7')]
    """

    needed: int = 3
    of: int = 4

    def __post_init__(self) -> None:
        settle(self)
        if not self.needed <= self.of:
            raise InvalidInputError(
                f"needed, of: {self.needed!r:.80}, {self.of!r:.80}; expected whole numbers N ≤ M"
            )
        if not 2 * self.needed > self.of:
            raise InvalidInputError(
                f"needed, of: {self.needed} of {self.of}; expected more than half, "
                "or two pairings of one track could both be declared"
            )

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the rule that a text such as "3/4" names.

        Parameters
        ----------
        text
            N, a slash and M.

        Returns
        -------
        The rule.

        Raises
        ------
        InvalidInputError
            If it is no such text, or the numbers are out of range.
        """
        needed, slash, of = str(text).partition("/")
        if not slash or not needed.strip().isdigit() or not of.strip().isdigit():
            raise InvalidInputError(f"confirm: {text!r:.80}; expected N/M, such as 3/4")
        return cls(int(needed), int(of))

    def declared(self, outcomes: Sequence[Iterable[_Pairing]]) -> frozenset[_Pairing]:
        """Return the pairings that are declared after so many associations.

        Parameters
        ----------
        outcomes
            What each association paired, the latest last; earlier ones than the last M do not
            count.

        Returns
        -------
        What came out in at least N of the last M.
        """
        last = outcomes[-self.of :]
        count = Counter(pairing for outcome in last for pairing in set(outcome))
        return frozenset(pairing for pairing, times in count.items() if times >= self.needed)

    def declared_groups(self, label: IntArray, sensor: IntArray) -> IntArray:
        """Return the groups that are declared, where tracks come and go.

        Two tracks are declared of one object when they came out together N times; a group is
        what hangs together so, with one track of a sensor at most.

        Parameters
        ----------
        label
            Group of each track in each of the last associations, -1 where it was not live,
            shape (associations, tracks).
        sensor
            Sensor of each track, shape (tracks,).

        Returns
        -------
        Group of each track, numbered from 0, shape (tracks,).
        """
        n_tracks = label.shape[1]
        pairs, count = _together(label[-self.of :], n_tracks)
        often = np.flatnonzero(count >= self.needed)
        group = np.arange(n_tracks)
        members = {track: [track] for track in range(n_tracks)}
        # The surest pairs first: a later one that would put two tracks of a sensor together is not
        # declared.
        for pair in often[np.argsort(-count[often], kind="stable")]:
            a, b = group[pairs[0, pair]], group[pairs[1, pair]]
            both = members[a] + members[b]
            if a != b and len({int(sensor[track]) for track in both}) == len(both):
                members[a] = both
                group[members.pop(b)] = a
        return np.unique(group, return_inverse=True)[1].reshape(-1).astype(np.int64)


def _together(label: IntArray, n_tracks: int) -> tuple[IntArray, IntArray]:
    """Return the pairs of tracks that ever were together, and how often."""
    keys = []
    for row in label:
        order = np.argsort(row, kind="stable")
        order = order[row[order] >= 0]
        # Pairs at distance 1, 2, … in order of groups, until no group is that large.
        for gap in range(1, n_tracks):
            first, second = order[:-gap], order[gap:]
            same = row[first] == row[second]
            if not np.any(same):
                break
            low, high = np.minimum(first, second)[same], np.maximum(first, second)[same]
            keys.append(low * n_tracks + high)
    key, count = np.unique(np.concatenate([np.empty(0, np.int64), *keys]), return_counts=True)
    return np.stack([key // n_tracks, key % n_tracks]), count.astype(np.int64)
