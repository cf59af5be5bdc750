"""Exit statuses, help, and what happens when things go wrong."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import pytest

from cli.conftest import Run, write_reports
from trackweave.cli import edge
from trackweave.errors import InvalidInputError, NumericalError, OutputError

COMMANDS = ("convert", "demo", "formats", "track", "simulate", "evaluate", "solve", "schema")
LIGHT = {
    "trackweave", "trackweave.cli", "trackweave.cli.app", "trackweave.cli.converting",
    "trackweave.cli.edge", "trackweave.cli.fusing", "trackweave.cli.letting_in",
    "trackweave.cli.options", "trackweave.cli.serving", "trackweave.cli.signals",
    "trackweave.cli.studying",
}  # fmt: skip
HEAVY = {
    "highspy", "matplotlib", "narwhals", "numba", "numpy", "pandas", "polars", "pyarrow",
    "pymap3d", "scipy",
}  # fmt: skip


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys, json\n"
        "from trackweave.cli import main\n"
        "sys.argv = ['trackweave', '--help']\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\n"
        "print(json.dumps(sorted(sys.modules)), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    imported = set(json.loads(done.stderr))
    assert {name for name in imported if name.split(".")[0] == "trackweave"} == LIGHT
    assert imported & HEAVY == set()


def test_help_lists_every_command(run: Run) -> None:
    done = run("--help")
    assert done.exit_code == 0
    assert all(f"  {command} " in done.stdout for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_is_explained(command: str, run: Run) -> None:
    done = run(command, "--help")
    assert done.exit_code == 0
    options = [line for line in done.stdout.splitlines() if line.startswith("  -")]
    assert options
    # Of several files the usage line says so.
    assert "..." not in done.stdout.replace("{REPORTS}...", "")


def test_version_is_printed(run: Run) -> None:
    done = run("--version")
    assert done.stdout.startswith("trackweave 0.")


@pytest.mark.parametrize("arguments", [["zap"], ["track"], ["track", "a.csv"], ["--zap"]])
def test_bad_usage_is_status_two(arguments: list[str], run: Run) -> None:
    done = run(*arguments)
    assert done.exit_code == 2
    assert "Error" in done.stderr


@pytest.mark.parametrize(
    ("raised", "status", "said"),
    [
        (InvalidInputError("a.csv: zap;\nexpected zip"), 2, "a.csv: zap; expected zip"),
        (OutputError("out: cannot be written"), 2, "out: cannot be written"),
        (OSError(errno.ENOSPC, "No space left on device", "out"), 2, "out: No space left"),
        (MemoryError(), 2, "not enough memory"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (NumericalError("not positive definite"), 1, "This is our fault"),
        (ZeroDivisionError("division"), 1, "trackweave failed: ZeroDivisionError: division."),
    ],
)
def test_every_failure_has_its_status_and_one_line(
    raised: BaseException, status: int, said: str, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail() -> None:
        raise raised

    monkeypatch.setattr("trackweave.config.schema.json_schema", fail)
    monkeypatch.delenv(edge.DEBUG, raising=False)
    done = run("schema")
    assert done.exit_code == status
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert "Traceback" not in done.stderr


def test_the_traceback_is_shown_on_request(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trackweave.config.schema.json_schema", lambda: 1 / 0)
    monkeypatch.setenv(edge.DEBUG, "1")
    assert "Traceback" in run("schema").stderr


def trackweave(*arguments: object, **options: object) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "trackweave", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


@pytest.mark.slow
def test_control_c_is_status_130_and_leaves_nothing(tmp_path: Path) -> None:
    reports = write_reports(tmp_path / "reports.csv", n_scans=20_000)
    process = trackweave("track", reports, "--out", tmp_path / "out")
    # Long enough to have begun even beside other tests, far from long enough to end.
    time.sleep(6.0)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["reports.csv"]


@pytest.mark.skipif(os.name != "posix", reason="permissions are POSIX")
def test_a_home_that_cannot_be_written_does_not_matter(tmp_path: Path) -> None:
    reports = write_reports(tmp_path / "reports.csv")
    home = tmp_path / "home"
    home.touch()  # a file, which not even root can write into
    environment = {**os.environ, "HOME": str(home), "NUMBA_CACHE_DIR": str(home / "cache")}
    environment.pop("MPLCONFIGDIR", None)
    process = trackweave("simulate", "none.toml", "--out", tmp_path / "out", env=environment)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 2
    assert len(said.splitlines()) == 1
    assert reports.exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize("arguments", [["--help"], ["track", "--help"], ["--version"], ["schema"]])
def test_a_full_standard_output_is_named(arguments: list[str]) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "trackweave", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == "standard output: No space left on device\n"


@pytest.mark.parametrize("arguments", [["schema"], ["--help"], ["--version"]])
def test_a_reader_that_leaves_is_no_failure_of_ours(arguments: list[str]) -> None:
    with trackweave(*arguments) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        said = process.stderr.read()
    assert process.returncode == 141
    assert said == ""


def test_our_warnings_are_notes_and_others_are_not_shown(
    capsys: pytest.CaptureFixture[str],
) -> None:
    before = warnings.showwarning
    try:
        with warnings.catch_warnings():
            edge.show_our_warnings()
            ours = {"__name__": "trackweave.zap"}
            exec("import warnings; warnings.warn('a\\nb', stacklevel=1)", ours)
            exec("import warnings; warnings.warn('c', RuntimeWarning, stacklevel=1)", ours)
            exec("import warnings; warnings.warn('d', stacklevel=1)", {"__name__": "numpy.zap"})
    finally:
        warnings.showwarning = before
    assert capsys.readouterr().err == "note: a b\n"


def test_a_panic_of_a_library_is_one_line(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    panic = type("PanicException", (BaseException,), {})

    def fail() -> None:
        raise panic("out of range")

    monkeypatch.setattr("trackweave.config.schema.json_schema", fail)
    done = run("schema")
    assert done.exit_code == 1
    assert "PanicException: out of range" in done.stderr
    assert len(done.stderr.splitlines()) == 1
