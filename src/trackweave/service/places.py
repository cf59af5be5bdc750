"""Where the reports of a scan are on the plane."""

from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.scans import Scan
from trackweave.models.measurements import to_position

__all__ = ["places_of"]


def places_of(scan: Scan, sensor: Any) -> FloatArray | None:
    """Return where reports put their objects [m], None where that takes more than a report."""
    kind, measured = sensor.measurement, scan.measurement
    if isinstance(kind, ForeignKind) or not kind.gives_position(2):
        return None
    platform = sensor.platform if scan.platform is None else scan.platform
    seen_from = np.broadcast_to(platform, (len(scan), 6))
    return to_position(kind, measured, np.zeros_like(measured), seen_from, 2)[0]
