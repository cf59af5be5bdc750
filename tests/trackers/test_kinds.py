"""Tracks of sensors that turn, that see directions alone, that know names and strengths."""

import numpy as np
import pytest

from oracles.scenes import all_assignments, run, scan, sensor, tracker
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
from trackweave.models.motion import ConstantVelocity
from trackweave.models.rotation import Rotation
from trackweave.models.strength import StrengthModel
from trackweave.trackers._arguments import merged
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.window import Window

LOUD = StrengthModel(target_mean=12.0, target_sigma=2.0, clutter_mean=3.0, clutter_sigma=2.0)


def named(time, names, swap=False):
    """Return a scan of two objects side by side; ``names`` are what their reports say."""
    rng = np.random.default_rng(int(time * 10))
    places = np.array([[8.0 * time, 0.0], [8.0 * time, 25.0]]) + rng.normal(0, 6.0, (2, 2))
    order = [1, 0] if swap else [0, 1]
    return Scan(
        float(time), "radar", places[order], report=2 * int(time) + np.arange(2),
        identity=np.array(names)[order],
    )  # fmt: skip


def test_names_keep_objects_apart_that_their_places_do_not():
    """Two objects cross at 25 m with σ = 10 m; what the reports say tells who is who."""
    target = tracker()
    scans = []
    for time in range(16):
        aside = 80.0 * np.cos(np.pi * time / 15)
        places = np.array([[8.0 * time, aside], [8.0 * time, -aside]])
        scans.append(Scan(float(time), "radar", places, report=[2 * time, 2 * time + 1],
                          identity=[3, 8]))  # fmt: skip
    assigned = all_assignments(target, run(target, scans))
    for first in (0, 1):
        assert len({assigned[2 * time + first] for time in range(16)} - {-1}) == 1
    assert len(set(assigned.values()) - {-1}) == 2


@pytest.mark.parametrize("wrong", [(3, 3), (8, 3), (-1, -1), (5, 8)])
def test_one_wrong_name_in_between_changes_no_track(wrong):
    target = tracker()
    scans = [named(time, wrong if time == 6 else (3, 8), swap=time % 2) for time in range(12)]
    assigned = all_assignments(target, run(target, scans))
    tracks = {}
    for time in (0, 5, 7, 11):
        first, second = (1, 0) if time % 2 else (0, 1)
        tracks.setdefault(3, set()).add(assigned[2 * time + first])
        tracks.setdefault(8, set()).add(assigned[2 * time + second])
    assert all(len(each) == 1 for each in tracks.values())
    assert tracks[3] != tracks[8]


def test_a_name_that_changes_for_good_is_the_same_track():
    """A lone object: what it is called changes, where it is does not."""
    target = tracker()
    scans = [
        Scan(float(time), "radar", [[8.0 * time, 0.0]], report=[time],
             identity=[3 if time < 6 else 9])
        for time in range(12)
    ]  # fmt: skip
    hypotheses = run(target, scans)
    assert set(all_assignments(target, hypotheses).values()) == {1}
    assert hypotheses[-1].tracks.hits.tolist() == [12]
    node = np.flatnonzero(target._tree.nodes.chosen[: target._tree.n_nodes])[0]
    assert target._tree.nodes.identity[node] == 9


def test_a_name_holds_a_track_that_leaps():
    """It is reported 400 m aside, where its gate lets nobody come."""
    target = tracker(motion=ConstantVelocity(process_noise=0.5, max_speed=500.0))
    scans = [
        Scan(float(time), "radar", [[8.0 * time, 400.0 * (time > 5)], [8.0 * time, -3000.0]],
             report=[2 * time, 2 * time + 1], identity=[3, 8])
        for time in range(12)
    ]  # fmt: skip
    hypotheses = run(target, scans)
    assigned = all_assignments(target, hypotheses)
    assert len({assigned[2 * time] for time in range(12)}) == 1
    assert len(set(assigned.values())) == 2
    last = hypotheses[-1].tracks.mean[:, :2]
    np.testing.assert_allclose(last[last[:, 1] > 0.0][0], [88.0, 400.0], atol=5.0)


