"""Skies of three radars: two straight courses, one with a turn, false alarms and misses."""

from dataclasses import dataclass

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.reports import ReportTable
from trackweave.domain.scans import Scan
from trackweave.domain.truth import TruthTable
from trackweave.models.coverage import FieldOfView
from trackweave.models.sensors import Sensor
from trackweave.run.scans import complete_scans, instants_of
from trackweave.simulation import Area, Manoeuvre, Scenario, SimulatedSensor, Target, simulate

__all__ = [
    "PERIOD",
    "SEEN",
    "SIDE",
    "SIGMA",
    "SKIES",
    "STRAIGHT",
    "TURN",
    "TURNING",
    "RadarSky",
    "SkyShape",
    "draw_sky",
]  # fmt: skip

RADARS = ("A", "B", "C")
SIDE, SIGMA, PERIOD, SEEN = 20_000.0, 50.0, 1.0, 0.9
STRAIGHT, TURNING = ("alpha", "bravo"), "charlie"
TURN = (35.0, 65.0)
"""Begin and end of the turn, by 3° a second [s]."""
FORMATION = 283.0
"""How far apart the aircraft of a formation fly [m]."""
# The two straight courses pass each other at 59 m, hardly more than σ, after 60 s.
COURSES = (
    Target((2000.0, 6000.0), (150.0, 40.0), name=STRAIGHT[0]),
    Target((3800.0, 15_300.0), (120.0, -110.0), name=STRAIGHT[1]),
    Target(
        (17_500.0, 18_000.0), (-150.0, 0.0), name=TURNING,
        manoeuvres=(Manoeuvre(TURN[0], TURN[1] - TURN[0], 3.0),),
    ),
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class SkyShape:
    """Expected false alarms of each radar and scan, aircraft abreast on each course, scans."""

    false_alarms: float = 4.0
    abreast: int = 1
    n_scans: int = 100

    @property
    def n_objects(self) -> int:
        """How many aircraft there are."""
        return len(COURSES) * self.abreast


SKIES = {
    "as chosen": SkyShape(),
    "dense clutter": SkyShape(false_alarms=20.0),
    "dense clutter, formations": SkyShape(false_alarms=20.0, abreast=3),
}


@dataclass(frozen=True, slots=True, eq=False)
class RadarSky:
    """What three identical radars report of a sky, and what was there.

    ``instants`` are the radars' scans by the times at which they look together; ``instant`` and
    ``target`` are of each plot, by the report's number: its instant, and its aircraft, -1 for a
    false alarm.
    """

    shape: SkyShape
    reports: ReportTable
    truth: TruthTable
    sensors: tuple[Sensor, ...]
    instants: tuple[tuple[Scan, ...], ...]
    instant: IntArray
    target: IntArray

    def course(self, name: str) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return times [s], positions [m] and velocities [m/s] of an aircraft."""
        own = self.truth.target == name
        assert self.truth.velocity is not None  # simulated
        return self.truth.time[own], self.truth.position[own], self.truth.velocity[own]


def draw_sky(shape: SkyShape, rng: np.random.Generator) -> RadarSky:
    """Return a sky and what the radars report of it."""
    radars = tuple(
        SimulatedSensor(name, SIGMA, PERIOD, SEEN, shape.false_alarms) for name in RADARS
    )
    area, aside = Area((0.0, 0.0), (SIDE, SIDE)), FORMATION / np.sqrt(2.0)
    # Of each course the first aircraft has the course's name.
    aircraft = tuple(
        Target(
            (course.position[0] + aside * place, course.position[1] + aside * place),
            course.velocity, manoeuvres=course.manoeuvres,
            name=course.name if place == 0 else f"{course.name}.{place}",
        )
        for course in COURSES
        for place in range(shape.abreast)
    )  # fmt: skip
    made = simulate(Scenario(area, (shape.n_scans - 1) * PERIOD, radars, aircraft), rng)
    scans = complete_scans(made.reports, dict.fromkeys(RADARS, PERIOD))
    instants = tuple(instants_of(scans, 0.1 * PERIOD))
    instant = np.empty(len(made.reports), dtype=np.int64)
    for number, together in enumerate(instants):
        for scan in together:
            instant[scan.report] = number
    names = [str(name) for name in dict.fromkeys(made.truth.target)]
    target = [names.index(name) if name else -1 for name in made.reports.carried["target"]]
    view = FieldOfView(polygon=((0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE)))
    sensors = tuple(
        Sensor(name, SIGMA, SEEN, shape.false_alarms / SIDE**2, PERIOD, field_of_view=view)
        for name in RADARS
    )
    return RadarSky(
        shape, made.reports, made.truth, sensors, instants, instant, np.array(target)
    )  # fmt: skip
