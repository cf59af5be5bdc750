"""Where a sensor can see, and objects that cannot be seen for a while."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, float_array, require_finite
from trackweave.errors import InvalidInputError
from trackweave.fields import Limit, settle

__all__ = ["Coverage", "FieldOfView", "everywhere", "hiding"]


class Coverage(NamedTuple):
    """A field of view as kernels read it.

    ``bounds`` holds min range, max range [m], azimuth at which the sector starts and its width
    [rad, clockwise from north]; an empty ``polygon`` is none. ``blur`` holds how far reports lie
    beside their objects, as standard deviations: across the line of sight [rad], along it [m], and
    across it besides [m]; edges are of what is reported. ``everywhere`` short-cuts all.
    """

    everywhere: bool
    position: FloatArray
    bounds: FloatArray
    polygon: FloatArray
    blur: FloatArray


@dataclass(frozen=True, slots=True)
class FieldOfView:
    """The part of the plane that a sensor covers: a ring sector, a polygon, or what both share.

    Parameters
    ----------
    position
        Where the sensor stands, x and y [m].
    min_range, max_range
        Distances between which it sees [m], 0 ≤ min < max.
    azimuth_deg
        Where the sector starts and ends [degrees clockwise from north]; (0, 360) is a full turn.
        A sector may pass north, such as (350, 20).
    polygon
        Corners x, y [m] in order, at least three; None for no polygon.

    Raises
    ------
    InvalidInputError
        If a value is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> # A sector of 90° about north, from 100 m to 20 km.
    >>> view = tw.FieldOfView(min_range=100.0, max_range=20_000.0, azimuth_deg=(315, 45))
    >>> view.coverage().bounds.round(3)  # m, m, rad, rad
    array([1.000e+02, 2.000e+04, 5.498e+00, 1.571e+00])
    """

    position: tuple[float, float] = (0.0, 0.0)
    min_range: float = 0.0
    max_range: Limit = np.inf
    azimuth_deg: tuple[float, float] = (0.0, 360.0)
    polygon: Sequence[tuple[float, float]] | None = None

    def __post_init__(self) -> None:
        settle(self)
        if not 0 <= self.min_range < self.max_range:
            raise InvalidInputError(
                f"field of view: ranges {self.min_range} to {self.max_range}; "
                "expected 0 ≤ min < max"
            )
        if not all(-360 <= angle <= 720 for angle in self.azimuth_deg):
            raise InvalidInputError(
                f"field of view: azimuth {self.azimuth_deg}; expected degrees from -360 to 720"
            )
        if self.polygon is not None:
            corners = float_array(self.polygon, "polygon", (None, 2))
            require_finite(corners, "polygon")
            if corners.shape[0] < 3:
                raise InvalidInputError(
                    f"field of view: a polygon of {corners.shape[0]} corners; expected at least 3"
                )

    def coverage(self) -> Coverage:
        """Return the form that kernels read."""
        start, end = self.azimuth_deg
        width = end - start if end - start >= 360 else (end - start) % 360
        polygon = np.empty((0, 2)) if self.polygon is None else np.asarray(self.polygon, float)
        return Coverage(
            everywhere=False,
            position=np.asarray(self.position, float),
            bounds=np.array(
                [self.min_range, self.max_range, np.radians(start), np.radians(width or 360.0)]
            ),
            polygon=np.ascontiguousarray(polygon),
            blur=np.zeros(3),
        )


def everywhere() -> Coverage:
    """Return the coverage of a sensor that sees the whole plane."""
    return Coverage(True, np.zeros(2), np.zeros(4), np.empty((0, 2)), np.zeros(3))


def hiding(share: float, mean_silence: float, waited: float) -> tuple[float, float]:
    """Return how probably an object in sight is hidden some time later, and the other way."""
    # A chain of two states in continuous time, so that two steps are as one over both. ``share``
    # is that of the time for which objects are hidden, ``mean_silence`` for how long on average
    # [s], ``waited`` the time [s].
    if share <= 0.0:
        return 0.0, 0.0
    mixed = -math.expm1(-waited / (mean_silence * (1.0 - share)))
    return share * mixed, (1.0 - share) * mixed
