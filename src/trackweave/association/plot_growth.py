"""Growing tuples of plots, as many as there may be."""

from collections.abc import Iterator

import numpy as np

from trackweave.association._plot_sets import Path, PlotLimits, PlotTable
from trackweave.association._plot_thinning import Choice
from trackweave.association._plot_views import Views
from trackweave.association._plots import DEPTH, DONE, FULL, N_ROWS, TupleRows, grow_sets

__all__ = ["grow_nearest", "grow_tuples"]

STEPS = 10_000
"""Steps of growth between two looks at what Python has to do: some milliseconds."""

THIN_STEPS = 2000
"""The same where each step may look at all plots of a sensor."""

FIRST_ROWS = 4096

STEPS_BESIDE = 4
"""Steps for each plot and tuple that there may be, beside one for each sensor, after which a
growth that is to be bounded gives up."""

SAMPLE = 64
"""Plots with which the sets of a sample begin."""


def grow_tuples(
    table: PlotTable,
    views: Views,
    limits: PlotLimits,
    max_tuples: int,
    max_steps: float = np.inf,
) -> TupleRows | None:
    """Return all tuples within the limits; None if there are more, or growing takes more steps."""
    # Of chains, each plot with its nearest alone, it is the first so many.
    n_sensors, dim = table.miss.shape[0], table.value.shape[1]
    path, choice = _new_path(n_sensors, dim), _new_choice(table, limits)
    rows = _new_rows(min(FIRST_ROWS, max_tuples + 1), n_sensors, dim)
    n_steps, at_once = 0, THIN_STEPS if limits.most else STEPS
    while (state := grow_sets(table, views, limits, path, choice, rows, at_once)) != DONE:
        n_steps += at_once
        n_rows = rows.cost.shape[0]
        if n_steps > max_steps or (state == FULL and n_rows > max_tuples):
            if not limits.is_chain:
                return None
            # Nothing is left to leave out: those of the first plots, in their order.
            return _resized(rows, min(int(path.counter[N_ROWS]), max_tuples))
        if state == FULL:
            rows = _resized(rows, min(2 * n_rows, max_tuples + 1))
    n_rows = int(path.counter[N_ROWS])
    return _resized(rows, n_rows)


def grow_nearest(
    table: PlotTable, views: Views, limits: PlotLimits, max_tuples: int
) -> tuple[TupleRows, bool]:
    """Return all tuples, or, if too many, those of the plots nearest to each other; and if all."""
    # Each set is grown by so many plots of each sensor, the nearest, that the tuples are few
    # enough: half as many again and again, at last one and no set without it, and of these sets
    # the first. A sample tells beforehand where they are far too many.
    n_plots, n_sensors = table.value.shape[0], table.miss.shape[0]
    max_steps = (n_sensors + STEPS_BESIDE) * (n_plots + max_tuples)
    stride = n_plots // SAMPLE
    for thinned in _thinner(table, limits):
        if stride > 1:
            # Far too many are twice too many: a sample is not sure.
            share = 2.0 / stride
            sample = thinned._replace(stride=stride)
            few, steps = int(share * max_tuples), share * max_steps
            if grow_tuples(table, views, sample, few, steps) is None:
                continue
        rows = grow_tuples(table, views, thinned, max_tuples, max_steps)
        if rows is not None:
            return rows, thinned.most == 0
    chains = limits._replace(most=1, is_chain=True)
    rows = grow_tuples(table, views, chains, max_tuples, max_steps)
    assert rows is not None
    return rows, False


def _thinner(table: PlotTable, limits: PlotLimits) -> Iterator[PlotLimits]:
    """Yield limits that let through less and less, beginning with everything."""
    yield limits
    most = int(np.diff(table.first).max()) // 2
    while most > 0:
        yield limits._replace(most=most)
        most //= 2


def _new_choice(table: PlotTable, limits: PlotLimits) -> Choice:
    n_sensors = table.miss.shape[0]
    longest = int(np.diff(table.first).max()) if limits.most else 0
    return Choice(
        near=np.zeros((n_sensors, limits.most), dtype=np.int64),
        has_grown=np.zeros(n_sensors, dtype=np.bool_),
        plot=np.zeros(longest, dtype=np.int64),
        distance=np.zeros(longest),
    )


def _new_path(n_sensors: int, dim: int) -> Path:
    counter = np.zeros(3, dtype=np.int64)
    counter[DEPTH] = -1
    whole = np.zeros((6, n_sensors), dtype=np.int64)
    real = np.zeros((5, n_sensors))
    return Path(
        counter=counter,
        plot=whole[0],
        sensor=whole[1],
        is_located=np.zeros(n_sensors, dtype=np.bool_),
        n_bearings=whole[2],
        cost=real[0],
        total=real[1],
        distance=real[2],
        log_information=real[3],
        mean=np.zeros((n_sensors, dim)),
        covariance=np.zeros((n_sensors, dim, dim)),
        next_sensor=whole[3],
        cursor=whole[4],
        stop=whole[5],
        weight=real[4],
        scratch=np.zeros((dim, dim)),
    )


def _new_rows(n_rows: int, n_sensors: int, dim: int) -> TupleRows:
    return TupleRows(
        plot=np.empty((n_rows, n_sensors), dtype=np.int64),
        cost=np.empty(n_rows),
        mean=np.empty((n_rows, dim)),
        covariance=np.empty((n_rows, dim, dim)),
    )


def _resized(rows: TupleRows, n_rows: int) -> TupleRows:
    """Return room for so many rows, with as many of the old ones as fit."""
    resized = _new_rows(n_rows, rows.plot.shape[1], rows.mean.shape[1])
    n_kept = min(n_rows, rows.cost.shape[0])
    for old, new in zip(rows, resized, strict=True):
        new[:n_kept] = old[:n_kept]
    return resized
