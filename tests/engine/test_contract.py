"""What every engine promises; each test runs on each of them."""

import importlib.util
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from oracles import errands
from trackweave.engine import Engine, EngineError, Outcome, WorkerLostError, engine_of
from trackweave.errors import InvalidInputError

HAS_RAY = importlib.util.find_spec("ray") is not None
ENGINES = [
    "local",
    pytest.param(
        "ray", marks=[pytest.mark.slow, pytest.mark.skipif(not HAS_RAY, reason="Ray is missing")]
    ),
]
Make = Callable[..., Engine]


@pytest.fixture(scope="module")
def on_ray() -> Iterator[None]:
    """Start Ray once, which takes ten seconds: engines join what runs already."""
    with engine_of("ray", 4):
        yield


@pytest.fixture(params=ENGINES)
def make(request: pytest.FixtureRequest) -> Iterator[Make]:
    """Return what makes an engine, which ends with the test."""
    made: list[Engine] = []
    if request.param == "ray":
        request.getfixturevalue("on_ray")

    def engine(workers: int = 2, **options: float) -> Engine:
        made.append(engine_of(request.param, workers, **options))
        return made[-1]

    yield engine
    for each in made:
        each.close()


def killed_when_marked(marks: Path, count: int) -> threading.Thread:
    """Kill the first processes that leave a mark."""

    def work() -> None:
        killed: set[str] = set()
        while len(killed) < count:
            for mark in marks.iterdir():
                if mark.name not in killed and len(killed) < count:
                    os.kill(int(mark.name), signal.SIGKILL)
                    killed.add(mark.name)
            time.sleep(0.02)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    return thread


@pytest.mark.skipif(not HAS_RAY, reason="Ray is missing")
@pytest.mark.parametrize("place", ["127.0.0.1:9", "127.0.0.1:x", "127.0.0.1:99999999", ""])
def test_a_head_that_is_not_there_is_told_at_once(place: str) -> None:
    begin = time.monotonic()
    with pytest.raises(EngineError, match=r"cannot be reached .*; expected ray://HOST"):
        engine_of(f"ray://{place}", 1)
    assert time.monotonic() - begin < 20.0


class TestTasks:
    """Functions carried out by whichever worker is free."""

    def test_are_refused_once_the_engine_is_closed(self, make: Make) -> None:
        engine = make()
        engine.close()

        with pytest.raises(EngineError, match=r"closed; expected work before close\(\)"):
            engine.submit(abs, -1)
        with pytest.raises(EngineError, match=r"closed; expected work before close\(\)"):
            engine.place(list)

    def test_come_back_in_the_order_in_which_they_were_entered(self, make: Make) -> None:
        engine = make()
        for number in range(6):
            engine.submit(errands.late_square, number, 0.3 if number == 0 else 0.0)
        assert [each.value for each in engine.gather()] == [0, 1, 4, 9, 16, 25]

    def test_come_back_as_they_are_done_where_order_does_not_matter(self, make: Make) -> None:
        engine = make()
        slow = engine.submit(errands.late_square, 3, 2.0)
        quick = [engine.submit(errands.square, number) for number in range(4)]
        found = [each.ticket for each in engine.gather(in_order=False)]
        assert found[-1] == slow
        assert sorted(found) == [slow, *quick]

    def test_are_the_same_for_any_number_of_workers(self, make: Make) -> None:
        found = []
        for workers in (1, 3):
            engine = make(workers)
            for number in range(5):
                engine.submit(errands.square, number)
            found.append(list(engine.gather()))
            engine.close()
        assert found[0] == found[1] == [Outcome(n, n * n) for n in range(5)]

    def test_work_side_by_side_and_in_the_same_processes_again(self, make: Make) -> None:
        engine = make()
        for _ in range(2):
            engine.submit(errands.late_square, 1, 0.0)
        assert len(list(engine.gather())) == 2
        for _ in range(8):
            engine.submit(errands.process)
        processes = {each.value for each in engine.gather()}
        assert 1 <= len(processes) <= 2
        assert os.getpid() not in processes

    def test_that_raise_are_told_in_one_line_and_not_tried_again(self, make: Make) -> None:
        engine = make(1)
        engine.submit(errands.refuse, 7)
        engine.submit(errands.square, 2)
        failed, done = engine.gather()
        assert failed == Outcome(0, error="ArithmeticError: no 7 here")
        assert done.value == 4

    def test_whose_results_cannot_be_sent_are_told(self, make: Make) -> None:
        engine = make(1)
        engine.submit(errands.unsendable)
        (failed,) = engine.gather()
        assert "pickle" in (failed.error or "")

    @pytest.mark.parametrize("work", [lambda: 1, "square"], ids=["lambda", "text"])
    def test_that_no_worker_can_import_are_refused_at_once(self, make: Make, work: object) -> None:
        engine = make(1)
        with pytest.raises(InvalidInputError, match="expected a function of a module"):
            engine.submit(work)  # type: ignore[arg-type]

    def test_nothing_entered_gives_nothing(self, make: Make) -> None:
        assert list(make().gather()) == []


