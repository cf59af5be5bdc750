"""What tuples of plots a solver chooses from, and what its choice says."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association.plots_rule import PlotsRule, ScoredTuples
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.association.sensor_plots import SensorPlots
from trackweave.domain.scans import Scan

__all__ = ["every_set", "identities_of", "numbered_scans", "objects_in", "worth_choosing"]

MOST_COMBINED = 6
"""Up to so many sensors, a fused sensor is made for every set of them."""


def worth_choosing(
    tuples: ScoredTuples, plots: Sequence[SensorPlots], rule: PlotsRule
) -> ScoredTuples:
    """Return the tuples of which a solver chooses, with the prices of plots left alone."""
    # By evidence a plot left alone is free, so that one that costs more as an object is none. By
    # equation 1 lone bearings have their price as lone positions have. Rows of single plots in
    # what is returned are prices of plots left alone.
    if rule.cost == "evidence":
        stands = (np.count_nonzero(tuples.tuples, axis=1) > 1) | (tuples.costs < 0.0)
        return _rows_of(tuples, np.flatnonzero(stands))
    if not rule.lone_plots:
        return tuples
    rows, prices = [], []
    for number, own in enumerate(plots):
        if not own.is_bearing:
            continue
        others = [p.detection_probability for k, p in enumerate(plots) if k != number]
        missed = -sum(math.log1p(-chance) for chance in others)
        noise = np.broadcast_to(np.asarray(own.sigma, dtype=np.float64), own.value.shape)
        price = np.log(math.sqrt(2.0 * math.pi) * noise / own.detection_probability)
        row = np.zeros((own.value.shape[0], len(plots)), dtype=np.int64)
        row[:, number] = 1 + np.arange(row.shape[0])
        rows.append(row)
        prices.append(price - np.log(np.asarray(own.volume, dtype=np.float64)) + missed)
    n_lone = sum(row.shape[0] for row in rows)
    nowhere = np.full((n_lone, *tuples.positions.shape[1:]), np.nan)
    unsure = np.full((n_lone, *tuples.covariances.shape[1:]), np.nan)
    return replace(
        tuples,
        tuples=np.concatenate([tuples.tuples, *rows]),
        costs=np.concatenate([tuples.costs, *prices]),
        positions=np.concatenate([tuples.positions, nowhere]),
        covariances=np.concatenate([tuples.covariances, unsure]),
    )


def _rows_of(tuples: ScoredTuples, rows: IntArray) -> ScoredTuples:
    return replace(
        tuples,
        tuples=tuples.tuples[rows],
        costs=tuples.costs[rows],
        positions=tuples.positions[rows],
        covariances=tuples.covariances[rows],
    )


def objects_in(
    tuples: ScoredTuples, problem: AssignmentProblem, answer: Answer, rule: PlotsRule
) -> IntArray:
    """Return the ascending rows of tuples that are objects: chosen, or lone plots that stand."""
    assert problem.row is not None
    chosen = problem.row[answer.nodes]
    if rule.cost == "evidence":
        is_lone = np.count_nonzero(tuples.tuples, axis=1) == 1
        for column in range(tuples.tuples.shape[1]):
            taken = tuples.tuples[chosen, column]
            is_lone &= ~np.isin(tuples.tuples[:, column], taken[taken > 0])
        chosen = np.concatenate([chosen, np.flatnonzero(is_lone)])
    return np.sort(chosen)


def identities_of(scans: Sequence[Scan], tuples: IntArray) -> IntArray | None:
    """Return whom each tuple is of by its plots, -1 for nobody; None where no scan says any."""
    # Where plots name several, it is nobody. Tuples hold 1-based numbers of plots, 0 for none,
    # shape (tuples, scans).
    if all(scan.identity is None for scan in scans):
        return None
    least = np.full(tuples.shape[0], np.iinfo(np.int64).max)
    greatest = np.full(tuples.shape[0], -1)
    for column, scan in enumerate(scans):
        if scan.identity is None:
            continue
        said = np.where(
            tuples[:, column] > 0, np.append(scan.identity, -1)[tuples[:, column] - 1], -1
        )
        least = np.where(said >= 0, np.minimum(least, said), least)
        greatest = np.maximum(greatest, said)
    return np.where(least == greatest, greatest, -1)


def numbered_scans(scans: list[Scan]) -> list[Scan]:
    """Return scans whose reports all have numbers."""
    following = 1 + max(int(scan.report.max(initial=-1)) for scan in scans)
    numbered = []
    for scan in scans:
        without = np.flatnonzero(scan.report < 0)
        report = scan.report.copy()
        report[without] = following + np.arange(without.shape[0])
        following += without.shape[0]
        numbered.append(replace(scan, report=report))
    return numbered


def every_set(names: Sequence[str]) -> list[tuple[str, ...]]:
    """Return the sets of sensors that may look together, the largest first."""
    if len(names) > MOST_COMBINED:
        return [tuple(names)]
    return [s for n in range(len(names), 0, -1) for s in itertools.combinations(names, n)]
