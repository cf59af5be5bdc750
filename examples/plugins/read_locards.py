"""Receptions of aircraft at five receivers each (LocaRDS) as reports and truth.

    python read_locards.py SET.csv SENSORS.csv FOLDER

Each message was heard by five receivers with clocks of their own that follow GPS. What it says of
its place and who it is from goes into the truth; the height that it tells, into the report.
"""

import json
import sys
from pathlib import Path

import numpy as np
import polars as pl
import pymap3d

ORIGIN = (47.5, 8.5, 0.0)
LIGHT = 299_702_547.0 * 1e-9
"""Metres of a nanosecond, in air."""
CURVED = 6_378_137.0
"""Heights are distances from a centre so far below the receivers, less this [m]."""


def on_plane(latitude: np.ndarray, longitude: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return places as x, y, z about the origin [m], straight through the Earth's curve."""
    return np.stack(pymap3d.geodetic2enu(latitude, longitude, height, *ORIGIN), axis=-1)


def main(messages: Path, sensors: Path, folder: Path) -> None:
    stands = pl.read_csv(sensors)
    where = {row["serial"]: row for row in stands.iter_rows(named=True)}
    reports, truth = [], []
    for row in pl.read_csv(messages, null_values="NA").sort("timeAtServer").iter_rows(named=True):
        heard = json.loads(row["measurements"])
        place = np.array(
            [[where[r][name] for name in ("latitude", "longitude", "height")] for r, _, _ in heard]
        )
        arrival = LIGHT * np.array([nanoseconds for _, nanoseconds, _ in heard])
        middle = place[:, :2].mean(axis=0)
        center = on_plane(*middle, -CURVED)
        farther = arrival[1:] - arrival[0]
        time, name = row["timeAtServer"], str(row["aircraft"])
        receivers = on_plane(*place.T).ravel()
        reports.append((row["id"], time, name, *farther, row["geoAltitude"], *receivers, *center))
        at = on_plane(row["latitude"], row["longitude"], row["geoAltitude"])
        truth.append((time, name, *at))
    names = [f"receiver_{n}_{axis}" for n in range(1, 6) for axis in "xyz"]
    columns = ["report", "time", "target", *(f"farther_{n}_m" for n in range(2, 6)), "above_m"]
    columns += [*names, "center_x", "center_y", "center_z"]
    folder.mkdir(parents=True, exist_ok=True)
    table = pl.DataFrame(reports, schema=columns, orient="row")
    table.write_csv(folder / "reports.csv")
    columns = ["time", "target", "x", "y", "z"]
    # A message may have been heard twice, by other receivers.
    once = pl.DataFrame(truth, schema=columns, orient="row").unique(["time", "target"])
    once.sort("time", "target").write_csv(folder / "truth.csv")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
