"""Scenes on the ground: one-way traffic, fixed clutter, radars told wrongly or not at all."""

import numpy as np
import polars as pl
from invented_scenes import NOBODY
from invented_sea import azimuth_of, unit

STOPS = (60.0, 130.0), 10.0
"""When a belt stops [s], and for how long."""


def traffic(rng: np.random.Generator) -> pl.DataFrame:
    """Return a picture every two seconds of two lanes, some false alarms beside."""
    cars = [
        (begun, 3.7 * lane, speed + rng.normal(0, 1))
        for lane, speed in enumerate((24.0, 30.0))
        for begun in -30.0 + np.cumsum(rng.uniform(1.4, 4.5, 90))
    ]
    rows = []
    for time in np.arange(0.0, 240.0, 2.0):
        for number, (begun, across, speed) in enumerate(cars):
            along = (time - begun) * speed
            if 0 <= along <= 600 and rng.random() < 0.93:
                place = np.array([along, across]) + rng.normal(0, (1.5, 0.5))
                rows.append((time, *place, f"o{number}"))
        rows += [(time, *rng.uniform((0, -3), (600, 7)), NOBODY) for _ in range(rng.poisson(0.3))]
    return _table(rows, ["x", "y"])


def belt(rng: np.random.Generator) -> pl.DataFrame:
    """Return a picture a second of parcels on a belt of 0.9 m/s that stops twice."""
    start, across = -np.cumsum(rng.uniform(0.45, 1.5, 230)), rng.uniform(0.15, 0.65, 230)
    rows, moved = [], 2.0
    for time in np.arange(0.0, 200.0):
        along = start + moved
        for parcel in np.flatnonzero((along >= 0) & (along <= 7) & (rng.random(230) < 0.96)):
            place = np.array([along[parcel], across[parcel]]) + rng.normal(0, 0.02, 2)
            rows.append((time, *place, f"o{parcel}"))
        begins, lasting = STOPS
        stands = any(begin <= time < begin + lasting for begin in begins)
        moved += 0.0 if stands else 0.9
    return _table(rows, ["x", "y"])


def walkers(rng: np.random.Generator) -> pl.DataFrame:
    """Return what a ground radar sees of people among places that it sees more or less often."""
    fixed = rng.uniform(60, 600, (20, 1)) * unit(rng.uniform(-50, 50, 20))
    share, at = rng.uniform(0.3, 0.95, 20), rng.uniform((-150, 150), (150, 450), (8, 2))
    heading, rows = rng.uniform(0, 360, 8), []
    for time in 2.5 * np.arange(100.0):
        heading += rng.normal(0, 8, 8)
        at = at + 3.0 * unit(heading)
        seen = np.flatnonzero(rng.random(8) < 0.85)
        names = [f"o{number}" for number in seen]
        echoes = fixed[rng.random(20) < share]
        places = np.concatenate([at[seen], echoes])
        for name, place in zip([*names, *([NOBODY] * len(echoes))], places, strict=True):
            rows.append((time, *_measured(rng, place, 1.5, 0.5), name))
    return _table(rows, ["range_m", "azimuth_deg"])


def gears(rng: np.random.Generator) -> pl.DataFrame:
    """Return what a ship's radar sees of boats, its turn 2.5 s, then 5 s, then 2.5 s."""
    place, way = rng.uniform(-3e3, 3e3, (10, 2)), rng.uniform(3, 13, (10, 1))
    way, rows, time = way * unit(rng.uniform(0, 360, 10)), [], 0.0
    while time < 480:
        period = 5.0 if 150 < time < 330 else 2.5
        when = np.full(10, time)
        for _ in range(3):
            azimuth = azimuth_of(place + when[:, None] * way) % 360
            when = time + period * azimuth / 360
        for boat in np.flatnonzero(rng.random(10) < 0.88):
            there = place[boat] + when[boat] * way[boat]
            rows.append((when[boat], *_measured(rng, there, 8.0, 0.5), f"o{boat}"))
        for azimuth in rng.uniform(0, 360, rng.poisson(2)):
            away = 6e3 * np.sqrt(rng.random())
            rows.append((time + period * azimuth / 360, away, azimuth, NOBODY))
        time += period
    return _table(rows, ["range_m", "azimuth_deg"])


