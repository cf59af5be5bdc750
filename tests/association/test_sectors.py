"""Where a scan looked: fields of view about their sensors, as far as the beam went."""

import numpy as np
import pytest

from trackweave.association.window_rule import Context, scan_input, swept
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.scans import Scan
from trackweave.models._kernels import is_covered
from trackweave.models.coverage import FieldOfView, everywhere
from trackweave.models.motion import ConstantVelocity
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor

MOTION = ConstantVelocity(0.1, 30.0)
PLACE = np.array([100.0, -50.0])


def turning(**changed):
    values = {
        "name": "radar", "sigma": (10.0, 0.01), "measurement": Kind.RANGE_AZIMUTH,
        "scan_period": 4.0, "rotation": Rotation(4.0), "position": (100.0, -50.0),
    }  # fmt: skip
    return Sensor(**(values | changed))


def looked(sensor, scan, start=None):
    return scan_input(scan, sensor, 0.0, Context(MOTION, 2, start=start))[0]


def sees(coverage, azimuth, distance=500.0, centre=PLACE):
    angle = np.radians(azimuth)
    x, y = centre + distance * np.array([np.sin(angle), np.cos(angle)])
    return bool(is_covered(x, y, coverage))


@pytest.mark.parametrize("seed", range(5))
def test_what_is_swept_is_what_both_hold(seed):
    """Where they overlap in one piece; of two, in the larger."""
    rng = np.random.default_rng(seed)
    for _ in range(40):
        own = rng.uniform(0, 360), rng.uniform(5, 360)
        first, width = rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 2 * np.pi)
        view = FieldOfView(tuple(PLACE), 100.0, 900.0, (own[0], own[0] + own[1])).coverage()
        both = swept(view, PLACE, (first, width))
        beam = swept(everywhere(), PLACE, (first, width))
        azimuths = np.arange(0.25, 360.0, 0.5)
        shared = np.array([sees(view, a) and sees(beam, a) for a in azimuths])
        held = np.array([sees(both, a) for a in azimuths])
        assert not np.any(held & ~shared)
        n_pieces = int(np.sum(shared != np.roll(shared, 1))) // 2
        if n_pieces < 2:
            assert np.sum(held != shared) <= 1
        else:
            assert np.sum(held) >= np.sum(shared) / 2 - 1
        assert not sees(both, np.degrees(first) + 1.0, distance=950.0)


def test_a_whole_turn_cuts_no_sector_that_passes_north():
    view = FieldOfView(tuple(PLACE), 0.0, 900.0).coverage()
    both = swept(view, PLACE, (np.radians(330.0), np.radians(45.0)))
    assert [sees(both, azimuth) for azimuth in (320, 335, 355, 5, 14, 20)] == [
        False, True, True, True, True, False,
    ]  # fmt: skip


def test_a_sector_of_a_sensor_that_sees_everything_is_about_the_sensor():
    scan = Scan(1.0, "radar", [[500.0, 0.3]], moments=[0.5])
    coverage = looked(turning(), scan, start=0.0).coverage
    assert [sees(coverage, azimuth) for azimuth in (1, 45, 89, 91, 180, 359)] == [
        True, True, True, False, False, False,
    ]  # fmt: skip
    assert sees(coverage, 45.0, distance=1e7)


@pytest.mark.parametrize(("direction", "azimuths"), [(1, (100, 170)), (-1, (190, 260))])
def test_a_beam_passes_either_way(direction, azimuths):
    sensor = turning(rotation=Rotation(4.0, direction=direction))
    scan = Scan(2.0, "radar", np.empty((0, 2)), moments=[])
    coverage = looked(sensor, scan, start=1.0).coverage
    assert all(sees(coverage, azimuth) for azimuth in azimuths)
    assert not any(sees(coverage, (azimuth + 180) % 360) for azimuth in azimuths)


