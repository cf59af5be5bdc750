"""All measures of a run against the truth."""

from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.tracks import TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError
from trackweave.metrics._distances import check_cutoff, check_order
from trackweave.metrics.assignments import AssignmentQuality
from trackweave.metrics.clear_mot import clear_mot_of_pairs
from trackweave.metrics.gospa import Gospa, gospa_from_distances, ospa_from_distances
from trackweave.metrics.hota import FACTORS, hota
from trackweave.metrics.identity import identity
from trackweave.metrics.moments import Moments, align
from trackweave.metrics.ospa2 import ospa2
from trackweave.metrics.pairing import pair_over_time
from trackweave.metrics.targets import (
    MOSTLY_LOST,
    MOSTLY_TRACKED,
    PARTLY_TRACKED,
    TargetRecord,
    target_records,
)
from trackweave.summaries import summary

__all__ = ["Evaluation", "evaluate"]

# What is told of pairs as CLEAR MOT has it.
PAIRING = ("mota", "motp", "switches", "fragmentations", "rmse", "covered", "n_found")


@dataclass(frozen=True, slots=True)
class Evaluation:
    """How far tracks are from the truth. Where a measure has no meaning it is None.

    Of reports alone, all but their own measures are None.

    Parameters
    ----------
    gospa, gospa_localisation, gospa_missed, gospa_false
        Mean over time of GOSPA, and of what distances of pairs, targets without a track and
        tracks without a target add to it [m].
    missed_per_time, false_per_time
        Mean number of targets without a track, and of tracks without a target.
    ospa
        Mean over time of OSPA [m].
    ospa2, ospa2_localisation, ospa2_cardinality
        Mean over time of OSPA(2), which takes identities into account, and of what distances of
        targets from their tracks and targets or tracks too many add to it [m].
    mota, motp
        CLEAR MOT accuracy, and precision: mean distance of pairs [m].
    idf1, idp, idr
        Identity F1 of track positions, precision and recall.
    hota, deta, assa, loca
        Higher order tracking accuracy; its detection, association and localisation accuracy.
    switches, fragmentations
        How often a target's track is another than the one that it had last, and how often a
        target is paired again after an interruption.
    rmse
        Root of the mean squared distance of pairs [m].
    covered
        Share of target positions that are paired with a track.
    n_truth, n_found
        Number of targets, and of those paired for at least half of their positions.
    mostly_tracked, partly_tracked, mostly_lost
        Number of targets paired for at least 80 % of their positions, of those in between, and of
        those paired for less than 20 %.
    n_tracks, n_times
        Number of tracks that were ever confirmed, and of the truth's times.
    right_share
        Share of reports assigned rightly.
    report_idf1, report_purity, report_mota, report_switches
        Identity F1 of reports; share of the assigned ones that come from their track's most
        frequent target; CLEAR MOT accuracy; how often a target's report is on another track than
        its last assigned one.
    cutoff, order, window
        What was used [m], and the number of times over which OSPA(2) was taken.
    targets
        Each target's own record.

    Examples
    --------
    >>> import trackweave as tw
    >>> truth = tw.TruthTable.from_columns([0.0, 1.0], ["a", "a"], [[0.0, 0.0], [10.0, 0.0]])
    >>> found = tw.evaluate(truth, truth, cutoff=20.0)  # m
    >>> found.gospa, found.idf1, found.switches
    (0.0, 1.0, 0)
    """

    gospa: float | None = None
    gospa_localisation: float | None = None
    gospa_missed: float | None = None
    gospa_false: float | None = None
    missed_per_time: float | None = None
    false_per_time: float | None = None
    ospa: float | None = None
    ospa2: float | None = None
    ospa2_localisation: float | None = None
    ospa2_cardinality: float | None = None
    mota: float | None = None
    motp: float | None = None
    idf1: float | None = None
    idp: float | None = None
    idr: float | None = None
    hota: float | None = None
    deta: float | None = None
    assa: float | None = None
    loca: float | None = None
    switches: int | None = None
    fragmentations: int | None = None
    rmse: float | None = None
    covered: float | None = None
    n_truth: int | None = None
    n_found: int | None = None
    mostly_tracked: int | None = None
    partly_tracked: int | None = None
    mostly_lost: int | None = None
    n_tracks: int | None = None
    n_times: int | None = None
    right_share: float | None = None
    report_idf1: float | None = None
    report_purity: float | None = None
    report_mota: float | None = None
    report_switches: int | None = None
    cutoff: float | None = None
    order: float | None = None
    window: int | None = None
    targets: tuple[TargetRecord, ...] = ()

    __repr__ = summary

    def as_dict(self) -> dict[str, Any]:
        """Return every measure by its name, in a fixed order, ready for JSON."""
        found = {field.name: getattr(self, field.name) for field in fields(self)}
        return found | {"targets": [record.as_dict() for record in self.targets]}

    def with_assignments(self, quality: AssignmentQuality) -> "Evaluation":
        """Return the same evaluation with the measures of reports filled in."""
        return replace(
            self,
            right_share=quality.right_share,
            report_idf1=quality.idf1,
            report_purity=quality.purity,
            report_mota=quality.mota,
            report_switches=quality.switches,
        )


