"""How often identities are wrong, and each one's reports."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave import track
from trackweave.estimation.identities import identity_error, identity_threads
from trackweave.estimation.lone import judged
from trackweave.metrics import assignment_quality


def herd(rng, *, wild=0.0):
    """Twenty animals within 200 m of each other, a fix every ten minutes; a share is wild."""
    rows, centre = [], np.zeros(2)
    away = rng.normal(0.0, 100.0, (20, 2))
    for number in range(60):
        centre = centre + 600.0 * rng.normal(0.0, 0.3, 2)
        away = 0.9 * away + rng.normal(0.0, 40.0, away.shape)
        for animal in range(20):
            time = 600.0 * number + 13.0 * animal + rng.uniform(0.0, 12.0)
            place = centre + away[animal] + rng.normal(0.0, 8.0, 2)
            place += 5e4 * rng.normal(size=2) * (rng.random() < wild)
            rows.append((time, *place, f"t{animal}", animal))
    names = ["time", "x", "y", "identity", "animal"]
    return pl.DataFrame(rows, names, orient="row").sort("time")


def ships(rng, *, wrong):
    """Forty that sail apart from each other, every ten seconds."""
    start, course = rng.uniform(-2e4, 2e4, (40, 2)), rng.uniform(0.0, 2 * np.pi, 40)
    rows = []
    for number in range(50):
        for ship in range(40):
            time = 10.0 * number + 0.2 * ship
            ahead = np.array([np.sin(course[ship]), np.cos(course[ship])])
            x, y = start[ship] + 8.0 * time * ahead
            who = rng.integers(40) if rng.random() < wrong else ship
            rows.append((time, x + rng.normal(0.0, 5.0), y + rng.normal(0.0, 5.0), f"s{who}"))
    return pl.DataFrame(rows, ["time", "x", "y", "identity"], orient="row").sort("time")


def read(table):
    return tw.read_reports(table.drop("animal", strict=False))


@pytest.mark.parametrize("wrong", [0.0, 0.01, 0.05])
def test_what_is_wrong_is_counted(wrong):
    found = identity_error(read(ships(np.random.default_rng(3), wrong=wrong)), 0)
    if wrong == 0.0:
        assert found < 1e-4
    else:
        assert 0.6 * wrong < found < 1.2 * wrong


@pytest.mark.slow
@pytest.mark.parametrize("names", ["numbers", "unknown", "half unknown"])
def test_what_names_no_object_is_no_identity(names):
    table = ships(np.random.default_rng(9), wrong=0.0)
    number = pl.int_range(pl.len()).cast(pl.String)
    named = {
        "numbers": number, "unknown": pl.lit("n/a"),
        "half unknown": pl.when(pl.int_range(pl.len()) % 80 < 40).then(pl.lit("-"))
        .otherwise("identity"),
    }[names]  # fmt: skip
    reports = read(table.with_columns(identity=named))
    found = identity_error(reports, 0)
    assert found > (0.3 if names == "half unknown" else 0.9)
    assert names == "half unknown" or identity_threads(reports, np.arange(len(reports))) is None
    result = track(table.with_columns(identity=named))
    assert sum("name no objects" in note for note in result.run["notes"]) == 1
    assert result.assignments["track"].null_count() < 20
    whose = table["identity"].to_list()
    assigned = result.assignments["track"].fill_null(-1).to_numpy()
    assert assignment_quality(whose, assigned).idf1 > 0.98


def test_who_is_seldom_named_and_walks_on_is_named_all_the_same():
    """Players whose numbers are read once in ten frames, one in twelve of them a team-mate's."""
    rng, rows = np.random.default_rng(4), []
    place, velocity = rng.uniform(0.0, 60.0, (12, 2)), rng.normal(0.0, 3.0, (12, 2))
    for frame in range(300):
        velocity = 0.98 * velocity + rng.normal(0.0, 0.6, (12, 2))
        place = place + 0.1 * velocity
        for player in range(12):
            who = rng.integers(12) if rng.random() < 1.0 / 12.0 else player
            name = f"n{who}" if rng.random() < 0.1 else None
            rows.append((0.1 * frame, *rng.normal(place[player], 0.2), name))
    table = pl.DataFrame(rows, ["time", "x", "y", "identity"], orient="row")
    assert identity_error(read(table), 0) < 0.1


def test_reports_that_are_far_off_are_under_their_own_name():
    """Where no other object is, nobody else can have sent them."""
    reports = read(herd(np.random.default_rng(4), wild=0.02))
    assert identity_error(reports, 0) < 1e-3


def test_without_names_nothing_is_known():
    reports = read(herd(np.random.default_rng(5)).drop("identity"))
    assert identity_error(reports, 0) is None
    assert identity_threads(reports, np.arange(len(reports))) is None


def test_threads_are_those_of_names():
    table = herd(np.random.default_rng(6))
    threads = judged(read(table), 0)[1]
    assert threads.is_whole
    animals = [set(table["animal"].gather(rows).to_list()) for rows in threads.rows]
    assert len(animals) == 20
    assert all(len(each) == 1 for each in animals)


def test_threads_are_those_of_names_where_many_reports_have_none():
    rng = np.random.default_rng(6)
    table = herd(rng)
    is_nameless = pl.Series(rng.random(len(table)) < 0.4)
    table = table.with_columns(identity=pl.when(~is_nameless).then("identity"))
    threads = judged(read(table), 0)[1]
    assert threads.n_reports == table["identity"].count()
    animals = [set(table["animal"].gather(rows).to_list()) for rows in threads.rows]
    assert len(animals) == 20
    assert all(len(each) == 1 for each in animals)


def test_threads_of_names_tell_although_most_names_were_heard_once():
    heard = ships(np.random.default_rng(4), wrong=0.0)
    often = heard.filter(pl.col("identity").is_in(["s0", "s1", "s2"]))
    once = heard.filter(~pl.col("identity").is_in(["s0", "s1", "s2"])).unique("identity")
    reports = read(pl.concat([often, once]).sort("time"))
    threads = identity_threads(reports, np.arange(len(reports)))
    assert threads is not None
    assert [each.size for each in threads[:4]] == [50, 50, 50, 1]


def test_names_that_are_often_wrong_thread_nothing():
    reports = read(ships(np.random.default_rng(7), wrong=0.1))
    assert identity_threads(reports, np.arange(len(reports))) is None


@pytest.mark.slow
@pytest.mark.parametrize(("nameless", "least"), [(0.0, 0.99), (0.25, 0.85)])
def test_a_herd_is_followed_by_names(nameless, least):
    """Animals nearer to each other than they go between two fixes, nothing told."""
    table = herd(np.random.default_rng(8))
    is_named = pl.Series(np.random.default_rng(1).random(len(table)) >= nameless)
    table = table.with_columns(identity=pl.when(is_named).then("identity"))
    result = track(table.drop("animal"))
    found = result.assignments["track"].fill_null(-1).to_numpy()
    assert assignment_quality(table["animal"].to_list(), found).idf1 > least
    assert result.run["configuration"]["sensors"]["default"]["identity_error"] < 1e-3