def test_two_that_swap_their_names_stay_where_they_are():
    """Kilometres apart they are sooner named wrongly than there at once."""
    target = tracker(sensor(identity_error=1e-7))
    scans = [
        Scan(float(time), "radar", [[8.0 * time, 0.0], [8.0 * time, -3000.0]],
             report=[2 * time, 2 * time + 1], identity=[3, 8] if time < 6 else [8, 3])
        for time in range(12)
    ]  # fmt: skip
    assigned = all_assignments(target, run(target, scans))
    assert len({assigned[2 * time] for time in range(12)}) == 1
    assert len(set(assigned.values())) == 2


@pytest.mark.parametrize(("level", "begins"), [(12.0, True), (2.0, False)])
def test_strength_helps_to_begin(level, begins):
    """In clutter where places alone leave it open, loud reports make a track, faint ones none."""
    heavy = sensor(strength=LOUD, clutter_density=1e-4)
    target = tracker(heavy, lifecycle=Lifecycle(new_target_density=1e-7))
    scans = [
        Scan(float(time), "radar", [[8.0 * time, 0.0]], strength=[level]) for time in range(4)
    ]
    assert (len(run(target, scans)[-1].tracks) == 1) == begins


def test_of_two_reports_a_track_takes_the_louder():
    target = tracker(sensor(strength=LOUD))
    scans = []
    for time in range(8):
        near = [[8.0 * time, 6.0], [8.0 * time, -6.0]]
        scans.append(Scan(float(time), "radar", near, report=[2 * time, 2 * time + 1],
                          strength=[13.0, 2.0]))  # fmt: skip
    assigned = all_assignments(target, run(target, scans))
    assert {assigned[2 * time] for time in range(8)} == {1}
    assert {assigned[2 * time + 1] for time in range(8)} == {-1}


def turning(name="radar", **changed):
    values = {
        "sigma": (10.0, 0.005), "measurement": Kind.RANGE_AZIMUTH, "scan_period": 4.0,
        "rotation": Rotation(4.0), "position": (0.0, 0.0), "clutter_density": 1e-4,
    }  # fmt: skip
    return sensor(name, **(values | changed))


def sectors(seconds, place, speed, number=0):
    """Yield the eighths of a radar's turns as they end, with a report of an object when met."""
    for step in range(1, int(2 * seconds) + 1):
        end = step / 2
        rows, times = [], []
        for time in np.arange(end - 0.5, end, 0.002):
            true = np.asarray(place) + np.asarray(speed) * time
            azimuth = np.arctan2(*true) % (2 * np.pi)
            if abs(np.angle(np.exp(1j * (azimuth - np.pi / 2 * time)))) < 0.0016:
                rows, times = [[np.hypot(*true), azimuth]], [time]
        numbers = number + np.arange(len(rows))
        number += len(rows)
        yield Scan(end, "radar", np.reshape(rows, (-1, 2)), report=numbers, moments=times)


def test_a_track_misses_nothing_while_the_beam_is_elsewhere():
    target = tracker(turning())
    scans = list(sectors(40.0, (900.0, 300.0), (0.0, 10.0)))
    hypotheses = run(target, scans)
    assert sum(len(each) for each in scans) in (10, 11)
    assert set(all_assignments(target, hypotheses).values()) == {1}
    believed = [hypothesis.tracks.status.tolist() for hypothesis in hypotheses[30:]]
    assert believed == [[1]] * len(believed)