def test_a_whole_turn_covers_the_whole_field_of_view():
    view = FieldOfView(tuple(PLACE), max_range=900.0)
    scan = Scan(4.0, "radar", [[500.0, 0.3]], moments=[1.0])
    coverage = looked(turning(field_of_view=view), scan, start=0.0).coverage
    np.testing.assert_array_equal(coverage.bounds, view.coverage().bounds)
    whole = looked(turning(), scan, start=-3.0).coverage
    assert whole.everywhere


def test_a_scan_of_one_time_looks_everywhere_at_once():
    data = looked(turning(), Scan(1.0, "radar", [[500.0, 0.3]]))
    assert data.coverage.everywhere
    assert (data.reference, data.has_moments) == (1.0, False)


def test_a_turn_is_looked_at_in_its_middle():
    data = looked(turning(), Scan(4.0, "radar", [[500.0, 0.3]], moments=[1.0]), start=1.0)
    assert (data.reference, data.time, data.has_moments) == (2.5, 4.0, True)
    # Of a turn whose begin nobody knows, the first report is the begin.
    data = looked(turning(), Scan(4.0, "radar", [[5.0, 0.3], [6.0, 0.4]], moments=[1.0, 2.0]))
    assert data.reference == 2.5


def test_reports_of_a_turning_sensor_lie_half_a_turn_apart():
    assert looked(turning(), Scan(1.0, "radar", [[5.0, 0.3]])).separation == 2.0
    still = turning(rotation=None)
    assert looked(still, Scan(1.0, "radar", [[5.0, 0.3]])).separation == 0.0
    own_times = Scan(1.0, "radar", [[5.0, 0.3]], moments=[0.5])
    # Nobody knows that it turns: a beam that sweeps to and fro is soon back.
    assert looked(still, own_times).separation == pytest.approx(0.2)


def test_a_moving_sensor_sees_about_where_it_is():
    sensor = turning(position=None, rotation=None, field_of_view=FieldOfView(max_range=600.0))
    platform = np.array([4000.0, 3000.0, 0.0, 10.0, 0.0, 0.0])
    for measurement in ([[500.0, 0.3]], np.empty((0, 2))):
        coverage = looked(sensor, Scan(1.0, "radar", measurement, platform=platform)).coverage
        assert sees(coverage, 200.0, 590.0, platform[:2])
        assert not sees(coverage, 200.0, 610.0, platform[:2])
        assert not is_covered(0.0, 0.0, coverage)


def test_a_configured_place_gives_way_to_where_the_scan_says_the_sensor_is():
    view = FieldOfView(tuple(PLACE), max_range=600.0)
    sensor = turning(rotation=None, field_of_view=view)
    platform = np.array([4000.0, 3000.0, 0.0, 10.0, 0.0, 0.0])
    coverage = looked(sensor, Scan(1.0, "radar", [[500.0, 0.3]], platform=platform)).coverage
    assert is_covered(4000.0, 3500.0, coverage)
    assert not is_covered(100.0, 0.0, coverage)


def test_a_scan_without_reports_may_hold_no_platforms():
    scan = Scan(1.0, "radar", np.empty((0, 2)), platform=np.empty((0, 6)))
    data = looked(turning(rotation=None), scan)
    assert data.measurement.shape == (0, 2)


def test_a_sensors_own_motion_is_no_motion_of_a_new_object():
    """What closes in because the sensor does is as likely as what stands still before it."""
    sensor = turning(
        name="doppler", sigma=(10.0, 0.01, 1.0), measurement=Kind.RANGE_AZIMUTH_RATE,
        rotation=None, position=None,
    )  # fmt: skip
    north = np.array([0.0, 0.0, 0.0, 0.0, 80.0, 0.0])
    ahead = np.array([[1000.0, 0.0, -80.0], [1000.0, np.pi, 80.0], [1000.0, np.pi / 2, 0.0]])
    moving = looked(sensor, Scan(0.0, "doppler", ahead, platform=north)).log_begin
    still = looked(sensor, Scan(0.0, "doppler", ahead * [1.0, 1.0, 0.0])).log_begin
    np.testing.assert_allclose(moving, still)
