"""Scenes of what keeps together, stops together or hides: formations, a lift, folds."""

import numpy as np
import polars as pl
from invented_scenes import NOBODY
from invented_sea import azimuth_of, by_time, unit


def formations(rng: np.random.Generator) -> pl.DataFrame:
    """Return what a radar of 4 s sees of two formations of four that join and part again."""
    aside, rows = np.array([(0, 0), (-180, 120), (-180, -120), (-360, 0)], dtype=float), []
    for turn in range(90):
        time = 4.0 * turn
        apart = np.interp(time, [60, 190, 250, 360], [4000, 360, 360, 3100])
        for flight in range(8):
            place = aside[flight % 4] + (200 * time - 38e3, 30e3 + (flight // 4 - 0.5) * apart)
            place = place + 12 * np.sin(0.05 * time + flight)
            late = azimuth_of(place) % 360 / 90
            if rng.random() < 0.9:
                place = place + late * np.array([200.0, 0.0])
                rows.append(_plot(rng, time + late, place, 30, 0.05, flight))
        for degrees in rng.uniform(0, 360, rng.poisson(8)):
            away = 60e3 * np.sqrt(rng.random())
            rows.append((round(time + degrees / 90, 2), away, degrees, NOBODY))
    return by_time(rows, ["time", "range_m", "azimuth_deg", "target"])


def lift(rng: np.random.Generator) -> pl.DataFrame:
    """Return a picture every two seconds of the cabins of a lift that stops twice."""
    rows, moved, speed = [], 0.0, 6.0
    for time in 2.0 * np.arange(150):
        for _ in range(20):
            stands = 100 < time < 130 or 210 < time < 226
            speed += float(np.clip((0.0 if stands else 6.0) - speed, -0.12, 0.08))
            moved += 0.1 * speed
        cabins = np.arange(np.floor(-moved / 45), (800 - moved) / 45)
        for side in (1, -1):
            along = moved + 45 * cabins + 5 * (1 - side)
            here = (along >= 0) & (along <= 800) & (rng.random(along.size) < 0.9)
            for x, cabin in zip(along[here], cabins[here], strict=True):
                place = rng.normal([x if side > 0 else 800 - x, 3 * side], 0.8)
                rows.append((time, *place, f"{side * (cabin + 1000):.0f}"))
        rows += [
            (time, *rng.uniform((0, -20), (800, 20)), NOBODY) for _ in range(rng.poisson(0.7))
        ]
    return by_time(rows, ["time", "x", "y", "target"])


def folded(rng: np.random.Generator) -> pl.DataFrame:
    """Return a look a second at aircraft and cars, whose range rates fold at 30 m/s."""
    speed, rows = np.r_[rng.uniform(40, 90, 6), rng.uniform(15, 25, 4)][:, None], []
    place, way = (
        rng.uniform(4e3, 12e3, (10, 1)) * unit(rng.uniform(0, 360, 10)),
        speed * unit(rng.uniform(0, 360, 10)),
    )
    for time in np.arange(150.0):
        way = way + rng.normal(0, 0.4, (10, 2))
        place = place + way
        distance = np.hypot(*place.T)
        rate = (np.sum(place * way, axis=1) / distance + 30) % 60 - 30 + rng.normal(0, 0.5, 10)
        for one in np.flatnonzero(rng.random(10) < 0.9):
            plot = _plot(rng, time, place[one], 15, 0.3, one)
            rows.append((*plot[:3], round(rate[one], 1), plot[3]))
        for _ in range(rng.poisson(10)):
            seen = 15e3 * np.sqrt(rng.random()), rng.uniform(0, 360), rng.uniform(-30, 30)
            rows.append((time, *seen, NOBODY))
    return by_time(rows, ["time", "range_m", "azimuth_deg", "range_rate_mps", "target"])


def _plot(  # noqa: PLR0913 a plot is all of these
    rng: np.random.Generator,
    time: float,
    place: np.ndarray,
    sigma: float,
    degrees: float,
    one: int,
) -> tuple:
    """Return time, range, azimuth and object of a plot."""
    azimuth = float(azimuth_of(place) + rng.normal(0, degrees)) % 360
    return (
        round(float(time), 2),
        float(np.hypot(*place) + rng.normal(0, sigma)),
        azimuth,
        f"o{one}",
    )


TOGETHER = {
    "formations": (formations, {"default": {"scan_period": 4.0}}),
    "lift": (lift, {}),
    "folded": (folded, {}),
}
