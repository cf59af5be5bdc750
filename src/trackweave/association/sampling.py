"""How probable each tuple of plots is, all plots considered together, by drawing answers.

Belief propagation is too sure of itself here: tuples of many sensors share plots in many short
loops. Answers drawn by their probability have no such error, only that of their number.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trackweave.arrays import (
    FloatArray,
    IntArray,
    int_array,
    require_instance,
)
from trackweave.association._sampling import (
    MOST_SWAPPED,
    Partition,
    Scratch,
    TupleIndex,
    fill_keys,
    list_near,
    record,
    sweep,
    take_rows,
)
from trackweave.association.plots_rule import ScoredTuples
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.randomness import RandomSource, generator_of
from trackweave.summaries import summary

__all__ = ["Draws", "Sampling"]

MARK_BITS = 62
RENEWAL = 0.05
"""Share of moves that renew a set from all tuples of a plot; they take longer than others."""


@dataclass(frozen=True, slots=True, eq=False)
class Draws:
    """Answers drawn by their probability.

    Parameters
    ----------
    answers
        The rows of the tuples of each, in ascending order.
    probability
        Of each tuple, that exactly its plots are one object's, shape (tuples,): the share of
        answers with it.
    """

    answers: tuple[IntArray, ...]
    probability: FloatArray

    __repr__ = summary


@dataclass(frozen=True, slots=True)
class Sampling:
    """Draws answers to the question which plots are one object's, by their probability.

    An answer of cost c weighs exp(−c). One follows from another by small moves, each of them from
    its exact conditional distribution: a plot changes sets, two sets share their plots in
    another way, a set dissolves or forms at once (Gibbs sampling; see [1]_ for moves of its kind).

    Parameters
    ----------
    sweeps
        How many answers are drawn, with as many moves of each kind between two as there are
        plots; at least 1.
    warm_up
        Answers left out at the beginning; at least 0.
    margin
        Tuples that cost more than this are left out [nats].

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] Oh, Russell, Sastry, *Markov chain Monte Carlo data association for multi-target
       tracking*, 2009. doi:10.1109/TAC.2009.2012975

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> plots = [
    ...     tw.SensorPlots([[x, 0.0], [x + 500.0, 0.0]], sigma=10.0, volume=1e8, false_alarms=0.1)
    ...     for x in (0.0, 6.0)
    ... ]
    >>> found = tw.PlotsRule(object_density=1e-6)(plots)  # objects per m²
    >>> finder = tw.ObjectFinder(cutoff=50.0, sampling=tw.Sampling(sweeps=100))
    >>> finder(found, rng=np.random.default_rng(1)).group_probability.round(2)
    array([1., 1.])
    """

    sweeps: int = 500
    warm_up: int = 50
    margin: float = 6.0

    def __post_init__(self) -> None:
        settle(self)
        for name, least in (("sweeps", 1), ("warm_up", 0)):
            value = getattr(self, name)
            if value < least:
                raise InvalidInputError(
                    f"{name}: {value!r:.80}; expected a whole number ≥ {least}"
                )

    def __call__(
        self,
        scored: ScoredTuples,
        start: ArrayLike,
        *,
        rng: RandomSource = 0,
        stop: Callable[[], bool] | None = None,
    ) -> Draws:
        """Return answers drawn one from another.

        Parameters
        ----------
        scored
            The tuples. Those that cost more than leaving their plots alone count too: make them
            without ``negative_only`` where there is memory for it.
        start
            Rows of a good answer; no two may share a plot.
        rng
            Source of randomness: a generator, or a seed.
        stop
            Asked after each answer whether to stop with those drawn so far.

        Returns
        -------
        The answers, at least one.

        Raises
        ------
        InvalidInputError
            If rows of the start are none of the table's, or share a plot.
        """
        rng = generator_of(rng)
        rows = _checked_start(scored, start)
        number, index, alone_row = _index(scored, self.margin, rng)
        partition, scratch = _partition(index), _scratch(index)
        # Lone plots need not be told.
        several = number[: index.item.shape[0]]
        take_rows(index, partition, np.flatnonzero(np.isin(several, rows)))
        buffer = np.empty(index.sensor.shape[0], dtype=np.int64)
        answers: list[IntArray] = []
        for turn in range(self.warm_up + self.sweeps):
            sweep(index, partition, scratch, RENEWAL, rng)
            is_over = stop is not None and stop()
            if turn >= self.warm_up or is_over:
                n_rows = record(index, partition, alone_row, rng, buffer)
                answers.append(np.sort(number[buffer[:n_rows]]))
            if is_over:
                break
        counts = np.bincount(np.concatenate(answers), minlength=len(scored))
        return Draws(tuple(answers), counts / len(answers))


def _checked_start(scored: ScoredTuples, start: ArrayLike) -> IntArray:
    require_instance(scored, ScoredTuples, "scored")
    rows = int_array(start, "start", (None,))
    if np.any((rows < 0) | (rows >= len(scored))):
        raise InvalidInputError(f"start: {rows!r:.80}; expected rows of {len(scored)} tuples")
    for chosen in scored.tuples[rows].T:
        if np.any(np.bincount(chosen[chosen > 0]) > 1):
            raise InvalidInputError("start: tuples that share a plot; expected disjoint ones")
    return rows


def _index(
    scored: ScoredTuples, margin: float, rng: np.random.Generator
) -> tuple[IntArray, TupleIndex, IntArray]:
    """Return the rows that count, those of several plots first; their index; lone plots' rows."""
    n_plots = scored.tuples.max(axis=0, initial=0)
    first = np.concatenate([[0], np.cumsum(n_plots)])
    is_several = np.count_nonzero(scored.tuples, axis=1) > 1
    several = np.flatnonzero(is_several & (scored.costs <= margin))
    lone = np.flatnonzero(~is_several)
    # The cheapest last, so that it is the one that stays.
    lone = lone[np.argsort(-scored.costs[lone], kind="stable")]
    table = scored.tuples[several]
    item = np.where(table > 0, table + first[:-1] - 1, -1).astype(np.int64)
    alone, alone_row = np.zeros(first[-1]), np.full(first[-1], -1, dtype=np.int64)
    plot = (scored.tuples[lone] + first[:-1] - 1)[scored.tuples[lone] > 0]
    # A false alarm weighs one.
    alone[plot] = np.logaddexp(0.0, -scored.costs[lone])
    alone_row[plot] = several.shape[0] + np.arange(lone.shape[0])
    row, column = np.nonzero(item >= 0)
    order = np.argsort(item[row, column], kind="stable")
    rows, count = row[order], np.bincount(item[row, column], minlength=first[-1])
    row_start = np.concatenate([[0], np.cumsum(count)])
    size = 1 << max(4, int(3 * several.shape[0]).bit_length())
    index = TupleIndex(
        item=item,
        log_weight=-scored.costs[several],
        alone=alone,
        sensor=np.repeat(np.arange(n_plots.shape[0]), n_plots),
        mark=rng.integers(0, 1 << MARK_BITS, size=first[-1]),
        key=np.zeros(size, dtype=np.int64),
        row=np.full(size, -1, dtype=np.int64),
        row_start=row_start,
        rows=rows,
        near_start=np.zeros(first[-1] + 1, dtype=np.int64),
        near=np.empty(0, dtype=np.int64),
    )
    fill_keys(index.item, index.mark, index.key, index.row)
    near = list_near(index.item, index.row_start, index.rows, index.near_start)
    return np.concatenate([several, lone]), index._replace(near=near), alone_row


def _partition(index: TupleIndex) -> Partition:
    """Return the partition in which every plot is alone."""
    n_plots, n_sensors = index.sensor.shape[0], index.item.shape[1]
    member = np.full((n_plots, n_sensors), -1, dtype=np.int64)
    member[np.arange(n_plots), index.sensor] = np.arange(n_plots)
    return Partition(
        member=member,
        home=np.arange(n_plots),
        key=index.mark.copy(),
        size=np.ones(n_plots, dtype=np.int64),
        empty=np.zeros(n_plots + 1, dtype=np.int64),
        counter=np.zeros(2, dtype=np.int64),
    )


def _scratch(index: TupleIndex) -> Scratch:
    n_plots = index.sensor.shape[0]
    most = max(1 << MOST_SWAPPED, n_plots + 2, int(np.diff(index.row_start).max(initial=0)) + 1)
    return Scratch(
        choice=np.empty(most, dtype=np.int64),
        log_weight=np.empty(most),
        seen_at=np.full(n_plots, -1, dtype=np.int64),
        swapped=np.empty(MOST_SWAPPED, dtype=np.int64),
    )
