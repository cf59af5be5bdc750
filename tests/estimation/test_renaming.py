"""Names that end where others begin are of objects that change their names."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.estimation.renaming import renaming_share


def walkers(rng, lasting, *, doors=False):
    """Ten people who report every five seconds, each under a name for so long [s]."""
    rows, number = [], 0
    for person in range(30 if doors else 10):
        # Through a door one comes after the other, whoever is inside meanwhile.
        begin = 25.0 * person + rng.uniform(0.0, 20.0) if doors else rng.uniform(0.0, 5.0)
        end = begin + rng.uniform(80.0, 160.0) if doors else 900.0
        place, velocity, until = rng.uniform(0.0, 100.0, 2), np.zeros(2), -1.0
        if doors:
            place, velocity = np.array([50.0, 0.0]), rng.normal(0.0, 0.7, 2)
        time = begin
        while time < end:
            if time > until:
                number, until = number + 1, time + rng.uniform(0.7, 1.3) * lasting
            rows.append((time, *(place + rng.normal(0.0, 1.0, 2)), f"n{number}", person))
            wait = rng.uniform(4.0, 6.0)
            if doors:
                # Out and back to the door.
                velocity = -velocity if abs(time - (begin + end) / 2) < wait / 2 else velocity
            else:
                velocity = 0.8 * velocity + 0.4 * rng.normal(size=2)
            place, time = place + wait * velocity, time + wait
    names = ["time", "x", "y", "identity", "person"]
    return pl.DataFrame(rows, names, orient="row").sort("time")


def share(table):
    return renaming_share(tw.read_reports(table.drop("person")), 0)


@pytest.mark.parametrize("seed", range(3))
def test_changes_of_names_are_share(seed):
    table = walkers(np.random.default_rng(seed), 400.0)
    changes = table["identity"].n_unique() - 10
    # Reckoned with are five times as many as are seen.
    assert 0.7 < share(table) * table.height / (5 * changes) <= 1.0


@pytest.mark.parametrize("seed", range(3))
def test_who_keeps_a_name_changes_none(seed):
    assert share(walkers(np.random.default_rng(seed), 1e9)) == 0.0
    assert share(walkers(np.random.default_rng(seed), 1e9, doors=True)) == 0.0


def test_reports_without_names_change_none():
    table = walkers(np.random.default_rng(1), 200.0).drop("identity", "person")
    assert renaming_share(tw.read_reports(table), 0) == 0.0


@pytest.mark.slow
def test_an_object_goes_on_under_another_name():
    table = walkers(np.random.default_rng(5), 200.0)
    result = tw.track(table.drop("person"), rng=0)
    assert result.run["totals"]["tracks"] <= 14  # 46 names
    assert any("identities change" in note for note in result.run["notes"])
