"""An airport under one radar: arrivals vanish at the runway, departures appear beyond it."""

from collections.abc import Callable, Iterator

import numpy as np
import polars as pl

Array = np.ndarray
PERIOD, RANGE_NOISE, AZIMUTH_NOISE, SEEN = 4.0, 50.0, np.radians(0.08), 0.93
FALSE = 2.0  # False alarms a turn
PAIRS, OVERFLIGHTS = 14, 10
THRESHOLD, RUNWAY, HEADING = np.array([25e3, 18e3]), 2500.0, np.radians(250.0)
AHEAD = np.array([np.sin(HEADING), np.cos(HEADING)])


def airport(rng: np.random.Generator) -> pl.DataFrame:
    """Return reports of a radar in the middle, false ones of nobody, by time."""
    rows = []
    for name, first, last, place in _flights(rng):
        for turn in np.arange(first + rng.uniform(0.0, PERIOD), last, PERIOD):
            x, y = place(turn)
            azimuth = np.arctan2(x, y)
            time = turn - (turn - azimuth / (2 * np.pi) * PERIOD) % PERIOD
            if rng.random() < SEEN:
                azimuth += AZIMUTH_NOISE * rng.normal()
                away = np.hypot(x, y) + RANGE_NOISE * rng.normal()
                rows.append((time, away * np.sin(azimuth), away * np.cos(azimuth), name))
    for time in np.arange(0.0, max(rows)[0], PERIOD):
        for _ in range(rng.poisson(FALSE)):
            away, azimuth = rng.uniform(0.0, 80e3), rng.uniform(0.0, 2 * np.pi)
            late = azimuth / (2 * np.pi) * PERIOD
            rows.append((time + late, away * np.sin(azimuth), away * np.cos(azimuth), ""))
    return pl.DataFrame(sorted(rows), ["time", "x", "y", "target"], orient="row")


def _flights(
    rng: np.random.Generator,
) -> Iterator[tuple[str, float, float, Callable[[float], Array]]]:
    """Yield who flies, from when to when it is seen, and where it is then."""
    lands = 120.0
    for number in range(PAIRS):
        over = lands + rng.uniform(-10.0, 10.0)
        yield f"A{number}", max(0.0, over - 400.0), over - 8.0, _arrival(over, rng)
        lifts = over + rng.uniform(60.0, 200.0)
        yield f"D{number}", lifts + 8.0, lifts + 395.0, _departure(lifts, rng)
        lands += rng.uniform(180.0, 260.0)
    for number in range(OVERFLIGHTS):
        middle, heading = rng.uniform(-60e3, 60e3, 2), rng.uniform(0.0, 2 * np.pi)
        velocity = rng.uniform(180.0, 240.0) * np.array([np.sin(heading), np.cos(heading)])
        first = rng.uniform(0.0, lands - 400.0)

        yield f"O{number}", first, first + 600.0, _straight(middle, velocity, first + 300.0)


def _straight(middle: Array, velocity: Array, when: float) -> Callable[[float], Array]:
    return lambda time: np.asarray(middle + velocity * (time - when))


def _arrival(over: float, rng: np.random.Generator) -> Callable[[float], Array]:
    slow, fast, braking = rng.normal(75.0, 3.0), 160.0, 0.35

    def place(time: float) -> Array:
        left = over - time
        slows = min(left, (fast - slow) / braking)
        way = slow * slows + 0.5 * braking * slows**2 + fast * (left - slows)
        return np.asarray(THRESHOLD - AHEAD * way)

    return place


def _departure(lifts: float, rng: np.random.Generator) -> Callable[[float], Array]:
    seconds = np.arange(400.0)
    speed = np.minimum(rng.normal(85.0, 3.0) + 0.6 * seconds, 190.0)
    turn = rng.choice([-1.0, 1.0]) * np.radians(rng.uniform(0.5, 1.5))
    heading = HEADING + turn * np.clip(seconds - 60.0, 0.0, 40.0)
    velocity = speed[:, None] * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    path = THRESHOLD + AHEAD * RUNWAY + np.cumsum(velocity, axis=0)

    def place(time: float) -> Array:
        return np.array([np.interp(time - lifts, seconds, axis) for axis in path.T])

    return place
