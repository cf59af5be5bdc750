"""Islands on the workers of an engine: the answer of one thread, whatever becomes of workers."""

import importlib.util
import os
import signal
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing import active_children

import numpy as np
import pytest

from oracles import errands
from oracles.assignment import hard_tuples
from oracles.unfit_search import Unfit
from trackweave.association.problem import Answer
from trackweave.config import load_configuration
from trackweave.config.load import without_deadline
from trackweave.config.search import make_solver
from trackweave.engine import EngineError, engine_of, keeping, kept_engine
from trackweave.errors import InvalidInputError
from trackweave.solvers import Annealing, AntSystem, Genetic, Islands, ListGenetic, TabuSearch

HARD = hard_tuples(4, 1500, 20)
METHODS = (
    Annealing(), Genetic(population=10), AntSystem(ants=6), ListGenetic(population=10),
    TabuSearch(),
)  # fmt: skip
MIXED = Islands(METHODS, islands=5, epoch=3, epochs=3)
RAY = pytest.param(
    "ray",
    marks=[
        pytest.mark.slow,
        pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="Ray is missing"),
    ],
)


def told(answer: Answer) -> tuple[object, ...]:
    return (
        answer.nodes.tobytes(), answer.certificate, answer.evaluations, answer.stop_reason,
        answer.prices.tobytes(),
    )  # fmt: skip


def answered(solver: Islands, seed: int = 3, **given: object) -> tuple[object, ...]:
    return told(solver(HARD, rng=np.random.default_rng(seed), **given))


@pytest.fixture(autouse=True)
def _ended() -> Iterator[None]:
    """End the workers that stay."""
    yield
    keeping._end()


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["local", RAY])
@pytest.mark.parametrize("neighbours", [1, 4])
def test_answers_are_those_of_one_thread_for_any_number_of_workers(
    engine: str, neighbours: int
) -> None:
    solver = replace(MIXED, neighbours=neighbours)
    alone = answered(replace(solver, threads=1))
    assert alone[3] == "epochs"
    for workers in (1, 2, 3):
        assert answered(replace(solver, engine=engine, workers=workers)) == alone


@pytest.mark.slow
def test_a_killed_worker_changes_nothing() -> None:
    solver = replace(MIXED, epochs=10, patience=100)
    alone = answered(replace(solver, threads=1))
    stop, killed = threading.Event(), []

    def kill() -> None:
        while not stop.is_set() and len(killed) < 2:  # a task is given out three times
            for child in active_children()[:1]:
                os.kill(child.pid, signal.SIGKILL)
                killed.append(child.pid)
            time.sleep(0.5)

    thread = threading.Thread(target=kill)
    with kept_engine("local", 2) as pool:
        pool.submit(errands.square, 1)
        assert len(list(pool.gather())) == 1
    thread.start()
    found = answered(replace(solver, engine="local", workers=2))
    stop.set()
    thread.join()
    assert killed
    assert found == alone


@pytest.mark.slow
def test_interrupted_searches_end_the_same() -> None:
    solver = replace(MIXED, engine="local", workers=2)
    state = solver.start(HARD, rng=np.random.default_rng(3))
    while not state.done:
        state = solver.advance(state, evaluations=300)
    whole = answered(replace(solver, engine=None, workers=None, threads=1))
    assert told(solver.answer(state)) == whole


def test_a_stop_is_heeded_at_the_end_of_an_epoch() -> None:
    asked = []

    def stop() -> bool:
        asked.append(threading.get_ident())
        return len(asked) > 20

    solver = replace(MIXED, epochs=10**6, patience=10**6, engine="local", workers=2)
    answer = solver(HARD, rng=np.random.default_rng(1), stop=stop)
    assert answer.stop_reason == "stopped"
    assert set(asked) == {threading.get_ident()}


@pytest.mark.slow
def test_workers_stay_from_search_to_search() -> None:
    solver = Islands(islands=2, epochs=2, engine="local", workers=2)
    answered(solver)
    before = {child.pid for child in active_children()}
    answered(solver, seed=4)
    assert {child.pid for child in active_children()} == before != set()


@pytest.mark.slow
def test_a_search_within_a_worker_brings_no_others() -> None:
    solver = Islands(islands=2, epochs=2, engine="local", workers=2)
    with engine_of("local", 1) as engine:
        engine.submit(Islands.__call__, solver, HARD)
        (outcome,) = engine.gather()
    assert outcome.error is None
    assert told(outcome.value) == told(replace(solver, engine=None, workers=None)(HARD))


def test_what_goes_wrong_in_a_worker_is_told_and_ends_the_workers() -> None:
    class Own(Annealing):
        """No worker can import it."""

    with pytest.raises(InvalidInputError, match="cannot be sent to a worker"):
        answered(Islands((Own(),), islands=2, engine="local", workers=1))
    failing = Islands((Unfit(),), islands=2, engine="local", workers=1)
    with pytest.raises(EngineError, match="islands: an island's worker: ArithmeticError: unfit"):
        answered(failing)
    assert answered(Islands(islands=2, epochs=1, engine="local", workers=1))[3] == "epochs"


def test_a_file_can_ask_for_them() -> None:
    table = {"method": "islands", "engine": "local", "workers": 2}
    given = load_configuration({"search": table}).table("search")
    assert make_solver(without_deadline(given)) == Islands(engine="local", workers=2)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"engine": "dask"}, "engine: 'dask'; expected local, ray or ray://HOST"),
        ({"engine": 3}, "engine: 3; expected"),
        ({"engine": "local", "workers": 0}, "workers: 0; expected a whole number from 1"),
        ({"workers": 2}, "workers: 2; expected an engine as well"),
    ],
)
def test_refuses_what_is_no_engine(wrong: dict[str, object], said: str) -> None:
    with pytest.raises(InvalidInputError, match=said):
        Islands(**wrong)
