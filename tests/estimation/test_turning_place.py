"""About which place a beam turns whose sensor nobody has placed."""

import numpy as np
import pytest

from trackweave.arrays import FloatArray
from trackweave.estimation.turning_place import place_of_turn

PLACE, PERIOD = np.array([30e3, -12e3]), 2.5


def passes(direction: int, seed: int = 1) -> tuple[FloatArray, FloatArray]:
    """Return when and where a beam meets twelve objects, and one false alarm in three."""
    rng = np.random.default_rng(seed)
    start, speed = rng.uniform(-15e3, 15e3, (12, 2)), rng.uniform(-150, 150, (12, 2))
    rows = []
    for turn in range(30):
        false = rng.uniform(-15e3, 15e3, (6, 2))
        for relative in np.concatenate([start + speed * PERIOD * turn, false]):
            azimuth = np.arctan2(relative[0], relative[1])
            time = PERIOD * (turn + (direction * azimuth / (2 * np.pi)) % 1.0)
            rows.append((time, *(PLACE + relative + rng.normal(0, 30.0, 2))))
    table = np.array(sorted(rows))
    return table[:, 0], table[:, 1:]


@pytest.mark.parametrize("direction", [1, -1])
def test_finds_about_which_place_a_beam_turns_and_how(direction: int) -> None:
    found = place_of_turn(*passes(direction))
    assert found is not None
    place, turn = found
    assert np.linalg.norm(place - PLACE) < 1000.0
    assert turn.period == pytest.approx(PERIOD, rel=0.02)
    assert turn.direction == direction


def test_finds_none_where_reports_come_in_no_order() -> None:
    time, place = passes(1)
    mixed = np.random.default_rng(2).permutation(len(place))
    assert place_of_turn(time, place[mixed]) is None


def test_finds_none_in_a_few_reports() -> None:
    time, place = passes(1)
    assert place_of_turn(time[:20], place[:20]) is None
