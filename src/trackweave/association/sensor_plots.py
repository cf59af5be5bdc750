"""One sensor's plots at one instant."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trackweave.arrays import (
    FloatArray,
    covariance_array,
    float_array,
    is_number,
    n_axes,
    require_finite,
)
from trackweave.errors import InvalidInputError
from trackweave.fields import plain, settle
from trackweave.models.coverage import FieldOfView
from trackweave.simulation.scenes import Scene

__all__ = ["SensorPlots", "scene_plots"]

LARGEST = 1e30
"""Greatest coordinate and standard deviation; with larger ones, kernels would lose their range."""


@dataclass(frozen=True, slots=True, eq=False)
class SensorPlots:
    """One sensor's plots at one instant, and what is known of that sensor.

    `trackweave.association.scan_plots.plots_of` makes them of a scan.

    Parameters
    ----------
    value
        Positions [m], shape (plots, 2) or (plots, 3), or bearings [rad], clockwise from north,
        shape (plots,).
    sigma
        Standard deviation [m or rad]: one number, or an array that fits ``value``; above 0. None
        with ``covariance``, whose diagonals it then holds.
    volume
        Field of view in the units of ``value`` [m², m³ or rad]; above 0. An array, one number
        per plot, where the sensor measures in other units, whose size in those of ``value``
        depends on the place. ``cost="equation-1"`` needs it.
    false_alarms
        Expected false alarms, spread evenly over the field of view; above 0.
    detection_probability
        Chance to report an object, above 0 and below 1.
    place
        Where the sensor stands [m], shape (2,), or where it stood at each plot, shape
        (plots, 2); only bearings need it.
    covariance
        Covariance of each position [m²], shape (plots, dimensions, dimensions), symmetric and
        positive definite, in place of ``sigma``; for errors that are correlated.
    clutter_density
        False alarms per unit of ``value`` [1/m², 1/m³ or 1/rad] in place of ``false_alarms``
        over ``volume``: one number, or one at each plot's place; above 0.
    drift
        How far an object may have come between a plot's own time and the common one [m]: one
        standard deviation along each axis, one number or one per plot; at least 0.
    coverage
        Where the sensor reports objects, so that its silence tells something; None for
        everywhere. Its own plots may lie anywhere.

    Raises
    ------
    InvalidInputError
        If a shape does not fit or a value is out of range.

    Examples
    --------
    >>> import trackweave as tw
    >>> # Two positions, known to 10 m; 0.1 false alarms a scan in 10 km × 10 km.
    >>> plots = tw.SensorPlots(
    ...     value=[[0.0, 0.0], [500.0, 0.0]], sigma=10.0, volume=1e8, false_alarms=0.1
    ... )
    >>> plots.is_bearing, plots.sigma
    (False, array([[10., 10.],
           [10., 10.]]))
    """

    value: FloatArray
    sigma: ArrayLike | None = None
    volume: ArrayLike | None = None
    false_alarms: float | None = None
    detection_probability: float = 0.9
    place: ArrayLike | None = None
    covariance: ArrayLike | None = None
    clutter_density: ArrayLike | None = None
    drift: ArrayLike = 0.0
    coverage: FieldOfView | None = None

    def __post_init__(self) -> None:
        settle(self)
        set_field = object.__setattr__
        value = _whole_table(self.value)
        n_plots = value.shape[0]
        _require_moderate(value, "value")
        if value.ndim == 1:
            value = np.mod(value, 2.0 * math.pi)
        set_field(self, "value", value)
        self._check_errors(value)
        for name in ("volume", "clutter_density"):
            if getattr(self, name) is not None:
                set_field(self, name, _per_plot(getattr(self, name), name, n_plots))
        set_field(self, "drift", _per_plot(self.drift, "drift", n_plots, may_be_zero=True))
        self._check_sensor()
        if self.place is not None:
            shape = (2,) if n_axes(self.place, "place") == 1 else (n_plots, 2)
            place = float_array(self.place, "place", shape)
            _require_moderate(place, "place")
            set_field(self, "place", place)
        elif value.ndim == 1:
            raise InvalidInputError("place: None; expected where the sensor of bearings stands")

    def _check_sensor(self) -> None:
        for name in ("false_alarms", "detection_probability"):
            found = getattr(self, name)
            if found is None and name == "false_alarms":
                continue
            if not found > 0:
                raise InvalidInputError(f"{name}: {found!r}; expected a finite number > 0")
        if not self.detection_probability < 1:
            raise InvalidInputError(
                f"detection_probability: {self.detection_probability}; expected between 0 and 1"
            )

    def _check_errors(self, value: FloatArray) -> None:
        """Check and cast how far off plots may be."""
        sigma = self.sigma
        if self.covariance is not None:
            if value.ndim == 1:
                raise InvalidInputError("covariance: of bearings; expected it of positions only")
            shape = (*value.shape, value.shape[1])
            covariance = covariance_array(self.covariance, "covariance", shape)
            object.__setattr__(self, "covariance", covariance)
            sigma = np.sqrt(np.einsum("kii->ki", covariance))
        if sigma is None:
            raise InvalidInputError("sigma: None; expected it, or a covariance")
        object.__setattr__(self, "sigma", _fit_sigma(sigma, value))

    @property
    def is_bearing(self) -> bool:
        """Whether it reports bearings."""
        return self.value.ndim == 1


def scene_plots(scene: Scene) -> tuple[SensorPlots, ...]:
    """Return a simulated scene's plots, with all that a tracker may know of the sensors.

    Parameters
    ----------
    scene
        The scene.

    Returns
    -------
    One entry per sensor. Where no false alarm is expected, one in 10⁹ is.
    """
    return tuple(
        SensorPlots(
            value=plots,
            sigma=scene.sigma[sensor],
            volume=float(scene.volume[sensor]),
            false_alarms=max(1e-9, float(scene.false_alarms[sensor])),
            detection_probability=scene.detection_probability,
            place=None if scene.places is None else scene.places[sensor],
        )
        for sensor, plots in enumerate(scene.plots)
    )


def _whole_table(values: ArrayLike) -> FloatArray:
    try:
        shape = np.shape(values)
    except ValueError as err:
        raise InvalidInputError(f"value: {values!r:.80}; expected rows of one length") from err
    wanted = (None,) if len(shape) == 1 else (None, 3 if shape[-1:] == (3,) else 2)
    return float_array(values, "value", wanted)


def _require_moderate(values: FloatArray, name: str) -> None:
    require_finite(values, name)
    if np.any(np.abs(values) > LARGEST):
        raise InvalidInputError(f"{name}: {values!r:.80}; expected numbers within ±{LARGEST:g}")


def _fit_sigma(sigma: ArrayLike, value: FloatArray) -> FloatArray:
    try:
        axes = n_axes(sigma, "sigma")
        given = float_array(sigma, "sigma", (None,) * axes).reshape(np.shape(sigma))
        fitted = np.broadcast_to(given, value.shape).copy()
    except ValueError as err:
        raise InvalidInputError(
            f"sigma: {sigma!r:.80}; expected a number, or an array of shape {value.shape}"
        ) from err
    if not np.all((fitted > 1.0 / LARGEST) & (fitted < LARGEST)):
        raise InvalidInputError(f"sigma: {sigma!r:.80}; expected finite numbers > 0")
    return fitted


def _per_plot(
    values: ArrayLike, name: str, n_plots: int, *, may_be_zero: bool = False
) -> FloatArray | float:
    """Return one number for all plots, or an array of one each."""
    values = plain(values)
    found = np.float64(values) if is_number(values) else float_array(values, name, (n_plots,))  # type: ignore[arg-type] # a number
    least, sign = (0.0, "≥") if may_be_zero else (np.nextafter(0.0, 1.0), ">")
    if not np.all((found >= least) & (found < LARGEST)):
        raise InvalidInputError(f"{name}: {values!r:.80}; expected finite numbers {sign} 0")
    return float(found) if isinstance(found, np.float64) else found
