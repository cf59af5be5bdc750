"""The usable preset: the document's search on lists as they come."""

import numpy as np
import pytest

import trackweave as tw
from oracles.local_tracks import sensor_table
from trackweave.errors import InvalidInputError
from trackweave.presets import huo, huo_2008

PLACES = {1: (0.0, 0.0), 2: (0.0, 400.0), 3: (300.0, 900.0), 4: (-200.0, 1500.0)}
TIMES = [float(time) for time in range(6)]


def tables() -> dict[str, object]:
    """Return tracks of one sensor that sees all, one that sees some, and one that sees none."""
    rng = np.random.default_rng(2)
    some = {7: PLACES[4], 8: PLACES[2]}
    blind = sensor_table(rng, some, TIMES).clear()
    return {"A": sensor_table(rng, PLACES, TIMES), "B": sensor_table(rng, some, TIMES), "C": blind}


@pytest.mark.slow
def test_takes_unequal_and_empty_lists_which_the_strict_one_refuses() -> None:
    found = tw.fuse(tables(), preset="huo", rng=np.random.default_rng(1))
    pairs = {
        number: {(one.sensor, one.track) for one in found.values.pairings if one.object == number}
        for number in {one.object for one in found.values.pairings if not one.reason}
    }
    assert {("A", 4), ("B", 7)} in pairs.values()
    assert {("A", 2), ("B", 8)} in pairs.values()
    assert found.run["totals"]["common_objects"] == 2
    with pytest.raises(InvalidInputError, match="the preset huo takes any"):
        tw.fuse(tables(), preset="huo-2008", rng=np.random.default_rng(1))


def test_keeps_the_documents_statistic_search_and_operators() -> None:
    strict, usable = huo_2008.CONFIGURATION, huo.CONFIGURATION
    assert usable["statistic"]["kind"] == strict["statistic"]["kind"] == "chain"
    for key in ("method", "reproduction", "mutation", "mutate", "population", "patience"):
        assert usable["search"][key] == strict["search"][key]
    assert huo_2008.USABLE == "huo"


def test_every_addition_has_its_reason() -> None:
    strict, usable = huo_2008.CONFIGURATION, huo.CONFIGURATION
    changed = {key for key in ("method", "confirm", "complete") if strict[key] != usable[key]}
    for table in ("statistic", "search"):
        changed |= {
            f"{table}.{key}"
            for key, value in usable[table].items()
            if strict[table].get(key) != value and key not in {"length"}
        }
    assert huo.__doc__ is not None
    assert [key for key in changed if f"``{key}``" not in huo.__doc__] == []
