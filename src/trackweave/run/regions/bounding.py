"""The bound of all regions: that of all clusters, each counted by one region that owns it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import IntArray
from trackweave.association.certificate import Certificate, Status, relative_gap
from trackweave.run.regions.cutting import Region
from trackweave.trackers.clusters import Clusters

__all__ = ["UNKNOWN", "Owned", "owned", "together"]

UNKNOWN: dict[str, Any] = {
    "cost": None, "lower_bound": None, "gap": None, "status": Status.FEASIBLE, "cut_reports": None,
}  # fmt: skip
"""What a scan's entry says where a region was left out."""


SHARED = np.dtype(
    [
        ("reports", np.int64),  # Which they are, in one number
        ("cost", np.float64),  # [nats]
        ("count", np.int64),
        ("n_own", np.int64),
        ("is_first", np.bool_),  # Whether its first report is the region's own
    ]
)
"""A cluster that has reports of a region's own and others."""


@dataclass(frozen=True, slots=True, eq=False)
class Owned:
    """What a region's own clusters cost after a step."""

    cost: float  # Of those all of whose reports are its own [nats]
    slack: float  # How much less all that it tracks may cost at most [nats]
    status: Status
    shared: NDArray[np.void] = field(default_factory=lambda: np.empty(0, SHARED))


def owned(
    clusters: Clusters,
    certificate: Certificate,
    region: Region,
    rows: IntArray,
    is_own: NDArray[np.bool_],
) -> Owned:
    """Return what of a certificate is a region's own.

    ``rows`` is each report's number in the run, by its number in the region, and ``is_own`` tells
    whether it lies there. A cluster without reports, a track that goes unseen, is where it was
    seen last. The slack is that of all clusters together: of each alone it is not known.

    Returns
    -------
    The part of the whole that the region knows alone, and what it shares with others.
    """
    count = clusters.cost.shape[0]
    of_each = np.bincount(clusters.owner, minlength=count)
    inside = np.bincount(clusters.owner, is_own[clusters.report], count)
    is_whole = np.where(of_each > 0, inside == of_each, region.holds(clusters.place))
    shared = _shared(clusters, np.flatnonzero((inside > 0) & ~is_whole), rows, is_own)
    return Owned(
        cost=float(clusters.cost[is_whole].sum()),
        slack=max(0.0, certificate.cost - certificate.lower_bound),
        status=certificate.status,
        shared=shared,
    )


def _shared(
    clusters: Clusters, chosen: IntArray, rows: IntArray, is_own: NDArray[np.bool_]
) -> NDArray[np.void]:
    """Return the rows of some clusters, which have a report of the region's own each."""
    order = np.lexsort((clusters.report, clusters.owner))
    owner, report = clusters.owner[order], clusters.report[order]
    once = (np.diff(owner, prepend=-1) != 0) | (np.diff(report, prepend=-1) != 0)
    owner, report = owner[once], report[once]
    begin, end = np.searchsorted(owner, chosen), np.searchsorted(owner, chosen, "right")
    n_own = np.r_[0, np.cumsum(is_own[report])]
    told = rows[report]
    shared = np.empty(chosen.size, SHARED)
    shared["reports"] = [
        int.from_bytes(blake2b(told[own], digest_size=8).digest(), "little", signed=True)
        for own in map(slice, begin.tolist(), end.tolist())
    ]
    shared["cost"], shared["count"] = clusters.cost[chosen], end - begin
    shared["n_own"], shared["is_first"] = n_own[end] - n_own[begin], is_own[report[begin]]
    return shared


def together(parts: Sequence[Owned]) -> dict[str, Any]:
    """Return what a scan's entry says of the clusters of all regions.

    A cluster over a border counts once, as the region of its first report has it, if all those in
    which it has reports have the same one. Else it is cut: nothing is said of what it costs.

    Returns
    -------
    Cost, bound, gap and status of what was not cut, and how many reports the cut clusters have.
    """
    shared = np.concatenate([part.shared for part in parts])
    _, which = np.unique(shared["reports"], return_inverse=True)
    is_alike = np.bincount(which, shared["n_own"])[which] == shared["count"]
    cost = sum(part.cost for part in parts)
    cost += float(shared["cost"][is_alike & shared["is_first"]].sum())
    bound = cost - sum(part.slack for part in parts)
    n_cut = int(shared["n_own"][~is_alike].sum())
    told = {part.status for part in parts}
    status = Status.FEASIBLE
    if not n_cut and told <= {Status.OPTIMAL, Status.OPTIMAL_AMONG_KEPT}:
        status = Status.OPTIMAL if told == {Status.OPTIMAL} else Status.OPTIMAL_AMONG_KEPT
    return {
        "cost": cost, "lower_bound": bound, "gap": relative_gap(cost, bound), "status": status,
        "cut_reports": n_cut,
    }  # fmt: skip
