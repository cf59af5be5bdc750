"""Tests of OSPA(2), the distance between sets of tracks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from metrics.test_pairing_over_time import moments, on_line, scenes
from oracles import metrics as oracle
from trackweave.errors import InvalidInputError
from trackweave.metrics.gospa import ospa
from trackweave.metrics.ospa2 import ospa2

CUTOFF = 10.0


@given(scenes(), st.integers(1, 6), st.sampled_from([1.0, 2.0]))
def test_agrees_with_all_pairings_of_whole_paths(
    scene: tuple[oracle.Rows, oracle.Rows], window: int, order: float
) -> None:
    found = ospa2(moments(*scene), window, CUTOFF, order)
    for place, total in enumerate(found.total):
        times = range(max(place - window + 1, 0), place + 1)
        expected = oracle.ospa2(*scene, times, CUTOFF, order)
        assert total == pytest.approx(expected, abs=1e-9)


@given(scenes(), st.sampled_from([1.0, 2.0]))
def test_parts_add_up_in_the_power_of_the_order(
    scene: tuple[oracle.Rows, oracle.Rows], order: float
) -> None:
    found = ospa2(moments(*scene), 3, CUTOFF, order)
    np.testing.assert_allclose(
        found.localisation**order + found.cardinality**order, found.total**order, atol=1e-9
    )


@given(scenes())
def test_a_window_of_one_time_is_ospa(scene: tuple[oracle.Rows, oracle.Rows]) -> None:
    truth, tracks = scene
    found = ospa2(moments(truth, tracks), 1, CUTOFF)
    for place, time in enumerate(sorted(truth)):
        here, there = list(truth[time].values()), list(tracks.get(time, {}).values())
        assert found.total[place] == pytest.approx(ospa(here, there, CUTOFF), abs=1e-9)


def test_a_track_that_breaks_costs_though_every_position_is_right() -> None:
    whole = ospa2(moments(on_line(*"aaaa"), on_line(*"xxxx")), 4, CUTOFF)
    broken = ospa2(moments(on_line(*"aaaa"), on_line(*"xxyy")), 4, CUTOFF, 1.0)
    assert whole.total.tolist() == [0.0] * 4
    assert broken.total[:2].tolist() == [0.0, 0.0]
    # The best of two halves is off for two times of four; the other half is one too many.
    assert broken.total[3] == pytest.approx((CUTOFF * 2 / 4 + CUTOFF) / 2)
    assert broken.localisation[3] == pytest.approx(CUTOFF / 4)
    assert broken.cardinality[3] == pytest.approx(CUTOFF / 2)


def test_what_left_the_window_is_forgotten() -> None:
    found = ospa2(moments(on_line(*"aaaaa"), on_line("", *"xxxx")), 2, CUTOFF)
    assert found.total.tolist() == pytest.approx([CUTOFF, CUTOFF / 2, 0.0, 0.0, 0.0])
    assert found.time.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert found.window == 2


def test_targets_that_come_and_go_cost_nothing_when_tracks_do_so_too() -> None:
    truth, tracks = on_line("a", "", "b", "a", "b"), on_line("x", "", "y", "x", "y")
    assert ospa2(moments(truth, tracks), 3, CUTOFF).total.tolist() == [0.0] * 4


def test_refuses_a_window_without_a_time() -> None:
    with pytest.raises(InvalidInputError, match="window: 0; expected at least 1"):
        ospa2(moments(on_line("a"), on_line("x")), 0, CUTOFF)
