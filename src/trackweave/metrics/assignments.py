"""How rightly reports were assigned to tracks."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import IntArray
from trackweave.errors import InvalidInputError

__all__ = ["AssignmentQuality", "assignment_quality"]

NOBODY = -1


@dataclass(frozen=True, slots=True)
class AssignmentQuality:
    """How rightly reports were assigned, under the best one-to-one naming of tracks.

    ``right_share`` is that of reports of a target on its own track and of false alarms on none;
    ``idf1`` twice the reports of targets on their own tracks over the reports of targets plus the
    assigned ones; ``purity`` the share of the assigned that come from their track's most frequent
    target; ``mota`` is 1 - (reports of targets on no track + false alarms on a track + switches)
    over the reports of targets. Each is None where there is nothing to divide by. A switch is a
    target's report on another track than its last report that was on any.
    """

    right_share: float | None
    idf1: float | None
    purity: float | None
    n_reports: int
    mota: float | None
    switches: int


def assignment_quality(targets: Iterable[Any], tracks: Iterable[Any]) -> AssignmentQuality:
    """Return how rightly each report was given to a track.

    Parameters
    ----------
    targets
        Each report's target: text or numbers; None, NaN, empty text or a negative number for a
        false alarm. Only switches depend on the order, which is that of time.
    tracks
        Each report's track, likewise.

    Returns
    -------
    The shares and the number of switches.

    Raises
    ------
    InvalidInputError
        If there are not as many tracks as targets.

    Examples
    --------
    >>> from trackweave.metrics import assignment_quality
    >>> judged = assignment_quality(["A", "A", "A", None], ["1", "1", "2", None])
    >>> judged.right_share, judged.switches
    (0.75, 1)
    """
    target, n_targets = _codes(targets)
    track, n_tracks = _codes(tracks)
    if target.size != track.size:
        raise InvalidInputError(
            f"tracks: {track.size} values; expected {target.size}, one for each report"
        )
    true, given = target != NOBODY, track != NOBODY
    shared = np.zeros((n_targets, n_tracks))
    np.add.at(shared, (target[true & given], track[true & given]), 1)
    agreed = float(shared[linear_sum_assignment(shared, maximize=True)].sum())
    n_right = agreed + np.count_nonzero(~true & ~given)
    n_true, n_given = np.count_nonzero(true), np.count_nonzero(given)
    switches = _switches(target[true & given], track[true & given])
    wrong = np.count_nonzero(true != given) + switches
    return AssignmentQuality(
        right_share=float(n_right / target.size) if target.size else None,
        idf1=2 * agreed / (n_true + n_given) if n_true + n_given else None,
        purity=float(shared.max(axis=0, initial=0.0).sum()) / n_given if n_given else None,
        n_reports=target.size,
        mota=1 - wrong / n_true if n_true else None,
        switches=switches,
    )


def _switches(target: IntArray, track: IntArray) -> int:
    order = np.argsort(target, kind="stable")
    same = np.diff(target[order]) == 0
    return int(np.count_nonzero(same & (np.diff(track[order]) != 0)))


def _codes(labels: Iterable[Any]) -> tuple[IntArray, int]:
    """Return a number from 0 for each different label, NOBODY for none."""
    numbers: dict[Any, int] = {}
    codes = [
        NOBODY if _is_nobody(label) else numbers.setdefault(label, len(numbers))
        for label in (labels.tolist() if isinstance(labels, np.ndarray) else labels)
    ]
    return np.array(codes, dtype=np.int64), len(numbers)


def _is_nobody(label: Any) -> bool:
    if label is None or isinstance(label, str):
        return not label
    return bool(label < 0 or label != label)  # NaN alone differs from itself
