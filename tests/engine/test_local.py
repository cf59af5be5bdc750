"""What only processes of this machine show: ends of all of them, scripts, names of engines."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from oracles import errands
from trackweave.engine import EngineError, WorkerLostError, engine_of
from trackweave.engine import choice as choosing
from trackweave.engine.local import LocalHost
from trackweave.errors import InvalidInputError

TESTS = Path(__file__).resolve().parents[1]
# No guard against being run anew by each process that it starts.
SCRIPT = """
import sys
from pathlib import Path
from oracles import errands
from trackweave.engine import engine_of

with engine_of("local", 2) as engine:
    for _ in range(2):
        engine.submit({work})
    print([outcome.value for outcome in engine.gather()])
"""


def started(folder: Path, work: str, *arguments: str) -> subprocess.Popen[str]:
    script = folder / "script.py"
    script.write_text(SCRIPT.format(work=work))
    path = os.pathsep.join([str(TESTS), *filter(None, sys.path)])
    return subprocess.Popen(
        [sys.executable, script, *arguments],
        env={**os.environ, "PYTHONPATH": path}, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip


def sleepers(marks: Path, count: int) -> list[int]:
    """Wait until so many tasks sleep; return their processes."""
    begin = time.monotonic()
    while len(list(marks.iterdir())) < count:
        assert time.monotonic() - begin < 60.0
        time.sleep(0.05)
    return [int(mark.name) for mark in marks.iterdir()]


def all_end(processes: list[int], within: float = 10.0) -> bool:
    begin = time.monotonic()
    while time.monotonic() - begin < within:
        if not any(Path(f"/proc/{each}/cmdline").exists() and
                   Path(f"/proc/{each}/cmdline").read_bytes() for each in processes):  # fmt: skip
            return True
        time.sleep(0.05)
    return False


@pytest.mark.skipif(not Path("/proc").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("is_stopped", [False, True])
def test_whatever_ends_the_caller_ends_all_workers(
    ending: signal.Signals, is_stopped: bool, tmp_path: Path
) -> None:
    marks = tmp_path / "marks"
    marks.mkdir()
    caller = started(tmp_path, "errands.nap, Path(sys.argv[1]), 600.0", str(marks))
    processes = sleepers(marks, 2)
    if is_stopped:
        if sys.platform != "linux" and ending != signal.SIGINT:
            pytest.skip("only Linux ends a process that is stopped")
        os.kill(processes[0], signal.SIGSTOP)
    caller.send_signal(ending)
    caller.communicate(timeout=20)
    assert all_end(processes)


def test_a_script_needs_no_guard_and_is_not_run_again(tmp_path: Path) -> None:
    done = started(tmp_path, "errands.square, 3")
    out, err = done.communicate(timeout=60)
    assert (out, err) == ("[9, 9]\n", "")


def test_work_of_the_script_itself_is_refused(tmp_path: Path) -> None:
    done = started(tmp_path, "(lambda: (exec('def own(): return 1', globals()), own)[1])()")
    _, err = done.communicate(timeout=60)
    assert "expected a function of a module that workers can import" in err


def test_workers_that_never_start_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trackweave.engine.local._serve", sys.exit)
    with engine_of("local", 2) as engine:
        engine.submit(sorted, [2, 1])
        with pytest.raises(EngineError, match="3 workers in a row did not start; the last ended"):
            list(engine.gather())


def test_nobody_waits_for_one_that_stops_in_a_message() -> None:
    told: list[str] = []
    with engine_of("local", 1, time_limit=1.0) as engine:
        actor = engine.place(errands.Counter, 0, lost=lambda _, reason: told.append(reason))
        actor.tell("process")
        os.kill(actor.answer(), signal.SIGSTOP)
        actor.tell("take", b"0" * 10_000_000)  # longer than a pipe holds
        with pytest.raises(WorkerLostError):
            actor.answer()
    assert told == ["was killed by signal 9"]


@pytest.mark.slow
def test_a_stopped_worker_is_replaced_and_its_task_done_by_another(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("trackweave.engine.local.LOOK_S", 0.5)
    monkeypatch.setattr("trackweave.engine.alive.SILENT_S", 4.0)

    def stop() -> None:
        os.kill(sleepers(tmp_path, 1)[0], signal.SIGSTOP)

    stopping = threading.Thread(target=stop)
    with engine_of("local", 1) as engine:
        # Longer than the silence that one is allowed: whoever lives may take any time.
        engine.submit(errands.nap, tmp_path, 6.0)
        stopping.start()
        (outcome,) = engine.gather()
    stopping.join()
    assert outcome.error is None
    assert len(list(tmp_path.iterdir())) == 2
    first = next(int(each.name) for each in tmp_path.iterdir() if each.name != str(outcome.value))
    assert all_end([first])


@pytest.mark.slow
def test_why_a_stopped_worker_was_ended_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trackweave.engine.local.LOOK_S", 0.5)
    monkeypatch.setattr("trackweave.engine.alive.SILENT_S", 3.0)
    with engine_of("local", 1) as engine:
        actor = engine.place(errands.Counter, 0)
        actor.tell("process")
        os.kill(actor.answer(), signal.SIGSTOP)
        actor.tell("add", 1)
        with pytest.raises(WorkerLostError, match="gave no sign of life for 3 s"):
            actor.answer()


def test_a_short_limit_of_tasks_leaves_messages_their_time() -> None:
    host = LocalHost(1e-6)
    worker = host.hire()
    worker.since = time.monotonic() - 0.1  # as a message looks that is on its way for so long
    worker.process.join(0.2)
    assert worker.process.is_alive()
    worker.kill()
    host.close()


@pytest.mark.parametrize("name", ["", "Ray", "dask", "ray:/x", None, 3])
def test_an_unknown_engine_is_refused(name: object) -> None:
    with pytest.raises(InvalidInputError, match="expected local, ray or ray://HOST"):
        engine_of(name)  # type: ignore[arg-type]


@pytest.mark.parametrize("workers", [0, -1, 1.5, True, "2", 10**6])
def test_a_number_of_workers_is_a_number(workers: object) -> None:
    with pytest.raises(InvalidInputError, match=r"workers: .*; expected a whole number from 1"):
        engine_of("local", workers)  # type: ignore[arg-type]


def test_a_time_limit_is_positive() -> None:
    with pytest.raises(InvalidInputError, match="time_limit: 0; expected seconds > 0"):
        engine_of("local", 1, time_limit=0)


def test_a_missing_ray_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    monkeypatch.delitem(sys.modules, "trackweave.engine.on_ray", raising=False)
    with pytest.raises(EngineError, match=r"pip install 'trackweave\[ray\]'"):
        engine_of("ray")


def test_processors_are_those_that_may_be_used() -> None:
    assert 1 <= choosing.processors() <= (os.cpu_count() or 1)
