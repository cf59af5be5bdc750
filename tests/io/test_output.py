"""Files appear whole or not at all, whatever fails and whenever."""

import errno
import json
import os
import shutil
import signal
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from trackweave.errors import OutputError
from trackweave.io.encoding import encode_json
from trackweave.io.output import RECORD, STAGING_PREFIX, OutputDirectory

OLD = {"tracks.csv": b"old tracks", "history.csv": b"old history"}
NEW = {"tracks.csv": b"new tracks", "assignments.csv": b"new assignments"}
RUN = {"trackweave": "0.1.0", "seed": 1}


def contents(folder: Path) -> dict[str, bytes | None]:
    """Return every file below a folder with its content, and every folder with None."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


@pytest.fixture
def area(tmp_path):
    """Return the folder around the place of output."""
    (tmp_path / "area").mkdir()
    return tmp_path / "area"


@pytest.fixture(params=["new", "nested", "empty", "ours"])
def place(request, area):
    """Return a path for output, in each state that is allowed."""
    path = area / "run"
    if request.param == "nested":
        return area / "deep" / "er" / "run"
    if request.param != "new":
        path.mkdir()
    if request.param == "ours":
        OutputDirectory(path, "track").write(OLD, RUN)
        (path / "notes.txt").write_text("mine")
        (path / "folder").mkdir()
        (path / "folder" / "tracks.csv").write_text("mine too")
    return path


def test_writes_all_files_and_a_record_that_lists_them(place, area):
    output = OutputDirectory(place, "track")
    output.check()
    output.write(NEW, RUN)
    for name, content in NEW.items():
        assert (place / name).read_bytes() == content
    record = json.loads((place / RECORD).read_bytes())
    assert record == {
        **RUN,
        "command": "track",
        "files": ["assignments.csv", "run.json", "tracks.csv"],
    }
    assert not list(area.rglob(f"{STAGING_PREFIX}*"))


def test_replaces_only_the_files_of_the_earlier_run(tmp_path):
    OutputDirectory(tmp_path, "track").write(OLD, RUN)
    (tmp_path / "notes.txt").write_text("mine")
    OutputDirectory(tmp_path, "track").write(NEW, RUN)
    assert names(tmp_path) == ["assignments.csv", "notes.txt", "run.json", "tracks.csv"]
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_the_picture_of_the_earlier_run_goes_with_it(tmp_path):
    OutputDirectory(tmp_path, "track").write(OLD, RUN)
    (tmp_path / "plot.png").write_bytes(b"the earlier run")
    OutputDirectory(tmp_path, "track").write(NEW, RUN)
    assert names(tmp_path) == ["assignments.csv", "run.json", "tracks.csv"]


def test_leaves_the_permissions_to_the_user(tmp_path):
    OutputDirectory(tmp_path / "run", "track").write(NEW, RUN)
    (tmp_path / "by_hand").mkdir()
    (tmp_path / "by_hand" / "file").write_bytes(b"")
    for ours, by_hand in (("run", "by_hand"), ("run/tracks.csv", "by_hand/file")):
        assert (tmp_path / ours).stat().st_mode == (tmp_path / by_hand).stat().st_mode


def test_a_file_that_the_earlier_run_did_not_write_is_not_replaced(tmp_path):
    OutputDirectory(tmp_path, "track").write(OLD, RUN)
    (tmp_path / "assignments.csv").write_text("mine")
    before = contents(tmp_path)
    with pytest.raises(OutputError, match=r"assignments\.csv that is not of the earlier run"):
        OutputDirectory(tmp_path, "track").write(NEW, RUN)
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    "record",
    [None, b"", b"{", b"[]", b'{"version": 1}', b"\xff", b"[" * 100_000, b'"trackweave"'],
)
def test_refuses_a_directory_of_others(tmp_path, record):
    (tmp_path / "thesis.tex").write_text("mine")
    if record is not None:
        (tmp_path / RECORD).write_bytes(record)
    before = contents(tmp_path)
    for attempt in (
        OutputDirectory(tmp_path, "track").check,
        lambda: OutputDirectory(tmp_path, "track").write(NEW, RUN),
    ):
        with pytest.raises(OutputError, match="not empty and not a run of trackweave"):
            attempt()
    assert contents(tmp_path) == before


def test_a_record_that_lists_what_is_not_ours_to_list_does_no_harm(tmp_path):
    (tmp_path / "precious").write_text("mine")
    run = tmp_path / "run"
    run.mkdir()
    listed = ["../precious", "/etc/passwd", "..", "", 3, None, "gone.csv"]
    (run / RECORD).write_text(json.dumps({"trackweave": "0", "files": listed}))
    OutputDirectory(run, "track").write(NEW, RUN)
    assert (tmp_path / "precious").read_text() == "mine"
    assert names(run) == ["assignments.csv", "run.json", "tracks.csv"]


def test_follows_a_symbolic_link_to_a_directory(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to("real")
    OutputDirectory(tmp_path / "link", "track").write(NEW, RUN)
    assert (tmp_path / "link").is_symlink()
    assert "tracks.csv" in names(tmp_path / "real")


@pytest.mark.parametrize("aim", ["nowhere", "link"])
def test_refuses_a_symbolic_link_to_nowhere(tmp_path, aim):
    (tmp_path / "link").symlink_to(aim)
    with pytest.raises(OutputError, match="a symbolic link to nowhere"):
        OutputDirectory(tmp_path / "link", "track").check()


@pytest.mark.parametrize("below", ["", "below"])
def test_refuses_a_file(tmp_path, below):
    (tmp_path / "file").write_text("mine")
    for attempt in ("check", "write"):
        arguments = () if attempt == "check" else (NEW, RUN)
        with pytest.raises(OutputError, match="file"):
            getattr(OutputDirectory(tmp_path / "file" / below, "track"), attempt)(*arguments)
    assert (tmp_path / "file").read_text() == "mine"


@pytest.mark.parametrize("path", ["a\0b", "x" * 300])
def test_refuses_what_cannot_be_a_name(tmp_path, path):
    with pytest.raises(OutputError):
        OutputDirectory(tmp_path / path, "track").check()


def test_says_early_where_it_may_not_write(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(OutputError, match="no permission to write in"):
        OutputDirectory(tmp_path / "a" / "b", "track").check()


def test_writes_where_one_stands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    OutputDirectory(".", "track").write(NEW, RUN)
    assert names(Path()) == ["assignments.csv", "run.json", "tracks.csv"]


@pytest.mark.parametrize("name", ["", "..", "a/b", "run.json", ".hidden"])
def test_our_own_slips_are_not_the_users_trouble(tmp_path, name):
    with pytest.raises(ValueError, match="expected the name of a file"):
        OutputDirectory(tmp_path, "track").write({name: b""}, RUN)
    with pytest.raises(ValueError, match="trackweave"):
        OutputDirectory(tmp_path, "track").write(NEW, {})


STEPS = ("mkdir", "fsync", "rename")


class Faults:
    """Counts the system's calls, and does something at one of them."""

    def __init__(self, monkeypatch, act, at):
        self.act, self.at, self.count = act, at, 0
        for name in STEPS:
            monkeypatch.setattr(os, name, self.wrapped(getattr(os, name)))

    def wrapped(self, real):
        def call(*arguments, **keywords):
            self.count += 1
            if self.count - 1 == self.at:
                self.act()
            return real(*arguments, **keywords)

        return call


