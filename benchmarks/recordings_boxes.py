"""Recordings of boxes in images: people by the rules of MOT, cars and people by those of KITTI."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from nearest_neighbour import Habits, nearest_neighbour
from recordings_data import Run, by_hand, run
from recordings_formats import (
    kitti_detections,
    kitti_ignored,
    kitti_truth,
    mot_detections,
    mot_truth,
)
from scipy.optimize import linear_sum_assignment
from text_tables import table

from trackweave.domain.tracks import CONFIRMED
from trackweave.metrics import Moment, clear_mot, identity
from trackweave.models.strength import StrengthModel

Array = np.ndarray[Any, Any]
FARTHEST = 0.5  # 1 - intersection over union
SIZE_GAIN = 0.3  # what a new report changes in a track's size
LOWEST = 25.0  # pixels; lower boxes are judged neither for nor against
PLAIN = "nearest neighbour, motion and noise of the same"
BOX = ["left", "top", "right", "bottom"]


class Boxes(NamedTuple):
    """Rows of one side: frame, who, and left, top, right, bottom."""

    frame: Array
    identity: Array
    box: Array


@dataclass
class Compared:
    """Boxes side by side frame by frame, in the form that the measures take."""

    truth: Boxes
    tracks: Boxes

    @property
    def n_targets(self) -> int:
        """Number of different targets."""
        return int(self.truth.identity.max(initial=-1)) + 1

    @property
    def n_tracks(self) -> int:
        """Number of different tracks."""
        return int(self.tracks.identity.max(initial=-1)) + 1

    def __iter__(self) -> Iterator[Moment]:
        for frame in np.union1d(self.truth.frame, self.tracks.frame):
            true, found = self.truth.frame == frame, self.tracks.frame == frame
            apart = 1.0 - overlap(self.truth.box[true], self.tracks.box[found])
            yield Moment(
                float(frame), self.truth.identity[true], self.tracks.identity[found], apart
            )


def overlap(first: Array, second: Array, *, of_second: bool = False) -> Array:
    """Return intersection over union of every pair, or over the second's own area."""
    low = np.maximum(first[:, None, :2], second[None, :, :2])
    high = np.minimum(first[:, None, 2:], second[None, :, 2:])
    common = np.prod(np.maximum(high - low, 0.0), axis=2)
    area = [np.prod(box[:, 2:] - box[:, :2], axis=1) for box in (first, second)]
    whole = area[1][None, :] if of_second else area[0][:, None] + area[1][None, :] - common
    return np.asarray(common / np.maximum(whole, 1e-9))


def judge(truth: Boxes, tracks: Boxes) -> list[Any]:
    """Return MOTA and IDF1 in per cent, switches, missed, false and the number of tracks."""
    compared: Any = Compared(_numbered(truth), _numbered(tracks))
    pairing = clear_mot(compared, FARTHEST, 1.0)
    named = identity(compared, FARTHEST)
    return [
        f"{100 * (pairing.mota or 0):.1f}", f"{100 * (named.idf1 or 0):.1f}", pairing.switches,
        pairing.n_missed, pairing.n_false, compared.n_tracks,
    ]  # fmt: skip


HEAD = ["method", "MOTA %", "IDF1 %", "switches", "missed", "false", "tracks", "CPU s"]


def _numbered(boxes: Boxes) -> Boxes:
    return boxes._replace(identity=np.unique(boxes.identity, return_inverse=True)[1].reshape(-1))


def tracked_boxes(one: Run, reports: pl.DataFrame, *, rule: str, shift: bool) -> Boxes:
    """Return the boxes of confirmed tracks.

    ``rule``: "seen" for what was known in each frame about tracks that took a report of it;
    "known" with those that coast as well, with their last size; "after" for what is known in the
    end. ``shift`` puts the box where the track is, and its size is a running mean, otherwise both
    stay the report's.
    """
    assert one.result is not None
    values = one.result.values
    table_of = values.history if rule == "after" else values.tracks
    times, frames = _frames_of(reports)
    names = values.assignment if rule == "after" else _names_of_then(one)
    latest = _boxes_by_track(one, reports, names, smooth=shift, after=rule == "after")
    rows: list[tuple[int, int, Array]] = []
    for place in np.flatnonzero(table_of.status >= CONFIRMED):
        time, number = table_of.time[place], int(table_of.track[place])
        taken, box = latest.get(number, (np.empty(0), np.empty((0, 4))))
        before = np.searchsorted(taken, time + 1e-6) - 1
        frame = int(np.searchsorted(times, time - 1e-6))
        if before < 0 or frame >= times.size:
            continue
        is_seen = taken[before] > time - 1e-6
        if rule == "seen" and not is_seen:
            continue
        here = box[before]
        if shift or not is_seen:
            middle = (here[:2] + here[2:]) / 2
            here = here + np.tile(table_of.mean[place, :2] - middle, 2)
        rows.append((int(frames[frame]), number, here))
    return _stacked(rows)


