"""Assignment problems from files, what is wrong with them, and answers as tables."""

import gzip
import os

import numpy as np
import pandas as pd
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oracles.assignment import least_cost_of_tuples, random_tuples
from trackweave.association.problem import Status
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.io.encoding import encode_table
from trackweave.io.problem_file import ProblemTable, answer_frame, read_problem
from trackweave.solvers import Exact, solve

TEXT = "i1,i2,i3,cost\n1,1,0,-2.5\n1,0,2,-3\n0,1,0,0.5\n"
TUPLES = [[1, 1, 0], [1, 0, 2], [0, 1, 0]]
COSTS = [-2.5, -3.0, 0.5]
AXIAL = "3\n2 2 2 \n1\n2\n3\n4\n5\n6\n7\n8\n\n"


@pytest.fixture
def written(tmp_path):
    """Return what writes a file and gives its path."""

    def write(content: str | bytes, name: str = "p.csv"):
        data = content.encode() if isinstance(content, str) else content
        (tmp_path / name).write_bytes(data)
        return tmp_path / name

    return write


def refusal(source) -> str:
    with pytest.raises(DataFormatError) as caught:
        read_problem(source)
    message = str(caught.value)
    assert "\n" not in message
    return message


def solved(table: ProblemTable):
    problem = table.problem()
    return problem, solve(problem, Exact(), rng=np.random.default_rng(0))


@pytest.mark.parametrize("name", ["p.csv", "p.CSV", "p.txt", "p.csv.gz"])
def test_reads_tuples_and_costs(written, name):
    table = read_problem(written(gzip.compress(TEXT.encode()) if "gz" in name else TEXT, name))
    assert table.tuples.tolist() == TUPLES
    assert table.costs.tolist() == COSTS
    assert (table.alone, len(table), table.n_lists, table.n_items) == (0.0, 3, 3, 3)


def test_reads_parquet_and_tables_of_other_libraries(tmp_path):
    frame = pl.DataFrame({"i1": [1, 0], "i2": [2, 1], "cost": [-1, 2]})
    frame.write_parquet(tmp_path / "p.parquet")
    for source in (tmp_path / "p.parquet", str(tmp_path / "p.parquet"), frame, frame.to_arrow()):
        table = read_problem(source)
        assert (table.tuples.tolist(), table.costs.tolist()) == ([[1, 2], [0, 1]], [-1.0, 2.0])
    assert len(read_problem(pd.DataFrame({"i1": [1.0], "cost": [0.5]}))) == 1


def test_columns_may_stand_in_any_order(written):
    table = read_problem(written("cost,i2,i1\n0.5,2,1\n"))
    assert table.tuples.tolist() == [[1, 2]]


def test_what_is_read_can_be_changed_by_whoever_has_it(written):
    for source in (written(TEXT), written(AXIAL, "p.txt")):
        table = read_problem(source)
        assert table.tuples.flags.writeable
        assert table.costs.flags.writeable


@pytest.mark.parametrize("name", ["p.csv", "p.txt"])
def test_a_header_alone_is_an_empty_problem(written, name):
    table = read_problem(written("i1,i2,cost\n", name))
    problem, answer = solved(table)
    assert (len(table), table.n_items) == (0, 0)
    assert (answer.cost, answer.status) == (0.0, Status.OPTIMAL)
    assert answer_frame(table, problem, answer).shape == (0, 3)


def test_equal_tuples_count_as_the_cheapest(written):
    table = read_problem(written("i1,i2,cost\n1,1,-1\n1,1,-4\n1,1,-2\n"))
    problem, answer = solved(table)
    assert answer.cost == -4.0
    assert answer_frame(table, problem, answer).rows() == [(1, 1, -4.0)]


@pytest.mark.parametrize(
    "text",
    [
        AXIAL,
        AXIAL.removeprefix("3\n"),
        "\n 3 \n\n2 2 2\n1 2 3 4\n5 6 7 8",
        "2\t2\t2\r\n1 2\r\n3 4 5\r\n6 7 8\r\n",
        "\ufeff3\n2 2 2\n1\n2\n3\n4\n5\n6\n7\n8.0",
    ],
)
def test_reads_axial_costs_with_the_third_item_fastest(written, text):
    table = read_problem(written(text, "p.txt"))
    assert table.alone == np.inf
    by_tuple = dict(zip(map(tuple, table.tuples.tolist()), table.costs.tolist(), strict=True))
    assert by_tuple == {
        (i, j, k): 4.0 * (i - 1) + 2.0 * (j - 1) + k
        for i in (1, 2)
        for j in (1, 2)
        for k in (1, 2)
    }


def test_an_axial_problem_of_nothing_is_solved(written):
    table = read_problem(written("0 0 0\n", "p.txt"))
    assert solved(table)[1].cost == 0.0


