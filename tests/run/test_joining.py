"""Objects that hide for minutes keep one name in assignments and history, once a run is over."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.metrics import assignment_quality

pytestmark = pytest.mark.slow

PERIOD, LAST = 5.0, 900.0


def reports(seed: int) -> pl.DataFrame:
    """Return twelve objects that wander in a square of 6 km, four of them unseen for minutes."""
    rng = np.random.default_rng(seed)
    rows = []
    for number in range(12):
        place, heading = rng.uniform(0, 6000, 2), rng.uniform(0, 2 * np.pi)
        speed, turn = rng.uniform(4, 14), 0.0
        hides = rng.uniform(200, 450)
        back = hides + rng.uniform(150, 250) if number < 4 else hides
        for time in np.arange(0.0, LAST, PERIOD):
            if rng.random() < 0.03:
                turn = rng.choice([0, 0, -1, 1]) * 0.01
            heading += turn * PERIOD
            home = 3000.0 - place
            if np.hypot(*home) > 3600.0:
                heading = np.arctan2(home[1], home[0])
            place = place + speed * PERIOD * np.array([np.cos(heading), np.sin(heading)])
            if not hides <= time < back and rng.random() < 0.95:
                rows.append((time, *(place + rng.normal(0.0, 5.0, 2)), number))
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row").sort("time")


def tracked(seed: int, **lifecycle: object) -> tuple[tw.TrackingResult, float]:
    table = reports(seed)
    result = tw.track(table.drop("target"), {"lifecycle": lifecycle})
    whose = [str(each) for each in table["target"]]
    found = result.assignments["track"].fill_null(-1).to_numpy()
    idf1 = assignment_quality(whose, found).idf1
    assert idf1 is not None
    return result, idf1


@pytest.fixture(scope="module")
def joined() -> tuple[tw.TrackingResult, float]:
    return tracked(6)


@pytest.fixture(scope="module")
def apart() -> tuple[tw.TrackingResult, float]:
    return tracked(6, join=False)


def test_names_last_through_silences(joined, apart):
    assert apart[1] < 0.93
    assert joined[1] > 0.99


def test_the_record_tells_what_was_joined(joined, apart):
    assert apart[0].run["joins"] is None
    told = joined[0].run["joins"]
    assert told["status"] == "optimal"
    assert len(told["list"]) == 3
    assert told["parted"] == []
    for each in told["list"]:
        assert 100.0 < each["silence"] < 300.0
        assert 0.5 < each["probability"] <= 1.0
        names = joined[0].assignments["track"]
        assert each["track"] not in names
        assert each["into"] in names
    assert any("3 tracks joined" in note for note in joined[0].run["notes"])
    assert not any("joined" in note for note in apart[0].run["notes"])


def test_what_was_known_then_is_not_changed(joined, apart):
    assert joined[0].tracks.equals(apart[0].tracks)


def test_history_goes_through_the_silence(joined):
    into = joined[0].run["joins"]["list"][0]["into"]
    own = joined[0].history.filter(pl.col("track") == into).sort("time")
    assert own["time"].diff().drop_nulls().max() == pytest.approx(PERIOD)
    assert set(own["status"]) == {"confirmed", "coasting"}
    whole = joined[0].history
    assert whole.equals(whole.sort("time", "track"))


def test_every_report_has_the_track_that_its_history_has(joined):
    names = set(joined[0].assignments["track"].drop_nulls())
    assert names == set(joined[0].history["track"])


def test_no_silence_is_longer_than_told():
    result, _ = tracked(6, rejoin=60.0)
    told = result.run["joins"]
    assert told is None or all(each["silence"] <= 60.0 for each in told["list"])


def test_the_same_seed_gives_the_same_bytes(joined):
    assert tracked(6)[0].files() == joined[0].files()


def test_documents_to_the_letter_join_nothing():
    table = reports(6).drop("target").filter(pl.col("time") < 60.0)
    for preset in ("hillis", "wiranto"):
        assert tw.track(table, preset=preset).run["joins"] is None
