"""Skies of three radars: two straight courses, one with a turn, false alarms and misses."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.domain.truth import TruthTable
from trackweave.models.coverage import FieldOfView
from trackweave.models.sensors import Sensor
from trackweave.run.instants import instants_of
from trackweave.run.scans import complete_scans
from trackweave.simulation import Area, Manoeuvre, Scenario, SimulatedSensor, Target, simulate

__all__ = [
    "FORMATION",
    "PERIOD",
    "RADARS",
    "SEEN",
    "SIDE",
    "SIGMA",
    "STRAIGHT",
    "TURNING",
    "TURN_BEGINS",
    "TURN_ENDS",
    "RadarSky",
    "SkyShape",
    "draw_sky",
]

RADARS = ("A", "B", "C")
SIDE, SIGMA, PERIOD, SEEN = 20_000.0, 50.0, 1.0, 0.9
STRAIGHT, TURNING = ("1", "2"), "3"
TURN_BEGINS, TURN_ENDS, TURN_RATE = 35.0, 65.0, 3.0
FORMATION = 283.0
"""How far apart the aircraft of a formation fly [m]."""
# The two straight courses pass each other at 59 m, hardly more than σ, after 60 s.
COURSES = (
    Target((2000.0, 6000.0), (150.0, 40.0), name=STRAIGHT[0]),
    Target((3800.0, 15_300.0), (120.0, -110.0), name=STRAIGHT[1]),
    Target(
        (17_500.0, 18_000.0), (-150.0, 0.0), name=TURNING,
        manoeuvres=(Manoeuvre(TURN_BEGINS, TURN_ENDS - TURN_BEGINS, TURN_RATE),),
    ),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class SkyShape:
    """What a sky is like.

    Parameters
    ----------
    false_alarms
        Expected false alarms of each radar and scan; above 0.
    abreast
        How many aircraft fly each of the three courses, in formation; at least 1.
    n_scans
        How many times the radars look, once a second.
    """

    false_alarms: float = 4.0
    abreast: int = 1
    n_scans: int = 100

    @property
    def n_objects(self) -> int:
        """How many aircraft there are."""
        return len(COURSES) * self.abreast


@dataclass(frozen=True, slots=True, eq=False)
class RadarSky:
    """What three identical radars report of a sky, and what was there.

    Parameters
    ----------
    shape
        What it is like.
    reports
        All plots.
    instants
        The radars' scans, by the times at which they look together.
    target
        The aircraft behind each plot, -1 for a false alarm, by the report's number.
    truth
        Where the aircraft are.
    sensors
        The radars, as they are.
    """

    shape: SkyShape
    reports: ReportTable
    instants: tuple[tuple[Scan, ...], ...]
    target: NDArray[np.int64]
    truth: TruthTable
    sensors: tuple[Sensor, ...]

    def course(self, name: str) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return times [s], positions [m] and velocities [m/s] of an aircraft."""
        own = self.truth.target == name
        assert self.truth.velocity is not None  # simulated
        return self.truth.time[own], self.truth.position[own], self.truth.velocity[own]


def draw_sky(shape: SkyShape, rng: np.random.Generator) -> RadarSky:
    """Return a sky and what the radars report of it.

    Parameters
    ----------
    shape
        What it is like.
    rng
        Source of randomness.

    Returns
    -------
    The sky.
    """
    radars = tuple(
        SimulatedSensor(name, SIGMA, PERIOD, SEEN, shape.false_alarms) for name in RADARS
    )
    area = Area((0.0, 0.0), (SIDE, SIDE))
    duration = (shape.n_scans - 1) * PERIOD
    made = simulate(Scenario(area, duration, radars, _aircraft(shape)), rng)
    periods: dict[str, float | None] = dict.fromkeys(RADARS, PERIOD)
    scans = complete_scans(made.reports, periods)
    names = [str(name) for name in dict.fromkeys(made.truth.target)]
    number = {name: place for place, name in enumerate(names)}
    target = [number.get(str(name), -1) for name in made.reports.carried["target"]]
    return RadarSky(
        shape, made.reports, tuple(instants_of(scans, 0.1 * PERIOD)),
        np.array(target, dtype=np.int64), made.truth, _sensors(shape),
    )  # fmt: skip


def _aircraft(shape: SkyShape) -> tuple[Target, ...]:
    """Return the aircraft: of each course the first has the course's name."""
    aside = FORMATION / np.sqrt(2.0)
    return tuple(
        Target(
            (course.position[0] + aside * place, course.position[1] + aside * place),
            course.velocity, manoeuvres=course.manoeuvres,
            name=course.name if place == 0 else f"{course.name}.{place}",
        )
        for course in COURSES
        for place in range(shape.abreast)
    )  # fmt: skip


def _sensors(shape: SkyShape) -> tuple[Sensor, ...]:
    corners = ((0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE))
    return tuple(
        Sensor(
            name, SIGMA, SEEN, shape.false_alarms / SIDE**2, PERIOD,
            field_of_view=FieldOfView(polygon=corners),
        )
        for name in RADARS
    )  # fmt: skip
