"""Static scenes whose truth is known: objects that several sensors see once, at one time.

The scenes on which association of plots is measured: the harder, the closer the objects stand
in units of the noise, and harder still where sensors tell a direction only.
"""

import math
from dataclasses import dataclass
from typing import Annotated, TypeAlias

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.keys import ABOVE_ZERO, AT_LEAST_ZERO, Key
from trackweave.randomness import RandomSource, generator_of

__all__ = ["BearingKind", "PositionKind", "Scene", "SceneKind", "draw_scene"]

MOST_PLOTS = 10_000_000
"""Greatest expected number of plots in a scene; a larger one is a mistake."""
CHANCE = Key("a number above 0, below 1", ABOVE_ZERO.least, math.nextafter(1.0, 0.0))
SENSORS = Key("a whole number of at least 2", 2)
OBJECTS = Key("a whole number of at least 0", 0)


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

    n_sensors: Annotated[int, SENSORS]
    n_objects: Annotated[int, OBJECTS]
    spacing: Annotated[float, ABOVE_ZERO] = 10.0
    sigma: Annotated[float, ABOVE_ZERO] = 10.0
    detection_probability: Annotated[float, CHANCE] = 0.9
    clutter_per_object: Annotated[float | None, AT_LEAST_ZERO] = None

    def __post_init__(self) -> None:
        settle(self)
        _check_common(self, 0.5 if self.n_sensors == 3 else 0.2)

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

    n_sensors: Annotated[int, SENSORS]
    n_objects: Annotated[int, OBJECTS]
    sigma: Annotated[float, Key("a number above 0, at most π", ABOVE_ZERO.least, math.pi)] = 0.002
    detection_probability: Annotated[float, CHANCE] = 0.9
    clutter_per_object: Annotated[float | None, AT_LEAST_ZERO] = None
    side: Annotated[float, ABOVE_ZERO] = 10_000.0
    radius: float = 9_000.0

    def __post_init__(self) -> None:
        settle(self)
        _check_common(self, 0.2)
        # Half the diagonal: from outside, the square fills less than half a turn.
        least = self.side / math.sqrt(2.0)
        if not self.radius > least:
            raise InvalidInputError(f"radius: {self.radius!r}; expected a number above {least:g}")


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
    if kind.clutter_per_object is None:
        object.__setattr__(kind, "clutter_per_object", clutter)
    clutter = kind.clutter_per_object or 0.0
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
