"""The usual practice, sensor after sensor."""

import numpy as np
import pytest

from trackweave.association.chain_rule import TrackEstimates
from trackweave.studies.huo_methods import nearest_neighbour, pairwise_sequential


def at(*places: float) -> TrackEstimates:
    """Return tracks on a line, with variance ½ along each axis: λ is the squared distance."""
    mean = np.array([[place, 0.0] for place in places]).reshape(len(places), 2)
    return TrackEstimates(mean, np.tile(0.5 * np.eye(2), (len(places), 1, 1)))


def test_two_lists_are_assigned_at_least_total_distance() -> None:
    # 0–1 and 1–2 sum to 2; the nearest pair 1–1 would leave 0 and 2 apart by 4, sum 4.
    first, second = at(0.0, 1.0), at(1.0, 2.0)
    assert [label.tolist() for label in pairwise_sequential([first, second])] == [[0, 1], [0, 1]]
    assert [label.tolist() for label in nearest_neighbour([first, second])] == [[0, 1], [1, 0]]


def test_what_is_too_far_begins_a_group() -> None:
    # δ = 9.21 for two dimensions at 1 %.
    for practice in (pairwise_sequential, nearest_neighbour):
        labels = practice([at(0.0), at(3.0), at(20.0, 3.1)])
        assert [label.tolist() for label in labels] == [[0], [0], [1, 0]]
        assert practice([at(0.0), at(3.1)])[1].tolist() == [1]


def test_a_group_is_where_its_fused_estimate_is() -> None:
    # After 0 and 2 the group is at 1, with half the variance: C = ¼ + ½, λ = 4 / 0.75 within.
    assert pairwise_sequential([at(0.0), at(2.0), at(3.0)])[2].tolist() == [0]
    # 1 + √(9.21 · 0.75) = 3.63.
    assert pairwise_sequential([at(0.0), at(2.0), at(3.7)])[2].tolist() == [1]


@pytest.mark.parametrize("practice", [pairwise_sequential, nearest_neighbour])
def test_lists_may_be_empty(practice: object) -> None:
    labels = practice([at(), at(1.0), at(), at(1.0)])  # type: ignore[operator]
    assert [label.tolist() for label in labels] == [[], [0], [], [0]]
