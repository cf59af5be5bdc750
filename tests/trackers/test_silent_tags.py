"""Who reports itself each second and then no more is not shown for minutes."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.association.living import still_lives

pytestmark = pytest.mark.slow

LAST = 100.0


@pytest.fixture(scope="module")
def rows():
    rng = np.random.default_rng(3)
    told = [
        (time + 0.3 * tag + rng.uniform(0, 0.1), 40.0 * tag + 0.5 * time, 0.0)
        for tag in range(3)
        for time in np.arange(0.0, 400.0)
        if tag < 2 or time < LAST
    ]
    table = pl.DataFrame(sorted(told), schema=["time", "x", "y"], orient="row")
    noise = rng.normal(0, 0.3, (2, len(table)))
    table = table.with_columns(x=pl.col("x") + noise[0], y=pl.col("y") + noise[1])
    tracks = tw.track(table, {"sensors": {"default": {"scans": False}}}).tracks
    return tracks.filter(pl.col("track") == tracks.filter(pl.col("time") < LAST)["track"].max())


def test_its_rows_end_when_it_has_been_silent_for_many_of_its_intervals(rows):
    assert LAST + 5.0 < rows["time"].max() < LAST + 100.0


def test_it_coasts_once_three_of_its_reports_are_missing(rows):
    since = pl.col("time") - pl.col("last_update")
    heard, missed = rows.filter(since < 2.0), rows.filter((since > 3.6) & (pl.col("time") > LAST))
    assert set(heard["status"]) <= {"confirmed", "tentative"}
    assert set(missed["status"]) == {"coasting"}
    assert missed["existence"].is_sorted(descending=True)
    assert missed["existence"][-1] < heard["existence"][-1]


def test_a_silence_lowers_the_chance_to_live_and_never_raises_it():
    lives = np.array([0.999, 0.5, 0.0, 1.0])
    before = lives
    for since in (0.0, 1.0, 3.0, 10.0, 100.0, 1e6):
        now = still_lives(lives, np.full(4, since))
        assert np.all(now <= before + 1e-12)
        before = now
    assert np.array_equal(still_lives(lives, np.zeros(4)), lives)
    assert before[:3].tolist() == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


def test_who_reported_once_among_those_who_report_each_second_is_not_shown_for_minutes():
    rng = np.random.default_rng(4)
    rows = [
        (time + 0.15 * tag, 0.5 * time, 60.0 * tag + rng.normal(0, 0.3))
        for tag in range(6)
        for time in np.arange(0.0, 300.0)
    ]
    rows.append((50.01, 1000.0, 1000.0))
    table = pl.DataFrame(sorted(rows), schema=["time", "x", "y"], orient="row")
    told = {"scans": False, "clutter_density": 1e-12}
    tracks = tw.track(table, {"sensors": {"default": told}}).tracks
    once = tracks.filter((pl.col("hits") == 1) & (pl.col("y") > 900.0))
    assert 50.0 < once["time"].max() < 240.0
