"""The command solve."""

import csv
import json
import signal
import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest
from numba.core.event import trigger_event

import trackweave as tw
from cli.conftest import Run
from cli.test_evaluate import Heard
from oracles.assignment import least_cost_of_tuples, random_tuples
from trackweave.cli.solve import run_solve
from trackweave.io.problem_file import read_problem
from trackweave.solvers import METHODS

TEXT = "i1,i2,cost\n1,1,-2\n1,2,-3\n2,2,-2\n2,0,0.5\n"
AXIAL = "3\n2 2 2\n5 1 4 3 2 6 8 7\n"


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let nobody be told of kernels that happen to be compiled here first."""
    monkeypatch.setattr("trackweave.run.kernels.PATIENCE", 600.0)


@pytest.fixture
def problem(tmp_path: Path) -> Path:
    file = tmp_path / "problem.csv"
    file.write_text(TEXT)
    return file


def write_tuples(path: Path, tuples: np.ndarray, costs: np.ndarray) -> Path:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*(f"i{place + 1}" for place in range(tuples.shape[1])), "cost"])
        for row, cost in zip(tuples.tolist(), costs.tolist(), strict=True):
            writer.writerow([*row, repr(cost)])
    return path


def random_axial(path: Path, n: int) -> Path:
    costs = np.random.default_rng(n).integers(1, 1000, n**3)
    path.write_text("\n".join([f"{n} {n} {n}", *map(str, costs)]))
    return path


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def found(run: Run, *arguments: object) -> dict[str, Any]:
    done = run("solve", *arguments, "--json")
    assert done.exit_code == 0, done.stderr
    assert done.stderr == ""
    values: dict[str, Any] = json.loads(done.stdout)
    return values


@pytest.mark.slow
def test_prints_one_json_object(run: Run, problem: Path) -> None:
    values = found(run, problem)
    assert values.pop("time_s") >= 0.0
    assert values.pop("evaluations") > 0
    assert values.pop("stop_reason")
    assert values.pop("method") in METHODS
    assert values == {
        "cost": -4.0, "lower_bound": -4.0, "gap": 0.0, "status": "optimal",
        "tuples": 4, "items": 4, "seed": 0, "out": None,
    }  # fmt: skip


def test_says_what_it_found_in_a_table_on_terminals_and_in_a_line_elsewhere(
    run: Run, problem: Path
) -> None:
    done = run("solve", problem, "--method", "exact", "--seed", 3)
    assert (done.exit_code, done.stdout) == (0, "")
    assert done.stderr == "cost -4, lower bound -4, optimal; --json tells all\n"
    voice = Heard()
    run_solve(voice, problem, method="exact", seed=3)
    assert voice.rows["cost"] == voice.rows["lower bound"] == "-4"
    assert voice.rows["status"] == "optimal"


def test_quiet_says_nothing(run: Run, problem: Path) -> None:
    done = run("solve", problem, "--quiet")
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_every_method_gives_a_bound_and_an_answer_that_costs_what_it_says(
    method: str, run: Run, tmp_path: Path
) -> None:
    rng = np.random.default_rng(11)
    for trial in range(3):
        tuples, costs = random_tuples(rng, 14)
        file = write_tuples(tmp_path / f"{trial}.csv", tuples, costs)
        out = tmp_path / f"answer{trial}.csv"
        values = found(run, file, "--method", method, "-o", out)
        optimum = least_cost_of_tuples(tuples, costs)
        assert values["lower_bound"] - 1e-9 <= optimum <= values["cost"] + 1e-9
        assert sum(float(row["cost"]) for row in rows(out)) == pytest.approx(values["cost"])
        assert values["method"] == method


def test_the_default_method_is_the_librarys(run: Run, tmp_path: Path) -> None:
    file = random_axial(tmp_path / "p.txt", 7)
    values = found(run, file, "--seed", 5)
    answer = tw.solve(read_problem(file).problem(), rng=np.random.default_rng(5))
    assert values["cost"] == answer.cost
    assert values["evaluations"] == answer.evaluations
    assert values["stop_reason"] == answer.stop_reason


def test_axial_items_are_each_covered_once(run: Run, tmp_path: Path) -> None:
    file, out = tmp_path / "p.txt", tmp_path / "a.csv"
    file.write_text(AXIAL)
    values = found(run, file, "--method", "exact", "-o", out)
    # 5 + 7, 1 + 8, 4 + 6 or 3 + 2.
    assert (values["cost"], values["status"], values["items"]) == (5.0, "optimal", 6)
    assert out.read_text() == "i1,i2,i3,cost\n1,2,2,3.0\n2,1,1,2.0\n"


@pytest.mark.parametrize("name", ["a.csv", "a.csv.gz", "a.parquet"])
def test_writes_the_answer_by_the_ending(name: str, run: Run, problem: Path) -> None:
    out = problem.parent / name
    out.write_bytes(b"old")
    values = found(run, problem, "--out", out)
    assert values["out"] == str(out)
    table = read_problem(out)
    assert table.tuples.tolist() == [[1, 1], [2, 2]]
    assert table.costs.tolist() == [-2.0, -2.0]
    assert sorted(path.name for path in problem.parent.iterdir()) == sorted([name, "problem.csv"])


@pytest.mark.slow
def test_the_same_seed_gives_the_same_answer(run: Run, tmp_path: Path) -> None:
    file = random_axial(tmp_path / "p.txt", 9)
    told, written = [], []
    for seed in (4, 4):
        values = found(run, file, "--seed", seed, "-o", tmp_path / "a.csv")
        told.append({name: value for name, value in values.items() if name != "time_s"})
        written.append((tmp_path / "a.csv").read_bytes())
    assert told[0] == told[1]
    assert written[0] == written[1]


def test_an_empty_problem_costs_nothing(run: Run, tmp_path: Path) -> None:
    file, out = tmp_path / "p.csv", tmp_path / "a.csv"
    file.write_text("i1,i2,cost\n")
    values = found(run, file, "-o", out)
    assert (values["cost"], values["status"], values["items"]) == (0.0, "optimal", 0)
    assert out.read_text() == "i1,i2,cost\n"


@pytest.mark.parametrize(("cost", "is_said"), [(3.0, True), (-3.0, False)])
def test_says_why_nothing_is_chosen(run: Run, tmp_path: Path, cost: float, is_said: bool) -> None:
    table = tmp_path / "problem.csv"
    table.write_text(f"i1,i2,cost\n1,1,{cost}\n1,2,4\n")
    assert ("no tuple is chosen" in run("solve", table).stderr) == is_said


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_no_time_at_all_gives_what_can_be_had_at_once(
    method: str, run: Run, tmp_path: Path
) -> None:
    values = found(
        run, random_axial(tmp_path / "p.txt", 12), "--method", method, "--time-limit", 0
    )
    assert values["status"] in {"feasible", "optimal", "unknown"}
    if values["status"] == "unknown":
        assert values["cost"] is None
    else:
        assert values["lower_bound"] <= values["cost"]
        assert values["gap"] > 0 or values["status"] == "optimal"


def test_the_clock_runs_from_the_start_of_solving(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from trackweave.cli import solve as command
    from trackweave.cli.edge import Voice

    now, limits = [100.0], []

    def watch(problem: Any, solver: Any, *, rng: Any, time_limit: Any) -> Any:
        limits.append(time_limit)
        now[0] += 1.0
        return original(problem, solver, rng=rng)

    def build_slowly(source: Path, table: Any) -> Any:
        now[0] += 1.0
        return build(source, table)

    def read_slowly(path: Path) -> Any:
        now[0] += 1000.0
        return read_problem(path)

    original, build = command.solvers.solve, command._problem
    monkeypatch.setattr(command, "_problem", build_slowly)
    monkeypatch.setattr(command, "perf_counter", lambda: now[0])
    monkeypatch.setattr(command, "read_problem", read_slowly)
    monkeypatch.setattr(command, "warm_up", lambda solver, rng: None)
    monkeypatch.setattr(command.solvers, "solve", watch)
    file = tmp_path / "p.csv"
    file.write_text(TEXT)
    values = run_solve(Voice(quiet=True), file, time_limit=2.5)
    assert limits == [1.5]
    assert values["time_s"] == 2.0


@pytest.mark.parametrize(("patience", "quiet", "said"), [(0.0, 0, 1), (60.0, 0, 0), (0.0, 1, 0)])
def test_says_that_it_compiles_where_that_takes_long(
    patience: float, quiet: int, said: int, run: Run, problem: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    def warm_up(solver: object, rng: object) -> None:
        with trigger_event("numba:compile"):
            pass

    monkeypatch.setattr("trackweave.run.kernels.PATIENCE", patience)
    monkeypatch.setattr("trackweave.cli.solve.warm_up", warm_up)
    done = run("solve", problem, *(["--quiet"] if quiet else []))
    assert done.exit_code == 0, done.stderr
    assert done.stderr.count("compiling kernels that run here") == said
    # Off a terminal one line stands for the table.
    assert ("lower bound" in done.stderr) != quiet


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--method", "exakt"], '--method: "exakt" is not known; did you mean exact?'),
        (["--method", ""], '--method: "" is not known; expected one of auto'),
        (["--time-limit", "-1"], "--time-limit: -1.0; expected a number ≥ 0 of seconds"),
        (["--time-limit", "nan"], "--time-limit: nan; expected a number"),
        (["--time-limit", "inf"], "--time-limit: inf; expected a number"),
        (["--time-limit", "zap"], "--time-limit"),
        (["--seed", "-1"], "--seed"),
        (["-o", "a.xlsx"], "a.xlsx: unknown file ending; expected .csv"),
        (["-o", "none/a.csv"], "none/a.csv: no such directory"),
        (["-o", "PROBLEM"], "an input of this run, which would be replaced"),
        (["-o", "FOLDER"], "a directory; expected the name of a file"),
    ],
)
def test_refuses_options_that_make_no_sense(
    options: list[str], said: str, run: Run, problem: Path
) -> None:
    (problem.parent / "folder.csv").mkdir()
    places = {"PROBLEM": str(problem), "FOLDER": str(problem.parent / "folder.csv")}
    done = run("solve", problem, *[places.get(option, option) for option in options])
    assert done.exit_code == 2
    assert said in done.stderr
    assert problem.read_text() == TEXT


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("p.csv", b"", "the file is empty"),
        ("p.csv", b"i1,i2,cost\n1,1,0\n1,2,nan\n", "p.csv, row 2, column cost: nan; expected a"),
        ("p.csv", b"i1,i2,cost\n1,-1,0\n", "p.csv, row 1, column i2: -1; expected a number"),
        ("p.txt", b"2 2 2\n1 2 3\n", "p.txt: 3 costs; expected 2"),
        ("p.zip", b"PK", "unknown file ending"),
    ],
)
def test_refuses_bad_problems_in_one_line(
    name: str, content: bytes, said: str, run: Run, tmp_path: Path
) -> None:
    file, out = tmp_path / name, tmp_path / "a.csv"
    file.write_bytes(content)
    done = run("solve", file, "-o", out)
    assert done.exit_code == 2
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""
    assert not out.exists()


@pytest.mark.slow
def test_a_table_of_an_infeasible_problem_is_empty(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from trackweave.io.problem_file import ProblemTable

    # Two items of the first list, one of the second, and all have to be covered.
    table = ProblemTable(np.array([[1, 1], [2, 1]]), np.array([1.0, 2.0]), alone=np.inf)
    monkeypatch.setattr("trackweave.cli.solve.read_problem", lambda path: table)
    out = tmp_path / "a.csv"
    values = found(run, "p.csv", "--method", "exact", "-o", out)
    assert values["status"] in {"infeasible", "unknown"}
    assert (values["cost"], values["gap"]) == (None, None)
    assert out.read_text() == "i1,i2,cost\n"


def test_takes_a_hundred_thousand_tuples(run: Run, tmp_path: Path) -> None:
    rng = np.random.default_rng(12)
    tuples, costs = rng.integers(1, 60, (100_000, 3)), rng.normal(size=100_000)
    frame = pl.DataFrame({f"i{k + 1}": tuples[:, k] for k in range(3)} | {"cost": costs})
    frame.write_csv(tmp_path / "p.csv")
    values = found(run, tmp_path / "p.csv", "--method", "greedy")
    assert (values["tuples"], values["items"]) == (100_000, 59 * 3)
    assert values["cost"] < -100


@pytest.mark.slow
def test_control_c_is_status_130_and_leaves_nothing(problem: Path) -> None:
    out = problem.parent / "a.csv"
    code = (
        "import sys, time\n"
        "import trackweave.cli.solve\n"
        "from trackweave.cli import main\n"
        "def solve(*_, **__):\n"
        "    print('solving', flush=True)\n"
        "    time.sleep(60)\n"
        "trackweave.cli.solve.solvers.solve = solve\n"
        f"sys.argv = ['trackweave', 'solve', {str(problem)!r}, '-o', {str(out)!r}]\n"
        "main()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "solving\n"
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=50)
    assert process.returncode == 130
    assert said.splitlines()[-1] == "interrupted"
    assert "Traceback" not in said
    assert not out.exists()


class NotOurs(tw.Greedy):
    """A solver as another package would bring one."""


def test_a_solver_of_another_package_is_found(problem: Path, monkeypatch) -> None:
    entry = EntryPoint("not-ours", f"{__name__}:NotOurs", "trackweave.solvers")
    monkeypatch.setattr("trackweave.config.plugins.entry_points", lambda **which: [entry])
    found = run_solve(Heard(), problem, method="not-ours")
    assert found["method"] == "not-ours"
    assert found["cost"] == run_solve(Heard(), problem, method="greedy")["cost"]