def test_a_second_report_of_a_turn_is_none_of_the_same_object():
    target = tracker(turning(), window=3)
    scans, doubles, number = [], [], 1000
    for each in sectors(40.0, (900.0, 300.0), (0.0, 10.0)):
        if len(each) and each.time in (13.0, 29.0):
            again = np.minimum(each.moments + 0.02, each.time)
            doubles.append((int(each.report[0]), number))
            scans.append(Scan(
                each.time, "radar", np.concatenate([each.measurement, each.measurement + 1e-3]),
                report=[*each.report, number], moments=[*each.moments, *again],
            ))  # fmt: skip
            number += 1
        else:
            scans.append(each)
    hypotheses = run(target, scans)
    assigned = all_assignments(target, hypotheses)
    assert len(doubles) == 2
    for pair in doubles:
        assert sum(assigned[number] == 1 for number in pair) == 1
    assert hypotheses[-1].tracks.track.tolist() == [1]


def test_bearings_of_one_place_begin_nothing():
    gaze = sensor("gaze", measurement=Kind.BEARING, sigma=0.003, clutter_density=0.5)
    target = tracker(gaze)
    scans = [Scan(float(time), "gaze", [[0.3 + 0.01 * time]]) for time in range(10)]
    for hypothesis in run(target, scans):
        assert len(hypothesis.tracks) == 0


def test_bearings_refine_a_radars_track():
    coarse = turning(rotation=None, scan_period=1.0, sigma=(20.0, 0.05))
    gaze = sensor(
        "gaze", measurement=Kind.BEARING, sigma=0.002, clutter_density=0.5, position=(0.0, 0.0)
    )
    spreads = []
    for sensors in ((coarse,), (coarse, gaze)):
        rng = np.random.default_rng(1)
        target, scans = tracker(*sensors), []
        for time in range(12):
            true = np.array([2000.0 + 8.0 * time, 3000.0])
            exact = np.array([np.hypot(*true), np.arctan2(*true)])
            scans.append(Scan(float(time), "radar", [exact + rng.normal(0, [20.0, 0.05])]))
            if len(sensors) > 1:
                scans.append(Scan(float(time), "gaze", [[exact[1] + rng.normal(0, 0.002)]]))
        tracks = run(target, scans)[-1].tracks
        assert len(tracks) == 1
        spreads.append(np.sqrt(np.linalg.eigvalsh(tracks.covariance[0, :2, :2])[-1]))
    assert spreads[1] < 0.4 * spreads[0]


def test_bearings_that_cross_begin_tracks():
    eyes = [
        sensor(name, measurement=Kind.BEARING, sigma=0.003, clutter_density=0.5, position=place)
        for name, place in {"west": (-1000.0, 0.0), "east": (1500.0, -200.0)}.items()
    ]
    target, rng, scans = tracker(*eyes), np.random.default_rng(2), []
    for time in range(10):
        true = np.array([300.0 + 5.0 * time, 1500.0])
        for eye in eyes:
            exact = np.arctan2(*(true - eye.position))
            scans.append(Scan(float(time), eye.name, [[exact + rng.normal(0, 0.003)]]))
    tracks = run(target, scans)[-1].tracks
    assert tracks.track.tolist() == [1]
    np.testing.assert_allclose(tracks.mean[0, :2], [345.0, 1500.0], atol=15.0)


def test_positions_without_height_join_a_track_in_space():
    point = sensor("map", sigma=10.0)
    high = sensor(
        "high", measurement=Kind.RANGE_AZIMUTH_ELEVATION, sigma=(10.0, 0.003, 0.003),
        clutter_density=1e-2,
    )  # fmt: skip
    target, scans = tracker(high, point), []
    for time in range(8):
        true = np.array([500.0 + 10.0 * time, 800.0, 300.0])
        level = np.hypot(*true[:2])
        full = [np.linalg.norm(true), np.arctan2(*true[:2]), np.arctan2(true[2], level)]
        scans += [Scan(float(time), "high", [full], report=[2 * time])]
        scans += [Scan(float(time), "map", [true[:2]], report=[2 * time + 1])]
    hypotheses = run(target, scans)
    assert set(all_assignments(target, hypotheses).values()) == {1}
    np.testing.assert_allclose(hypotheses[-1].tracks.mean[0, :3], true, atol=8.0)


