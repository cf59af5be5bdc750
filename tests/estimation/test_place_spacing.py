"""Places that all come back to, such as rooms: how far apart, and what a name says there."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.estimation.place_spacing import spacing_of_places


def badges(rng, n_reports=150):
    """Six badges, each told to be in the middle of a room of eight metres or of one beside."""
    rows = []
    for badge in range(6):
        room, time = rng.integers(0, 5, 2), rng.uniform(0.0, 3.0)
        for _ in range(n_reports):
            if rng.random() < 0.1:
                room = np.clip(room + rng.integers(-1, 2, 2), 0, 4)
            told = np.clip(room + (rng.random(2) < 0.05), 0, 4)
            rows.append((time, *(8.0 * told + 4.0), f"b{badge}", badge))
            time += rng.uniform(2.0, 4.0)
    names = ["time", "x", "y", "identity", "badge"]
    return pl.DataFrame(rows, names, orient="row").sort("time")


def test_the_spacing_of_rooms():
    table = badges(np.random.default_rng(1)).sort("badge", "time")
    place = table.select("x", "y").to_numpy()
    same = table["badge"].diff().to_numpy()[1:] == 0
    assert spacing_of_places(place[:-1][same], place[1:][same]) == 8.0


def test_who_goes_anywhere_has_none_however_long_it_rests():
    rng = np.random.default_rng(2)
    place = np.repeat(rng.normal(0.0, 100.0, (60, 2)), 3, axis=0)
    assert spacing_of_places(place[:-1], place[1:]) == 0.0
    assert spacing_of_places(place[:0], place[:0]) == 0.0


@pytest.mark.slow
def test_badges_in_rooms_are_who_they_say():
    # Somebody else was in each room lately, so that all names seemed to be at many places at once.
    table = badges(np.random.default_rng(3))
    result = tw.track(table.drop("badge"), rng=0)
    found = result.reports.with_columns(table["badge"])
    assert result.run["totals"]["tracks"] == 6
    assert found["track"].null_count() == 0
    assert not any("identities" in note for note in result.run["notes"])
