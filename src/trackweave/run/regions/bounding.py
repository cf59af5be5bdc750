"""The bound of all regions: that of all clusters, each counted by one region that owns it."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import IntArray
from trackweave.association.certificate import Certificate, Status, relative_gap
from trackweave.run.regions.cutting import Region
from trackweave.trackers.clusters import Clusters

__all__ = ["UNKNOWN", "Owned", "Shared", "owned", "together"]

UNKNOWN: dict[str, Any] = {
    "cost": None, "lower_bound": None, "gap": None, "status": Status.FEASIBLE, "cut_reports": None,
}  # fmt: skip
"""What a scan's entry says where a region was left out."""


@dataclass(frozen=True, slots=True)
class Shared:
    """A cluster that has reports of a region's own and others."""

    reports: bytes  # Which they are, in few bytes
    cost: float  # [nats]
    count: int
    n_own: int
    is_first: bool  # Whether its first report is the region's own


@dataclass(frozen=True, slots=True)
class Owned:
    """What a region's own clusters cost after a step."""

    cost: float  # Of those all of whose reports are its own [nats]
    slack: float  # How much less all that it tracks may cost at most [nats]
    status: Status
    shared: tuple[Shared, ...]


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
    shared = []
    for cluster in np.flatnonzero((inside > 0) & ~is_whole).tolist():
        own = np.unique(clusters.report[clusters.owner == cluster])
        key = blake2b(rows[own].tobytes(), digest_size=16).digest()
        cost, n_own = float(clusters.cost[cluster]), int(is_own[own].sum())
        shared.append(Shared(key, cost, own.size, n_own, bool(is_own[own[0]])))
    return Owned(
        cost=float(clusters.cost[is_whole].sum()),
        slack=max(0.0, certificate.cost - certificate.lower_bound),
        status=certificate.status,
        shared=tuple(shared),
    )


def together(parts: Sequence[Owned]) -> dict[str, Any]:
    """Return what a scan's entry says of the clusters of all regions.

    A cluster over a border counts once, as the region of its first report has it, if all those in
    which it has reports have the same one. Else it is cut: nothing is said of what it costs.

    Returns
    -------
    Cost, bound, gap and status of what was not cut, and how many reports the cut clusters have.
    """
    shared = [each for part in parts for each in part.shared]
    held = Counter[bytes]()
    for each in shared:
        held[each.reports] += each.n_own
    alike = [each for each in shared if held[each.reports] == each.count]
    cost = sum(part.cost for part in parts) + sum(each.cost for each in alike if each.is_first)
    bound = cost - sum(part.slack for part in parts)
    n_cut = sum(each.n_own for each in shared) - sum(each.n_own for each in alike)
    told = {part.status for part in parts}
    status = Status.FEASIBLE
    if not n_cut and told <= {Status.OPTIMAL, Status.OPTIMAL_AMONG_KEPT}:
        status = Status.OPTIMAL if told == {Status.OPTIMAL} else Status.OPTIMAL_AMONG_KEPT
    return {
        "cost": cost, "lower_bound": bound, "gap": relative_gap(cost, bound), "status": status,
        "cut_reports": n_cut,
    }  # fmt: skip