@pytest.mark.shared
def test_axial_files_have_the_cost_that_their_solutions_say(shared):
    files = sorted((shared / "data" / "ap3").glob("*.txt"))
    assert len(files) == 30
    for file in files:
        said = file.with_suffix(".sol").read_text().split()
        table = read_problem(file)
        n = round(len(table) ** (1 / 3))
        chosen = np.array(said[2:], dtype=int).reshape(n, 3) - 1
        rows = np.ravel_multi_index(tuple(chosen.T), (n, n, n))
        assert table.tuples[rows].tolist() == (chosen + 1).tolist()
        assert table.costs[rows].sum() == float(said[1])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no header, the file is empty; expected columns' names"),
        ("i1,i2\n1,1\n", "column cost: missing; expected the cost of each tuple"),
        ("cost\n1\n", "column i1: missing; expected the number of the first list's item"),
        ("i1,I2,cost\n1,1,0\n", "column I2: unknown; expected i1, i2 and so on, and cost"),
        ("i1,i3,cost\n1,1,0\n", "column i2: missing; expected a column for each list"),
        ("i1,i2,price\n1,1,0\n", "column cost: missing; expected the cost of each tuple"),
        ("i1,i2,Cost\n1,1,0\n", "column cost: only Cost; expected"),
        ("i1,i01,cost\n1,1,0\n", "column i01: unknown; expected i1, i2"),
        ("i1,,cost\n1,1,0\n", "column (without a name): unknown; expected i1, i2"),
        ("i1,i1,cost\n1,1,0\n", "column i1: twice in the header; expected each name once"),
        ("i1|i2|cost\n1|1|0\n", "expected columns separated by commas"),
        ("i1,i2,cost\n1,1,nan\n", "row 1, column cost: nan; expected a finite number"),
        ("i1,i2,cost\n1,1,0\n1,2,inf\n", "row 2, column cost: inf; expected a number from -1e+12"),
        ("i1,i2,cost\n1,1,1e13\n", "row 1, column cost: 1e13; expected a number from -1e+12"),
        ("i1,i2,cost\n1,1,\n", "row 1, column cost: (empty); expected a finite number"),
        ("i1,i2,cost\n1,1,zap\n", "row 1, column cost: zap; expected a finite number"),
        (
            "i1,i2,cost\n1,1.5,0\n",
            "row 1, column i2: 1.5; expected a whole number from 1 up, or 0",
        ),
        ("i1,i2,cost\n1,-1,0\n", "row 1, column i2: -1; expected a number from 0 to 1e+07"),
        ("i1,i2,cost\n1,10000001,0\n", "row 1, column i2: 10000001; expected a number from 0"),
        ("i1,i2,cost\n1,,0\n", "row 1, column i2: (empty); expected a whole number"),
        ("i1,i2,cost\n1,2,0\n0,0,4\n", "row 2, column i1: 0; expected an item in one of i1 to i2"),
        ("i1,cost\n0,4\n", "row 1, column i1: 0; expected an item, numbered from 1 up"),
        ("i1,i2,cost\n1,1\n", "row 1: 2 cells; expected 3 as in the header"),
        ("i1,i2,cost\n1,2,0\n1,\xff,0\n", "row 2, column i2: ÿ; expected a whole number"),
    ],
)
def test_refuses_tables_that_are_no_problems(written, text, said):
    file = written(text)
    assert refusal(file).startswith(f"{file}")
    assert said in refusal(file)


def test_names_the_first_bad_row_whatever_its_column(written):
    file = written("i1,i2,cost\n1,1,0\n0,0,1\n1,1,nan\n-1,0,0\n")
    assert "row 2, column i1" in refusal(file)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", ": the file is empty; expected a line n n n"),
        (" \n\n", ": the file is empty; expected a line n n n"),
        ("3\n", ", line 2: (empty); expected the number of items in each of three lists"),
        ("\n3\n2 2\n1", ", line 3: 2 2; expected the number of items in each"),
        ("2 2 3\n" + "1\n" * 12, ", line 1: 2 2 3; expected the number of items in each"),
        ("-1 -1 -1\n1", ", line 1: -1 -1 -1; expected the number of items in each"),
        ("4\n2 2 2 2\n1", ", line 1: 4; expected the number of items in each"),
        ("201 201 201\n1", ", line 1: 201 items; expected at most 200 in each list"),
        ("9" * 400 + (" " + "9" * 400) * 2, "; expected the number of items in each"),
        ("2 2 2\n1 2 3 4 5 6 7\n", ": 7 costs; expected 2³ = 8"),
        ("2 2 2\n1 2 3 4 5 6 7 8\n9\n", ": 9 costs; expected 2³ = 8"),
        ("3\n2 2 2\n1 2 3\n\n4 zap 6 7 8", ", line 5: zap; expected a finite number"),
        ("2 2 2\n1 2 3\n4 5 6 7 nan", ", line 3: nan; expected a finite number"),
        ("2 2 2\n1 2 3\n4 5 6 -inf 8", ", line 3: -inf; expected a number from -1e+12 to 1e+12"),
        ("2 2 2\n1 2 3 4 5 6 7 1_0", ", line 2: 1_0; expected a finite number"),
        ("\x1f\x8b\x08\0\0", ", line 1: '"),
        ("2 2 2\n1,2,3,4,5,6,7,8\n", ": 1 costs; expected 2³ = 8"),
        ("i1\n1\n", ", column cost: missing"),
    ],
)
def test_refuses_text_that_is_no_problem(written, text, said):
    file = written(text, "p.txt")
    assert refusal(file).startswith(f"{file}{said}" if said[0] in ":," else f"{file}, line 1: ")
    assert said in refusal(file)
    assert len(refusal(file)) < 600


