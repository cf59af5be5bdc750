import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    RandomWalk,
)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_new_velocity_has_the_variance_of_a_uniform_ball(dim):
    rng = np.random.default_rng(1)
    points = rng.uniform(-30.0, 30.0, size=(400_000, dim))
    inside = points[np.sum(points**2, axis=1) <= 900.0]
    expected = ConstantVelocity(0.1, 30.0).velocity_variance(dim)
    assert inside.var(axis=0) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("process_noise", [-1.0, np.nan, np.inf])
def test_refuses_a_process_noise_that_is_none(process_noise):
    with pytest.raises(InvalidInputError, match=r"process_noise: .*m²/s³"):
        ConstantVelocity(process_noise, 30.0)


@pytest.mark.parametrize("max_speed", [0.0, -1.0, np.nan, np.inf])
def test_refuses_a_speed_that_is_none(max_speed):
    with pytest.raises(InvalidInputError, match=r"max_speed: .*m/s"):
        ConstantVelocity(0.1, max_speed)


def test_takes_an_object_that_never_turns():
    assert ConstantVelocity(0.0, 30.0).process_noise == 0.0


STRAIGHT = ConstantVelocity(0.1, 30.0)
PULLING = ConstantAcceleration(0.2, 40.0, 5.0)
TURNING = CoordinatedTurn(0.3, 1e-4, 50.0, 0.2)
WALKING = RandomWalk(4.0, 20.0)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_state_has_room_for_what_any_mode_needs(dim):
    assert STRAIGHT.rule(dim).prior.size == 2 * dim
    assert WALKING.rule(dim).prior.size == 2 * dim
    assert PULLING.rule(dim).acceleration_at == 2 * dim
    assert TURNING.rule(dim).turn_at == 2 * dim
    both = Imm((STRAIGHT, TURNING, PULLING), (10.0, 20.0, 30.0)).rule(dim)
    assert (both.acceleration_at, both.turn_at) == (2 * dim, 3 * dim)
    assert both.prior.size == 3 * dim + 1
    assert STRAIGHT.rule(dim).acceleration_at == STRAIGHT.rule(dim).turn_at == -1


def test_what_is_not_known_is_spread_over_the_ball_or_the_interval():
    rule = Imm((STRAIGHT, TURNING, PULLING), (10.0, 20.0, 30.0)).rule(2)
    wanted = [0, 0, 50**2 / 4, 50**2 / 4, 5**2 / 4, 5**2 / 4, 0.2**2 / 3]
    assert rule.prior == pytest.approx(wanted)
    assert rule.max_speed == 50.0


def test_each_mode_has_its_own_noise():
    rule = Imm((WALKING, TURNING), (10.0, 20.0)).rule(2, unscented=True)
    np.testing.assert_array_equal(rule.kind, [3, 2])
    np.testing.assert_array_equal(rule.noise, [[4.0, 0.0], [0.3, 1e-4]])
    assert rule.unscented


@pytest.mark.parametrize("times", [(10.0, 30.0), (60.0, 10.0, 20.0), (1.0, 100.0, 100.0, 3.0)])
def test_modes_are_left_after_their_sojourn_time_and_had_for_their_share(times):
    rule = Imm((STRAIGHT, TURNING, PULLING, WALKING)[: len(times)], times).rule(2)

    def change(interval):
        return rule.basis[0] * np.exp(-rule.decay * interval) @ rule.basis[1]

    assert np.diag(change(1e-6)) == pytest.approx(1 - 1e-6 / np.array(times), abs=1e-11)
    np.testing.assert_allclose(change(7.0).sum(axis=1), 1.0)
    np.testing.assert_allclose(change(1e6), np.tile(rule.share, (len(times), 1)), atol=1e-9)
    np.testing.assert_allclose(rule.share, np.array(times) / np.sum(times))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ConstantAcceleration(-1.0, 30.0, 5.0), r"process_noise: .*m²/s⁵"),
        (lambda: ConstantAcceleration(1.0, 30.0, 0.0), r"max_acceleration: .*m/s²"),
        (lambda: CoordinatedTurn(1.0, -1.0, 30.0, 0.1), r"turn_noise: .*rad²/s³"),
        (lambda: CoordinatedTurn(1.0, 1.0, 30.0, np.nan), r"max_turn_rate: .*rad/s"),
        (lambda: RandomWalk(np.inf, 30.0), r"process_noise: .*m²/s"),
        (lambda: RandomWalk(1.0, "fast"), r"max_speed: 'fast'"),
        (lambda: Imm((STRAIGHT,), (10.0,)), r"models: \[ConstantVelocity\]; expected two"),
        (lambda: Imm((STRAIGHT, 3), (10.0, 10.0)), r"models: .*; expected a sequence"),
        (lambda: Imm((STRAIGHT, TURNING), (10.0,)), r"sojourn_time: 1 times for 2"),
        (lambda: Imm((STRAIGHT, TURNING), (10.0, 0.0)), r"sojourn_time: 0.0; expected"),
    ],
)
def test_refuses_what_is_no_motion(make, message):
    with pytest.raises(InvalidInputError, match=message):
        make()


def test_takes_lists_of_models_and_times():
    assert Imm([STRAIGHT, TURNING], [10.0, 5.0]) == Imm((STRAIGHT, TURNING), (10.0, 5.0))
