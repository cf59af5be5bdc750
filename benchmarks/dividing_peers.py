"""Peers that follow cells which divide: laptrack and btrack, on the same detections.

pip install traccuracy laptrack btrack
"""

import logging
from typing import Any

import numpy as np
import polars as pl

# The values of btrack's own example for cells (its ``cell_config``), and of laptrack's
# documentation, whose cutoffs are squares of the farthest step [pixels²].
_STATES = 6
_HYPOTHESES = {
    "name": "cell_hypothesis",
    "hypotheses": ["P_FP", "P_init", "P_term", "P_link", "P_branch", "P_dead"],
    "lambda_time": 5.0, "lambda_dist": 3.0, "lambda_link": 10.0, "lambda_branch": 50.0,
    "eta": 1e-10, "theta_dist": 20.0, "theta_time": 5.0, "dist_thresh": 40, "time_thresh": 2,
    "apop_thresh": 5, "segmentation_miss_rate": 0.1, "apoptosis_rate": 0.001, "relax": True,
}  # fmt: skip


def by_laptrack(detections: pl.DataFrame, *, farthest: float = 15.0) -> pl.DataFrame:
    """Return tracks of laptrack, its cutoffs for a farthest step, splitting on."""
    import pandas as pd
    from laptrack import LapTrack

    tracker = LapTrack(
        cutoff=farthest**2, gap_closing_cutoff=farthest**2, splitting_cutoff=farthest**2
    )
    table = pd.DataFrame(detections.select("time", "x", "y").to_dict(as_series=False))
    table["frame"] = table["time"].astype(int)
    found, splits, _ = tracker.predict_dataframe(
        table, coordinate_cols=["x", "y"], frame_col="frame", only_coordinate_cols=False
    )
    names = found["track_id"].to_numpy()
    parent = {} if splits.empty else dict(
        zip(splits["child_track_id"], splits["parent_track_id"], strict=True)
    )  # fmt: skip
    return _table(found["time"].to_numpy(), names, found[["x", "y"]].to_numpy(), parent)


def by_btrack(detections: pl.DataFrame) -> pl.DataFrame:
    """Return tracks of btrack with its example's parameters for cells, optimised globally."""
    import btrack

    logging.getLogger("btrack").setLevel(logging.ERROR)
    objects = [
        btrack.btypes.PyTrackObject.from_dict(
            {"ID": number, "t": int(time), "x": x, "y": y, "z": 0.0, "label": 5}
        )
        for number, (time, x, y) in enumerate(detections.select("time", "x", "y").iter_rows())
    ]
    with btrack.BayesianTracker(verbose=False) as tracker:
        tracker.configure(_configuration())
        tracker.append(objects)
        place = detections.select("x", "y")
        low, high = place.min().row(0), place.max().row(0)
        tracker.volume = tuple((a - 1.0, b + 1.0) for a, b in zip(low, high, strict=True))
        tracker.track(step_size=100)
        tracker.optimize(tm_lim=60_000, msg_lev="GLP_MSG_OFF")
        tracks = tracker.tracks
    rows: list[Any] = [
        (float(time), track.ID, (x, y))
        for track in tracks
        # Its places of frames in which the cell was not detected too.
        for time, x, y in zip(track.t, track.x, track.y, strict=True)
    ]
    parent = {track.ID: track.parent for track in tracks if track.parent not in (None, track.ID)}
    time, names, places = (np.array(column) for column in zip(*rows, strict=True))
    return _table(time, names, places, parent)


def _configuration() -> dict[str, Any]:
    from btrack.config import TrackerConfig
    from btrack.models import HypothesisModel, MotionModel

    half = _STATES // 2
    step, seen = np.eye(_STATES) + np.eye(_STATES, k=half), np.eye(half, _STATES)
    begin = np.diag([0.1] * half + [1.0] * half) * 150.0
    noise = np.array([[0.5] * half + [1.0] * half]) * 15.0
    motion = MotionModel(
        name="cell_motion", dt=1.0, measurements=half, states=_STATES, accuracy=7.5,
        prob_not_assign=0.001, max_lost=5, A=step, H=seen, P=begin, G=noise, R=5.0 * np.eye(half),
    )  # fmt: skip
    return TrackerConfig(motion_model=motion, hypothesis_model=HypothesisModel(**_HYPOTHESES))


def _table(
    time: np.ndarray, track: np.ndarray, place: np.ndarray, parent: dict[int, int]
) -> pl.DataFrame:
    # Numbers from 1.
    shift = 1 - int(min(track.min(initial=1), 1))
    known = {int(child) + shift: int(mother) + shift for child, mother in parent.items()}
    table = pl.DataFrame(
        {"time": time, "track": track.astype(np.int64) + shift, "x": place[:, 0], "y": place[:, 1]}
    )
    column = pl.col("track").replace_strict(known, default=None, return_dtype=pl.Int64)
    return table.with_columns(column.alias("parent"))
