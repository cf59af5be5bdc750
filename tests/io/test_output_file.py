"""A single file of output: whole or not at all, and never in the place of something else."""

import errno
import os
from pathlib import Path

import pytest

from trackweave.errors import OutputError
from trackweave.io.output import STAGING_PREFIX, OutputFile


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


@pytest.mark.parametrize("old", [None, b"old and longer"])
def test_a_file_appears_or_is_replaced(tmp_path, old):
    place = tmp_path / "a.csv"
    if old is not None:
        place.write_bytes(old)
    output = OutputFile(str(place))
    output.check()
    output.write(b"new")
    assert place.read_bytes() == b"new"
    assert names(tmp_path) == ["a.csv"]


def test_a_link_to_a_file_stays_one(tmp_path):
    (tmp_path / "real.csv").write_bytes(b"old")
    (tmp_path / "link.csv").symlink_to("real.csv")
    OutputFile(tmp_path / "link.csv").write(b"new")
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "real.csv").read_bytes() == b"new"


def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch):
    place = tmp_path / "a.csv"
    place.write_bytes(b"old")

    def fail(descriptor):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OutputError, match=r"a\.csv: cannot be written \(No space left") as caught:
        OutputFile(place).write(b"new")
    assert STAGING_PREFIX not in str(caught.value)
    assert place.read_bytes() == b"old"
    assert names(tmp_path) == ["a.csv"]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        pytest.param(Path.mkdir, "a directory; expected the name of a file", id="directory"),
        pytest.param(
            lambda p: p.symlink_to("nowhere"), "a symbolic link to nowhere", id="dangling"
        ),
        pytest.param(lambda p: p.symlink_to(p.name), "a.csv", id="loop"),
        pytest.param(lambda p: p.parent.rmdir(), "no such directory", id="no folder"),
        pytest.param(
            lambda p: os.mkfifo(p),
            "not a regular file",
            id="pipe",
            marks=pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names"),
        ),
    ],
)
def test_refuses_a_place_that_is_none_for_a_file(tmp_path, make, said):
    (tmp_path / "folder").mkdir()
    place = tmp_path / "folder" / "a.csv"
    make(place)
    for act in (OutputFile(place).check, lambda: OutputFile(place).write(b"new")):
        with pytest.raises(OutputError) as caught:
            act()
        assert said in str(caught.value)


def test_refuses_what_cannot_be_a_name(tmp_path):
    for name in ("a\0b.csv", "x" * 300 + ".csv"):
        with pytest.raises(OutputError):
            OutputFile(tmp_path / name).check()


def test_refuses_to_replace_an_input(tmp_path):
    place = tmp_path / "a.csv"
    place.write_bytes(b"mine")
    (tmp_path / "link.csv").symlink_to(place)
    with pytest.raises(OutputError, match="an input of this run, which would be replaced"):
        OutputFile(tmp_path / "link.csv").check([place])
    OutputFile(tmp_path / "b.csv").check([place])


@pytest.mark.parametrize("refused", ["a.csv", "folder"])
def test_refuses_what_may_not_be_written(tmp_path, monkeypatch, refused):
    (tmp_path / "folder").mkdir()
    place = tmp_path / "folder" / "a.csv"
    place.write_bytes(b"old")
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != refused)
    with pytest.raises(OutputError, match="no permission to"):
        OutputFile(place).check()
