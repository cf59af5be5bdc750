"""The document's own problem, with thresholds and lists of its own."""

import numpy as np
import pytest

from oracles.track_scenes import partition, picture
from trackweave.errors import InvalidInputError
from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.complete import require_equal_lists
from trackweave.fusion.statistic import Statistic


def test_a_tuple_beyond_its_threshold_is_no_object() -> None:
    associator = TrackAssociator(statistic=Statistic("chain", "full"), complete=True)
    pictures = {
        "A": picture("A", 0.0, {1: (0.0, 0.0), 2: (900.0, 0.0)}),
        "B": picture("B", 0.0, {1: (901.0, 0.0), 2: (90.0, 0.0)}),
    }
    found = associator.step(0.0, pictures, rng=np.random.default_rng(0))
    # 90 m apart: λ = 40.5; J counts it all the same, as every track is used.
    assert partition(found) == {frozenset({("A", 2), ("B", 1)})}
    assert found.certificate.cost == pytest.approx(40.5 + 0.005)


def test_one_sensor_and_no_tracks_are_nothing_to_choose() -> None:
    for tracks in ({1: (0.0, 0.0)}, {}):
        associator = TrackAssociator(statistic=Statistic("chain", "full"), complete=True)
        found = associator.step(
            0.0, {"A": picture("A", 0.0, tracks)}, rng=np.random.default_rng(0)
        )
        assert len(found) == len(tracks)
        assert found.certificate.cost == 0.0


def test_equal_lists_are_required_by_name() -> None:
    require_equal_lists({"A": 2, "B": 2})
    with pytest.raises(InvalidInputError, match="tracks A 2, B 3; expected equally many"):
        require_equal_lists({"A": 2, "B": 3})
