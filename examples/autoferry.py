"""Autoferry: the radar, lidar, infra-red and camera of a small ferry → reports and truth.

    python examples/autoferry.py RECORDING/scenario2 OUT
    python examples/autoferry.py RECORDING/scenario2 OUT --sensors radar lidar
    trackweave track OUT/reports.csv --out OUT/result

RECORDING is github.com/Autoferry/sensor_fusion_dataset; one folder a scenario, each with two JSON
files. Radar and lidar measure positions relative to the ferry, which is added here. Infra-red and
camera measure bearings clockwise from north, seen from where the ferry was; such rows have no
position. The truth is satellite navigation on board two vessels. Other boats and the shores give
reports too and have no truth.
"""

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

SENSORS = {1: "lidar", 2: "radar", 3: "ir", 4: "eo"}
BEARINGS = {"ir", "eo"}
VESSELS = {1: "havfruen", 2: "other"}  # the other one: Gunnerus until scenario 6, then a jet boat
REPORTS = {
    "time": pl.Float64, "sensor": pl.String, "x": pl.Float64, "y": pl.Float64,
    "bearing_deg": pl.Float64, "sensor_x": pl.Float64, "sensor_y": pl.Float64,
}  # fmt: skip
STEP = 0.5  # seconds between rows of the truth
LONGEST_GAP = 3.0  # seconds without navigation that the truth bridges


def read(folder: Path) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return the reports and the truth of a scenario, times in seconds from its begin."""
    scans = _load(folder, "detections")
    positions = _load(folder, "groundTruth")
    begin = math.floor(min(scan["time"] for scan in scans))
    reports = [row for scan in scans for row in _rows_of(scan, begin)]
    truth = [_truth_of(positions, number, begin) for number in VESSELS]
    # Times of different scans are not in order.
    return (
        pl.DataFrame(reports, REPORTS, orient="row").sort("time", "sensor", maintain_order=True),
        pl.concat(truth).sort("time", "target"),
    )


def _load(folder: Path, what: str) -> Any:
    path = folder / f"{folder.resolve().name}_{what}.json"
    if not path.exists():
        raise SystemExit(f"{path}: not there; expected a scenario's folder")
    return json.loads(path.read_text(encoding="utf-8"))


def _truth_of(moments: Any, number: int, begin: float) -> pl.DataFrame:
    """Return where a vessel was, at times that are the same for all vessels."""
    # The truth stands beside each scan, so that one position comes several times.
    known = {
        one["time"] - begin: one["position"][:2]
        for moment in moments
        for one in moment
        if one["targetID"] == number and all(map(math.isfinite, one["position"][:2]))
    }
    times = np.array(sorted(known))
    north, east = np.array([known[time] for time in times]).T
    common = np.arange(math.ceil(times[0] / STEP), math.floor(times[-1] / STEP) + 1) * STEP
    after = np.searchsorted(times, common).clip(1)
    common = common[times[after] - times[after - 1] < LONGEST_GAP]
    where = {"x": np.interp(common, times, east), "y": np.interp(common, times, north)}
    return pl.DataFrame({"time": common, "target": VESSELS[number], **where})


def _rows_of(scan: dict[str, Any], begin: float) -> list[tuple[Any, ...]]:
    """Return a row for each thing that a sensor saw at one time."""
    time, sensor = round(scan["time"] - begin, 4), SENSORS[scan["sensorID"]]
    own_north, own_east = scan["ownshipPosition"][:2]
    measured = scan["measurement"]
    if sensor in BEARINGS:
        # One number alone is not in a list.
        bearings = measured if isinstance(measured, list) else [measured]
        return [
            (time, sensor, None, None, math.degrees(bearing) % 360.0, own_east, own_north)
            for bearing in bearings
            if math.isfinite(bearing)
        ]
    if not measured:
        return []
    # A row of norths and a row of easts; of one report, two numbers.
    norths, easts = ([one] if isinstance(one, float) else one for one in measured)
    return [
        (time, sensor, own_east + east, own_north + north, None, own_east, own_north)
        for north, east in zip(norths, easts, strict=True)
        if math.isfinite(north) and math.isfinite(east)
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("recording", type=Path, help="folder of a scenario")
    parser.add_argument("out", type=Path, help="folder for reports.csv and truth.csv")
    names = list(SENSORS.values())
    parser.add_argument("--sensors", nargs="+", choices=names, default=names)
    arguments = parser.parse_args()
    reports, truth = read(arguments.recording)
    reports = reports.filter(pl.col("sensor").is_in(arguments.sensors))
    # Without bearings, or without positions, their columns are empty.
    reports = reports[[column.name for column in reports if column.null_count() < len(column)]]
    arguments.out.mkdir(parents=True, exist_ok=True)
    reports.write_csv(arguments.out / "reports.csv")
    truth.write_csv(arguments.out / "truth.csv")
    print(f"{len(reports)} reports of {', '.join(arguments.sensors)}")


if __name__ == "__main__":
    main()
