"""Units that the numbers alone give away."""

from collections.abc import Iterator

import numpy as np

from trackweave.domain.measurements import MeasurementKind
from trackweave.run.diagnostics.case import Case, Finding
from trackweave.run.diagnostics.senses import NARROW

__all__ = ["azimuths_in_radians"]

# So many directions that fill all that radians can be, and nothing else, are radians.
FEWEST, FILLED = 60, 0.97
WEIGHT = 130.0


def azimuths_in_radians(case: Case) -> Iterator[Finding]:
    """Yield sensors whose directions lie between 0 and 2π degrees, or -π and π, all over."""
    for index, name in enumerate(case.reports.sensors):
        kind, rows = case.reports.kind_of(index), case.rows[index]
        if kind is MeasurementKind.POSITION or rows.size < FEWEST:
            continue
        angle = case.reports.measurement[rows, 1 if kind.has_range else 0]
        about = (angle + np.pi) % (2 * np.pi) - np.pi
        low, high = np.degrees(about.min()), np.degrees(about.max())
        fits = any(
            begin - 1e-3 <= low <= begin + (1 - FILLED) * 2 * np.pi
            and end - (1 - FILLED) * 2 * np.pi <= high <= end + 1e-3
            for begin, end in ((0.0, 2 * np.pi), (-np.pi, np.pi))
        )
        if fits and np.abs(about).max() < NARROW:
            yield Finding(
                "radians",
                name,
                f"sensor {name}: all {rows.size} of its directions lie from {low:.4g} to "
                f"{high:.4g} degrees, as radians of a full turn do; give them in degrees",
                weight=WEIGHT,
                seen=float(high),
            )
