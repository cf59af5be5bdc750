"""Scenes of those that report themselves: beside a radar, in rooms, and under changing names."""

import numpy as np
import polars as pl
from invented_scenes import NOBODY
from invented_sea import azimuth_of, by_time, unit

MINUTES, PERIOD = 6, 4.0
RADAR = {"position": [0.0, 0.0]}
# What is wrong with the radar: ranges [m], azimuths [degrees], times [s].
LONG, TURNED, LATE = 100.0, 0.25, 0.8


def receiver(rng: np.random.Generator) -> pl.DataFrame:
    """Return a biased radar's plots of forty aircraft, and what thirty of them say a second."""
    start, angle = rng.uniform(-8e4, 8e4, (40, 2)), rng.uniform(0, 360, 40)
    speed = np.r_[rng.uniform(90, 240, 30), rng.uniform(25, 60, 10)]
    height, way = rng.uniform(300, 9000, 40), speed[:, None] * unit(angle)
    rows = []
    for turn in range(int(60 * MINUTES / PERIOD)):
        time = np.full(40, turn * PERIOD)
        for _ in range(4):
            place = start + time[:, None] * way
            azimuth = azimuth_of(place) % 360
            time = (turn + azimuth / 360) * PERIOD
        slant = np.hypot(np.hypot(*place.T), height)
        for one in np.flatnonzero((rng.random(40) < 0.88) & (slant < 1.1e5)):
            told = slant[one] + LONG + rng.normal(0, 45)
            seen = (azimuth[one] + TURNED + rng.normal(0, 0.08)) % 360
            rows.append(
                (time[one] + LATE, "radar", told, seen, None, None, height[one], None, f"o{one}")
            )
        for azimuth_deg in rng.uniform(0, 360, rng.poisson(8)):
            far = 1.1e5 * np.sqrt(rng.random())
            when = (turn + azimuth_deg / 360) * PERIOD + LATE
            rows.append((when, "radar", far, azimuth_deg, None, None, None, None, NOBODY))
    for one in range(30):
        time = rng.uniform(0, 1)
        while time < 60 * MINUTES:
            x, y = start[one] + time * way[one] + rng.normal(0, 15, 2)
            if rng.random() < 0.85:
                rows.append((time, "adsb", None, None, x, y, height[one], f"A{one}", f"o{one}"))
            time += rng.uniform(0.8, 1.2)
    names = ["range_m", "azimuth_deg", "x", "y", "height_m", "identity"]
    return by_time(rows, ["time", "sensor", *names, "target"])


def unnamed(rng: np.random.Generator) -> pl.DataFrame:
    """Return the same where nobody says who it is."""
    return receiver(rng).drop("identity")


def network(rng: np.random.Generator) -> pl.DataFrame:
    """Return what 25 aircraft say every five seconds, nameless, to receivers of unlike clocks."""
    start, way = rng.uniform(-7e4, 7e4, (25, 2)), rng.uniform(90, 240, 25)[:, None]
    way = way * unit(rng.uniform(0, 360, 25))
    late, rows = rng.uniform(0.7, 1.1), []
    for one in range(25):
        time = rng.uniform(0, 5)
        while time < 60 * MINUTES:
            time += rng.uniform(4.8, 5.2)
            place = start[one] + time * way[one] + rng.normal(0, 10, 2)
            # The second tells whole seconds, the third comes late.
            stamps = (round(time, 2), float(np.floor(time)), round(time + late, 2))
            for hears, name, stamp in zip(rng.random(3) < 0.3, "abc", stamps, strict=True):
                if hears:
                    rows.append((stamp, name, *place, f"o{one}"))
    return by_time(rows, ["time", "sensor", "x", "y", "target"])


def rooms(rng: np.random.Generator) -> pl.DataFrame:
    """Return badges, each heard to be in the middle of a room of eight metres, or of the next."""
    rows = []
    for badge in range(9):
        room, time = rng.integers(0, 5, 2), rng.uniform(0, 3)
        while time < 600:
            if rng.random() < 0.08:
                room = np.clip(room + rng.integers(-1, 2, 2), 0, 4)
            told = np.clip(room + rng.integers(-1, 2, 2) * (rng.random(2) < 0.06), 0, 4)
            rows.append((time, *(8.0 * told), f"b{badge}", f"o{badge}"))
            time += rng.uniform(2, 4)
    return by_time(rows, ["time", "x", "y", "identity", "target"])


def pings(rng: np.random.Generator) -> pl.DataFrame:
    """Return tagged fish, heard at up to three of sixteen receivers that tell their own places."""
    east, north = np.meshgrid(500.0 * np.arange(4), 500.0 * np.arange(4))
    station = np.column_stack([east.ravel(), north.ravel()]) + rng.normal(0, 50, (16, 2))
    slow, rows = rng.normal(0, 0.8, 16), []
    for fish in range(12):
        place, velocity, time = rng.uniform(0, 1500, 2), rng.normal(0, 0.3, 2), rng.uniform(0, 90)
        while time < 3 * 3600:
            wait = rng.uniform(60, 120)
            velocity = 0.8 * velocity + rng.normal(0, 0.15, 2)
            place, time = np.clip(place + wait * velocity, -100, 1600), time + wait
            away = np.hypot(*(station - place).T)
            for one in np.flatnonzero(rng.random(16) < 0.95 / (1 + np.exp((away - 380) / 60))):
                heard = np.floor(time + slow[one] + away[one] / 1500)
                rows.append((heard, f"r{one:02d}", *station[one], f"tag{fish}", f"o{fish}"))
    return by_time(rows, ["time", "sensor", "x", "y", "identity", "target"])


def nameless(rng: np.random.Generator) -> pl.DataFrame:
    """Return collars that sleep at one place and roam by day, a quarter of the fixes nameless."""
    rows = []
    for animal in range(8):
        place, time = np.zeros(2), rng.uniform(0, 3600)
        while time < 8 * 86400:
            time += rng.uniform(0.9, 1.1) * 3600
            roams = 6 < time / 3600 % 24 < 19
            place = place + rng.normal(0, 500, 2) if roams else 0.3 * place + rng.normal(0, 80, 2)
            name = f"c{animal}" if rng.random() < 0.75 else None
            rows.append((time, *(place + rng.normal(0, 12, 2)), name, f"o{animal}"))
    return by_time(rows, ["time", "x", "y", "identity", "target"])


def renamed(rng: np.random.Generator) -> pl.DataFrame:
    """Return walkers whose address changes every few minutes, as telephones' do."""
    rows, number = [], 0
    for person in range(12):
        place, goal, until, time = *rng.uniform(0, 120, (2, 2)), -1.0, rng.uniform(0, 4)
        while time < 900:
            if time > until:
                number, until = number + 1, time + rng.uniform(120, 300)
            rows.append((time, *(place + rng.normal(0, 2, 2)), f"n{number}", f"o{person}"))
            wait, left = rng.uniform(2, 6), goal - place
            far = np.hypot(*left)
            place = goal if far < 1.2 * wait else place + 1.2 * wait * left / far
            goal = rng.uniform(0, 120, 2) if far < 1.2 * wait else goal
            time += wait
    return by_time(rows, ["time", "x", "y", "identity", "target"])


NAMED = {
    "receiver": (receiver, {"radar": RADAR}),
    "unnamed": (unnamed, {"radar": RADAR}),
    "network": (network, {}),
    "rooms": (rooms, {}),
    "renamed": (renamed, {}),
    "nameless": (nameless, {}),
    "pings": (pings, {}),
}
