"""What the numbers of a report are."""

from enum import IntEnum

__all__ = ["MeasurementKind"]


class MeasurementKind(IntEnum):
    """What a sensor measures. Angles are in radians, azimuth and bearing clockwise from north.

    Range is the distance from the sensor in all dimensions of the tracking space, elevation the
    angle over the horizontal plane through the sensor, range rate the time derivative of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> tw.MeasurementKind.RANGE_AZIMUTH.word, tw.MeasurementKind.RANGE_AZIMUTH.n_components(2)
    ('range-azimuth', 2)
    >>> kind = tw.MeasurementKind.RANGE_AZIMUTH
    >>> radar = tw.Sensor("radar", sigma=(30.0, 0.002), measurement=kind)
    >>> radar.sigmas(2)  # m, rad
    array([3.e+01, 2.e-03])
    """

    POSITION = 0
    """x, y, and z in space [m]."""
    RANGE_AZIMUTH = 1
    """Range [m], azimuth [rad]."""
    RANGE_AZIMUTH_RATE = 2
    """Range [m], azimuth [rad], range rate [m/s]."""
    RANGE_AZIMUTH_ELEVATION = 3
    """Range [m], azimuth and elevation [rad]; in space alone."""
    RANGE_AZIMUTH_ELEVATION_RATE = 4
    """Range [m], azimuth and elevation [rad], range rate [m/s]; in space alone."""
    BEARING = 5
    """Bearing alone [rad], on a plane."""
    RANGE_RATE = 6
    """Range rate alone; no sensor reports it, but the others' rates are taken in by it."""

    @property
    def word(self) -> str:
        """The name in configuration files."""
        return self.name.lower().replace("_", "-")

    @property
    def is_position(self) -> bool:
        """Whether the numbers are a place in the tracking space, whoever looks."""
        return self is MeasurementKind.POSITION

    @property
    def is_bearing_only(self) -> bool:
        """Whether the numbers tell a direction and no distance."""
        return self is MeasurementKind.BEARING

    @property
    def needs_place(self) -> bool:
        """Whether the numbers count from where the sensor stands."""
        return not self.is_position

    @property
    def azimuth(self) -> int | None:
        """Which of the numbers is the azimuth; None where none is."""
        return 1 if self.has_range else 0 if self.is_bearing_only else None

    @property
    def has_range(self) -> bool:
        """Whether the first component is a range."""
        return 1 <= self <= 4

    @property
    def has_elevation(self) -> bool:
        """Whether the third component is an elevation."""
        return self in {3, 4}

    @property
    def has_rate(self) -> bool:
        """Whether the last component is a range rate."""
        return self in {2, 4}

    @property
    def without_rate(self) -> "MeasurementKind":
        """What is measured beside a range rate."""
        return MeasurementKind(self - 1) if self.has_rate else self

    def n_components(self, dim: int) -> int:
        """Return how many numbers a report holds.

        Parameters
        ----------
        dim
            Number of dimensions of the tracking space.

        Returns
        -------
        The number.
        """
        if self.is_position:
            return dim
        return (0, 2, 3, 3, 4, 1, 1)[self]

    def columns(self, dim: int) -> tuple[str, ...]:
        """Return the names of a report's numbers in files; those in ``_deg`` are angles.

        Parameters
        ----------
        dim
            Number of dimensions of the tracking space.

        Returns
        -------
        Such as range_m, azimuth_deg.
        """
        if self.is_position:
            return ("x", "y", "z")[:dim]
        if self.is_bearing_only:
            return ("bearing_deg",)
        if self is MeasurementKind.RANGE_RATE:
            return ("range_rate_mps",)
        elevation = ("elevation_deg",) if self.has_elevation else ()
        rate = ("range_rate_mps",) if self.has_rate else ()
        return ("range_m", "azimuth_deg", *elevation, *rate)

    def gives_position(self, dim: int) -> bool:
        """Tell whether one report says where its object is.

        Parameters
        ----------
        dim
            Number of dimensions of the tracking space.

        Returns
        -------
        False for a bearing, and in three dimensions for a range without an elevation.
        """
        if self.has_range:
            return dim == 2 or self.has_elevation
        return self.is_position
