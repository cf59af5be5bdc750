"""The tree's sequences of any kind of report and motion against the enumeration of all."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.kind_windows import KindWindow, radar
from oracles.kinds import every
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.models.coverage import FieldOfView
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    RandomWalk,
)
from trackweave.models.strength import StrengthModel

APART = 0.05 * 4.0  # of scans that a column tells, in seconds
STEADY = ConstantVelocity(2.0, 100.0)
PULLING = ConstantAcceleration(0.3, 100.0, 10.0)
TURNING = CoordinatedTurn(2.0, 1e-4, 100.0, 0.1)
TWO = Imm((STEADY, PULLING), (40.0, 15.0))
THREE = Imm((ConstantVelocity(0.1, 100.0), TURNING, PULLING), (50.0, 20.0, 30.0))
POINT = radar("point", Kind.POSITION)
POLAR = radar("polar", position=(-800.0, 900.0))
RATE = radar("rate", Kind.RANGE_AZIMUTH_RATE)
HIGH = radar("high", Kind.RANGE_AZIMUTH_ELEVATION)
HIGH_RATE = radar("high rate", Kind.RANGE_AZIMUTH_ELEVATION_RATE)
GAZE = radar("gaze", Kind.BEARING, position=(-500.0, 4000.0))
NORTH_WEST = FieldOfView((500.0, -300.0), max_range=4200.0, azimuth_deg=(10.0, 47.0))
WILD = {"tail_share": 0.2, "tail_scale": 6.0}
WILD_POLAR = radar("polar", position=(-800.0, 900.0), **WILD)
WILD_POINT = radar("point", Kind.POSITION, **WILD)
BAD = WILD | {"tail_persistence": 0.9}
BAD_POLAR = radar("polar", position=(-800.0, 900.0), **BAD)
BAD_POINT = radar("point", Kind.POSITION, **BAD)
LOUD = StrengthModel(12.0, 4.0, 6.0, 3.0)


def assert_same(window):
    """Compare costs and states; return how many sequences have more than one report."""
    tree = window.tree()
    wanted = every(window.views, window.setting, window.known)
    found = window.sequences(tree)
    assert found.keys() == wanted.keys()
    totals = tree.totals()
    close = {"rtol": 1e-5, "atol": 1e-5}
    for key, node in found.items():
        expected = wanted[key]
        np.testing.assert_allclose(tree.nodes.cost[node], expected.cost, **close)
        np.testing.assert_allclose(totals[node], expected.total, **close)
        state = expected.state
        np.testing.assert_allclose(tree.nodes.weight[node], state.weight, **close)
        for mode, centre in enumerate(state.mean):
            scale = np.sqrt(np.diagonal(state.covariance[mode]))
            apart = (tree.nodes.mean[node, mode] - centre) / scale
            np.testing.assert_allclose(apart, 0.0, atol=1e-4)
            spread = (tree.nodes.covariance[node, mode] - state.covariance[mode]) / scale
            np.testing.assert_allclose(spread.T / scale, 0.0, atol=1e-4)
    return sum(sum(index is not None for index in choice) > 1 for _, choice in found)


@pytest.mark.parametrize(
    ("motion", "sensors", "options"),
    [
        pytest.param(STEADY, (POLAR,), {}, id="range-azimuth"),
        pytest.param(STEADY, (POLAR, RATE, POINT), {}, id="kinds mixed"),
        pytest.param(STEADY, (POLAR,), {"unscented": True}, id="range-azimuth unscented"),
        pytest.param(STEADY, (RATE,), {}, id="range-azimuth-rate"),
        pytest.param(STEADY, (RATE, POLAR), {"moving": True}, id="moving platforms"),
        pytest.param(STEADY, (HIGH,), {"dim": 3}, id="elevation"),
        pytest.param(STEADY, (HIGH_RATE, HIGH), {"dim": 3, "moving": True}, id="elevation-rate"),
        pytest.param(STEADY, (POINT, GAZE), {}, id="bearings join"),
        pytest.param(STEADY, (POINT, GAZE), {"dim": 3}, id="bearings join in space"),
        pytest.param(STEADY, (POINT, GAZE), {"unscented": True}, id="bearings join unscented"),
        pytest.param(TWO, (POINT,), {}, id="two modes"),
        pytest.param(TWO, (POLAR, GAZE), {}, id="two modes, polar"),
        pytest.param(THREE, (POINT, POLAR), {}, id="three modes"),
        pytest.param(PULLING, (POINT,), {}, id="acceleration"),
        pytest.param(PULLING, (HIGH,), {"dim": 3}, id="acceleration in space"),
        pytest.param(TURNING, (POINT,), {}, id="turn"),
        pytest.param(RandomWalk(40.0, 100.0), (POINT, POLAR), {}, id="walk"),
        pytest.param(STEADY, (WILD_POINT, POINT), {}, id="tails"),
        pytest.param(TWO, (WILD_POLAR, POINT), {}, id="tails, two modes, polar"),
        pytest.param(STEADY, (WILD_POLAR,), {"unscented": True}, id="tails, unscented"),
        pytest.param(STEADY, (BAD_POINT,), {}, id="tails that persist"),
        pytest.param(STEADY, (BAD_POLAR, POINT, WILD_POINT), {}, id="tails that persist in some"),
        pytest.param(TWO, (POINT, BAD_POLAR, BAD_POINT), {}, id="tails that persist, two modes"),
        pytest.param(
            STEADY, (HIGH, POINT), {"dim": 3, "widths": {"point": 2}}, id="positions on a map"
        ),
    ],
)
@pytest.mark.parametrize("seed", range(2))
def test_holds_every_sequence_at_its_cost(motion, sensors, options, seed):
    window = KindWindow(seed, motion, sensors, n_known=seed, **options)
    assert assert_same(window) > 0


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("motion", [STEADY, TWO], ids=["one mode", "two"])
def test_reports_of_a_turn_are_scored_at_their_own_times(motion, seed):
    """Two radars' turns overlap, so that a later scan's report may lie before an earlier's."""
    sensors = (POLAR, radar("other"))
    window = KindWindow(
        seed, motion, sensors, times=(4.0, 5.5, 8.0, 9.5), turning=4.0, n_known=seed % 2
    )
    moments = [view.scan.moments for view in window.views]
    assert moments[1].min() < moments[0].max()
    assert assert_same(window) > 0


