"""Bodies that fall back through the atmosphere, as a radar sees them: reports and truth.

    python make_reentry.py FOLDER

The bodies move by equations of their own, each with a drag of its own; nothing is taken from the
motion model that then follows them.
"""

import sys
from pathlib import Path

import numpy as np
import polars as pl

PERIOD, SCANS, FINE = 1.0, 60, 20
SIGMA = np.array([30.0, np.radians(0.1), np.radians(0.1)])
DETECTED, ALARMS = 0.9, 5.0
BALLISTIC = (150.0, 400.0, 1000.0, 2500.0)
"""Mass over drag area of each body [kg/m²]."""


def fallen(place: np.ndarray, velocity: np.ndarray, ballistic: float) -> np.ndarray:
    """Return where a body is at each scan and how fast, by small steps."""
    path, step = [], PERIOD / FINE
    for _ in range(SCANS):
        path.append(np.r_[place, velocity])
        for _ in range(FINE):
            drag = 1.225 * np.exp(-place[2] / 7200.0) * np.linalg.norm(velocity) / ballistic / 2
            velocity = velocity + step * (np.array([0.0, 0.0, -9.6]) - drag * velocity)
            place = place + step * velocity
    return np.array(path)


def seen(place: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return range, azimuth and elevation of places as measured [m, rad]."""
    east, north, up = place.T
    distance = np.linalg.norm(place, axis=1)
    angles = np.arctan2(east, north), np.arctan2(up, np.hypot(east, north))
    return np.stack([distance, *angles], axis=1) + rng.normal(0.0, SIGMA, place.shape)


def main(folder: Path) -> None:
    rng = np.random.default_rng(1)
    truth, reports = [], []
    for number, ballistic in enumerate(BALLISTIC):
        place = np.array([-60e3 + 3e3 * number, 40e3 + 2e3 * number, 70e3])
        path = fallen(place, np.array([2500.0, 0.0, -1400.0]), ballistic)
        kept = path[:, 2] > 1e3
        truth += [(k * PERIOD, number + 1, *path[k]) for k in np.flatnonzero(kept)]
    for scan in range(SCANS):
        now = [row for row in truth if row[0] == scan * PERIOD and rng.random() < DETECTED]
        for measured, row in zip(seen(np.array([r[2:5] for r in now]), rng), now, strict=True):
            reports.append((row[0], *measured, str(row[1])))
        for _ in range(rng.poisson(ALARMS)):
            spread = rng.uniform([20e3, -np.pi / 2, 0.1], [120e3, np.pi / 2, 1.2])
            reports.append((scan * PERIOD, *spread, None))
    columns = ["time", "range_m", "azimuth_deg", "elevation_deg", "target"]
    table = pl.DataFrame(reports, schema=columns, orient="row")
    degrees = pl.col("azimuth_deg", "elevation_deg").degrees()
    turned = table.with_columns(degrees).with_columns(pl.col("azimuth_deg") % 360.0)
    folder.mkdir(parents=True, exist_ok=True)
    turned.sample(fraction=1.0, shuffle=True, seed=1).sort("time").write_csv(
        folder / "reports.csv"
    )
    columns = ["time", "target", "x", "y", "z", "vx", "vy", "vz"]
    pl.DataFrame(truth, schema=columns, orient="row").sort("time").write_csv(folder / "truth.csv")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
