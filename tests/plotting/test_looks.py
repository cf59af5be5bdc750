"""Colours and lines by which tracks are told apart."""

import numpy as np
import pytest

from trackweave.arrays import FloatArray
from trackweave.plotting._canvas import COLOURS, Look, looks_of


def path(x: float, y: float) -> FloatArray:
    return np.array([x, y]) + np.linspace(0.0, 10.0, 5)[:, None]


@pytest.mark.parametrize("order", [range(28), range(27, -1, -1)])
def test_near_ones_differ_in_colour_however_many_lie_far_away(order: range) -> None:
    """Pairs of tracks side by side, numbered so that cycling would give them one colour."""
    paths = [path(1000.0 * (k % 14), 20.0 * (k // 14)) for k in order]
    looks = looks_of(paths)
    for k in range(14):
        pair = [looks[number] for number, place in enumerate(order) if place % 14 == k]
        assert pair[0].colour != pair[1].colour


def test_looks_of_a_page_are_all_different() -> None:
    looks = looks_of([path(float(k), 0.0) for k in range(len(COLOURS))])
    assert len({look.colour for look in looks}) == len(COLOURS)
    looks = looks_of([path(50.0 * k, 0.0) for k in range(2 * len(COLOURS))])
    assert len(set(looks)) == 2 * len(COLOURS)


def test_very_many_take_colours_in_turn() -> None:
    looks = looks_of([path(0.0, 0.0)] * 300)
    assert looks[: len(COLOURS)] == [Look(colour, ()) for colour in COLOURS]
    assert looks[len(COLOURS)] == looks[0]


def test_a_track_of_one_place_has_a_look() -> None:
    assert looks_of([np.zeros((1, 2))]) == [Look(COLOURS[0], ())]
