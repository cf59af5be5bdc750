"""Scenes of what changes at once or was never set right, and of reports of unequal worth."""

import numpy as np
import polars as pl
from invented_scenes import NOBODY
from invented_sea import azimuth_of, by_time, unit

DAY = 86_400.0
PLACES = {"west": (0.0, 0.0), "east": (45e3, 5e3)}
PERIOD = {"west": 5.0, "east": 6.0}
MINUTES = 12


def drifters(rng: np.random.Generator) -> pl.DataFrame:
    """Return fixes of six drifters hundreds of kilometres apart that tell their own noise."""
    rows = []
    for one in range(6):
        start, drift = rng.uniform(-5e5, 5e5, 2), rng.normal([0.12, 0.0], 0.06)
        turn, time = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.0, 7200.0)
        while time < 20.0 * DAY:
            # A current of 0.2 m/s that goes round in 17 hours.
            angle = turn + 2.0 * np.pi * time / 61_200.0
            place = start + drift * time + 1950.0 * np.array([np.sin(angle), np.cos(angle)])
            sigma = rng.choice([150.0, 350.0, 1000.0, 3000.0], p=[0.3, 0.3, 0.3, 0.1])
            rows.append((round(time), *(place + rng.normal(0.0, sigma, 2)), sigma, sigma, one))
            time += rng.uniform(1.0, 5.0) * 3600.0
    frame = by_time(rows, ["time", "x", "y", "sigma_x", "sigma_y", "target"])
    return frame.with_columns(pl.format("o{}", "target").alias("target"))


def acoustic(rng: np.random.Generator) -> pl.DataFrame:
    """Return where twelve named tags in a lake are, one time in twenty by an echo."""
    rows = []
    for one in range(12):
        place, course, time = (
            rng.uniform(-200.0, 200.0, 2),
            rng.uniform(0, 360),
            rng.uniform(0, 30),
        )
        while time < 7200.0:
            wait = rng.uniform(20.0, 40.0)
            course += rng.normal(0.0, 25.0) + 180.0 * (np.abs(place).max() > 250.0)
            place = np.clip(place + 0.5 * wait * unit(np.array([course]))[0], -260.0, 260.0)
            time += wait
            sigma = 60.0 if rng.random() < 0.05 else 2.0
            rows.append((time, *(place + rng.normal(0.0, sigma, 2)), f"T{one}", f"o{one}"))
    return by_time(rows, ["time", "x", "y", "identity", "target"])


def balloons(rng: np.random.Generator) -> pl.DataFrame:
    """Return the way of eight balloons that rise in the wind, burst and fall."""
    rows = []
    for one in range(8):
        place = np.array([*rng.uniform(-8e4, 8e4, 2), 9000.0 + rng.uniform(0.0, 3000.0)])
        time, burst = rng.uniform(0.0, 600.0), rng.uniform(15e3, 21e3)
        falls = False
        while place[2] > 100.0:
            falls = falls or place[2] > burst
            up = -(6.0 + 44.0 * place[2] / 20e3) if falls else 5.0
            place = place + 10.0 * np.array([14.0, 3.0, up]) + rng.normal(0.0, 4.0, 3)
            time += 10.0
            if rng.random() < 0.9:
                rows.append((time, *(place + rng.normal(0.0, 8.0, 3)), f"o{one}"))
    return by_time(rows, ["time", "x", "y", "z", "target"])


def two_radars(
    rng: np.random.Generator, turned: float, later: float = 0.0, n_aircraft: int = 14
) -> pl.DataFrame:
    """Return what two radars see of aircraft, one turned by so many degrees, from half time more.

    Ranges are on the ground, and none tells a height.
    """
    start, speed = rng.uniform(-5e4, 8e4, (n_aircraft, 2)), rng.uniform(150, 240, (n_aircraft, 1))
    way, rows, half = speed * unit(rng.uniform(0, 360, n_aircraft)), [], 30.0 * MINUTES
    for name, place in PLACES.items():
        for turn in range(int(60.0 * MINUTES / PERIOD[name])):
            time = np.full(n_aircraft, turn * PERIOD[name])
            for _ in range(4):
                away = start + time[:, None] * way - place
                azimuth = azimuth_of(away) % 360.0
                time = (turn + azimuth / 360.0) * PERIOD[name]
            far, off = (
                np.hypot(*away.T),
                turned * (name == "east") + rng.normal(0, 0.08, time.size),
            )
            for one in np.flatnonzero((far < 1.2e5) & (rng.random(n_aircraft) < 0.92)):
                also = later * (name == "east" and time[one] >= half)
                told = far[one] + rng.normal(0, 50.0), (azimuth[one] + off[one] + also) % 360.0
                rows.append((round(time[one], 3), name, *told, f"o{one}"))
            for azimuth_deg in rng.uniform(0.0, 360.0, rng.poisson(4)):
                when = (turn + azimuth_deg / 360.0) * PERIOD[name]
                rows.append((when, name, 1.2e5 * np.sqrt(rng.random()), azimuth_deg, NOBODY))
    return by_time(rows, ["time", "sensor", "range_m", "azimuth_deg", "target"])


def magnetic(rng: np.random.Generator) -> pl.DataFrame:
    """Return the same with a radar that counts from the needle's north."""
    return two_radars(rng, turned=5.0)


def serviced(rng: np.random.Generator) -> pl.DataFrame:
    """Return the same with a radar that is set otherwise from half time on."""
    return two_radars(rng, turned=0.0, later=0.8)


RADARS = {name: {"position": [*place]} for name, place in PLACES.items()}
CHANGES = {
    "drifters": (drifters, {}),
    "acoustic": (acoustic, {}),
    "balloons": (balloons, {}),
    "magnetic": (magnetic, RADARS),
    "serviced": (serviced, RADARS),
}
