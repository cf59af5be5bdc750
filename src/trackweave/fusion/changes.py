"""Why objects changed, in words and numbers."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from trackweave.arrays import IntArray
from trackweave.fusion._statistic import Form, Rings, evaluate_all
from trackweave.fusion.objects import Change, Renumbering

__all__ = ["Evidence", "described"]


class Evidence(NamedTuple):
    """What tells whether tracks fit together.

    ``form`` is the statistic with the threshold for what is held, ``row`` and ``held`` are the
    live tracks' rows and objects until now; ``times`` says how often pairings had to come out.
    """

    rings: Rings
    form: Form
    row: IntArray
    held: IntArray
    times: str

    def of(self, places: IntArray) -> tuple[float, float]:
        """Return the statistic and the threshold of some live tracks together."""
        value, limit = np.empty((2, 1))
        evaluate_all(self.rings, self.form, self.row[places][None], value, limit)
        return float(value[0]), float(limit[0])


def described(new: Renumbering, evidence: Evidence) -> tuple[Change, ...]:
    """Return what became of objects: begun, merged, split, ended."""
    return (
        *(Change("begun", number, (), "no object fits its tracks") for number in new.begun),
        *(Change("begun", number, (), "its tracks are back") for number in new.returned),
        *_merged(new, evidence),
        *_split(new, evidence),
        *(Change("ended", number, (), "none of its tracks is left") for number in new.ended),
    )


def _merged(new: Renumbering, evidence: Evidence) -> Iterator[Change]:
    for number, others in new.merged.items():
        value, limit = evidence.of(np.flatnonzero(new.object == number))
        reason = f"λ = {value:.1f} of the tracks together is within {limit:.1f}{evidence.times}"
        yield Change("merged", number, others, reason, value, limit)


def _split(new: Renumbering, evidence: Evidence) -> Iterator[Change]:
    for number, others in new.split.items():
        value, limit = evidence.of(np.flatnonzero(evidence.held == number))
        reason = f"λ = {value:.1f} of its tracks together exceeds {limit:.1f}"
        if value <= limit:
            reason = f"its tracks fit others better (λ = {value:.1f}, within {limit:.1f})"
        yield Change("split", number, others, f"{reason}{evidence.times}", value, limit)
