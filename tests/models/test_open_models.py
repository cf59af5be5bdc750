"""What every motion model and every kind of measurement keeps to, ours and others' alike."""

import importlib
import sys

import numpy as np
import pytest

import trackweave as tw
from oracles.plugin_site import EXAMPLES
from oracles.plugins import Place, RangeAzimuth, Straight
from trackweave.domain.foreign_kind import ForeignKind, kind_of
from trackweave.errors import InvalidInputError
from trackweave.filters._measuring import measure
from trackweave.filters.foreign import States, advanced, foreseen, taken_in
from trackweave.models.foreign_motion import ForeignMotion, checked_motion
from trackweave.models.measurements import to_position

sys.path.insert(0, str(EXAMPLES))
Reentry = importlib.import_module("trackweave_plugins.reentry").Reentry
TimeDifferences = importlib.import_module("trackweave_plugins.time_differences").TimeDifferences
sys.path.remove(str(EXAMPLES))

ROWS = 6
STRAIGHT = tw.ConstantVelocity(1.0, 100.0)
MOTIONS = {
    "constant velocity": (STRAIGHT, 2),
    "constant acceleration": (tw.ConstantAcceleration(0.1, 100.0, 5.0), 3),
    "coordinated turn": (tw.CoordinatedTurn(1.0, 1e-5, 100.0, 0.1), 2),
    "random walk": (tw.RandomWalk(2.0, 100.0), 2),
    "several modes": (tw.Imm((STRAIGHT, tw.ConstantVelocity(9.0, 100.0)), (60.0, 20.0)), 2),
    "straight, from outside": (Straight(1.0, 100.0), 2),
    "re-entry, from outside": (Reentry(max_speed=3000.0), 3),
}


@pytest.fixture(params=MOTIONS.values(), ids=MOTIONS.keys())
def motion(request):
    """Return a rule, the model where it is from outside, and states."""
    model, dim = request.param
    model = checked_motion(model)
    rule, way = model.rule(dim), model if isinstance(model, ForeignMotion) else None
    rng, size, modes = np.random.default_rng(2), model.rule(dim).prior.size, len(rule.kind)
    root = rng.normal(0.0, 1.0, (ROWS, modes, size, size))
    scale = np.ones(size)
    scale[:dim], scale[dim : 2 * dim], scale[2 * dim :] = 20.0, 5.0, 0.05
    mean = rng.normal(0.0, scale, (ROWS, modes, size))
    mean[..., :dim] += 20_000.0
    covariance = 0.02 * (root @ root.swapaxes(2, 3) + np.eye(size)) * scale[:, None] * scale
    weight = rng.dirichlet(np.ones(modes), ROWS)
    return rule, way, States(mean, covariance, weight)


def _ahead(motion, interval, rows=slice(None)):
    rule, way, states = motion
    part = States(*(np.ascontiguousarray(column[rows]) for column in states))
    return advanced(part, np.broadcast_to(interval, (ROWS,))[rows].copy(), rule, way)


def test_no_time_changes_nothing(motion):
    for column, before in zip(_ahead(motion, 0.0), motion[2], strict=True):
        np.testing.assert_array_equal(column, before)


