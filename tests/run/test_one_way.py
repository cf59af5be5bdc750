"""Objects that go as far from look to look as the next is ahead: traffic, moving stairs."""

import numpy as np
import polars as pl
import pytest

from trackweave import track
from trackweave.metrics import assignment_quality

pytestmark = pytest.mark.slow


def traffic(seed: int, gaps: float) -> pl.DataFrame:
    """Return a picture every two seconds of a carriageway of two lanes, and what is nobody's."""
    rng, rows, cars = np.random.default_rng(seed), [], []
    for lane, speed in enumerate((24.0, 30.0)):
        began = -30.0
        while began < 200.0:
            began += gaps * rng.uniform(1.4, 4.5)
            cars.append((began, 3.7 * lane, speed + rng.normal(0.0, 1.0)))
    for time in np.arange(0.0, 200.0, 2.0):
        for car, (began, across, speed) in enumerate(cars):
            along = (time - began) * speed
            if 0.0 <= along <= 600.0 and rng.random() < 0.93:
                noise = rng.normal(0.0, (1.5, 0.5))
                rows.append((time, along + noise[0], across + noise[1], str(car)))
        for _ in range(rng.poisson(0.3)):
            rows.append((time, *rng.uniform((0.0, -3.0), (600.0, 7.0)), ""))
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


def stairs(seed: int) -> pl.DataFrame:
    """Return a picture a second of people on stairs that move, one row up and one down."""
    rng, rows, people = np.random.default_rng(seed), [], []
    for across, speed, least, most in ((0.0, 0.65, 1.0, 3.5), (1.2, -0.65, 1.2, 4.0)):
        began = -25.0
        while began < 100.0:
            began += rng.uniform(least, most)
            people.append((began, across + rng.normal(0.0, 0.08), speed))
    for time in np.arange(0.0, 100.0):
        for who, (began, across, speed) in enumerate(people):
            along = (time - began) * abs(speed)
            if 0.0 <= along <= 16.0 and rng.random() < 0.95:
                place = np.array([along if speed > 0.0 else 16.0 - along, across])
                rows.append((time, *(place + rng.normal(0.0, 0.08, 2)), str(who)))
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


@pytest.mark.parametrize("reports", [traffic(3, 1.0), traffic(4, 2.0), stairs(3)])
def test_all_are_tracked_with_nothing_told(reports: pl.DataFrame) -> None:
    result = track(reports.drop("target"))
    whose = reports["target"].to_list()
    found = assignment_quality(whose, result.assignments["track"].fill_null(-1).to_list())
    assert found.idf1 > 0.95
