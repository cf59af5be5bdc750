"""Autoferry: tracks of radar alone and of lidar alone, fused.

    python benchmarks/fusion_autoferry.py                 # half a minute

Each sensor is tracked on its own with the configuration made by hand; both files of tracks are
fused. A vessel counts as seen by both at the truth's times at which a track of each sensor is
within 30 m of it; there the errors of radar, lidar and fused tracks are compared. Objects: the
numbers of fused tracks that were the nearest to the vessel at those times. First as by default,
then with covariances taken twice: the sensors see different parts of vessels of 10 and 30 m.
"""

import argparse
from collections import Counter
from typing import Any

import numpy as np
import polars as pl
from recordings_data import add_arguments, by_hand, example
from text_tables import command, heading, table

from trackweave import fuse, track
from trackweave.domain.tracks import TrackTable
from trackweave.io.tracks_in import read_local_tracks

SCENARIOS = (2, 4, 13, 16)
SENSORS = ("radar", "lidar")
NEAR_M = 30.0
FRESH_S = 2.0
CONFIGURATIONS: dict[str, dict[str, Any]] = {
    "none": {},
    "covariances twice": {"statistic": {"correlation": "inflated", "inflation": 2.0}},
}


def tracked(reports: pl.DataFrame, sensor: str) -> pl.DataFrame:
    """Return the tracks of one sensor."""
    shown = reports.filter(pl.col("sensor") == sensor).drop("target", "identity", strict=False)
    shown = shown[[one.name for one in shown if one.null_count() < len(one)]]
    hand = by_hand("autoferry")
    sensors = {sensor: hand["sensors"][sensor]}
    result = track(shown, {**hand, "sensors": sensors}, rng=np.random.default_rng(1))
    tracks: pl.DataFrame = result.tracks
    return tracks


def nearest(tracks: TrackTable, time: float, place: np.ndarray) -> tuple[int, float]:
    """Return the track nearest to a place at a time, and how far; -1 where none is near."""
    recent = (tracks.time <= time) & (tracks.time > time - FRESH_S)
    rows = np.flatnonzero(recent)
    # The last row of each track, at the velocity that it had.
    rows = rows[np.unique(tracks.track[rows][::-1], return_index=True)[1] * -1 - 1 + rows.size]
    ahead = tracks.mean[rows, :2] + (time - tracks.time[rows])[:, None] * tracks.mean[rows, 2:4]
    apart = np.linalg.norm(ahead - place, axis=1)
    if not apart.size or apart.min() > NEAR_M:
        return -1, np.nan
    return int(tracks.track[rows[np.argmin(apart)]]), float(apart.min())


def compare(tables: dict[str, TrackTable], truth: pl.DataFrame, vessel: str) -> list[Any]:
    """Return how one vessel was followed where both sensors see it."""
    errors: dict[str, list[float]] = {name: [] for name in tables}
    objects: Counter[int] = Counter()
    for time, x, y in (
        truth.filter(pl.col("target") == vessel).select("time", "x", "y").iter_rows()
    ):
        found = {name: nearest(own, time, np.array([x, y])) for name, own in tables.items()}
        if any(number < 0 for number, _ in found.values()):
            continue
        objects[found["fused"][0]] += 1
        for name, (_, error) in found.items():
            errors[name].append(error)
    n = len(errors["fused"])
    rmse = [float(np.sqrt(np.mean(np.square(errors[name])))) for name in tables] if n else []
    listed = ", ".join(f"{number}: {count}" for number, count in objects.most_common())
    return [n, listed or "–", *(rmse or [None] * len(tables))]


def run(data: Any) -> list[list[Any]]:
    """Return the rows of the table."""
    reader, rows = example("autoferry"), []
    for number in SCENARIOS:
        reports, truth = reader.read(data / "autoferry" / f"scenario{number}")
        frames = {sensor: tracked(reports, sensor) for sensor in SENSORS}
        tables = {name: read_local_tracks(frame).tracks for name, frame in frames.items()}
        for name, config in CONFIGURATIONS.items():
            fused = fuse(frames, config, rng=np.random.default_rng(1))
            tables["fused"] = fused.values.tracks
            splits = fused.run["totals"]["split"]
            rows += [
                [number, name, vessel, *compare(tables, truth, vessel), splits]
                for vessel in ("havfruen", "other")
            ]
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    add_arguments(parser)
    data = parser.parse_args().recordings
    if not (data / "autoferry").exists():
        print(f"Skipped: no recordings in {data}")
        return
    print(heading(command("fusion_autoferry.py")), end="\n\n")
    head = ["scenario", "configuration", "vessel", "times", "objects: times"]
    head += ["radar RMSE m", "lidar RMSE m", "fused RMSE m", "splits in all"]
    print(table(head, run(data)))


if __name__ == "__main__":
    main()
