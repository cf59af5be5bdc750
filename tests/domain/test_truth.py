"""Tests of the table of true positions."""

import numpy as np
import pytest

from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError


def test_sorts_by_time_then_by_target_as_text() -> None:
    table = TruthTable.from_columns(
        [1.0, 0.0, 1.0], ["b", "b", "a"], [[1, 1], [2, 2], [3, 3]], [[10, 0], [20, 0], [30, 0]]
    )
    assert table.time.tolist() == [0.0, 1.0, 1.0]
    assert table.target.tolist() == ["b", "a", "b"]
    assert table.position[:, 0].tolist() == [2.0, 3.0, 1.0]
    assert table.velocity is not None
    assert table.velocity[:, 0].tolist() == [20.0, 30.0, 10.0]


def test_turns_numbers_into_text() -> None:
    table = TruthTable.from_columns([0.0, 0.0], [7, 12], [[0, 0, 1], [1, 1, 2]])
    assert table.target.tolist() == ["12", "7"]
    assert (len(table), table.dim) == (2, 3)
    assert table.velocity is None


def test_holds_no_rows_at_all() -> None:
    assert len(TruthTable.from_columns([], [], np.empty((0, 2)))) == 0


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (([np.nan], ["a"], [[0, 0]]), "time"),
        (([0.0], ["a"], [[0, np.inf]]), "position"),
        (([0.0], ["a"], [[0, 0]], [[0, np.nan]]), "velocity"),
        (([0.0], ["a"], [[0]]), "expected 2 or 3"),
        (([0.0], ["a", "b"], [[0, 0]]), "target"),
        (([0.0], ["a"], [[0, 0]], [[0, 0, 0]]), "velocity"),
        (([0.0, 0.0], ["a", "a"], [[0, 0], [1, 1]]), "one place at a time"),
    ],
)
def test_refuses_what_is_no_truth(columns: tuple, words: str) -> None:
    with pytest.raises(InvalidInputError, match=words):
        TruthTable.from_columns(*columns)
