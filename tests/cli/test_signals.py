"""Signals that end a program at any moment, and streams that somebody closed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and streams are POSIX")
LONG = "import time\nfrom trackweave.cli.signals import end_on_signals\nend_on_signals()\n"
SWAP = """
import os, sys
from pathlib import Path
from trackweave.io.output import OutputDirectory
place = OutputDirectory(sys.argv[1], "simulate")
place.write({"reports.csv": b"old", "truth.csv": b"old"}, {"trackweave": "1"})
moved = Path.replace
def slow(path, target):
    found = moved(path, target)
    if Path(target).name == "reports.csv" and path.parent.name == "new":
        print("half way", flush=True)
        time.sleep(0.5)
    return found
Path.replace = slow
place.write({"reports.csv": b"new", "truth.csv": b"new"}, {"trackweave": "1"})
"""


def started(code: str, *arguments: object) -> "subprocess.Popen[str]":
    """Start a program and wait until it says something."""
    process = subprocess.Popen(
        [sys.executable, "-c", code, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    process.stdout.readline()
    return process


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, -15)])
def test_a_change_that_a_signal_meets_half_way_is_finished(
    number: signal.Signals, status: int, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    process = started(LONG + SWAP, out)
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == status
    assert said == ("interrupted\n" if number == signal.SIGINT else "")
    assert sorted(path.name for path in out.iterdir()) == ["reports.csv", "run.json", "truth.csv"]
    assert (out / "reports.csv").read_bytes() == (out / "truth.csv").read_bytes() == b"new"


def test_an_interrupt_is_not_lost_where_exceptions_are() -> None:
    code = LONG + (
        "print('begun', flush=True)\n"
        "while True:\n    try:\n        time.sleep(30)\n    except BaseException:\n        pass\n"
    )
    process = started(code)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert (process.returncode, said) == (130, "interrupted\n")


@pytest.mark.parametrize("delay", [0.1, 0.4, 0.9])
def test_an_interrupt_while_modules_load_is_one_line(delay: float, tmp_path: Path) -> None:
    code = (
        "import sys\nfrom trackweave.cli import main\nprint('begun', flush=True)\n"
        "sys.argv = ['trackweave', 'init', 'none.csv', '-o', sys.argv[1]]\nmain()\n"
    )
    process = started(code, tmp_path / "t.toml")
    time.sleep(delay)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert (process.returncode, len(said.splitlines())) in {(130, 1), (2, 1)}
    assert "Traceback" not in said


@pytest.mark.parametrize(
    ("closed", "arguments", "status"),
    [("2>&-", "init none.csv", 2), ("2>&-", "--version", 0), (">&-", "schema", 2),
     (">&-", "--version", 2), (">&- 2>&-", "zap", 2)],
)  # fmt: skip
def test_closed_streams_are_no_failure_of_ours(closed: str, arguments: str, status: int) -> None:
    done = subprocess.run(
        ["sh", "-c", f"exec '{sys.executable}' -m trackweave {arguments} {closed}"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == status
    assert "Traceback" not in done.stderr
    assert len(done.stderr.splitlines()) <= 1
