"""Static scenes whose truth is known: objects that several sensors see once, at one time.

The scenes on which association of plots is measured: the harder, the closer the objects stand
in units of the noise, and harder still where sensors tell a direction only.
"""

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.errors import InvalidInputError
from trackweave.randomness import RandomSource, generator_of
from trackweave.simulation._checks import number, whole

__all__ = ["BearingKind", "PositionKind", "Scene", "SceneKind", "draw_scene"]

MOST_PLOTS = 10_000_000
"""Greatest expected number of plots in a scene; a larger one is a mistake."""

_set = object.__setattr__


@dataclass(frozen=True, slots=True)
class PositionKind:
    """Sensors that report positions of objects in a square.

    Parameters
    ----------
    n_sensors
        How many sensors; at least 2.
    n_objects
        How many objects; at least 0.
    spacing
        Mean distance of objects in units of ``sigma``, so that the square's side is
        spacing · sigma · √n_objects; above 0.
    sigma
        Standard deviation of a plot along each axis [m]; above 0.
    detection_probability
        Chance of each object to be reported by each sensor, above 0 and below 1.
    clutter_per_object
        Expected false alarms of each sensor for each object; at least 0. None for 0.5 with three
        sensors and 0.2 otherwise.

    Raises
    ------
    InvalidInputError
        If a value is out of range.
    """

    n_sensors: int
    n_objects: int
    spacing: float = 10.0
    sigma: float = 10.0
    detection_probability: float = 0.9
    clutter_per_object: float | None = None

    def __post_init__(self) -> None:
        _check_common(self, 0.5 if self.n_sensors == 3 else 0.2)
        _set(self, "spacing", number(self.spacing, "spacing", above=0.0))
        _set(self, "sigma", number(self.sigma, "sigma", above=0.0))

    @property
    def side(self) -> float:
        """Side of the square in which the objects stand [m]."""
        return self.spacing * self.sigma * math.sqrt(max(1, self.n_objects))


@dataclass(frozen=True, slots=True)
class BearingKind:
    """Sensors that report bearings of objects in a square, from a circle around it.

    The sensors stand at equal angles, the first in the north.

    Parameters
    ----------
    n_sensors
        How many sensors; at least 2.
    n_objects
        How many objects; at least 0.
    sigma
        Standard deviation of a bearing [rad]; above 0.
    detection_probability
        Chance of each object to be reported by each sensor, above 0 and below 1.
    clutter_per_object
        Expected false alarms of each sensor for each object; at least 0. None for 0.2.
    side
        Side of the square in which the objects stand [m]; above 0.
    radius
        Distance of the sensors from the square's centre [m], such that they stand outside.

    Raises
    ------
    InvalidInputError
        If a value is out of range.
    """

    n_sensors: int
    n_objects: int
    sigma: float = 0.002
    detection_probability: float = 0.9
    clutter_per_object: float | None = None
    side: float = 10_000.0
    radius: float = 9_000.0

    def __post_init__(self) -> None:
        _check_common(self, 0.2)
        _set(self, "sigma", number(self.sigma, "sigma", above=0.0, high=math.pi))
        _set(self, "side", number(self.side, "side", above=0.0))
        # Half the diagonal: from outside, the square fills less than half a turn.
        _set(self, "radius", number(self.radius, "radius", above=self.side / math.sqrt(2.0)))


SceneKind: TypeAlias = PositionKind | BearingKind


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """What the sensors report, and what is true.

    For each sensor ``plots`` are positions [m], shape (plots, 2), or bearings [rad], clockwise
    from north, from 0 to 2π, in an order that tells nothing; ``label`` is the object of each, −1
    for a false alarm. ``objects`` and ``places`` tell where objects and sensors stand [m], None
    where that makes no difference; ``area`` are the square's south-west and north-east corners. Of
    each sensor ``sigma`` is the standard deviation of plots, ``volume`` the field of view [m² or
    rad], over which as many ``false_alarms`` are expected, spread evenly.
    """

    plots: tuple[FloatArray, ...]
    label: tuple[IntArray, ...]
    objects: FloatArray
    places: FloatArray | None
    sigma: FloatArray
    area: tuple[tuple[float, float], tuple[float, float]]
    volume: FloatArray
    false_alarms: FloatArray
    detection_probability: float

    @property
    def object_density(self) -> float:
        """Objects per m²."""
        (west, south), (east, north) = self.area
        density: float = self.objects.shape[0] / ((east - west) * (north - south))
        return density