def _frames_of(reports: pl.DataFrame) -> tuple[Array, Array]:
    pairs = reports.select("time", "frame").unique().sort("time")
    return pairs["time"].to_numpy(), pairs["frame"].to_numpy()


def _names_of_then(one: Run) -> dict[int, int]:
    """Return the number that each assigned report's track had in tracks.csv, by row."""
    assert one.result is not None
    values, joins = one.result.values, one.result.run["joins"] or {"list": [], "parted": []}
    names = dict(values.assignment)
    for join in sorted([*joins["list"], *joins["parted"]], key=lambda each: each["time"]):
        for row, number in values.assignment.items():
            if number == join["into"] and values.reports.time[row] >= join["time"]:
                names[row] = join["track"]
    return names


def _boxes_by_track(
    one: Run, reports: pl.DataFrame, names: dict[int, int], *, smooth: bool, after: bool
) -> dict[int, tuple[Array, Array]]:
    """Return from each track to the times and boxes of its reports, whose tracks are told."""
    assert one.result is not None
    values = one.result.values
    box = reports.select(BOX).to_numpy()
    found: dict[int, list[tuple[float, int]]] = {}
    for row, number in names.items():
        record = int(values.reports.report[row]) - 1
        found.setdefault(number, []).append((float(values.reports.time[row]), record))
    boxes = {}
    for number, rows in found.items():
        rows.sort()
        own = box[[record for _, record in rows]]
        boxes[number] = (
            np.array([time for time, _ in rows]),
            _steadied(own, after) if smooth else own,
        )
    return boxes


def _steadied(box: Array, after: bool) -> Array:
    """Return boxes about the same middles whose sizes are running means."""
    middle, size = (box[:, :2] + box[:, 2:]) / 2, box[:, 2:] - box[:, :2]
    steady = _running(size)
    if after:
        # What comes later counts as well.
        steady = (steady + _running(size[::-1])[::-1]) / 2
    return np.hstack([middle - steady / 2, middle + steady / 2])


def _running(values: Array) -> Array:
    running = values.copy()
    for place in range(1, len(values)):
        share = max(SIZE_GAIN, 1.0 / (place + 1))
        running[place] = running[place - 1] + share * (values[place] - running[place - 1])
    return running


def _stacked(rows: list[tuple[int, int, Array]]) -> Boxes:
    return Boxes(
        np.array([frame for frame, _, _ in rows], dtype=np.int64),
        np.array([who for _, who, _ in rows], dtype=np.int64),
        np.array([box for _, _, box in rows]).reshape(-1, 4),
    )


def _plain_boxes(reports: pl.DataFrame, habits: Habits) -> Boxes:
    """Return the boxes of the plain tracker's tracks that took a report."""
    position = reports.select("x", "y").to_numpy()
    frame, box = reports["frame"].to_numpy(), reports.select(BOX).to_numpy()
    seen = nearest_neighbour(reports["time"].to_numpy(), position, habits)
    return _stacked(
        [(int(frame[one.report]), one.track, box[one.report]) for one in seen if one.report >= 0]
    )


def true_boxes(truth: pl.DataFrame) -> Boxes:
    return Boxes(
        truth["frame"].to_numpy(), truth["target"].to_numpy(), truth.select(BOX).to_numpy()
    )


def tud(data: Path) -> str:
    """Return the table of TUD-Campus."""
    folder = data / "mot_tud_campus"
    reports = cornered(mot_detections(folder / "dets" / "det" / "det.txt"))
    truth = cornered(mot_truth(folder / "gt.txt"))
    rows = []
    for one in _both("tud_campus", reports):
        if one.result is None:
            rows.append([one.name, one.refused, *["–"] * 6])
            continue
        for rule in ("seen", "known", "after"):
            boxes = tracked_boxes(one, reports, rule=rule, shift=True)
            rows.append([f"{one.name}, {rule}", *judge(true_boxes(truth), boxes), one.cpu])
    sort = ["SORT, as published", "62.7", "60.6", 6, "–", "–", "–", "–"]
    return table(HEAD, [*rows, sort])