def test_states_do_not_know_of_one_another(motion):
    interval = np.array([0.5, 1.0, 0.0, -1.0, 2.0, 0.5])
    together = _ahead(motion, interval)
    for row in range(ROWS):
        alone = _ahead(motion, interval, slice(row, row + 1))
        for column, whole in zip(alone, together, strict=True):
            np.testing.assert_allclose(column[0], whole[row], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("interval", [0.2, 3.0, -1.0])
def test_covariances_stay_symmetric_and_positive_definite(motion, interval):
    covariance = _ahead(motion, interval).covariance
    np.testing.assert_allclose(covariance, covariance.swapaxes(2, 3), rtol=1e-9, atol=1e-12)
    assert np.linalg.eigvalsh(covariance).min() > 0.0


@pytest.mark.parametrize("interval", [1.0, -1.0])
def test_a_place_becomes_less_sure_with_time_not_surer(motion, interval):
    rule, _, states = motion
    still = States(states.mean, states.covariance.copy(), states.weight)
    # What is known of the speed must not tell of the place.
    still.covariance[:, :, : rule.dim, rule.dim :] = 0.0
    still.covariance[:, :, rule.dim :, : rule.dim] = 0.0
    wider = _ahead((rule, motion[1], still), interval).covariance
    before = np.trace(still.covariance[:, 0, : rule.dim, : rule.dim], 0, 1, 2).min()
    assert np.trace(wider[:, 0, : rule.dim, : rule.dim], 0, 1, 2).min() >= before * 0.999


def test_two_short_steps_are_one_long(motion):
    rule, way, _ = motion
    half = _ahead(motion, 0.1)
    twice = advanced(half, np.full(ROWS, 0.1), rule, way)
    once = _ahead(motion, 0.2)
    np.testing.assert_allclose(twice.mean, once.mean, rtol=2e-3, atol=0.3)
    ratio = np.trace(twice.covariance, 0, 2, 3) / np.trace(once.covariance, 0, 2, 3)
    np.testing.assert_allclose(ratio, 1.0, atol=0.05)


@pytest.mark.parametrize("name", ["straight, from outside", "re-entry, from outside"])
def test_a_slope_is_that_of_the_mean(name):
    model, dim = MOTIONS[name]
    way = ForeignMotion(model)
    size = way.rule(dim).prior.size
    mean = np.random.default_rng(1).normal(0.0, 1.0, (ROWS, size)) + np.full(size, 3.0)
    mean[:, 2] += 3e4
    interval, spread = np.linspace(0.5, 2.0, ROWS), np.tile(np.eye(size), (ROWS, 1, 1))
    _, _, slope = way.predict(mean, spread, interval)
    step = 1e-3
    for column in range(size):
        beside = mean.copy()
        beside[:, column] += step
        change = way.predict(beside, spread, interval)[0] - way.predict(mean, spread, interval)[0]
        np.testing.assert_allclose(change / step, slope[:, :, column], rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("name", ["straight, from outside", "re-entry, from outside"])
def test_a_new_object_is_where_it_was_reported(name):
    model, dim = MOTIONS[name]
    way, place = ForeignMotion(model), np.random.default_rng(3).normal(0.0, 9e3, (ROWS, dim))
    spread = np.tile(np.diag(np.arange(1.0, dim + 1)), (ROWS, 1, 1))
    mean, covariance = way.begin(place, spread, way.rule(dim).prior.size)
    np.testing.assert_array_equal(mean[:, :dim], place)
    np.testing.assert_array_equal(covariance[:, :dim, :dim], spread)
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_a_model_for_another_space_is_refused():
    with pytest.raises(InvalidInputError, match="motion Reentry: for 3 dimensions; expected 2"):
        tw.MultiHypothesisTracker(motion=Reentry(), sensors=[tw.Sensor("a")], dim=2).step(
            tw.Scan(0.0, "a", [[1.0, 2.0]])
        )


class _Ours:
    """A kind of ours in the words of those from outside."""

    def __init__(self, kind, dim):
        self.kind, self.dim, self.columns = kind, dim, kind.columns(dim)

    def expect(self, mean, platform, reported):
        width, size = len(self.columns), mean.shape[1]
        value, slope = np.empty((len(mean), width)), np.empty((len(mean), width, size))
        for row in range(len(mean)):
            cross = np.empty((size, width))
            measure(
                int(self.kind), mean[row], np.eye(size), platform[row], self.dim, False,
                value[row], np.empty((width, width)), cross,
            )  # fmt: skip
            slope[row] = cross.T
        return value, slope

    def difference(self, values, expected):
        off = values - expected
        for column, name in enumerate(self.columns):
            if name in ("azimuth_deg", "bearing_deg"):
                off[:, column] = np.pi - (np.pi - off[:, column]) % (2 * np.pi)
        return off


class _OursWithPlaces(_Ours):
    def first_state(self, platform, reported):
        return to_position(self.kind, reported.values, reported.sigma, platform, self.dim)


def _ours(name, dim):
    kind = tw.MeasurementKind[name]
    return (_OursWithPlaces if kind.gives_position(dim) else _Ours)(kind, dim)


KINDS = {
    **{
        f"{name}, {dim}": (_ours(name, dim), dim, None)
        for name, dim in (
            ("POSITION", 2), ("POSITION", 3), ("RANGE_AZIMUTH", 2), ("RANGE_AZIMUTH_RATE", 2),
            ("RANGE_AZIMUTH_ELEVATION", 3), ("RANGE_AZIMUTH_ELEVATION_RATE", 3), ("BEARING", 2),
        )
    },
    "place, from outside": (Place(), 2, None),
    "range and azimuth, from outside": (RangeAzimuth(), 2, None),
    "time differences, from outside": (TimeDifferences(), 3, "receivers"),
}  # fmt: skip


@pytest.fixture(params=KINDS.values(), ids=KINDS.keys())
def seen(request):
    """Return a kind, states, platforms and what a sensor reports of them without noise."""
    model, dim, context = request.param
    kind, rng = kind_of(model), np.random.default_rng(5)
    mean = rng.normal(0.0, 50.0, (ROWS, 2 * dim))
    mean[:, :dim] += rng.uniform(4e4, 8e4, (ROWS, dim)) * rng.choice([-1.0, 1.0], (ROWS, dim))
    if context:
        mean[:, 2] = np.abs(mean[:, 2]) / 8
        context = _receivers(rng)
    platform = np.zeros((ROWS, 6))
    platform[:, :2] = rng.normal(0.0, 1e3, (ROWS, 2))
    width = len(kind.model.columns)
    sigma = np.full((ROWS, width), 1e-3)
    told = kind.reported(np.zeros((ROWS, width)), sigma, context)
    value, _ = kind.expect(mean, platform, told)
    return kind, mean, platform, kind.reported(value, sigma, context)


def _receivers(rng):
    """Return five receivers a row that stand around, and the centre of a globe below them."""
    angle = np.arange(5) * 2 * np.pi / 5 + rng.uniform(0, 1, (ROWS, 1))
    round_about = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=2)
    stands = 1e5 * round_about + rng.uniform(0, 2e3, (ROWS, 5, 3))
    center = np.tile([0.0, 0.0, -6_378_137.0], (ROWS, 1))
    return np.concatenate([stands.reshape(ROWS, 15), center], axis=1)


def test_a_slope_is_that_of_the_values(seen):
    kind, mean, platform, reported = seen
    slope = kind.expect(mean, platform, reported)[1]
    measured = tw.slope_of(lambda state: kind.expect(state, platform, reported)[0], mean)
    np.testing.assert_allclose(slope, measured, rtol=1e-4, atol=1e-6)


def test_reports_do_not_know_of_one_another(seen):
    kind, mean, platform, reported = seen
    together = kind.expect(mean, platform, reported)
    for row in range(ROWS):
        one = np.array([row])
        alone = kind.expect(mean[one], platform[one], reported.part(one))
        for found, whole in zip(alone, together, strict=True):
            np.testing.assert_allclose(found[0], whole[row], rtol=1e-12, atol=1e-12)


def test_a_first_state_is_where_the_report_comes_from(seen):
    kind, mean, platform, reported = seen
    dim = mean.shape[1] // 2
    if not kind.gives_position(dim):
        pytest.skip("such reports begin no track")
    place, spread = kind.first_state(platform, reported, dim)
    np.testing.assert_allclose(place, mean[:, :dim], rtol=1e-5, atol=0.1)
    assert np.linalg.eigvalsh(spread).min() > 0.0


def test_a_difference_from_oneself_is_none(seen):
    kind, _, _, reported = seen
    off = kind.difference(reported.values, reported.values)
    np.testing.assert_allclose(off, 0.0, atol=1e-9)


def test_a_report_makes_a_state_surer_and_draws_it_near(seen):
    kind, mean, platform, reported = seen
    spread = np.tile(np.diag(np.full(mean.shape[1], 100.0)), (ROWS, 1, 1, 1))
    beside = mean.copy()
    beside[:, : mean.shape[1] // 2] += np.random.default_rng(8).normal(0, 3.0, (ROWS, 1))
    states = States(beside[:, None], spread, np.ones((ROWS, 1)))
    before = foreseen(kind, states, platform, reported)
    after = taken_in(states, before)
    assert np.all(np.trace(after.covariance[:, 0], 0, 1, 2) < np.trace(spread[:, 0], 0, 1, 2))
    # In units of the report's own noise.
    own = np.linalg.inv(reported.covariance)
    left, off = (
        np.einsum("ri,rij,rj->r", each.innovation[:, 0], own, each.innovation[:, 0])
        for each in (foreseen(kind, after, platform, reported), before)
    )
    assert np.all(left < off)


def test_ours_are_no_kinds_from_outside():
    assert kind_of(tw.MeasurementKind.POSITION) is tw.MeasurementKind.POSITION
    assert isinstance(kind_of(Place()), ForeignKind)