def draw_scene(kind: SceneKind, rng: RandomSource = 0) -> Scene:
    """Draw a scene.

    Objects stand anywhere in the square, independently; the number of false alarms of each
    sensor is Poisson distributed.

    Parameters
    ----------
    kind
        What kind of scene.
    rng
        Source of randomness: a generator, or a seed. The same gives the same scene.

    Returns
    -------
    The plots and the truth.
    """
    rng, side, n_sensors = generator_of(rng), kind.side, kind.n_sensors
    objects = rng.uniform(0.0, side, size=(kind.n_objects, 2))
    expected = (kind.clutter_per_object or 0.0) * kind.n_objects
    places = None if isinstance(kind, PositionKind) else _circle(kind)
    plots, labels, volumes = [], [], []
    for sensor in range(n_sensors):
        seen = np.flatnonzero(rng.random(kind.n_objects) < kind.detection_probability)
        n_false = int(rng.poisson(expected))
        if places is None:
            exact, volume = objects[seen], side * side
            false = rng.uniform(0.0, side, size=(n_false, 2))
        else:
            start, volume = _view(places[sensor], side)
            exact = _azimuth(objects[seen] - places[sensor])
            false = start + rng.uniform(0.0, volume, size=n_false)
        values = np.concatenate([exact + rng.normal(0.0, kind.sigma, size=exact.shape), false])
        order = rng.permutation(values.shape[0])
        plots.append(values[order] if places is None else np.mod(values[order], 2.0 * math.pi))
        labels.append(np.concatenate([seen, np.full(n_false, -1)])[order])
        volumes.append(volume)
    return Scene(
        plots=tuple(plots),
        label=tuple(labels),
        objects=objects,
        places=places,
        sigma=np.full(n_sensors, kind.sigma),
        area=((0.0, 0.0), (side, side)),
        volume=np.array(volumes),
        false_alarms=np.full(n_sensors, expected),
        detection_probability=kind.detection_probability,
    )


def _check_common(kind: SceneKind, clutter: float) -> None:
    _set(kind, "n_sensors", whole(kind.n_sensors, "n_sensors", 2))
    _set(kind, "n_objects", whole(kind.n_objects, "n_objects", 0))
    chance = number(kind.detection_probability, "detection_probability", above=0.0, high=1.0)
    if chance == 1.0:
        raise InvalidInputError("detection_probability: 1; expected a number below 1")
    _set(kind, "detection_probability", chance)
    if kind.clutter_per_object is not None:
        clutter = number(kind.clutter_per_object, "clutter_per_object", low=0.0)
    _set(kind, "clutter_per_object", clutter)
    expected = kind.n_sensors * kind.n_objects * (1.0 + clutter)
    if expected > MOST_PLOTS:
        raise InvalidInputError(
            f"n_objects: {kind.n_objects}, some {expected:g} plots; expected at most {MOST_PLOTS}"
        )


def _circle(kind: BearingKind) -> FloatArray:
    angle = 2.0 * math.pi * np.arange(kind.n_sensors) / kind.n_sensors
    return kind.side / 2.0 + kind.radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)


def _azimuth(offset: FloatArray) -> FloatArray:
    return np.arctan2(offset[:, 0], offset[:, 1])


def _view(place: FloatArray, side: float) -> tuple[float, float]:
    """Return the azimuth at which the square begins, and how wide it looks [rad]."""
    centre = math.atan2(side / 2.0 - place[0], side / 2.0 - place[1])
    corners = np.array([[0.0, 0.0], [0.0, side], [side, 0.0], [side, side]])
    # Seen from outside, no corner is more than a right angle from the centre.
    aside = np.remainder(_azimuth(corners - place) - centre + math.pi, 2.0 * math.pi) - math.pi
    return centre + float(aside.min()), float(aside.max() - aside.min())