def wanted(before: dict[str, bytes | None]) -> dict[str, bytes | None]:
    """Return what the place holds after a whole run, given what it held before."""
    kept = {name: data for name, data in before.items() if name not in {*OLD, RECORD}}
    record = encode_json(
        {"trackweave": "0.1.0", "command": "track", "seed": 1, "files": sorted([*NEW, RECORD])}
    )
    return {**kept, **NEW, RECORD: record}


def attempts(area, place, monkeypatch, act):
    """Run with something happening at each step in turn, each time in a fresh copy of the area.

    Yields the copy, the place in it, and the exception that came out.
    """
    for step in range(20):
        copy = area.parent / f"copy{step}"
        shutil.copytree(area, copy)
        there, raised = copy / place.relative_to(area), None
        with monkeypatch.context() as patch:
            faults = Faults(patch, act, step)
            try:
                OutputDirectory(there, "track").write(NEW, RUN)
            except BaseException as err:
                raised = err
        if faults.count <= step:
            assert raised is None
            assert step > 4
            return
        yield copy, there, raised
    raise AssertionError("no end of steps")


def test_a_full_disk_at_any_step_changes_nothing(place, area, monkeypatch):
    def fill():
        raise OSError(errno.ENOSPC, "No space left on device")

    before = contents(area)
    for copy, _, err in attempts(area, place, monkeypatch, fill):
        assert isinstance(err, OutputError)
        assert "No space left on device" in str(err)
        assert contents(copy) == before


def test_ctrl_c_at_any_step_waits_until_the_files_are_whole(place, area, monkeypatch):
    held = contents(place)
    for _, there, err in attempts(
        area, place, monkeypatch, lambda: signal.raise_signal(signal.SIGINT)
    ):
        assert isinstance(err, KeyboardInterrupt)
        assert contents(there) == wanted(held)


def test_writes_from_another_thread_than_the_first(tmp_path):
    with ThreadPoolExecutor(1) as pool:
        pool.submit(OutputDirectory(tmp_path / "run", "track").write, NEW, RUN).result()
    assert "tracks.csv" in names(tmp_path / "run")


def test_what_a_killed_run_left_is_no_trouble_and_goes_in_time(tmp_path):
    left = tmp_path / f"{STAGING_PREFIX}left"
    (left / "new").mkdir(parents=True)
    (left / "new" / "tracks.csv").write_bytes(b"half")
    OutputDirectory(tmp_path, "track").write(OLD, RUN)
    assert left.exists()  # whose run may still be at work
    os.utime(left, (1.0, 1.0))
    OutputDirectory(tmp_path, "track").write(NEW, RUN)
    assert contents(tmp_path) == wanted({})
