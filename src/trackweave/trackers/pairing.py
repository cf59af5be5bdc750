"""Which track takes which report of one scan."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import Certificate, Status

__all__ = ["Offers", "Pairing", "nearest", "one_to_one"]


@dataclass(frozen=True, slots=True, eq=False)
class Offers:
    """The reports that tracks may take, one row per pair, grouped by track in ascending order."""

    track: IntArray  # From 0, as reports are, shape (pairs,)
    report: IntArray
    cost: FloatArray  # What it costs that the track takes the report [nats]
    alone: FloatArray  # What it costs each track to take none [nats], shape (tracks,)
    n_reports: int  # One that no track takes costs nothing


@dataclass(frozen=True, slots=True, eq=False)
class Pairing:
    """What the tracks take."""

    taken: IntArray  # For each track the row of its pair, -1 for none, shape (tracks,)
    holder: IntArray  # For each report the track that it is said to be of, -1 for none
    # What the holders' pairs cost, against the best without a shared report.
    certificate: Certificate


def nearest(offers: Offers) -> Pairing:
    """Let every track take its cheapest report, whoever else takes it too."""
    # No offer costs a track more than to take none. A report that several tracks take is said to
    # be of the one to which it is cheapest, and only that pair counts in the cost; the bound is
    # what all the tracks take.
    n_tracks = offers.alone.shape[0]
    order = np.lexsort((offers.report, offers.cost, offers.track))
    track, first = np.unique(offers.track[order], return_index=True)
    taken = np.full(n_tracks, -1, dtype=np.int64)
    taken[track] = order[first]
    rows = taken[track]
    # From the dearest to the cheapest, so that the cheapest is the last to write.
    rows = rows[np.lexsort((offers.track[rows], offers.cost[rows]))[::-1]]
    holder = np.full(offers.n_reports, -1, dtype=np.int64)
    holder[offers.report[rows]] = offers.track[rows]
    holds = np.zeros(n_tracks, dtype=np.bool_)
    holds[holder[holder >= 0]] = True
    cost = _cost(offers, np.where(holds, taken, -1))
    if np.count_nonzero(holds) == rows.shape[0]:
        return Pairing(taken, holder, Certificate(cost, cost, Status.OPTIMAL))
    # No pairing is cheaper than one in which every track has what it likes best.
    return Pairing(taken, holder, Certificate(cost, _cost(offers, taken), Status.FEASIBLE))


def one_to_one(offers: Offers) -> Pairing:
    """Give each track at most one report and each report to at most one track, at least cost."""
    n_tracks, n_reports = offers.alone.shape[0], offers.n_reports
    taken = np.full(n_tracks, -1, dtype=np.int64)
    holder = np.full(n_reports, -1, dtype=np.int64)
    if offers.track.shape[0]:
        # A column of its own lets each track take none. Every row is matched once, so that a
        # shift of its weights changes nothing and keeps them off zero, which would be no edge.
        row = np.concatenate([offers.track, np.arange(n_tracks)])
        column = np.concatenate([offers.report, n_reports + np.arange(n_tracks)])
        weight = np.concatenate([offers.cost, offers.alone])
        least = np.full(n_tracks, np.inf)
        np.minimum.at(least, row, weight)
        shape = (n_tracks, n_reports + n_tracks)
        # SciPy takes longer to import than many a run takes.
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import min_weight_full_bipartite_matching

        graph = csr_array((weight - least[row] + 1.0, (row, column)), shape=shape)
        matched, given = min_weight_full_bipartite_matching(graph)
        is_report = given < n_reports
        holder[given[is_report]] = matched[is_report]
        rows = np.flatnonzero(holder[offers.report] == offers.track)
        taken[offers.track[rows]] = rows
    cost = _cost(offers, taken)
    return Pairing(taken, holder, Certificate(cost, cost, Status.OPTIMAL))


def _cost(offers: Offers, taken: IntArray) -> float:
    """Return what it costs that each track takes a pair, or none."""
    return float(offers.cost[taken[taken >= 0]].sum() + offers.alone[taken < 0].sum())
