"""A beam's turn is found from when it reports in which direction."""

import numpy as np
import pytest

from trackweave.estimation.rotation import loose_rotation_of, rotation_of
from trackweave.models.rotation import FollowedRotation, Rotation


def plots(
    rotation: Rotation, *, n_turns: int, n_objects: int, start: float = 0.0, odd: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Objects at slowly changing azimuths, each seen when the beam passes it."""
    rng = np.random.default_rng(5)
    place = rng.uniform(0, 2 * np.pi, n_objects)
    drift = rng.normal(0, 0.02, n_objects)
    turn = np.arange(n_turns)[:, None]
    azimuth = (place + drift * turn + rng.normal(0, 0.002, (n_turns, n_objects))).ravel()
    ahead = (rotation.direction * (azimuth - rotation.azimuth(start))) % (2 * np.pi)
    time = start + rotation.period * (np.repeat(np.arange(n_turns), n_objects) + ahead / 2 / np.pi)
    seen = rng.random(time.size) < 0.8
    strange = rng.random(time.size) < odd
    azimuth = np.where(strange, rng.uniform(0, 2 * np.pi, time.size), azimuth)[seen]
    order = np.argsort(time[seen])
    return time[seen][order], azimuth[order] % (2 * np.pi)


@pytest.mark.parametrize(("wander", "is_followed"), [(0.0, False), (1.0, True)])
def test_a_beam_that_wanders_by_a_degree_is_followed(wander: float, is_followed: bool) -> None:
    # An object within a degree of a sector's border would else be looked for on its other side.
    time, azimuth = plots(Rotation(4.0), n_turns=300, n_objects=8)
    late = 4.0 * wander / 360 * np.sin(2 * np.pi * time / 600)
    found = rotation_of(time + late, azimuth)
    assert isinstance(found, FollowedRotation) is is_followed


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(("n_turns", "n_objects"), [(400, 3), (60, 20), (15, 200)])
def test_finds_period_direction_and_phase(direction: int, n_turns: int, n_objects: int) -> None:
    truth = Rotation(3.97, 1.0, direction)
    time, azimuth = plots(truth, n_turns=n_turns, n_objects=n_objects, odd=0.1)
    found = rotation_of(time, azimuth)
    assert found is not None
    assert found.direction == direction
    assert found.period == pytest.approx(3.97, rel=2e-4 + 0.05 / n_turns**2)
    off = [found.azimuth(t) - truth.azimuth(t) for t in time]
    assert np.abs((np.array(off) + np.pi) % (2 * np.pi) - np.pi).max() < 0.05


def test_times_counted_from_1970_do_no_harm() -> None:
    truth = Rotation(4.8, 0.3, 1)
    start = 1.62e9
    time, azimuth = plots(truth, n_turns=200, n_objects=8, start=start)
    found = rotation_of(time, azimuth)
    assert found is not None
    off = found.azimuth(start + 500) - truth.azimuth(start + 500)
    assert abs((off + np.pi) % (2 * np.pi) - np.pi) < 0.02


def test_a_period_that_is_given_is_made_exact() -> None:
    time, azimuth = plots(Rotation(3.97), n_turns=300, n_objects=4)
    found = rotation_of(time, azimuth, period=4.1, direction=1)
    assert found is not None
    assert found.period == pytest.approx(3.97, rel=1e-4)
    assert rotation_of(time, azimuth, period=4.1, direction=-1) is None


@pytest.mark.parametrize("step", [1.0, 1.5, 2.5, -3.0])
def test_a_clock_that_is_set_meanwhile_is_followed_on_both_sides(step: float) -> None:
    truth = Rotation(4.0, 1.0, 1)
    time, azimuth = plots(truth, n_turns=100, n_objects=12)
    shown = time + step * (time > 200.0)
    order = np.argsort(shown, kind="stable")
    found = rotation_of(shown[order], azimuth[order])
    assert found is not None
    beam = np.array([found.azimuth(moment) for moment in shown[order]])
    off = np.abs(np.angle(np.exp(1j * (azimuth[order] - beam))))
    assert np.mean(off < 0.1) > 0.8


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_a_sensor_that_does_not_turn_is_told(seed: int) -> None:
    rng = np.random.default_rng(seed)
    time = np.sort(rng.uniform(0, 500, 600))
    assert rotation_of(time, rng.uniform(0, 2 * np.pi, 600)) is None


def test_one_object_in_one_direction_tells_no_turn() -> None:
    assert rotation_of(np.arange(100.0), np.full(100, 1.0) + 1e-3 * np.arange(100)) is None


@pytest.mark.parametrize("time", [[], [1.0], [1.0] * 20, list(range(5))])
def test_too_little_is_no_turn(time: list[float]) -> None:
    assert rotation_of(np.array(time), np.zeros(len(time))) is None


def staring() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(2)
    place = np.tile(rng.uniform(0, 2 * np.pi, 10), 50)
    return np.repeat(2.0 * np.arange(50), 10), place + rng.normal(0, 0.01, 500)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("time", "azimuth"),
    [
        staring(),
        (np.arange(200.0), np.linspace(0, 3, 200)),
        (np.arange(200.0), np.linspace(0, 30, 200)),
    ],
    ids=["ten objects, all at once", "one that passes", "one that circles"],
)
def test_what_moves_before_a_sensor_that_stares_is_no_beam(
    time: np.ndarray, azimuth: np.ndarray
) -> None:
    assert rotation_of(time, azimuth) is None
    assert rotation_of(time, azimuth, period=2.0) is None


@pytest.mark.parametrize("grain", [0.1, 0.125])
@pytest.mark.parametrize("start", [0.0, 1.62e9])
def test_times_may_be_rounded(grain: float, start: float) -> None:
    truth = Rotation(4.0, 0.3, 1)
    time, azimuth = plots(truth, n_turns=150, n_objects=40, start=start, odd=0.1)
    found = rotation_of(np.round(time / grain) * grain, azimuth)
    assert found is not None
    assert found.period == pytest.approx(4.0, rel=1e-3)
    assert found.direction == 1


def test_what_goes_round_before_a_camera_is_no_beam() -> None:
    rng = np.random.default_rng(1)
    time = np.flatnonzero(rng.random(1200) < 0.9) * 0.1
    azimuth = 2 * np.pi * time / 12.0 + rng.normal(0, 0.02, time.size)
    assert rotation_of(time, azimuth) is None


def test_a_crowd_in_one_direction_does_not_hide_a_turn_of_loose_stamps() -> None:
    rng = np.random.default_rng(4)
    place = np.r_[rng.normal(1.0, 0.15, 16), rng.uniform(2.0, 6.0, 3)]
    time = 4.0 * (np.arange(200)[:, None] + place / (2 * np.pi))
    azimuth = np.tile(place, 200)
    time = (time + rng.exponential(0.2, time.shape)).ravel()
    order = np.argsort(time)
    found = loose_rotation_of(time[order], azimuth[order])
    assert found is not None
    assert (found.period, found.direction) == (pytest.approx(4.0, rel=1e-3), 1)


@pytest.mark.parametrize("period", [2.0, 2.5, 3.1])
def test_stamps_may_be_so_coarse_that_two_are_of_a_turn(period: float) -> None:
    truth = Rotation(period, 0.3, 1)
    time, azimuth = plots(truth, n_turns=200, n_objects=20, start=1.62e9, odd=0.03)
    told = None if period > 2.0 else period
    found = loose_rotation_of(np.floor(time), azimuth, period=told)
    assert found is not None
    assert (found.period, found.direction) == (pytest.approx(period, rel=1e-3), 1)


@pytest.mark.parametrize("seed", range(5))
def test_slots_of_whole_seconds_are_no_turn(seed: int) -> None:
    rng = np.random.default_rng(seed)
    place, way = rng.uniform(-5e3, 5e3, (20, 1, 2)), rng.normal(0, 5, (20, 1, 2))
    time = rng.uniform(0, 3, (20, 1)) + 3.0 * np.arange(200)
    there = (place + time[..., np.newaxis] * way).reshape(-1, 2)
    order = np.argsort(np.floor(time.ravel()), kind="stable")
    azimuth = np.arctan2(*there[order].T)
    assert loose_rotation_of(np.floor(time.ravel())[order], azimuth) is None


def test_a_crowd_in_one_direction_is_no_turn() -> None:
    rng = np.random.default_rng(4)
    time = np.sort(rng.uniform(0, 800, 3000))
    crowd = rng.random(3000) < 0.8
    azimuth = np.where(crowd, rng.normal(1, 0.15, 3000), rng.uniform(0, 6, 3000))
    assert loose_rotation_of(time, azimuth) is None


@pytest.mark.parametrize("periods", [(2.5, 5.0, 2.5), (5.0, 2.5), (2.5, 2.65)])
def test_a_beam_whose_speed_is_changed_is_followed_in_parts(periods: tuple[float, ...]) -> None:
    parts, begun = [], 0.0
    for period in periods:
        time, azimuth = plots(Rotation(period), n_turns=40, n_objects=6)
        parts.append((time + begun, azimuth))
        begun += 40 * period
    time, azimuth = (np.concatenate(each) for each in zip(*parts, strict=True))
    found = rotation_of(time, azimuth)
    assert isinstance(found, FollowedRotation)
    beam = found.phase + 2.0 * np.pi * found.turned(time)
    assert np.mean(np.abs(np.angle(np.exp(1j * (azimuth - beam)))) < 0.1) > 0.97
    lengths = np.diff(found.when(np.arange(1.0, found.turned(time[-1]))))
    for period in periods:
        assert np.min(np.abs(lengths - period)) < 0.01 * period


@pytest.mark.slow
def test_reports_that_come_as_they_like_are_no_beam_in_parts() -> None:
    rng = np.random.default_rng(5)
    for _ in range(5):
        time, azimuth = np.sort(rng.uniform(0, 600, 900)), rng.uniform(0, 2 * np.pi, 900)
        assert rotation_of(time, azimuth) is None


def test_a_turn_is_found_where_its_first_hundreds_of_reports_are_a_small_part_of_it() -> None:
    # A radar beside its traffic: half of three thousand plots a turn come within 20 degrees.
    truth, rng = Rotation(12.0), np.random.default_rng(8)
    azimuth = np.r_[rng.normal(0.6, 0.17, 9000) % (2 * np.pi), rng.uniform(0, 2 * np.pi, 9000)]
    time = 12.0 * (rng.integers(0, 6, azimuth.size) + azimuth / (2 * np.pi))
    time = time + 0.3  # north is passed then
    order = np.argsort(time)
    begin = np.flatnonzero(np.sort(time) > 1.2)[0]  # in the midst of them
    found = rotation_of(time[order][begin:], azimuth[order][begin:])
    assert found is not None
    assert found.period == pytest.approx(truth.period, rel=1e-3)