def test_two_reports_beside_one_another_in_told_scans_are_never_of_one_object():
    """Of scans with times of their own, a track's reports lie apart by a part of the period."""
    window = KindWindow(4, STEADY, (POLAR,), times=(2.0, 4.0, 6.0, 8.0), turning=2.0)
    assert assert_same(window) > 0
    tree = window.tree()
    found = window.sequences(tree)
    for _, choice in found:
        times = [
            view.scan.moments[index]
            for view, index in zip(window.views, choice, strict=True)
            if index is not None
        ]
        assert np.all(np.diff(times) >= APART)
    # The nearer they have to lie apart, the fewer there are.
    for view in window.views:
        assert view.separation == APART
        view.separation = 2.0
    assert len(every(window.views, window.setting)) < len(found)


@pytest.mark.slow
@pytest.mark.parametrize("motion", [STEADY, THREE], ids=["one mode", "three"])
@pytest.mark.parametrize("turning", [0.0, 4.0], ids=["at once", "in a turn"])
def test_misses_are_charged_by_the_share_that_is_covered(motion, turning):
    sensors = (radar("polar", field_of_view=NORTH_WEST), POINT)
    window = KindWindow(
        2, motion, sensors, times=(4.0, 8.0, 12.0, 12.0), turning=turning, n_known=1, max_misses=2
    )
    assert assert_same(window) > 0


@pytest.mark.parametrize("seed", range(3))
def test_names_and_strengths_are_evidence(seed):
    sensors = (radar("polar", strength=LOUD), radar("point", Kind.POSITION, identity_error=0.2))
    window = KindWindow(seed, STEADY, sensors, names=(3, 8, 9))
    assert assert_same(window) > 0


# Two levels, a climb from one, one that is garbled, and none [m].
HEIGHTS = (900.0, 930.0, 990.0, 6000.0, np.nan)


@pytest.mark.parametrize("motion", [STEADY, THREE], ids=["one mode", "three"])
@pytest.mark.parametrize("height", [{}, {"sigma_height": 150.0, "height_offset": -40.0}])
@pytest.mark.parametrize("seed", range(4))
def test_heights_are_evidence(motion, height, seed):
    sensors = (replace(POINT, **height), GAZE)
    window = KindWindow(
        seed, motion, sensors, heights=HEIGHTS, times=(2.0, 4.0, 6.0, 8.0), n_known=1
    )
    assert assert_same(window) > 0


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("sensors", [(POINT,), (POINT, RATE, GAZE)], ids=["positions", "all"])
def test_two_modes_that_are_the_same_are_one(sensors, seed):
    """Positions of one mode go a short way of their own, those of two the general one."""
    twice = Imm((STEADY, STEADY), (20.0, 35.0))
    one = KindWindow(seed, STEADY, sensors).tree()
    two = KindWindow(seed, twice, sensors).tree()
    assert one.n_nodes == two.n_nodes > 20
    for name in ("parent", "report", "family", "hits", "is_line"):
        np.testing.assert_array_equal(
            getattr(one.nodes, name)[: one.n_nodes], getattr(two.nodes, name)[: one.n_nodes]
        )
    np.testing.assert_allclose(
        one.nodes.cost[: one.n_nodes], two.nodes.cost[: one.n_nodes], atol=1e-9
    )
    np.testing.assert_allclose(one.totals(), two.totals(), atol=1e-9)
    is_place = one.nodes.is_line[: one.n_nodes] == 0
    for mode in range(2):
        for name, slack in (("mean", 1e-7), ("covariance", 1e-6)):
            mine = getattr(one.nodes, name)[: one.n_nodes][is_place, 0]
            theirs = getattr(two.nodes, name)[: one.n_nodes][is_place, mode]
            np.testing.assert_allclose(mine, theirs, rtol=1e-8, atol=slack)