def evaluate(  # noqa: PLR0913 the one function that users call with everything
    truth: TruthTable,
    tracks: TrackTable | TruthTable,
    *,
    cutoff: float = 50.0,
    order: float = 2.0,
    max_gap: float | None = None,
    window: int = 10,
) -> Evaluation:
    """Return how far tracks are from the truth.

    Confirmed and coasting rows are interpolated linearly to the truth's times; nothing is
    extrapolated. Every measure is taken over these times.

    Parameters
    ----------
    truth
        Where targets really were; at least one row.
    tracks
        A ``TrackTable``, or a ``TruthTable`` whose targets are the tracks' identifiers.
    cutoff
        Distance from which a track is not a target's [m], in all measures; positive. Some five
        times the reports' noise is a fair choice: 50 suits noise of 10.
    order
        Exponent p of GOSPA, OSPA and OSPA(2); at least 1.
    max_gap
        Longest time between two rows of a track that is bridged [s]; None for 1.5 times the
        tracks' own period.
    window
        Number of the truth's times over which OSPA(2) is taken; at least 1.

    Returns
    -------
    All measures; those of reports are None until ``with_assignments``.

    Raises
    ------
    InvalidInputError
        If the truth is empty, dimensions differ, or a parameter is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> truth = tw.TruthTable.from_columns([0.0, 1.0], ["a", "a"], [[0.0, 0.0], [10.0, 0.0]])
    >>> tracks = tw.TruthTable.from_columns([0.0, 1.0], ["1", "1"], [[0.0, 3.0], [10.0, 3.0]])
    >>> found = tw.evaluate(truth, tracks, cutoff=20.0)  # m
    >>> found.rmse, found.mota, found.switches  # m
    (3.0, 1.0, 0)
    """
    check_cutoff(cutoff)
    check_order(order)
    if len(truth) == 0:
        raise InvalidInputError("truth: no rows; expected at least one")
    moments = align(truth, tracks, max_gap)
    parts, ospa = _over_time(moments, cutoff, order)
    over_window = ospa2(moments, window, cutoff, order)
    pairs = pair_over_time(moments, cutoff, order)
    pairing, records = clear_mot_of_pairs(moments, pairs), target_records(moments, pairs)
    completeness = [record.completeness for record in records]
    higher = hota(moments, cutoff)
    factors: dict[str, Any] = {name: getattr(higher, name, None) for name in FACTORS[:4]}
    return Evaluation(
        gospa=_mean([part.total for part in parts]),
        gospa_localisation=_mean([part.localisation for part in parts]),
        gospa_missed=_mean([part.missed for part in parts]),
        gospa_false=_mean([part.false for part in parts]),
        missed_per_time=_mean([part.n_missed for part in parts]),
        false_per_time=_mean([part.n_false for part in parts]),
        ospa=_mean(ospa),
        ospa2=_mean(over_window.total),
        ospa2_localisation=_mean(over_window.localisation),
        ospa2_cardinality=_mean(over_window.cardinality),
        **{name: getattr(pairing, name) for name in PAIRING},
        **asdict(identity(moments, cutoff)),
        **factors,
        n_truth=moments.n_targets,
        mostly_tracked=completeness.count(MOSTLY_TRACKED),
        partly_tracked=completeness.count(PARTLY_TRACKED),
        mostly_lost=completeness.count(MOSTLY_LOST),
        n_tracks=moments.n_tracks,
        n_times=len(moments),
        cutoff=float(cutoff),
        order=float(order),
        window=window,
        targets=records,
    )


def _over_time(moments: Moments, cutoff: float, order: float) -> tuple[list[Gospa], list[float]]:
    parts, ospa = [], []
    for moment in moments:
        parts.append(gospa_from_distances(moment.distance, cutoff, order))
        ospa.append(ospa_from_distances(moment.distance, cutoff, order))
    return parts, ospa


def _mean(values: list[float] | list[int] | FloatArray) -> float:
    return float(np.mean(values))
