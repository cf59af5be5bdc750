"""Only what a command writes itself is replaced or removed, and never what it reads."""

import errno
import json
import os
from pathlib import Path

import pytest

from trackweave.errors import OutputError
from trackweave.io.output import RECORD, OutputDirectory

OLD = {"tracks.csv": b"old tracks", "history.csv": b"old history"}
NEW = {"tracks.csv": b"new tracks", "assignments.csv": b"new assignments"}
RUN = {"trackweave": "0.1.0", "seed": 1}


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def simulated(folder: Path) -> Path:
    OutputDirectory(folder, "simulate").write({"reports.csv": b"mine", "truth.csv": b"mine"}, RUN)
    return folder


@pytest.mark.parametrize("says_so", [True, False])
def test_refuses_a_run_of_another_command_and_leaves_its_files(tmp_path, says_so):
    simulated(tmp_path)
    if not says_so:
        listed = json.loads((tmp_path / RECORD).read_bytes())["files"]
        (tmp_path / RECORD).write_text(json.dumps({**RUN, "files": listed}))
    before = contents(tmp_path)
    message = (
        "holds a run of `trackweave simulate`; expected a new or empty directory, or an earlier "
        "run of `trackweave track`"
    )
    output = OutputDirectory(tmp_path, "track")
    for attempt in (output.check, lambda: output.write(NEW, RUN)):
        with pytest.raises(OutputError, match=message):
            attempt()
    assert contents(tmp_path) == before


def test_never_removes_what_the_command_does_not_write(tmp_path):
    OutputDirectory(tmp_path, "track").write(OLD, RUN)
    (tmp_path / "thesis.tex").write_text("mine")
    (tmp_path / "reports.csv").write_text("mine too")
    listed = ["thesis.tex", "tracks.csv", "history.csv", "reports.csv"]
    record = {**RUN, "command": "track", "files": listed}
    (tmp_path / RECORD).write_text(json.dumps(record))
    OutputDirectory(tmp_path, "track").write(NEW, RUN)
    assert (tmp_path / "thesis.tex").read_text() == "mine"
    assert (tmp_path / "reports.csv").read_text() == "mine too"
    assert not (tmp_path / "history.csv").exists()


@pytest.mark.parametrize("name", ["tracks.csv", "history.csv", RECORD])
def test_refuses_to_replace_an_input_of_the_run(tmp_path, name):
    OutputDirectory(tmp_path / "run", "track").write(OLD, RUN)
    (tmp_path / "link").symlink_to(tmp_path / "run" / name)
    output = OutputDirectory(tmp_path / "run", "track")
    for path in (tmp_path / "run" / name, tmp_path / "link"):
        with pytest.raises(OutputError, match=f"its {name} is an input of this run"):
            output.check([None, path])
    output.check([tmp_path / "absent", tmp_path / "run" / "other.csv"])


def test_an_input_beside_the_results_is_no_trouble(tmp_path):
    OutputDirectory(tmp_path, "track").write(OLD, RUN)
    (tmp_path / "reports.csv").write_text("mine")
    OutputDirectory(tmp_path, "track").check([tmp_path / "reports.csv"])
    OutputDirectory(tmp_path, "track").write(NEW, RUN)
    assert (tmp_path / "reports.csv").read_text() == "mine"


def test_says_early_that_a_name_is_taken(tmp_path):
    OutputDirectory(tmp_path, "track").write(OLD, RUN)
    (tmp_path / "assignments.csv").write_text("mine")
    with pytest.raises(OutputError, match=r"assignments\.csv that is not of the earlier run"):
        OutputDirectory(tmp_path, "track").check()


def test_names_the_directory_and_not_the_staging(tmp_path, monkeypatch):
    real = os.mkdir

    def refuse(path, *arguments, **keywords):
        if "staging" in str(path):
            raise FileNotFoundError(errno.ENOENT, "No such file or directory", str(path))
        real(path, *arguments, **keywords)

    monkeypatch.setattr(os, "mkdir", refuse)
    with pytest.raises(OutputError) as caught:
        OutputDirectory(tmp_path / "run", "track").write(NEW, RUN)
    assert str(caught.value).startswith(f"{tmp_path / 'run'}: cannot be written")
    assert "staging" not in str(caught.value)