def test_names_the_endings_that_it_knows(written):
    file = written(TEXT, "p.xlsx")
    known = ".csv, .csv.gz, .parquet, .txt"
    assert refusal(file) == f"{file}: unknown file ending; expected {known}"


@pytest.mark.parametrize("name", ["p.csv", "p.txt", "p.zap"])
def test_names_a_file_that_is_not_there(tmp_path, name):
    assert refusal(tmp_path / name) == f"{tmp_path / name}: no such file"


def test_names_what_is_no_file(tmp_path):
    (tmp_path / "p.txt").mkdir()
    assert "a directory; expected a file" in refusal(tmp_path / "p.txt")
    assert "not a file name" in refusal("a\0b.txt")
    assert "cannot be read" in refusal("x" * 300 + ".txt")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes with names")
def test_does_not_wait_for_a_pipe(tmp_path):
    os.mkfifo(tmp_path / "p.txt")
    assert "not a regular file" in refusal(tmp_path / "p.txt")


def test_refuses_what_is_no_table():
    with pytest.raises(InvalidInputError, match="not a table; expected a path"):
        read_problem([1, 2])


def test_the_answers_rows_add_up_to_its_cost():
    rng = np.random.default_rng(8)
    for _ in range(40):
        table = ProblemTable(*random_tuples(rng, 12))
        problem, answer = solved(table)
        frame = answer_frame(table, problem, answer)
        assert answer.cost == pytest.approx(least_cost_of_tuples(table.tuples, table.costs))
        assert frame["cost"].sum() == pytest.approx(answer.cost)
        chosen = frame.drop("cost").to_numpy()
        for place in range(table.n_lists):
            taken = chosen[chosen[:, place] > 0, place].tolist()
            assert sorted(taken) == sorted(set(table.tuples[:, place].tolist()) - {0})


def test_an_answer_lists_tuples_first_and_then_what_is_left_alone(written):
    text = "i1,i2,cost\n2,1,-5\n1,3,-4\n3,0,0.25\n3,0,0.5\n3,2,9\n"
    table = read_problem(written(text))
    frame = answer_frame(table, *solved(table))
    assert frame.columns == ["i1", "i2", "cost"]
    assert frame.rows() == [(1, 3, -4.0), (2, 1, -5.0), (3, 0, 0.25), (0, 2, 0.0)]
    assert encode_table(frame, "a.csv").decode().splitlines()[1:] == [
        "1,3,-4.0", "2,1,-5.0", "3,0,0.25", "0,2,0.0",
    ]  # fmt: skip


def test_an_item_that_a_number_skips_is_none():
    table = ProblemTable(np.array([[1, 900], [7, 0]]), np.array([-1.0, 2.0]))
    assert table.n_items == 3
    assert answer_frame(table, *solved(table)).rows() == [(1, 900, -1.0), (7, 0, 2.0)]


def test_where_nothing_covers_every_item_there_is_no_answer():
    table = ProblemTable(np.array([[1, 1], [2, 1]]), np.array([1.0, 2.0]), alone=np.inf)
    problem, answer = solved(table)
    assert answer.status in {Status.INFEASIBLE, Status.UNKNOWN}
    assert answer_frame(table, problem, answer).shape == (0, 3)


nasty = st.sampled_from(
    ["", " ", "nan", "inf", "-1", "1e9", "1e309", "2.5", "x", '"', "a,b", "\n", "\0", "é", "٣",
     "1_0", "True", "9" * 400, "3", "2 2 2", "i1", "i2", "cost", "\u2028", "1.0 ", "\ufeff"]
)  # fmt: skip


@given(st.lists(st.tuples(st.integers(0, 12), nasty), min_size=1, max_size=4), st.booleans())
def test_mangled_files_are_problems_or_refused(tmp_path_factory, changes, is_axial):
    cells = (AXIAL if is_axial else TEXT).replace("\n", " \n ").split(" ")
    for place, cell in changes:
        cells[place % len(cells)] = cell
    file = tmp_path_factory.getbasetemp() / ("m.txt" if is_axial else "m.csv")
    file.write_text((" " if is_axial else "").join(cells), encoding="utf-8")
    try:
        table = read_problem(file)
    except DataFormatError as err:
        assert str(err).isprintable()
        assert len(str(err)) < 600
    else:
        assert np.isfinite(table.costs).all()
        assert np.all(table.tuples.any(axis=1) & (table.tuples >= 0).all(axis=1))
