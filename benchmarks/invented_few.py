"""Scenes of one that turns among few that do not, and of what receivers and networks repeat."""

import numpy as np
import polars as pl
from invented_sea import by_time

TURN, LOOK = 4.0, 10.0


def circuits(rng: np.random.Generator, *, n_straight: int = 4) -> pl.DataFrame:
    """Return what a radar sees of airliners that fly straight, and of a trainer in circuits."""
    rows = []
    for one in range(n_straight + 1):
        place, heading = rng.uniform(-2.5e4, 2.5e4, 2), rng.uniform(0.0, 2.0 * np.pi)
        speed = rng.uniform(150.0, 250.0) if one < n_straight else 105.0
        rate, wait, ways = 0.0, rng.uniform(60.0, 300.0), []
        for _ in range(680):
            wait -= 1.0
            if one == n_straight and wait < 0.0:
                rate = 0.0 if rate else np.radians(rng.uniform(1.5, 3.0))
                wait = np.radians(90.0) / rate if rate else rng.uniform(20.0, 90.0)
            heading += rate
            place = place + speed * np.array([np.sin(heading), np.cos(heading)])
            ways.append(place)
        for turn in range(160):
            time = TURN * turn
            for _ in range(3):
                east, north = ways[int(time)] + (time % 1.0) * (
                    ways[int(time) + 1] - ways[int(time)]
                )
                azimuth = np.degrees(np.arctan2(east, north)) % 360.0
                time = TURN * (turn + azimuth / 360.0)
            seen = np.hypot(east, north) + rng.normal(0.0, 15.0), azimuth + rng.normal(0.0, 0.03)
            if rng.random() < 0.97:
                rows.append((round(time, 3), seen[0], seen[1] % 360.0, f"o{one}"))
    return by_time(rows, ["time", "range_m", "azimuth_deg", "target"])


def twice(rng: np.random.Generator) -> pl.DataFrame:
    """Return the same of fourteen airliners, a fifth of which a second network brings again."""
    frame = circuits(rng, n_straight=14)
    again = frame.filter(pl.Series(rng.random(frame.height) < 0.2))
    later = pl.Series(rng.uniform(0.001, 0.3, again.height))
    both = pl.concat([frame, again.with_columns((pl.col("time") + later).round(3))])
    return both.sort("time", maintain_order=True)


def vectors(rng: np.random.Generator) -> pl.DataFrame:
    """Return state vectors of aircraft, whose last places are said on for up to five minutes."""
    rows = []
    for one in range(60):
        place, course = rng.uniform(-1.5e5, 1.5e5, 2), rng.uniform(0.0, 2.0 * np.pi)
        way = rng.uniform(60.0, 230.0) * np.array([np.cos(course), np.sin(course)])
        first = rng.integers(0, 60)
        silent = rng.integers(30, 90) if rng.random() < 0.4 else 10**6
        back = silent + rng.integers(10, 30)
        for look in range(first, min(first + 120, 150)):
            if look < silent or look > back:
                said = place + way * LOOK * look + rng.normal(0.0, 60.0, 2)
            rows.append((LOOK * look, *np.round(said[::-1] / 111e3 + [51.0, 0.0], 6), f"o{one}"))
    return by_time(rows, ["time", "lat", "lon", "target"])


RADAR = {"default": {"position": [0.0, 0.0], "scan_period": TURN}}
FEW = {
    "circuits": (circuits, RADAR),
    "twice": (twice, RADAR),
    "vectors": (vectors, {}),
}