class TestDeaths:
    """Workers that are killed or hang."""

    def test_a_killed_workers_task_goes_to_another(self, make: Make, tmp_path: Path) -> None:
        engine = make()
        for number in range(4):
            engine.submit(errands.fall_first, tmp_path, number, 2 if number == 1 else 0)
        assert [each.value for each in engine.gather()] == [0, 1, 2, 3]
        assert len(list(tmp_path.glob("1-*"))) == 3

    def test_a_task_that_kills_every_worker_ends_as_an_error(
        self, make: Make, tmp_path: Path
    ) -> None:
        engine = make()
        engine.submit(errands.fall_first, tmp_path, 0, 99)
        engine.submit(errands.square, 5)
        fallen, done = engine.gather()
        assert fallen.is_lost
        assert (fallen.error or "").startswith("given to 3 workers; the last was ")
        assert len(list(tmp_path.iterdir())) == 3
        assert done.value == 25

    def test_a_kill_from_outside_is_noticed_at_once(self, make: Make, tmp_path: Path) -> None:
        engine = make(1)
        engine.submit(errands.square, 1)
        assert len(list(engine.gather())) == 1  # it has started
        for _ in range(2):
            engine.submit(errands.nap, tmp_path, 1.0)
        killer = killed_when_marked(tmp_path, 1)
        first, second = engine.gather()
        killer.join()
        marks = {int(mark.name) for mark in tmp_path.iterdir()}
        assert len(marks) == 2
        assert first.value == second.value
        assert first.value in marks

    def test_a_hung_worker_is_noticed_by_the_time_limit(self, make: Make, tmp_path: Path) -> None:
        engine = make(2, time_limit=2.0)
        for number in range(3):
            engine.submit(errands.hang_first if number == 0 else errands.fall_first,
                          tmp_path, number, *([0] if number else []))  # fmt: skip
        begin = time.monotonic()
        assert [each.value for each in engine.gather()] == [0, 1, 2]
        assert time.monotonic() - begin < 60.0

    def test_a_task_that_always_hangs_ends_as_an_error(self, make: Make) -> None:
        engine = make(1, time_limit=0.5)
        engine.submit(errands.late_square, 1, 600.0)
        (hung,) = engine.gather()
        assert hung == Outcome(
            0, error="given to 3 workers; the last gave no answer within 0.5 s", is_lost=True
        )


class TestActors:
    """Objects that live in a worker of their own."""

    def test_keep_their_state_and_answer_in_order(self, make: Make) -> None:
        actor = make().place(errands.Counter, 10)
        for number in (1, 2, 3):
            actor.tell("add", number)
        assert [actor.answer() for _ in range(3)] == [11, 13, 16]
        assert actor.is_alive

    def test_need_not_be_waited_for(self, make: Make) -> None:
        engine = make()
        actor = engine.place(errands.Counter, 10, waits=False)
        assert not actor.has_answered
        while not actor.has_answered:
            engine.look(1.0)
        assert actor.answer() is None
        actor.tell("add", 1)
        assert actor.answer() == 11

    def test_work_beside_one_another_and_beside_tasks(self, make: Make) -> None:
        engine = make(2)
        one, other = engine.place(errands.Counter, 0), engine.place(errands.Counter, 100)
        one.tell("add", 1)
        other.tell("add", 1)
        one.end()  # Ray counts actors and workers of tasks against the same processors
        engine.submit(errands.square, 3)
        assert other.answer() == 101
        assert [each.value for each in engine.gather()] == [9]

    def test_death_is_told_once_and_asked_for_again(self, make: Make) -> None:
        told: list[str] = []
        engine = make()
        actor = engine.place(errands.Counter, 0, lost=lambda _, reason: told.append(reason))
        actor.tell("fall")
        with pytest.raises(WorkerLostError, match="actor: its worker was "):
            actor.answer()
        assert len(told) == 1
        assert not actor.is_alive
        actor.tell("add", 1)
        with pytest.raises(WorkerLostError):
            actor.answer()

    def test_death_is_told_while_nobody_asks_it_anything(self, make: Make) -> None:
        told: list[str] = []
        engine = make()
        actor = engine.place(errands.Counter, 0, lost=lambda _, reason: told.append(reason))
        actor.tell("fall")
        begin = time.monotonic()
        while not told and time.monotonic() - begin < 20.0:
            engine.look(0.5)
        assert len(told) == 1
        assert not actor.is_alive

    def test_one_that_hangs_is_dead_after_the_time_limit(self, make: Make) -> None:
        actor = make(1, time_limit=0.5).place(errands.Counter, 0)
        actor.tell("sleep", 600.0)
        with pytest.raises(WorkerLostError, match=r"gave no answer within 0\.5 s"):
            actor.answer()

    def test_an_error_of_its_own_does_not_end_it(self, make: Make) -> None:
        actor = make().place(errands.Counter, 4)
        actor.tell("fail")
        with pytest.raises(EngineError, match="LookupError: not today"):
            actor.answer()
        actor.tell("add", 1)
        assert actor.answer() == 5

    def test_one_that_cannot_be_made_says_why(self, make: Make) -> None:
        with pytest.raises(EngineError, match="ArithmeticError: no 3"):
            make().place(errands.refuse, 3)

    def test_an_answer_needs_a_call(self, make: Make) -> None:
        with pytest.raises(EngineError, match="no call to answer"):
            make().place(errands.Counter, 0).answer()