def cornered(boxes: pl.DataFrame) -> pl.DataFrame:
    """Return boxes with their corners and frames."""
    corners = [
        (pl.col("x") - pl.col("width") / 2).alias("left"),
        (pl.col("y") - pl.col("height") / 2).alias("top"),
        (pl.col("x") + pl.col("width") / 2).alias("right"),
        (pl.col("y") + pl.col("height") / 2).alias("bottom"),
    ]
    frame = (pl.col("time") * 25.0).round().cast(pl.Int64).alias("frame")
    return boxes.with_columns(*corners, frame)


def _both(name: str, reports: pl.DataFrame) -> list[Run]:
    return [
        run("no configuration", reports, None),
        run(f"`{name}.toml`", reports, by_hand(name)),
    ]


def kitti(data: Path) -> str:
    """Return the tables of both KITTI sequences, cars and pedestrians."""
    parts = []
    for sequence in ("0000", "0002"):
        for kind in ("Car", "Pedestrian"):
            folder = data / "kitti" / sequence
            reports = kitti_detections(folder, kind)
            truth = judged(kitti_truth(folder, kind))
            others = ignored(folder, kind)
            name = f"kitti_{kind.lower()}"
            rows = []
            for one in _both(name, reports):
                if one.result is None:
                    rows.append([one.name, one.refused, *["–"] * 6])
                    continue
                boxes = tracked_boxes(one, reports, rule="seen", shift=False)
                rows.append([one.name, *judge(*spared(truth, boxes, others)), one.cpu])
            sure = reports.filter(pl.Series(_evidence(name, reports) >= 0.0))
            for words, shown in ((PLAIN, reports), (f"{PLAIN}, sure detections only", sure)):
                boxes = _plain_boxes(shown, _habits(name))
                rows.append([words, *judge(*spared(truth, boxes, others)), "–"])
            parts.append(f"Sequence {sequence}, {kind.lower()}s:\n\n{table(HEAD, rows)}")
    return "\n\n".join(parts)


def _habits(name: str) -> Habits:
    """Return the plain tracker's parameters: those of the configuration by hand."""
    values = by_hand(name)
    motion, sigma = values["motion"], values["sensors"]["default"]["sigma"]
    return Habits(motion["process_noise"], sigma, motion["max_speed"], most_misses=3)


def _evidence(name: str, reports: pl.DataFrame) -> Array:
    """Return what each score says for an object by the configuration made by hand [nats]."""
    model = StrengthModel(**by_hand(name)["sensors"]["default"]["strength"])
    return model.evidence(reports["strength"].to_numpy())


def judged(truth: pl.DataFrame) -> Boxes:
    """Return the boxes that KITTI asks for: whole, not largely hidden, not too small."""
    return true_boxes(truth.filter(_is_judged()))


def _is_judged() -> pl.Expr:
    is_high = pl.col("bottom") - pl.col("top") >= LOWEST
    return (pl.col("truncated") <= 0) & (pl.col("occluded") <= 2) & is_high


def ignored(folder: Path, kind: str) -> pl.DataFrame:
    """Return what KITTI does not ask for: regions, similar objects, objects cut or hidden."""
    truth = kitti_truth(folder, kind)
    hidden = truth.filter(~_is_judged())
    others = hidden.select("frame", *BOX, pl.lit(value=False).alias("is_region"))
    return pl.concat([kitti_ignored(folder, kind), others])


def spared(truth: Boxes, tracks: Boxes, ignored: pl.DataFrame) -> tuple[Boxes, Boxes]:
    """Leave out boxes of tracks that match no true box and are not to be judged."""
    kept = np.ones(tracks.frame.size, dtype=bool)
    for frame in np.unique(tracks.frame):
        rows = np.flatnonzero(tracks.frame == frame)
        near = overlap(truth.box[truth.frame == frame], tracks.box[rows])
        first, second = linear_sum_assignment(-near)
        matched = second[near[first, second] >= FARTHEST]
        there = ignored.filter(pl.col("frame") == int(frame))
        alike = there.filter(~pl.col("is_region")).select(BOX).to_numpy()
        region = there.filter(pl.col("is_region")).select(BOX).to_numpy()
        box = tracks.box[rows]
        spare = (overlap(alike, box) >= FARTHEST).any(axis=0)
        spare |= (overlap(region, box, of_second=True) >= FARTHEST).any(axis=0)
        spare |= box[:, 3] - box[:, 1] < LOWEST
        spare[matched] = False
        kept[rows[spare]] = False
    return truth, Boxes(*(column[kept] for column in tracks))
