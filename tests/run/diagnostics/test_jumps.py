"""A stage that jumps, and all objects with it, is told of."""

import numpy as np
import polars as pl
import pytest

from trackweave import track

pytestmark = pytest.mark.slow


def cells(jump, *, born=0):
    """Return reports of thirty cells, a minute apart; ``born`` of them in the middle only."""
    rng = np.random.default_rng(4)
    place, velocity, rows = rng.uniform(0.0, 400.0, (30, 2)), np.zeros((30, 2)), []
    for frame in range(40):
        velocity = 0.8 * velocity + rng.normal(0.0, 0.2, place.shape)
        place = place + velocity
        seen = place + rng.normal(0.0, 0.4, place.shape) + np.array(jump) * (frame >= 20)
        there = rng.random(30) < 0.96
        there[:born] &= frame >= 20
        there[born : 2 * born] &= frame < 20
        rows += [(60.0 * frame, *each) for each in seen[there].tolist()]
    return pl.DataFrame(rows, ["time", "x", "y"], orient="row")


def said(reports):
    found = track(reports).run["diagnostics"]
    return [each for each in found if each["cause"] == "jump"]


def test_a_jump_is_told_with_when_and_how_far():
    (found,) = said(cells((25.0, -10.0)))
    assert found["sensor"] == "default"
    assert found["seen"] == pytest.approx(np.hypot(25.0, 10.0), abs=0.5)
    assert "at 1200 s" in found["sentence"]
    x, y = found["sentence"].split("(")[1].split(")")[0].split(", ")
    assert (float(x), float(y)) == pytest.approx((25.0, -10.0), abs=0.5)


@pytest.mark.parametrize("born", [0, 12])
def test_nothing_is_told_where_nothing_jumps(born):
    """Twelve that end while twelve begin elsewhere are others."""
    assert said(cells((0.0, 0.0), born=born)) == []
