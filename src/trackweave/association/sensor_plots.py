"""One sensor's plots at one instant."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from trackweave.arrays import FloatArray, float_array, is_number, require_finite
from trackweave.errors import InvalidInputError
from trackweave.simulation.scenes import Scene

__all__ = ["SensorPlots", "scene_plots"]

LARGEST = 1e30
"""Greatest coordinate and standard deviation; with larger ones, kernels would lose their range."""


@dataclass(frozen=True, slots=True, eq=False)
class SensorPlots:
    """One sensor's plots at one instant, and what is known of that sensor.

    Parameters
    ----------
    value
        Positions [m], shape (plots, 2) or (plots, 3), or bearings [rad], clockwise from north,
        shape (plots,).
    sigma
        Standard deviation [m or rad]: one number, or an array that fits ``value``; above 0.
    volume
        Field of view in the measurement's units [m², m³ or rad]; above 0.
    false_alarms
        Expected false alarms, spread evenly over the field of view; above 0.
    detection_probability
        Chance to report an object, above 0 and below 1.
    place
        Where the sensor stands [m], shape (2,); only bearings need it.

    Raises
    ------
    InvalidInputError
        If a shape does not fit or a value is out of range.
    """

    value: FloatArray
    sigma: ArrayLike
    volume: float
    false_alarms: float
    detection_probability: float = 0.9
    place: ArrayLike | None = None

    def __post_init__(self) -> None:
        value = _whole_table(self.value)
        dim = value.ndim
        _require_moderate(value, "value")
        if dim == 1:
            value = np.mod(value, 2.0 * math.pi)
        object.__setattr__(self, "value", value)
        object.__setattr__(self, "sigma", _fit_sigma(self.sigma, value))
        for name in ("volume", "false_alarms", "detection_probability"):
            found = getattr(self, name)
            if not (is_number(found) and found > 0):
                raise InvalidInputError(f"{name}: {found!r}; expected a finite number > 0")
        if not self.detection_probability < 1:
            raise InvalidInputError(
                f"detection_probability: {self.detection_probability}; expected between 0 and 1"
            )
        if self.place is not None:
            place = float_array(self.place, "place", (2,))
            _require_moderate(place, "place")
            object.__setattr__(self, "place", place)
        elif dim == 1:
            raise InvalidInputError("place: None; expected where the sensor of bearings stands")

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
        fitted = np.broadcast_to(np.asarray(sigma, dtype=np.float64), value.shape).copy()
    except (TypeError, ValueError) as err:
        raise InvalidInputError(
            f"sigma: {sigma!r:.80}; expected a number, or an array of shape {value.shape}"
        ) from err
    if not np.all((fitted > 1.0 / LARGEST) & (fitted < LARGEST)):
        raise InvalidInputError(f"sigma: {sigma!r:.80}; expected finite numbers > 0")
    return fitted
