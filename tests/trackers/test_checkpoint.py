"""Trackers go on from a checkpoint as if nothing had happened; what is none is refused."""

import json
import os
import pickle
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import trackweave as tw
from oracles.checkpoints import CASES, CLASSES, SHAPES, advance, shapes, told
from oracles.scenes import MOTION, scene, sensor, tracker
from trackweave.errors import DataFormatError, InvalidInputError, OutputError
from trackweave.trackers.checkpoint import LAYOUT, pack, unpack

ELSEWHERE = """
import json, sys
import trackweave as tw
from oracles.checkpoints import CASES, CLASSES, advance
name, folder, cut = sys.argv[1], sys.argv[2], int(sys.argv[3])
case = CASES[name]()
found = type(case.tracker).load(f"{folder}/saved", classes=CLASSES)
print(json.dumps([advance(found, step) for step in case.steps[cut:]]))
"""


def after(case, cut):
    """Return a case's tracker after some steps."""
    for step in case.steps[:cut]:
        advance(case.tracker, step)
    return case.tracker


@pytest.mark.parametrize("name", CASES)
def test_goes_on_byte_for_byte_from_any_step(name):
    case = CASES[name]()
    target, said, saved = case.tracker, [], []
    for step in case.steps:
        saved.append(pack(target, CLASSES))
        said.append(advance(target, step))
    assert len(set(said)) > len(said) // 2
    for cut in range(0, len(case.steps), max(1, len(case.steps) // 5)):
        found = unpack(saved[cut], CLASSES)
        assert pack(found, CLASSES) == saved[cut]
        assert [advance(found, step) for step in case.steps[cut:]] == said[cut:]
        assert pack(found, CLASSES) == pack(target, CLASSES)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["two halves", "nearest", "boxes", "models of others"])
def test_goes_on_in_another_process(tmp_path, name):
    case = CASES[name]()
    cut = len(case.steps) // 2
    target = after(case, cut)
    target.save(tmp_path / "saved", classes=CLASSES)
    tests = str(Path(__file__).resolve().parents[1])
    paths = os.pathsep.join([*sys.path, tests])
    done = subprocess.run(
        [sys.executable, "-c", ELSEWHERE, name, str(tmp_path), str(cut)],
        env={**os.environ, "PYTHONPATH": paths, "PYTHONHASHSEED": "77"},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert json.loads(done.stdout) == [advance(target, step) for step in case.steps[cut:]]


def test_what_a_checkpoint_holds_changes_only_with_its_layout():
    # After a change write the shapes anew (``oracles.checkpoints`` says how), and count LAYOUT up
    # if a release has written files of the layout before.
    assert told(shapes()) == SHAPES.read_text()


def saved(tmp_path):
    target = tracker()
    for each in scene(1, times=range(3)):
        target.step(each)
    path = tmp_path / "saved"
    target.save(path)
    return path


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b"", "begins with b''; expected a checkpoint of trackweave"),
        (b"PK\3\4 a zip file of somebody else's", r"begins with b'PK\\x03\\x04 a zip"),
        (pickle.dumps({"a": 1}), "expected a checkpoint of trackweave"),
        (pack(3)[:40], "expected a checkpoint of trackweave"),
        (pack(3)[:-1], "damaged: 9 bytes of content; expected 10"),
        (pack(3) + b"\0", "damaged: 11 bytes of content; expected 10"),
        (pack(3), "a checkpoint of int; expected one of MultiHypothesisTracker"),
        (
            pack(3).replace(struct.pack("<I", LAYOUT), struct.pack("<I", LAYOUT + 1), 1),
            rf"layout {LAYOUT + 1}, written by trackweave \S+; expected layout {LAYOUT}$",
        ),
    ],
)
def test_says_what_came_instead_of_a_checkpoint(tmp_path, content, what):
    path = tmp_path / "saved"
    path.write_bytes(content)
    with pytest.raises(DataFormatError, match=f"^{path}: .*{what}"):
        tw.MultiHypothesisTracker.load(path)


def test_a_checkpoint_of_another_tracker_is_refused_by_name(tmp_path):
    tw.BoxTracker().save(tmp_path / "boxes")
    with pytest.raises(DataFormatError, match="of BoxTracker; expected one of NearestNeighbour"):
        tw.NearestNeighbourTracker.load(tmp_path / "boxes")


def test_any_damaged_byte_is_found(tmp_path):
    path = saved(tmp_path)
    whole = path.read_bytes()
    rng = np.random.default_rng(1)
    for place in [*range(66), *rng.integers(66, len(whole), 200).tolist()]:
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        if 26 <= place < 42:  # who wrote it is told, and no more
            assert pack(tw.MultiHypothesisTracker.load(path))[66:] == whole[66:]
        else:
            with pytest.raises(DataFormatError, match=f"^{path}: "):
                tw.MultiHypothesisTracker.load(path)


def test_what_is_no_file_is_an_error_of_ours(tmp_path):
    for path in (tmp_path / "none", tmp_path, "\0"):
        with pytest.raises(InvalidInputError, match="cannot be read"):
            tw.BoxTracker.load(path)
    for path in (tmp_path / "no" / "folder", tmp_path, "\0"):
        with pytest.raises(OutputError, match="cannot be written"):
            tw.BoxTracker().save(path)
    assert list(tmp_path.iterdir()) == []


def test_arguments_of_another_kind_are_refused_by_name(tmp_path):
    for path in (None, 3, b"saved", tw.BoxTracker()):
        for call in (tw.BoxTracker().save, tw.BoxTracker.load):
            with pytest.raises(InvalidInputError, match=r"^path: .*; expected a path of a file"):
                call(path)
    for classes in (int, [3], "int", [None]):
        with pytest.raises(InvalidInputError, match=r"^classes"):
            tw.BoxTracker().save(tmp_path / "saved", classes=classes)


def test_a_file_is_replaced_whole_or_stays(tmp_path, monkeypatch):
    path = saved(tmp_path)
    before = path.read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(OutputError, match=r"saved: cannot be written \(No space left"):
            tw.BoxTracker().save(path)
    assert path.read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["saved"]
    tw.BoxTracker().save(path)
    assert isinstance(tw.BoxTracker.load(path), tw.BoxTracker)


@pytest.mark.parametrize("path", [".", ""])
def test_a_path_without_a_name_is_refused(path):
    with pytest.raises(OutputError, match="a directory; expected the path of a file"):
        tw.BoxTracker().save(path)


class Stranger:
    """A solver from somewhere else."""

    def __call__(self, problem, **options):
        return tw.Exact()(problem, **options)


def test_names_what_it_cannot_hold(tmp_path):
    target = tw.MultiHypothesisTracker(motion=MOTION, sensors=[sensor()], search=Stranger())
    with pytest.raises(InvalidInputError, match=r"^_search: a .*Stranger; a checkpoint holds"):
        target.save(tmp_path / "saved")
    target.save(tmp_path / "saved", classes=[Stranger])
    with pytest.raises(DataFormatError, match="class 'Stranger', which is none of ours"):
        tw.MultiHypothesisTracker.load(tmp_path / "saved")
    found = tw.MultiHypothesisTracker.load(tmp_path / "saved", classes=[Stranger])
    assert isinstance(found._search, Stranger)


@given(st.binary(max_size=60))
def test_bytes_that_are_no_checkpoint_are_never_one(content):
    with pytest.raises(DataFormatError):
        unpack(content)
