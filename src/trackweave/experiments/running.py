"""Runs on an engine, each kept as soon as it is done, so that a killed study goes on."""

import json
import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any, Self

from trackweave.engine import Engine
from trackweave.errors import InvalidInputError, OutputError
from trackweave.experiments.cases import Job, carry_out
from trackweave.experiments.study_file import StudyPlan
from trackweave.io.output import OutputDirectory

try:
    import fcntl
except ModuleNotFoundError:  # Windows, which has no such locks
    fcntl = None  # type: ignore[assignment]

__all__ = ["LOG", "Log", "Progress", "record_of", "run_jobs"]

LOG = "runs.jsonl"
"""Every run as it came, a line each; the order is that in which they were done."""
Progress = Callable[[int, int], None]


class Log:
    """What runs have found so far, kept in a directory where there is one.

    Parameters
    ----------
    study
        Whose runs they are.
    place
        The directory, checked; None to keep them in memory alone.

    Raises
    ------
    OutputError
        If the directory holds another study, or another process works on it.
    """

    def __init__(self, study: StudyPlan, place: OutputDirectory | None) -> None:
        self.found: dict[int, dict[str, Any]] = {}
        self._path: Path | None = None
        if place is None:
            return
        self._path = place.path / LOG
        earlier = place.record()
        if earlier is None:
            place.write({LOG: b""}, {**record_of(study), "complete": False})
        else:
            _require_same(study, earlier, place.path)
        self._handle = _locked(self._path)
        self.found = _read(self._path)

    def add(self, number: int, found: dict[str, Any]) -> None:
        """Keep what a run found, on the disk before anything else is done."""
        self.found[number] = found
        if self._path is None:
            return
        line = json.dumps({"run": number, **found}, allow_nan=False) + "\n"
        try:
            os.write(self._handle, line.encode())
            os.fsync(self._handle)
        except OSError as err:
            raise OutputError(f"{self._path}: cannot be written ({err.strerror})") from err

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._path is not None:
            os.close(self._handle)


def record_of(study: StudyPlan) -> dict[str, Any]:
    """Return what tells a study from others."""
    return {"trackweave": version("trackweave"), "study": dict(study.parts), "runs": study.runs()}


def run_jobs(
    jobs: Sequence[Job],
    wanted: Iterable[int],
    log: Log,
    engine: Engine,
    progress: Progress | None = None,
) -> None:
    """Carry out the wanted jobs that have not been, each kept in the log as it comes."""
    todo = [number for number in wanted if number not in log.found]
    ticket_of = {engine.submit(carry_out, jobs[number]): number for number in todo}
    for done, outcome in enumerate(engine.gather(in_order=False), start=1):
        failed = {"error": outcome.error, "is_lost": outcome.is_lost}
        log.add(ticket_of[outcome.ticket], outcome.value or failed)
        if progress is not None:
            progress(done, len(todo))


def _locked(path: Path) -> int:
    """Return a handle that appends to a file, which no other process may do meanwhile."""
    try:
        handle = os.open(path, os.O_WRONLY | os.O_APPEND)
        if fcntl is not None:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise OutputError(
            f"{path.parent}: another process works on it; expected to be alone, or another "
            "directory"
        ) from None
    except OSError as err:
        raise OutputError(f"{path}: cannot be written ({err.strerror})") from err
    return handle


def _require_same(study: StudyPlan, earlier: dict[str, Any], path: Path) -> None:
    own, theirs = record_of(study), earlier.get("study")
    if not isinstance(theirs, dict):
        theirs = {}
    others = [part for part, digest in study.parts.items() if theirs.get(part) != digest]
    if others:
        raise OutputError(
            f"{path}: holds another study, which differs in {', '.join(others)}; expected this "
            "study as it was begun, or another directory"
        )
    if earlier.get("trackweave") != own["trackweave"]:
        raise OutputError(
            f"{path}: begun by trackweave {earlier.get('trackweave')}, this is "
            f"{own['trackweave']}; expected the same version, or another directory"
        )


def _read(path: Path) -> dict[int, dict[str, Any]]:
    """Return the runs of an earlier start; a last line that was cut off is dropped."""
    found: dict[int, dict[str, Any]] = {}
    try:
        content = path.read_bytes()
        whole = content.rfind(b"\n") + 1
        if whole < len(content):
            os.truncate(path, whole)
    except OSError as err:
        raise OutputError(f"{path}: cannot be read ({err.strerror})") from err
    for row, line in enumerate(content[:whole].splitlines(), start=1):
        run: Any = None
        with suppress(ValueError):
            run = json.loads(line)
        if not isinstance(run, dict) or type(run.get("run")) is not int:
            raise InvalidInputError(f"{path}, row {row}: {line[:60]!r}; expected a run as written")
        # A run that was lost with its workers is tried again; one that failed would fail again.
        if not run.get("is_lost"):
            found[run.pop("run")] = run
    return found
