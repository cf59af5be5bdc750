"""The command ``evaluate``."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trackweave.domain.truth import TruthTable
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.truth import plane_of, read_assignments, read_tracks, read_truth
from trackweave.metrics import assignment_quality, evaluate

__all__ = ["Measure", "run_evaluate"]


@dataclass(frozen=True, slots=True)
class Measure:
    """How to compare.

    Parameters
    ----------
    cutoff
        Distance from which a track is not a target's [m].
    order
        Exponent of GOSPA and OSPA.
    max_gap
        Longest time between rows that is bridged [s]; None for a period and a half.
    """

    cutoff: float = 50.0
    order: float = 2.0
    max_gap: float | None = None


def run_evaluate(
    truth: Path, tracks: Path, assignments: Path | None, measure: Measure
) -> dict[str, Any]:
    """Return every measure of tracks against the truth by its name."""
    frame = plane_of(truth)
    true, claimed = read_truth(truth, frame), read_tracks(tracks, frame)
    _require_common_time((truth, true), (tracks, claimed))
    found = evaluate(
        true,
        claimed,
        cutoff=measure.cutoff,
        order=measure.order,
        max_gap=measure.max_gap,
    )
    if assignments is not None:
        table = read_assignments(assignments)
        if table.target is None:
            raise DataFormatError(
                f"{assignments}: no column target; expected the truth of each report, which "
                "passes through when the reports have it"
            )
        found = found.with_assignments(assignment_quality(table.target, table.track))
    return found.as_dict()


def _require_common_time(truth: tuple[Path, TruthTable], tracks: tuple[Path, TruthTable]) -> None:
    """Refuse tracks of another time: every measure would say that nothing was found."""
    if len(truth[1]) == 0 or len(tracks[1]) == 0:
        return
    (begin, end), (first, last) = (
        (float(table.time.min()), float(table.time.max())) for _, table in (truth, tracks)
    )
    if last < begin or first > end:
        raise InvalidInputError(
            f"{tracks[0]}: from {first:.15g} to {last:.15g} s, {truth[0]}: from {begin:.15g} to "
            f"{end:.15g} s; expected tracks and truth of the same time"
        )
