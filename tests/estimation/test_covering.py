"""The area that reports cover is that of their hull."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from trackweave.estimation.covering import covered_by, note_on_area
from trackweave.estimation.trees import FEW


@pytest.mark.parametrize("count", [20, FEW, FEW + 1])
@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_few_reports_and_many_cover_the_area_of_their_hull(count: int, offset: float) -> None:
    rng = np.random.default_rng(count)
    places = rng.normal(size=(count, 2)) * (1.0, 50.0) + offset
    expected = ConvexHull(places - offset).volume * (1 + 2 / count) ** 2
    assert covered_by(places, 1e-3) == pytest.approx(expected, rel=1e-7)


def test_of_corners_on_a_grid_those_within_a_side_count_for_nothing() -> None:
    places = np.stack(np.meshgrid(np.arange(5.0), np.arange(7.0)), axis=-1).reshape(-1, 2)
    assert covered_by(places, 1e-3) == pytest.approx(4.0 * 6.0 * (1 + 2 / 35) ** 2, rel=1e-12)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.3, 0.7), (1.0, -3.0)])
def test_reports_on_a_line_span_no_area(direction: tuple[float, float]) -> None:
    along = np.random.default_rng(2).normal(0.0, 1e4, 30)
    assert note_on_area(np.outer(along, direction) + np.array([1e5, -3e4]), 1.0) is not None
    aside = np.random.default_rng(3).normal(0.0, 1.0, (30, 2))
    assert note_on_area(np.outer(along, direction) + aside, 1.0) is None
