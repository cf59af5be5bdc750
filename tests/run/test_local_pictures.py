"""What a sensor said of all its tracks at one time."""

import numpy as np
import pytest

from oracles.local_tracks import NOISE, sensor_tracks
from trackweave.domain.tracks import TrackTable
from trackweave.filters.kalman import predicted
from trackweave.run.fusion_record import local_pictures


def tracks() -> TrackTable:
    objects = {4: (0.0, 0.0), 2: (500.0, 0.0)}
    return sensor_tracks(np.random.default_rng(1), objects, [0.0, 1.0, 2.0, 3.0, 4.0])


def without(table: TrackTable, *rows: int) -> TrackTable:
    keep = np.setdiff1d(np.arange(len(table)), rows)
    return TrackTable(*(getattr(table, name)[keep] for name in table.__dataclass_fields__))


def test_rows_of_one_time_are_one_picture() -> None:
    table = tracks()
    found = local_pictures("A", table, NOISE)
    assert [each.time for each in found] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert {each.sensor for each in found} == {"A"}
    assert found[1].track.tolist() == [4, 2]
    assert found[1].mean.tolist() == table.mean[2:4].tolist()


def test_a_track_that_misses_a_time_is_predicted_to_it() -> None:
    table = tracks()
    found = local_pictures("A", without(table, 2), NOISE)
    assert sorted(found[1].track.tolist()) == [2, 4]
    mean, spread = predicted(table.mean[:1], table.covariance[:1], np.ones(1), NOISE)
    place = found[1].track.tolist().index(4)
    assert found[1].mean[place] == pytest.approx(mean[0])
    assert found[1].covariance[place] == pytest.approx(spread[0])


def test_a_track_that_is_away_for_long_or_has_ended_is_not_there() -> None:
    found = local_pictures("A", without(tracks(), 2, 4, 6), NOISE)
    assert [len(each) for each in found] == [2, 1, 1, 1, 2]
    ended = local_pictures("A", without(tracks(), 8), NOISE)
    assert ended[-1].track.tolist() == [2]


def test_no_rows_are_no_pictures() -> None:
    assert local_pictures("A", TrackTable.empty(2), NOISE) == []
