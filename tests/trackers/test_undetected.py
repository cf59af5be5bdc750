import copy

import numpy as np
import pytest

from trackweave.association.window_rule import Context, scan_input, swept
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.scans import Scan
from trackweave.models.coverage import FieldOfView, everywhere
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.trackers.undetected import Undetected

ORIGIN = np.zeros((1, 2))


def density(undetected, place=(0.0, 0.0), time=0.0):
    return float(np.exp(undetected.log_density(np.array([place]), time))[0])


def disc(x):
    return FieldOfView(position=(x, 0.0), max_range=10.0).coverage()


def test_is_what_was_there_in_the_beginning():
    assert density(Undetected(1e-4, 1e-6, 30.0, 1.0)) == pytest.approx(1e-4)


def test_a_scan_takes_out_what_it_detects():
    undetected = Undetected(1e-4, 1e-6, 30.0, 1.0)
    undetected.scanned(0.9, everywhere())
    assert density(undetected) == pytest.approx(1e-5)
    undetected.wait(2.0, 2.0)
    assert density(undetected) == pytest.approx(1e-5 + 2e-6)


def test_comes_to_rest_where_scans_take_out_what_comes():
    undetected = Undetected(1e-3, 1e-6, 30.0, 1.0)
    for time in range(1, 200):
        undetected.wait(float(time), 1.0)
        before = density(undetected)
        undetected.scanned(0.8, everywhere())
    assert before == pytest.approx(1e-6 / 0.8)


def test_a_scan_thins_only_where_it_looks():
    undetected = Undetected(1e-4, 1e-6, 30.0, 1.0)
    undetected.scanned(0.9, disc(0.0))
    undetected.wait(1.0, 1.0)
    undetected.scanned(0.5, disc(100.0))
    assert density(undetected, (0.0, 0.0)) == pytest.approx(1e-5 + 1e-6)
    assert density(undetected, (100.0, 0.0)) == pytest.approx(0.5 * (1e-4 + 1e-6))
    assert density(undetected, (50.0, 0.0)) == pytest.approx(1e-4 + 1e-6)


def test_what_it_remembers_of_looks_is_bounded():
    undetected = Undetected(1e-4, 1e-6, 30.0, 1.0)
    for time in range(1, 1000):
        undetected.wait(float(time), 1.0)
        undetected.scanned(0.9, disc(100.0 * (time % 2)))
    assert len(undetected._looks) <= Undetected.MAX_LOOKS
    # Each disc is looked at every other scan: two periods' worth came, then 0.9 was taken out.
    undetected.wait(1000.0, 1.0)
    assert density(undetected, (0.0, 0.0)) == pytest.approx(2e-6 / 0.9, rel=0.01)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_lost_object_is_spread_over_where_it_can_be(dim):
    undetected = Undetected(1e-9, 1e-12, 30.0, 1.0)
    undetected.lose(np.zeros(dim), 20.0, 5.0, 5.0)
    rng = np.random.default_rng(1)
    points = rng.uniform(-60.0, 60.0, size=(200_000, dim))
    values = np.exp(undetected.log_density(points, 6.0)) - 1e-9
    assert values.mean() * 120.0**dim == pytest.approx(Undetected.LOST_CHANCE, rel=0.05)
    assert np.all((np.linalg.norm(points, axis=1) <= 50.0) == (values > 1e-12))


def test_a_lost_object_is_forgotten_in_the_end_and_unknown_before():
    undetected = Undetected(1e-9, 1e-12, 30.0, 1.0)
    undetected.lose(np.zeros(2), 20.0, 5.0, 8.0)
    assert density(undetected, time=8.0) == pytest.approx(1e-9)
    assert density(undetected, time=9.0) > 1e-8
    undetected.wait(30.0, 22.0)
    assert density(undetected, time=30.0) < 1e-8


def test_a_copy_goes_its_own_way():
    one = Undetected(1e-4, 1e-6, 30.0, 1.0)
    other = copy.copy(one)
    other.scanned(0.9, disc(0.0))
    other.lose(np.zeros(2), 20.0, 5.0, 5.0)
    assert density(one, time=6.0) == pytest.approx(1e-4)


def test_years_of_waiting_are_no_flood():
    undetected = Undetected(1e-4, 1e-6, 30.0, 1.0)
    undetected.wait(1e9, 1e9)
    assert density(undetected) < 1e-2


def sector(turns):
    """Return the quarter of a turn that begins after so many turns from north."""
    return swept(everywhere(), np.zeros(2), (2 * np.pi * turns, np.pi / 2))


def test_a_beam_thins_what_it_passes():
    undetected = Undetected(1e-4, 1e-6, 30.0, 1.0)
    undetected.scanned(0.9, sector(0.0))
    assert density(undetected, (50.0, 50.0)) == pytest.approx(1e-5)
    assert density(undetected, (50.0, -50.0)) == pytest.approx(1e-4)
    for quarter in (0.25, 0.5, 0.75):
        undetected.scanned(0.9, sector(quarter))
    for place in [(50.0, 50.0), (50.0, -50.0), (-50.0, -50.0), (-50.0, 50.0)]:
        assert density(undetected, place) == pytest.approx(1e-5)


def test_sectors_that_are_forgotten_come_to_the_same_as_whole_turns():
    """Behind the last looks a sector thins everywhere by its share of a turn."""
    whole, parts = (Undetected(1e-4, 1e-6, 30.0, 4.0) for _ in range(2))
    for time in range(1, 801):
        parts.wait(float(time), 1.0)
        parts.scanned(0.8, sector(0.25 * (time % 4)))
        if time % 4 == 0:
            whole.wait(float(time), 4.0)
            whole.scanned(0.8, everywhere())
    assert len(parts._looks) <= Undetected.MAX_LOOKS
    places = [(50.0, 50.0), (50.0, -50.0), (-50.0, -50.0), (-50.0, 50.0)]
    mean = np.mean([density(parts, place) for place in places])
    # Just swept to a whole turn ago: half a period's new objects on the average.
    assert mean == pytest.approx(density(whole) + 0.375 * 1e-6, rel=0.05)


def test_beside_sensors_that_tell_places_bearings_leave_the_undetected_alone():
    sensor = Sensor("camera", 0.01, 0.9, 1e-3, 1.0, measurement=MeasurementKind.BEARING)
    context = Context(ConstantVelocity(0.1, 30.0), 2)
    data, _ = scan_input(Scan(0.0, "camera", np.empty((0, 1))), sensor, 0.0, context)
    for by_bearings, left in ((True, 0.1), (False, 1.0)):
        undetected = Undetected(1e-4, 1e-6, 30.0, 1.0, by_bearings=by_bearings)
        undetected.look(data, 0.0)
        assert density(undetected) == pytest.approx(1e-4 * left)
