"""Scenes of what the sea does to a radar: spikes that last, wind; and bearings of nobody."""

import numpy as np
import polars as pl
from invented_scenes import NOBODY

N_OBJECTS, PERIOD, TURNS = 14, 2.5, 110


def unit(degrees: float | np.ndarray) -> np.ndarray:
    """Return the direction of each azimuth, shape (..., 2)."""
    return np.stack([np.sin(np.radians(degrees)), np.cos(np.radians(degrees))], axis=-1)


def azimuth_of(place: np.ndarray) -> np.ndarray:
    """Return the azimuth of each place, in degrees."""
    return np.degrees(np.arctan2(place[..., 0], place[..., 1]))


def sea(rng: np.random.Generator) -> pl.DataFrame:
    """Return what a radar on a coast sees: ships, boats at anchor, and spikes that last."""
    place = rng.uniform(700, 5000, (N_OBJECTS, 1)) * unit(rng.uniform(190, 350, N_OBJECTS))
    speed = np.r_[rng.uniform(3, 16, 8), np.zeros(N_OBJECTS - 8)][:, None]
    way = speed * unit(rng.uniform(0, 360, N_OBJECTS))
    chance, lasting = rng.uniform(0.7, 0.97, N_OBJECTS), rng.uniform(0.3, 0.5)
    rows, spikes = [], np.empty((0, 2))
    for turn in range(TURNS):
        spikes = spikes[rng.uniform(size=len(spikes)) < lasting]
        count = rng.poisson(18)
        reach, towards = 150 + rng.exponential(1200, (count, 1)), rng.normal(270, 35, count)
        spikes = np.concatenate([spikes, reach * unit(towards)])
        seen = np.flatnonzero(rng.uniform(size=N_OBJECTS) < chance)
        names = [*(f"o{number}" for number in seen), *([NOBODY] * len(spikes))]
        there = np.concatenate([(place + turn * PERIOD * way)[seen], spikes])
        for name, at in zip(names, there, strict=True):
            azimuth = (float(azimuth_of(at)) + rng.normal(0, 0.5)) % 360
            away = float(np.hypot(*at)) + rng.normal(0, 12)
            rows.append((PERIOD * (turn + azimuth / 360), "coast", away, azimuth, name))
    return by_time(rows, ["time", "sensor", "range_m", "azimuth_deg", "target"])


def wind(rng: np.random.Generator) -> pl.DataFrame:
    """Return what a radar sees whose antenna the wind turns, by 5 % from turn to turn."""
    place = rng.uniform(2e3, 9e3, (20, 1)) * unit(rng.uniform(0, 360, 20))
    way = rng.uniform(4, 14, (20, 1)) * unit(rng.uniform(0, 360, 20))
    bend = rng.uniform(-0.3, 0.3, 20)
    rows, begin = [], 0.0
    while begin < 600.0:
        length = 3.0 * (1.0 + 0.05 * rng.normal())
        seen = np.flatnonzero(rng.random(20) < 0.9)
        count = rng.poisson(15)
        nobody = 12e3 * np.sqrt(rng.random((count, 1))) * unit(rng.uniform(0, 360, count))
        names = [*(f"o{number}" for number in seen), *([NOBODY] * count)]
        for name, at in zip(names, np.concatenate([place[seen], nobody]), strict=True):
            azimuth = float(azimuth_of(at)) % 360
            told = np.hypot(*at) + rng.normal(0, 15), (azimuth + rng.normal(0, 0.35)) % 360
            rows.append((begin + length * azimuth / 360, *told, name))
        place, begin = place + length * way, begin + length
        turned = np.radians(bend * length)[:, None]
        way = np.cos(turned) * way + np.sin(turned) * way[:, ::-1] * [1.0, -1.0]
    return by_time(rows, ["time", "range_m", "azimuth_deg", "target"])


def buoys(rng: np.random.Generator) -> pl.DataFrame:
    """Return the bearings of four stations, of ships and of nobody, a third of them."""
    places = 5000.0 * unit(np.array([0, 90, 180, 270]) + rng.normal(0, 10, 4))
    place, noise = rng.uniform(-4000, 4000, (4, 2)), rng.uniform(0.7, 1.8)
    way = rng.uniform(1, 7, (4, 1)) * unit(rng.uniform(0, 360, 4))
    looks = [
        (float(second), number, second + 1.3 * number)
        for second in range(0, 1200, 6)
        for number in range(4)
    ]
    return _bearings(rng, places, (place, way), looks, (0.85, noise, 1.7))


def stations(rng: np.random.Generator) -> pl.DataFrame:
    """Return the bearings of three stations 150 km apart, of aircraft and of nobody."""
    places = np.array([[0.0, 0.0], [150e3, 10e3], [70e3, 120e3]])
    place, noise = rng.uniform(0, 150e3, (6, 2)), rng.uniform(0.05, 0.3)
    way = rng.uniform(150, 250, (6, 1)) * unit(rng.uniform(0, 360, 6))
    looks = [
        (float(second), number, float(second))
        for second in range(0, 360, 5)
        for number in range(3)
    ]
    return _bearings(rng, places, (place, way), looks, (0.9, noise, 1.0))


def _bearings(
    rng: np.random.Generator,
    places: np.ndarray,
    objects: tuple[np.ndarray, np.ndarray],
    looks: list[tuple[float, int, float]],
    seen_as: tuple[float, float, float],
) -> pl.DataFrame:
    """Return what stations report of objects that move straight on, and of nobody."""
    # Each look is when objects are where they are, whose it is, and when it is told;
    # ``seen_as`` are the chance of detection, the noise in degrees, and false bearings a look.
    (place, way), (chance, noise, n_false), rows = objects, seen_as, []
    for second, number, told in looks:
        seen = np.flatnonzero(rng.uniform(size=len(place)) < chance)
        angles = azimuth_of(place[seen] + second * way[seen] - places[number])
        angles += rng.normal(0, noise, seen.size)
        false = rng.uniform(0, 360, rng.poisson(n_false))
        names = [*(f"o{each}" for each in seen), *([NOBODY] * false.size)]
        for name, angle in zip(names, [*angles, *false], strict=True):
            rows.append((told, f"b{number}", angle % 360, *places[number], name))
    return by_time(rows, ["time", "sensor", "bearing_deg", "sensor_x", "sensor_y", "target"])


def by_time(rows: list[tuple], names: list[str]) -> pl.DataFrame:
    """Return rows as a table in order of time."""
    table = pl.DataFrame(rows, schema=names, orient="row", infer_schema_length=None)
    return table.sort("time", maintain_order=True)


SEA = {
    "sea": (sea, {"coast": {"position": [0.0, 0.0]}}),
    "wind": (wind, {"default": {"position": [0.0, 0.0]}}),
    "buoys": (buoys, {}),
    "stations": (stations, {}),
}
