"""Joyride: a ship's radar follows one boat → reports and truth, from a MATLAB file.

    python examples/joyride.py joyride.mat OUT
    trackweave track OUT/reports.csv --out OUT/result

The file holds, for each turn of the radar, its time, the plots (north and east, in metres), the
boat's true state and the state of the ship that carries the radar (north, its rate, east, its
rate).
"""

import argparse
from pathlib import Path

import numpy as np
import polars as pl
from scipy.io import loadmat


def read(path: Path) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return the reports and the truth, times in seconds from the first turn."""
    if not path.exists():
        raise SystemExit(f"{path}: not there; expected joyride.mat")
    content = loadmat(path, simplify_cells=True)
    times = np.round(content["time"] - content["time"][0], 4)
    rows = []
    turns = zip(times, content["measurements"], content["telemetron"], strict=True)
    for time, plots, ship in turns:
        # One plot alone is a list of two numbers, and a turn may have none.
        for north, east in np.reshape(plots, (-1, 2)):
            rows.append((time, east, north, ship[2], ship[0]))
    reports = pl.DataFrame(rows, ["time", "x", "y", "sensor_x", "sensor_y"], orient="row")
    north, north_rate, east, east_rate = content["target"].T
    truth = {"time": times, "target": "boat", "x": east, "y": north}
    return reports, pl.DataFrame({**truth, "vx": east_rate, "vy": north_rate})


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("recording", type=Path, help="joyride.mat")
    parser.add_argument("out", type=Path, help="folder for reports.csv and truth.csv")
    arguments = parser.parse_args()
    reports, truth = read(arguments.recording)
    arguments.out.mkdir(parents=True, exist_ok=True)
    reports.write_csv(arguments.out / "reports.csv")
    truth.write_csv(arguments.out / "truth.csv")
    print(f"{len(reports)} reports of {len(truth)} turns")


if __name__ == "__main__":
    main()
