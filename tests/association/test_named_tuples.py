"""What was chosen, in the numbers or names that the problem was given in."""

from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest

from trackweave.association.problem import Answer, AssignmentProblem, Certificate, Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import solve

NAMES = [["a", "x", None], ["a", "y", "q"], ["b", "x", ""], ["b", "y", "r"], ["b", None, None]]
COSTS = [-3.0, -5.0, -4.0, -1.0, 0.5]


def answered(problem: AssignmentProblem) -> Answer:
    return solve(problem, rng=np.random.default_rng(1))


def test_tuples_are_the_rows_that_were_chosen() -> None:
    rows = [[2, 1, 0], [1, 2, 1], [1, 1, 0], [2, 0, 0]]
    problem = AssignmentProblem.from_tuples(rows, [-4.0, -5.0, -3.0, 1.0])
    assert answered(problem).tuples.tolist() == [[2, 1, 0], [1, 2, 1]]


def test_tuples_of_an_array_are_its_indices() -> None:
    costs = np.random.default_rng(3).random((4, 4, 4))
    costs[0, 0, 0] = np.inf
    answer = answered(AssignmentProblem.from_array(costs))
    assert answer.tuples.shape == (4, 3)
    assert costs[tuple(answer.tuples.T)].sum() == pytest.approx(answer.cost)


def test_names_come_back_as_they_were_given() -> None:
    problem = AssignmentProblem.from_tuples(NAMES, COSTS)
    assert answered(problem).tuples.tolist() == [["a", "y", "q"], ["b", "x", ""]]
    assert problem.n_items == 6


def test_names_are_numbered_as_they_first_come() -> None:
    numbers = [[1, 1, 0], [1, 2, 1], [2, 1, 0], [2, 2, 2], [2, 0, 0]]
    prices = np.arange(6.0)
    named = AssignmentProblem.from_tuples(NAMES, COSTS, alone=prices)
    plain = AssignmentProblem.from_tuples(numbers, COSTS, alone=prices)
    assert named.item.tolist() == plain.item.tolist()
    assert named.total.tolist() == plain.total.tolist()


@pytest.mark.parametrize(
    "table",
    [
        pd.DataFrame(NAMES),
        pd.DataFrame(NAMES).replace({None: np.nan}),
        pd.DataFrame(NAMES, dtype="string"),
        pl.DataFrame(NAMES, orient="row"),
        np.array(NAMES, dtype=object),
        tuple(map(tuple, NAMES)),
    ],
)
def test_text_columns_of_any_table_are_names(table: Any) -> None:
    chosen = answered(AssignmentProblem.from_tuples(table, COSTS)).tuples
    assert chosen[:, :2].tolist() == [["a", "y"], ["b", "x"]]


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (np.array([["a", 1], ["b", "x"]], dtype=object), r"tuples\[0, 1\]: 1; expected a name"),
        ([["a", "x"], ["b"]], "tuples: .* expected rows of one length"),
        ([["a", ""], ["", None]], "tuples: a row without items"),
        (["a", "b"], "tuples: .*expected"),
    ],
)
def test_refuses_names_that_are_none(rows: Any, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        AssignmentProblem.from_tuples(rows, [0.0, 0.0])


def test_tuples_of_sequences_are_their_items() -> None:
    problem = AssignmentProblem(
        parent=[-1, 0, -1], item=[0, 2, 1], cost=[-1.0, -3.0, -1.0], total=[-1.0, -3.0, -1.0],
        must_cover=[0, 0, 0], instant=[0, 0, 1],
    )  # fmt: skip
    assert sorted(answered(problem).tuples.tolist()) == [[0, 2], [1, -1]]


def test_no_answer_has_no_tuples() -> None:
    answer = answered(AssignmentProblem.from_array([[1.0, np.inf], [2.0, np.inf]]))
    assert answer.status is Status.INFEASIBLE
    assert answer.tuples.shape == (0, 2)
    alone = Answer(answer.nodes, Certificate(0.0, 0.0, Status.OPTIMAL), 0, "", answer.prices)
    with pytest.raises(InvalidInputError, match="tuples: the answer of no problem"):
        _ = alone.tuples


def test_an_answer_prints_in_one_line() -> None:
    text = repr(answered(AssignmentProblem.from_tuples(NAMES, COSTS)))
    assert text == (
        "Answer(cost=-9, lower_bound=-9, gap=0, status='optimal', 2 sequences, "
        "stop_reason='gap closed')"
    )
