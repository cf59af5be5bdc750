"""Fields of view that reports contradict are told."""

import numpy as np
import pytest

from run.diagnostics.scenes import case_of, positions
from trackweave.run.diagnostics.told import out_of_view

pytestmark = pytest.mark.slow


def two_radars(reach: float):
    """Return uniform reports of two radars 3 km apart, each within a reach."""
    rng = np.random.default_rng(1)
    place = rng.uniform([-1000, -1000], [4000, 1000], (4000, 2))
    sensor = np.arange(4000) % 2
    away = np.linalg.norm(place - np.array([[0.0, 0.0], [3000.0, 0.0]])[sensor], axis=1)
    kept = away < reach
    return positions(np.arange(4000.0)[kept], place[kept], sensor[kept], ("a", "b"))


A, B = {"position": [0.0, 0.0]}, {"position": [3000.0, 0.0]}


def test_reports_outside_their_own_field_of_view_are_told() -> None:
    view = {"field_of_view": {"max_range_m": 1.0}}
    (found,) = out_of_view(case_of(two_radars(1500.0), a=A, b={**B, **view}))
    assert found.sentence.startswith("sensor b: 100% of its ")
    assert "field_of_view of 1 m; they come from " in found.sentence
    view = {"field_of_view": {"max_range_m": 1490.0}}
    assert list(out_of_view(case_of(two_radars(1500.0), a=A, b={**B, **view}))) == []
