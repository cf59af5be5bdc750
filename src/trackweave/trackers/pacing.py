"""Keeping a deadline: what a step takes is learned, and the tree grows no larger than fits."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from time import perf_counter
from typing import Any

import numpy as np

from trackweave.association.problem import Answer
from trackweave.association.tree import AssociationTree
from trackweave.solvers.protocol import Stop

__all__ = ["Pace", "Pacer"]

AIM = 0.87
"""The part of a deadline that is planned with; the rest is for what nobody foresees."""
REMEMBERED, GUESSES = 15, 3
"""Steps of which times are remembered, and guesses that stand for as many at first."""
SEARCH = 0.5
"""The part of what a search usually takes that a tree is planned with: it can be told to stop."""
BASE = 1_000
"""What a step does for its tracks and reports takes as long as so many sequences."""
FEWEST = 3
"""A tree is planned with no fewer sequences for each beginning, however short the deadline:
without them tracks would be lost, and little time gained."""
SLOW = 1e-6
"""What a part takes per sequence before anything was measured [s]."""


@dataclass(frozen=True, slots=True)
class _Rate:
    """How long a part of a step takes per sequence [s], as in the last steps."""

    last: tuple[float, ...]
    usual: float
    most: float

    @classmethod
    def guessed(cls, guess: float = SLOW) -> "_Rate":
        """Return a guess, which counts as several steps: the first may load kernels."""
        return cls((guess,) * GUESSES, guess, guess)

    def learned(self, seconds: float, n_sequences: int) -> "_Rate":
        """Return what is known once it took so long for so many sequences."""
        last = (*self.last, seconds / (n_sequences + BASE))[-REMEMBERED:]
        ordered = sorted(last)
        # The median and nearly the longest, which no single step can move far.
        return _Rate(last, ordered[len(ordered) // 2], ordered[-2])

    def time(self, n_sequences: int) -> float:
        """Return how long it takes at most for so many sequences [s]."""
        return self.most * (n_sequences + BASE)


@dataclass(slots=True)
class Pacer:
    """What the parts of a tracker's steps take: growth, search, what follows, and a late stop."""

    growth: _Rate = field(default_factory=_Rate.guessed)
    search: _Rate = field(default_factory=_Rate.guessed)
    rest: _Rate = field(default_factory=_Rate.guessed)
    overrun: _Rate = field(default_factory=lambda: _Rate.guessed(SLOW / 10.0))

    def at_rest(self) -> dict[str, Any]:
        """Return what a checkpoint holds: how fast the machine is, the next one has to learn."""
        fresh = Pacer()
        return {each.name: getattr(fresh, each.name) for each in fields(fresh)}

    def start(self, deadline: float | None, stop: Stop | None) -> "Pace":
        """Return a step that begins now; the deadline is the seconds that it may take."""
        now = perf_counter()
        end = np.inf if deadline is None else now + AIM * float(deadline)
        return Pace(self, end, stop, last=now)


@dataclass(slots=True)
class Pace:
    """One step against the clock."""

    pacer: Pacer
    """Learns from this step."""
    end: float
    """When the step is to be over, by the clock of ``perf_counter`` [s]."""
    stop: Stop | None
    last: float
    """When the last part of it was over [s]."""
    stopped: float | None = None
    """When the search was first told to stop [s]; None while it was not."""

    @property
    def is_timed(self) -> bool:
        """Whether the step has a deadline."""
        return bool(np.isfinite(self.end))

    @contextmanager
    def growth(self, tree: AssociationTree, n_reports: int, n_scans: int = 1) -> Iterator[None]:
        """Let a tree grow no larger than the clock allows, and take in how long it took."""
        self._lap()
        n_before, n_scans = tree.n_nodes, max(1, n_scans)
        tree.limit(self._room(tree, n_reports, n_scans))
        yield
        self.pacer.growth = self.pacer.growth.learned(
            self._lap() / n_scans, n_before + tree.n_nodes
        )

    def _room(self, tree: AssociationTree, n_reports: int, n_scans: int) -> int:
        """Return how many sequences there may be: fewer where the clock allows no more."""
        if not self.is_timed:
            return tree.limits.max_nodes
        pacer = self.pacer
        # Growth cannot be told to stop, and how much is proposed differs from scan to scan.
        growth = n_scans * (pacer.growth.usual + pacer.growth.most) / 2
        each = growth + SEARCH * pacer.search.usual + pacer.overrun.usual + pacer.rest.most
        left = self.end - self.last - growth * (tree.n_nodes + BASE)
        fits = max(FEWEST * (tree.n_families + n_reports), left / each - BASE, 1)
        # The lesser first: a deadline of ages is no whole number.
        return int(min(tree.limits.max_nodes, fits))

    def gap_of(self, answer: Answer) -> float | None:
        """Return the gap that a search left open because it had to stop; None without a clock."""
        if not self.is_timed:
            return None
        return answer.certificate.gap if answer.stop_reason == "stopped" else 0.0

    def alarm(self, n_sequences: int) -> Stop | None:
        """Return what tells a search among so many sequences to stop; None for nothing."""
        if not self.is_timed:
            return self.stop
        pacer = self.pacer
        last = self.end - pacer.rest.time(n_sequences) - pacer.overrun.time(n_sequences)

        def is_due() -> bool:
            now = perf_counter()
            due = now >= last or (self.stop is not None and self.stop())
            if due and self.stopped is None:
                # Whichever came first: the clock, or what else may end the search.
                self.stopped = max(min(last, now), self.last)
            return due

        return is_due

    def searched(self, n_sequences: int) -> None:
        """Take in that the search is over."""
        took = self._lap()
        pacer = self.pacer
        if self.stopped is None:
            pacer.search = pacer.search.learned(took, n_sequences)
            return
        overrun = self.last - self.stopped
        if overrun < took:
            # Told to stop before it began, it takes the least time that there is.
            pacer.overrun = pacer.overrun.learned(overrun, n_sequences)
        # It would have taken longer; how much nobody knows.
        usual = pacer.search.usual * (n_sequences + BASE)
        pacer.search = pacer.search.learned(max(took, usual), n_sequences)

    def done(self, n_sequences: int) -> None:
        """Take in that the step is over."""
        self.pacer.rest = self.pacer.rest.learned(self._lap(), n_sequences)

    def _lap(self) -> float:
        """Return the seconds since the last part was over, and begin the next."""
        before, self.last = self.last, perf_counter()
        return self.last - before
