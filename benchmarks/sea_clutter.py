"""A harbour radar with sea clutter about it and eight places of echoes: false reports in tracks.

Twenty boats, a third of them moored, turn now and then; false alarms lie exponentially about the
radar (8 a scan, 500 m), and about each of eight places (0.3 a scan, 25 m). Nothing is told but,
where ranges and azimuths are measured, that the radar is in the middle. With ``--wide`` boats are
that wide besides, the same from near and far, and with ``--berths`` the moored ones lie that near.
"""

import argparse
import time

import numpy as np
import polars as pl
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

PERIOD, LAST, NOISE, AZIMUTH_NOISE = 2.5, 600.0, 8.0, np.radians(0.3)
HEAD = ["measured", "seed", "IDF1", "false reports in tracks", "boats' on none", "tracks", "CPU s"]
POLAR = {"sensors": {"default": {"position": [0.0, 0.0]}}}


def harbour(
    rng: np.random.Generator, *, wide: float = 0.0, berths: float = 3000.0
) -> pl.DataFrame:
    """Return reports with their target, "" for false ones."""
    # Any point of a boat may be seen, as of a normal distribution ``wide`` [m]; moored ones lie
    # within ``berths`` of the radar, east and north [m].
    moments, boats = np.arange(0.0, LAST, PERIOD), range(20)
    rows = [row for each in boats for row in _boat(f"s{each}", moments, rng, (wide, berths))]
    places = rng.uniform(-2500.0, 2500.0, (8, 2))
    for moment in moments:
        there = places[rng.random(8) < 0.3]
        echoes = there + rng.normal(0.0, 25.0, there.shape)
        count = rng.poisson(8.0)
        away, azimuth = rng.exponential(500.0, count), rng.uniform(0.0, 2 * np.pi, count)
        sea = away[:, None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=1)
        rows += [(moment, float(x), float(y), "") for x, y in np.concatenate([echoes, sea])]
    names = ["time", "x", "y", "target"]
    return pl.DataFrame(rows, names, orient="row").sort("time", maintain_order=True)


def _boat(
    name: str, moments: np.ndarray, rng: np.random.Generator, of: tuple[float, float]
) -> list[tuple[float, float, float, str]]:
    place, heading = rng.uniform(-3000.0, 3000.0, 2), rng.uniform(0.0, 2 * np.pi)
    speed, turn, rows = rng.choice([0.0, 0.0, 3.0, 6.0, 9.0, 14.0]), 0.0, []
    wide, berths = of
    if speed == 0.0:
        place *= berths / 3000.0
    for moment in moments:
        if rng.random() < 0.02:
            turn = rng.choice([0.0, 0.0, 0.03, -0.03])
        heading += turn * PERIOD
        if np.hypot(*place) > 3500.0:
            heading = np.arctan2(-place[0], -place[1])
        place = place + speed * PERIOD * np.array([np.sin(heading), np.cos(heading)])
        if rng.random() < 0.88:
            point = place + rng.normal(0.0, wide, 2) if wide else place
            away = np.hypot(*point) + rng.normal(0.0, NOISE)
            azimuth = np.arctan2(*point) + rng.normal(0.0, AZIMUTH_NOISE)
            x, y = away * np.sin(azimuth), away * np.cos(azimuth)
            rows.append((float(moment), float(x), float(y), name))
    return rows


def _polar(reports: pl.DataFrame) -> pl.DataFrame:
    away = (pl.col("x") ** 2 + pl.col("y") ** 2).sqrt().alias("range_m")
    azimuth = pl.arctan2("x", "y").degrees().mod(360.0).alias("azimuth_deg")
    return reports.select("time", away, azimuth, "target")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=4)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--wide", type=float, default=0.0, help="boats [m]")
    parser.add_argument("--berths", type=float, default=3000.0, help="how far they are [m]")
    told = parser.parse_args()
    lines = []
    for seed in range(told.first, told.first + told.seeds):
        plane = harbour(np.random.default_rng(seed), wide=told.wide, berths=told.berths)
        for name, reports, known in (
            ("x, y", plane, {}),
            ("range, azimuth", _polar(plane), POLAR),
        ):
            begun = time.process_time()
            result = track(reports.drop("target"), known)
            spent = time.process_time() - begun
            whose = reports["target"].to_list()
            found = result.assignments["track"].fill_null(-1).to_numpy()
            is_false = np.array([each == "" for each in whose])
            lines.append([
                name, seed, f"{assignment_quality(whose, found).idf1:.3f}",
                f"{np.count_nonzero(found[is_false] >= 0)} of {is_false.sum()}",
                np.count_nonzero(found[~is_false] < 0),
                np.unique(found[found >= 0]).size, f"{spent:.0f}",
            ])  # fmt: skip
    print(heading(command("sea_clutter.py")), end="\n\n")
    print(table(HEAD, lines))


if __name__ == "__main__":
    main()
