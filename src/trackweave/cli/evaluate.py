"""The command ``evaluate``."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from trackweave.errors import DataFormatError
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
    found = evaluate(
        read_truth(truth, frame),
        read_tracks(tracks, frame),
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
