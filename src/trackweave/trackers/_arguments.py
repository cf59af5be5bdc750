"""The tracker's border: what it is given is checked here, before anything changes.

Values come as ``object``, because a caller's types are not to be trusted.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from trackweave.arrays import is_number, is_whole, name_text, require_instance
from trackweave.association.tree import GrowthLimits
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.solvers.protocol import require_solver
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.window import Window


def checked_sensors(sensors: object) -> dict[str, Sensor]:
    """Return the sensors by name, the names as text."""
    if isinstance(sensors, str) or not isinstance(sensors, Iterable):
        raise InvalidInputError(f"sensors: {sensors!r:.80}; expected a list of sensors")
    listed = list(sensors)
    for place, sensor in enumerate(listed):
        require_instance(sensor, Sensor, f"sensors[{place}]")
    named = [replace(sensor, name=name_text(sensor.name, "sensors: name")) for sensor in listed]
    known = {sensor.name: sensor for sensor in named}
    if not known or len(known) < len(named):
        raise InvalidInputError("sensors: expected at least one, and names that differ")
    return known


def checked_window(window: object) -> Window:
    """Return the window, which may be given as its depth or not at all."""
    if window is None:
        return Window()
    if isinstance(window, Window):
        return window
    if not is_whole(window):
        raise InvalidInputError(f"window: {window!r:.80}; expected a Window or a number of scans")
    return Window(depth=window)  # type: ignore[arg-type] # the line above


def checked_priors(priors: TrackTable | None) -> TrackTable | None:
    """Return the tracks known beforehand, None where there are none."""
    if priors is None:
        return None
    require_instance(priors, TrackTable, "priors")
    if np.any(priors.track < 0) or np.unique(priors.track).shape[0] < len(priors):
        raise InvalidInputError("priors: expected one row for each track, and no name below 0")
    return priors if len(priors) else None


def require_parts(motion: object, search: object, lifecycle: object, limits: object) -> None:
    """Refuse parts of a tracker that are of another kind; only the first must be there."""
    require_instance(motion, ConstantVelocity, "motion")
    if search is not None:
        require_solver(search, "search")
    if lifecycle is not None:
        require_instance(lifecycle, Lifecycle, "lifecycle")
    if limits is not None:
        require_instance(limits, GrowthLimits, "limits")


def require_step(scan: object, rng: object, deadline: object) -> None:
    """Refuse what no step can be taken with."""
    require_instance(scan, Scan, "scan")
    require_instance(rng, np.random.Generator, "rng")
    if deadline is not None and not (is_number(deadline) and deadline > 0):  # type: ignore[operator] # a number
        raise InvalidInputError(f"deadline: {deadline!r:.80}; expected a number > 0 [s], or None")


def dimensions_of(scan: Scan, sensor: Sensor, expected: int | None) -> int | None:
    """Return a scan's number of dimensions once it fits; None where nothing tells it."""
    dim = int(scan.measurement.shape[1])
    if len(scan) == 0 and dim == 0:
        own = int(np.size(sensor.sigma))
        if expected is None and own == 1:
            return None
        dim = expected or own
    if dim not in (2, 3) or (expected is not None and dim != expected):
        raise InvalidInputError(f"scan of {dim} dimensions; expected {expected or '2 or 3'}")
    sensor.sigmas(dim)
    return dim


def with_dimensions(scan: Scan, dim: int) -> Scan:
    """Return a scan that is empty if it is of other dimensions, in these."""
    if scan.measurement.shape[1] == dim:
        return scan
    return replace(scan, measurement=np.empty((0, dim)), sigma=np.empty((0, dim)))