def shore(rng: np.random.Generator) -> pl.DataFrame:
    """Return what two shore radars see of ships, of which one is told to stand 2.5 km off."""
    place, way = rng.uniform((-4e3, 0), (13e3, 12e3), (14, 2)), rng.uniform(3, 11, (14, 1))
    way, rows = way * unit(rng.uniform(0, 360, 14)), []
    for name, site, period in (("a", (0.0, 0.0), 3.0), ("b", (9e3, 1e3), 4.0)):
        for turn in range(int(300 / period)):
            for ship in np.flatnonzero(rng.random(14) < 0.9):
                time = turn * period
                for _ in range(3):
                    away = place[ship] + time * way[ship] - site
                    time = (turn + float(azimuth_of(away)) % 360 / 360) * period
                rows.append((time, name, *_measured(rng, away, 15.0, 0.3), f"o{ship}"))
    return _table(rows, ["sensor", "range_m", "azimuth_deg"])


def chart(rng: np.random.Generator) -> pl.DataFrame:
    """Return where a ship's radar puts twenty others, 2.5 s a turn, in stamps of whole seconds."""
    place, way = rng.uniform(-7e3, 7e3, (20, 2)), rng.uniform(4, 12, (20, 1))
    way = way * unit(rng.uniform(0, 360, 20))
    rows = _turned(rng, (place, way, 600.0), (2.5, 12e3, 3.0), (10.0, 0.3))
    return _table([(float(int(row[0])), *row[1:]) for row in rows], ["x", "y"])


def plan(rng: np.random.Generator) -> pl.DataFrame:
    """Return where two radars put forty aircraft, on a plane that counts from elsewhere."""
    place, way = rng.uniform(-9e4, 9e4, (40, 2)), rng.uniform(80, 250, (40, 1))
    way, rows = way * unit(rng.uniform(0, 360, 40)), []
    for name, east, north, period in (("a", -3e4, 2e4, 4.0), ("b", 5e4, -1e4, 8.0)):
        seen = (place - (east, north), way, 300.0)
        for time, x, y, target in _turned(rng, seen, (period, 1.2e5, 8.0), (50.0, 0.07)):
            rows.append((time, name, 4e5 + east + x, 5e6 + north + y, target))
    return _table(rows, ["sensor", "x", "y"])


def _turned(
    rng: np.random.Generator,
    objects: tuple[np.ndarray, np.ndarray, float],
    beam: tuple[float, float, float],
    noise: tuple[float, float],
) -> list[tuple]:
    """Return time, x, y and object of what a beam saw of objects, and of false alarms."""
    (place, way, lasting), (period, reach, n_false), rows = objects, beam, []
    for turn in range(int(lasting / period)):
        time = np.full(len(place), turn * period)
        for _ in range(3):
            azimuth = azimuth_of(place + time[:, None] * way) % 360
            time = (turn + azimuth / 360) * period
        there = place + time[:, None] * way
        for one in np.flatnonzero((rng.random(len(place)) < 0.9) & (np.hypot(*there.T) < reach)):
            distance, degrees = _measured(rng, there[one], *noise)
            rows.append((time[one], *(distance * unit(degrees)), f"o{one}"))
        for degrees in rng.uniform(0, 360, rng.poisson(n_false)):
            away = reach * np.sqrt(rng.random()) * unit(degrees)
            rows.append(((turn + degrees / 360) * period, *away, NOBODY))
    return rows


def _measured(
    rng: np.random.Generator, away: np.ndarray, sigma: float, degrees: float
) -> tuple[float, float]:
    """Return a range and an azimuth with their noise."""
    azimuth = (float(azimuth_of(away)) + rng.normal(0, degrees)) % 360
    return float(np.hypot(*away)) + rng.normal(0, sigma), azimuth


def _table(rows: list[tuple], names: list[str]) -> pl.DataFrame:
    columns = ["time", *names, "target"]
    return pl.DataFrame(rows, schema=columns, orient="row").sort("time", maintain_order=True)


AT = {"position": [0.0, 0.0]}
GROUND = {
    "traffic": (traffic, {}),
    "belt": (belt, {}),
    "walkers": (walkers, {"default": AT}),
    "gears": (gears, {"default": AT}),
    "chart": (chart, {"default": AT | {"scan_period": 2.5}}),
    "plan": (plan, {}),
    "shore": (shore, {"a": AT, "b": {"position": [10.8e3, -0.8e3]}}),
}
