"""Recordings of boxes frame by frame, and TrackEval's judgement of the tracks made of them."""

import contextlib
import io
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

Array = np.ndarray[Any, Any]
# Columns of PointRCNN's rows: box in the image, score, height, width, length, place, heading.
IMAGE, SCORE, HEIGHT, WIDTH, LENGTH, PLACE, HEADING = (
    slice(2, 6), 6, 7, 8, 9, slice(10, 13), 13,
)  # fmt: skip
CLASS = {"Pedestrian": 1, "Car": 2}


class Seen(NamedTuple):
    """A frame: boxes in the image, scores, and boxes in 3-D where there are any."""

    box: Array
    score: Array
    solid: Array


@dataclass(frozen=True)
class Sequence:
    """A sequence of one kind of object, and where its truth lies."""

    dataset: str
    name: str
    kind: str
    frames: list[Seen]
    period: float
    truth: Path

    @property
    def words(self) -> str:
        """What a table calls it."""
        return f"{self.dataset} {self.name}, {self.kind.lower()}s"


def sequences(recordings: Path) -> list[Sequence]:
    """Return all sequences: people in a video, then cars and people before a car."""
    folder = recordings / "mot_tud_campus"
    rows = np.loadtxt(folder / "dets" / "det" / "det.txt", delimiter=",")
    corners = np.hstack([rows[:, 2:4], rows[:, 2:4] + rows[:, 4:6]])
    frames = [
        Seen(corners[rows[:, 0] == k], rows[rows[:, 0] == k, 6], np.empty((0, 7)))
        for k in range(1, 72)
    ]
    found = [Sequence("TUD", "Campus", "Pedestrian", frames, 0.04, folder / "gt.txt")]
    for name in ("0000", "0002"):
        for kind in ("Car", "Pedestrian"):
            found.append(_kitti(recordings / "kitti" / name, kind))
    return found


def _kitti(folder: Path, kind: str) -> Sequence:
    rows = np.loadtxt(folder / f"pointrcnn_{kind}.txt", delimiter=",")
    truth = folder / "labels.txt"
    n_frames = 1 + max(int(line.split(" ", 1)[0]) for line in truth.read_text().splitlines())
    frames = []
    for k in range(n_frames):
        here = rows[rows[:, 0] == k]
        frames.append(Seen(here[:, IMAGE], here[:, SCORE], solid_of(here)))
    return Sequence("KITTI", folder.name, kind, frames, 0.1, truth)


def solid_of(rows: Array) -> Array:
    """Return x ahead, y to the left, z up, length, width, height, yaw from x towards y."""
    right, down, ahead = rows[:, PLACE].T
    size = [rows[:, LENGTH], rows[:, WIDTH], rows[:, HEIGHT]]
    middle = [ahead, -right, -down + rows[:, HEIGHT] / 2]
    return np.column_stack([*middle, *size, -rows[:, HEADING] - np.pi / 2])


class Found(NamedTuple):
    """A row of what a tracker found: frame from 0, identifier, box in the image."""

    frame: int
    who: int
    box: Array


def judged(one: Sequence, found: list[Found]) -> dict[str, Any]:
    """Return TrackEval's results of one sequence, by metric."""
    import trackeval

    with tempfile.TemporaryDirectory() as name, contextlib.redirect_stdout(io.StringIO()):
        folder = Path(name)
        dataset = (_mot if one.dataset == "TUD" else _as_kitti)(one, found, folder, trackeval)
        raw = dataset.get_raw_seq_data("ours", one.name)
        data = dataset.get_preprocessed_seq_data(raw, one.kind.lower())
        metrics = metrics_of()
        return {key: metric.eval_sequence(data) for key, metric in metrics.items()}


def together(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Return TrackEval's results over sequences as if they were one."""
    with contextlib.redirect_stdout(io.StringIO()):
        return {
            key: metric.combine_sequences({str(k): one[key] for k, one in enumerate(results)})
            for key, metric in metrics_of().items()
        }


def figures(result: dict[str, Any]) -> list[float]:
    """Return HOTA, IDF1 and MOTA in per cent."""
    hota = float(np.mean(result["HOTA"]["HOTA"]))
    return [100.0 * hota, 100.0 * result["Identity"]["IDF1"], 100.0 * result["CLEAR"]["MOTA"]]


def metrics_of() -> dict[str, Any]:
    """Return TrackEval's metrics by name."""
    import trackeval

    quiet = {"PRINT_CONFIG": False}
    made = trackeval.metrics
    return {
        "HOTA": made.HOTA(), "CLEAR": made.CLEAR(quiet), "Identity": made.Identity(quiet),
    }  # fmt: skip


def _mot(one: Sequence, found: list[Found], folder: Path, trackeval: Any) -> Any:
    (folder / "gt").mkdir()
    (folder / "gt" / "gt.txt").write_text(one.truth.read_text())
    (folder / "ours" / "data").mkdir(parents=True)
    lines = [
        f"{row.frame + 1},{row.who},{row.box[0]:.3f},{row.box[1]:.3f},"
        f"{row.box[2] - row.box[0]:.3f},{row.box[3] - row.box[1]:.3f},1,-1,-1,-1\n"
        for row in found
    ]
    (folder / "ours" / "data" / f"{one.name}.txt").write_text("".join(lines))
    return trackeval.datasets.MotChallenge2DBox({
        "GT_FOLDER": str(folder), "TRACKERS_FOLDER": str(folder), "BENCHMARK": "MOT15",
        "SEQ_INFO": {one.name: len(one.frames)}, "SKIP_SPLIT_FOL": True, "PRINT_CONFIG": False,
        "GT_LOC_FORMAT": "{gt_folder}/gt/gt.txt", "TRACKERS_TO_EVAL": ["ours"],
    })  # fmt: skip


def _as_kitti(one: Sequence, found: list[Found], folder: Path, trackeval: Any) -> Any:
    (folder / "label_02").mkdir()
    (folder / "label_02" / f"{one.name}.txt").write_text(one.truth.read_text())
    seqmap = f"{one.name} empty 000000 {len(one.frames):06d}\n"
    (folder / "evaluate_tracking.seqmap.training").write_text(seqmap)
    (folder / "trackers" / "ours" / "data").mkdir(parents=True)
    lines = [
        f"{row.frame} {row.who} {one.kind} -1 -1 -10 "
        + " ".join(f"{corner:.3f}" for corner in row.box)
        + " -1 -1 -1 -1000 -1000 -1000 -10 1\n"
        for row in found
    ]
    path = folder / "trackers" / "ours" / "data" / f"{one.name}.txt"
    path.write_text("".join(lines))
    return trackeval.datasets.Kitti2DBox({
        "GT_FOLDER": str(folder), "TRACKERS_FOLDER": str(folder / "trackers"),
        "TRACKERS_TO_EVAL": ["ours"], "CLASSES_TO_EVAL": [one.kind.lower()],
        "PRINT_CONFIG": False,
    })  # fmt: skip
