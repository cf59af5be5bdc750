"""All measures of a run against the truth."""

from dataclasses import dataclass, fields, replace

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.tracks import TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError
from trackweave.metrics._distances import check_cutoff, check_order
from trackweave.metrics.assignments import AssignmentQuality
from trackweave.metrics.clear_mot import clear_mot
from trackweave.metrics.gospa import Gospa, gospa_from_distances
from trackweave.metrics.hota import hota
from trackweave.metrics.identity import identity
from trackweave.metrics.moments import Moments, align
from trackweave.metrics.ospa import ospa_from_distances

__all__ = ["Evaluation", "evaluate"]


@dataclass(frozen=True, slots=True)
class Evaluation:
    """How far tracks are from the truth. Where a measure has no meaning it is None.

    Parameters
    ----------
    gospa
        Mean over time of GOSPA [m].
    gospa_localisation
        Mean over time of what the distances of pairs add to it [m].
    gospa_missed
        Mean over time of what targets without a track add to it [m].
    gospa_false
        Mean over time of what tracks without a target add to it [m].
    missed_per_time
        Mean number of targets without a track.
    false_per_time
        Mean number of tracks without a target.
    ospa
        Mean over time of OSPA [m].
    mota
        CLEAR MOT accuracy.
    motp
        CLEAR MOT precision: mean distance of pairs [m].
    idf1
        Identity F1 of track positions.
    idp
        Identity precision.
    idr
        Identity recall.
    hota
        Higher order tracking accuracy.
    deta
        Its detection accuracy.
    assa
        Its association accuracy.
    switches
        How often a target's track is another than the one that it had last.
    fragmentations
        How often a target is paired again after an interruption.
    rmse
        Root of the mean squared distance of pairs [m].
    covered
        Share of target positions that are paired with a track.
    n_truth
        Number of targets.
    n_found
        Number of targets paired for at least half of their positions.
    n_tracks
        Number of tracks that were ever confirmed.
    n_times
        Number of the truth's times.
    right_share
        Share of reports assigned rightly.
    report_idf1
        Identity F1 of reports.
    report_purity
        Share of the assigned reports that come from their track's most frequent target.
    cutoff
        The cutoff used [m].
    order
        The order used.
    """

    gospa: float | None
    gospa_localisation: float | None
    gospa_missed: float | None
    gospa_false: float | None
    missed_per_time: float | None
    false_per_time: float | None
    ospa: float | None
    mota: float | None
    motp: float | None
    idf1: float | None
    idp: float | None
    idr: float | None
    hota: float | None
    deta: float | None
    assa: float | None
    switches: int
    fragmentations: int
    rmse: float | None
    covered: float | None
    n_truth: int
    n_found: int
    n_tracks: int
    n_times: int
    right_share: float | None = None
    report_idf1: float | None = None
    report_purity: float | None = None
    cutoff: float = 50.0
    order: float = 2.0

    def as_dict(self) -> dict[str, float | int | None]:
        """Return every measure by its name, in a fixed order, ready for JSON."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def with_assignments(self, quality: AssignmentQuality) -> "Evaluation":
        """Return the same evaluation with the measures of reports filled in."""
        return replace(
            self,
            right_share=quality.right_share,
            report_idf1=quality.idf1,
            report_purity=quality.purity,
        )


def evaluate(
    truth: TruthTable,
    tracks: TrackTable | TruthTable,
    *,
    cutoff: float = 50.0,
    order: float = 2.0,
    max_gap: float | None = None,
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
        Exponent p of GOSPA and OSPA; at least 1.
    max_gap
        Longest time between two rows of a track that is bridged [s]; None for 1.5 times the
        tracks' own period.

    Returns
    -------
    All measures; those of reports are None until ``with_assignments``.

    Raises
    ------
    InvalidInputError
        If the truth is empty, dimensions differ, or a parameter is out of range.
    """
    check_cutoff(cutoff)
    check_order(order)
    if len(truth) == 0:
        raise InvalidInputError("truth: no rows; expected at least one")
    moments = align(truth, tracks, max_gap)
    parts, ospa = _over_time(moments, cutoff, order)
    pairing = clear_mot(moments, cutoff, order)
    naming = identity(moments, cutoff)
    higher = hota(moments, cutoff)
    return Evaluation(
        gospa=_mean([part.total for part in parts]),
        gospa_localisation=_mean([part.localisation for part in parts]),
        gospa_missed=_mean([part.missed for part in parts]),
        gospa_false=_mean([part.false for part in parts]),
        missed_per_time=_mean([part.n_missed for part in parts]),
        false_per_time=_mean([part.n_false for part in parts]),
        ospa=_mean(ospa),
        mota=pairing.mota,
        motp=pairing.motp,
        idf1=naming.idf1,
        idp=naming.idp,
        idr=naming.idr,
        hota=higher.hota if higher else None,
        deta=higher.deta if higher else None,
        assa=higher.assa if higher else None,
        switches=pairing.switches,
        fragmentations=pairing.fragmentations,
        rmse=pairing.rmse,
        covered=pairing.covered,
        n_truth=moments.n_targets,
        n_found=pairing.n_found,
        n_tracks=moments.n_tracks,
        n_times=len(moments),
        cutoff=float(cutoff),
        order=float(order),
    )


def _over_time(moments: Moments, cutoff: float, order: float) -> tuple[list[Gospa], list[float]]:
    parts, ospa = [], []
    for moment in moments:
        parts.append(gospa_from_distances(moment.distance, cutoff, order))
        ospa.append(ospa_from_distances(moment.distance, cutoff, order))
    return parts, ospa


def _mean(values: list[float] | list[int] | FloatArray) -> float:
    return float(np.mean(values))