@pytest.mark.parametrize("dim", [2, 3])
def test_dimensions_may_be_said_beforehand(dim):
    target = tracker(dim=dim)
    assert run(target, [scan(0.0, [])])[0].tracks.dim == dim


@pytest.mark.parametrize("dim", [1, 4, "2", 2.5])
def test_refuses_dimensions_that_are_none(dim):
    with pytest.raises(InvalidInputError, match=r"dim: .*; expected 2 or 3"):
        tracker(dim=dim)


@pytest.mark.parametrize(
    ("kind", "rows", "message"),
    [
        (
            Kind.RANGE_AZIMUTH,
            [[1.0, 2.0, 3.0]],
            "3 numbers per report; expected 2 of range-azimuth",
        ),
        (Kind.BEARING, [[1.0, 2.0]], "2 numbers per report; expected 1 of bearing"),
        (Kind.RANGE_AZIMUTH_ELEVATION, [[1.0, 2.0]], "expected 3 of range-azimuth-elevation"),
    ],
)
def test_refuses_reports_of_another_size(kind, rows, message):
    target = tracker(sensor(measurement=kind, sigma=0.01))
    with pytest.raises(InvalidInputError, match=message):
        run(target, [Scan(0.0, "radar", rows)])


@pytest.mark.parametrize("first", [(6,), (2, 6), None])
def test_reports_that_come_in_two_parts_keep_where_their_sensor_was(first):
    own = sensor(position=(5.0, 6.0))
    known = None if first is None else np.full(first, 7.0)
    one = Scan(1.0, "radar", [[1.0, 2.0], [3.0, 4.0]], platform=known, identity=[3, -1])
    other = Scan(1.0, "radar", [[5.0, 6.0]], platform=np.full(6, 9.0), strength=[2.0])
    whole = merged(one, other, own)
    usual = [5.0, 6.0, 0.0, 0.0, 0.0, 0.0]
    wanted = [usual] * 2 if first is None else [[7.0] * 6] * 2
    np.testing.assert_array_equal(whole.platform, [*wanted, [9.0] * 6])
    assert whole.identity.tolist() == [3, -1, -1]
    np.testing.assert_array_equal(whole.strength, [np.nan, np.nan, 2.0])
    nothing = Scan(1.0, "radar", np.empty((0, 2)), platform=np.full(6, 9.0))
    assert merged(nothing, nothing, own).platform.tolist() == [9.0] * 6


def test_depth_counts_turns_however_many_sectors_they_have():
    target = tracker(turning(), window=Window(depth=2, max_scans=60))
    run(target, list(sectors(24.0, (900.0, 300.0), (0.0, 10.0))))
    held = [known.data.time for known in target._open.scans]
    assert held == [16.5 + 0.5 * step for step in range(16)]


def test_room_for_scans_is_counted_in_turns():
    """Eighths of a turn are no scans of their own; room is kept for a whole one to come."""
    target = tracker(turning(), window=Window(depth=9, max_scans=3))
    run(target, list(sectors(24.0, (900.0, 300.0), (0.0, 10.0))))
    shares = [known.share for known in target._open.scans]
    np.testing.assert_allclose(shares, 1 / 8)
    assert 2.0 <= sum(shares) <= 3.0


@pytest.mark.parametrize("second", [5300.0, 350.0, -90.0])
def test_positions_and_degrees_are_no_azimuths(second):
    radar = sensor(sigma=(30.0, 0.002), measurement=Kind.RANGE_AZIMUTH)
    with pytest.raises(InvalidInputError, match=f"azimuth of {second:g} rad; expected radians"):
        run(tracker(sensors=[radar]), [scan(0.0, [(4000.0, 1.0), (2000.0, second)])])
