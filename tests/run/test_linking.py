"""Particles linked in one line, as those know who come from trackpy."""

import json

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import trackweave as tw
from trackweave.errors import InvalidInputError
from trackweave.metrics import assignment_quality


def wandering(n_frames: int = 20) -> tuple[pl.DataFrame, list[int]]:
    """Four particles far from one another, one of them unseen once, in no order."""
    rng = np.random.default_rng(2)
    rows = []
    for number in range(4):
        place = np.array([100.0 * number, 50.0])
        for frame in range(n_frames):
            place = place + rng.normal(0.0, 1.0, 2)
            if not (number == 2 and frame == 7):
                rows.append((frame, *place, number))
    order = rng.permutation(len(rows))
    table = pl.DataFrame([rows[k] for k in order], ["frame", "x", "y", "true"], orient="row")
    return table.drop("true"), table["true"].to_list()


@pytest.mark.parametrize(
    "make",
    [lambda t: t, lambda t: pd.DataFrame(t.to_dict(as_series=False)), pl.DataFrame.to_arrow],
)
def test_each_row_gets_its_particle_in_the_table_that_came(make):
    table, true = wandering()
    given = make(table)
    found = tw.link(given, search_range=5.0, memory=1)
    assert type(found) is type(given)
    particle = (
        found["particle"].to_pylist() if isinstance(found, pa.Table) else list(found["particle"])
    )
    assert len(set(zip(true, particle, strict=True))) == 4 == len(set(particle))
    assert particle[0] == 0


def test_without_memory_a_particle_unseen_is_another():
    table, true = wandering()
    found = tw.link(table, search_range=5.0)["particle"].to_list()
    assert len({p for t, p in zip(true, found, strict=True) if t == 2}) == 2


def test_what_stands_alone_is_a_particle():
    table = pl.DataFrame({"frame": [0, 1, 1], "x": [0.0, 0.5, 500.0], "y": [0.0] * 3})
    assert tw.link(table, search_range=3.0)["particle"].to_list() == [0, 0, 1]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"search_range": 0.0}, "search_range"),
        ({"search_range": 5.0, "memory": -1}, "memory"),
        ({"search_range": 5.0, "t_column": "time"}, "column time: missing"),
        ({"search_range": 5.0, "pos_columns": ["x"]}, "two or three"),
    ],
)
def test_what_cannot_be_used_is_refused(given, expected):
    table, _ = wandering(3)
    with pytest.raises(InvalidInputError, match=expected):
        tw.link(table, **given)


@pytest.mark.slow
@pytest.mark.shared
def test_cells_are_all_linked_rightly(shared):
    folder = shared / "data" / "cell_btrack"
    table = pl.read_csv(folder / "test_data.csv")
    known = json.loads((folder / "test_ground_truth.json").read_text())
    true = np.full(len(table), "", dtype=object)
    for name, rows in known.items():
        true[rows] = name
    found = tw.link(table, search_range=10.0, pos_columns=["x", "y"], t_column="t")
    assert assignment_quality(true.tolist(), found["particle"].to_numpy()).idf1 == 1.0
