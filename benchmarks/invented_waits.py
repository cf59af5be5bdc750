"""Scenes of what turns back, drives under several radars, waits its turn, or lies at a berth."""

import numpy as np
import polars as pl
from invented_scenes import NOBODY
from invented_sea import by_time

MINUTE = 60.0
# Lanes [m], their speeds [m/s] and how far cars are apart [m]; radars and how far clocks are off.
LANES, SPEEDS, APART = (0.0, 3.6, 8.5, 12.1), (24.0, 32.0, -30.0, -22.0), 70.0
RADARS = {"r1": (100.0, -0.12), "r2": (350.0, 0.2), "r3": (600.0, 0.0)}


def reversals(rng: np.random.Generator) -> pl.DataFrame:
    """Return bacteria under a microscope that glide, and turn back every eight minutes or so."""
    side, count = 250.0, 70
    place = rng.uniform(-30.0, side + 30.0, (count, 2))
    heading, step = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(1.5, 4.5, count)
    step[:12] = 0.05
    rows = []
    for frame in range(120):
        turn = np.where(rng.random(count) < 1 / 8, np.pi, 0.0)
        heading = heading + turn + rng.normal(0.0, 0.12, count)
        place = place + step[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
        place = (place + 40.0) % (side + 80.0) - 40.0
        is_seen = ((place > 0) & (place < side)).all(axis=1) & (rng.random(count) < 0.93)
        for one in np.flatnonzero(is_seen):
            rows.append((frame * MINUTE, *(place[one] + rng.normal(0.0, 0.3, 2)), f"o{one}"))
        for dust in rng.uniform(0.0, side, (rng.poisson(5), 2)):
            rows.append((frame * MINUTE, *dust, NOBODY))
    return by_time(rows, ["time", "x", "y", "target"])


def road(rng: np.random.Generator) -> pl.DataFrame:
    """Return cars on four lanes that brake, under three roadside radars whose clocks differ."""
    cars = [
        [f"o{lane}-{k}", lane, first + rng.uniform(0, 20), speed * rng.uniform(0.9, 1.1), 0.0]
        for lane, speed in enumerate(SPEEDS)
        for k, first in enumerate(np.arange(-1200.0, 1900.0, APART))
    ]
    rows = []
    for tick in range(400):
        time = 0.1 * tick
        for car in cars:
            if rng.random() < 0.004:
                car[4] = rng.choice([-4.0, 0.0, 2.0])  # brakes, keeps on, or speeds up
            usual, lane = abs(SPEEDS[car[1]]), np.sign(SPEEDS[car[1]])
            speed = np.clip(abs(car[3]) + 0.1 * car[4], 0.3 * usual, 1.15 * usual)
            car[3] = lane * speed
            car[2] += 0.1 * car[3]
        for number, (name, (at, off)) in enumerate(RADARS.items()):
            if tick % 2 != number % 2:
                continue
            stamp = round(time + off + 0.3, 3)
            for label, lane, x, *_ in cars:
                if abs(x - at) < 200.0 and rng.random() < 0.93:
                    seen = np.array([x, LANES[lane]]) + rng.normal(0.0, [0.6, 0.5])
                    rows.append((stamp, name, *seen, label))
            for _ in range(rng.poisson(0.7)):
                false = at + rng.uniform(-200, 200), rng.uniform(-4, 16)
                rows.append((stamp, name, *false, NOBODY))
    return by_time(rows, ["time", "sensor", "x", "y", "target"])


def queue(rng: np.random.Generator) -> pl.DataFrame:
    """Return aircraft that report each second: they taxi, wait at a holding point, take off."""
    rows = []
    for one in range(12):
        wait, time = rng.uniform(100.0, 130.0), MINUTE * one
        begun, spot = time, 20.0 * (one % 3)
        while time < begun + wait + 150.0:
            taxied = min(time - begun, 90.0)
            gone = max(time - begun - 90.0 - wait, 0.0)
            place = np.array(
                [spot - 9.0 * (90.0 - taxied) + 2.0 * gone, min(1.2 * gone**1.5, 4e3)]
            )
            rows.append((time, *(place + rng.normal(0.0, 5.0, 2)), f"o{one}"))
            time += 1.0 + rng.normal(0.0, 0.05)
    return by_time(rows, ["time", "x", "y", "target"])


def berths(rng: np.random.Generator) -> pl.DataFrame:
    """Return ships under way and at berths that a radar sees seldom, with a quay; AIS of both."""
    start, angle = rng.uniform((-3000, 0), (3000, 1500), (10, 2)), rng.uniform(0, 2 * np.pi, 10)
    way = rng.uniform(2, 8, 10)[:, None] * np.stack([np.sin(angle), np.cos(angle)], axis=1)
    start = np.r_[start, np.stack([np.linspace(-1400, 1300, 6), np.full(6, -380.0)], axis=1)]
    way, pause = np.r_[way, np.zeros((6, 2))], np.r_[np.full(10, 8.0), np.full(6, 120.0)]
    rows = []
    for scan in range(300):
        time = 3.0 * scan
        is_seen = rng.random(16) < np.where(np.arange(16) < 10, 0.9, 0.45)
        for one in np.flatnonzero(is_seen):
            place = start[one] + time * way[one] + rng.normal(0, 14, 2)
            rows.append((time, "radar", *place, f"o{one}"))
        sea = rng.uniform((-3500, -600), (3500, 2200), (rng.poisson(2), 2))
        quay = np.stack([rng.uniform(-1600, 1600, n := rng.poisson(1.2)), np.full(n, -430.0)], 1)
        for false in np.r_[sea, quay + rng.normal(0, 15, quay.shape)]:
            rows.append((time, "radar", *false, NOBODY))
    for one in range(16):
        time = rng.uniform(0, pause[one])
        while time < 900.0:
            place = start[one] + time * way[one] + rng.normal(0, 4, 2)
            rows.append((time + abs(rng.normal(0, 0.4)), "ais", *place, f"o{one}"))
            time += pause[one] + rng.normal(0, 0.2)
    return by_time(rows, ["time", "sensor", "x", "y", "target"])


WAITS = {
    "reversals": (reversals, {}),
    "road": (road, {}),
    "queue": (queue, {}),
    "berths": (berths, {}),
}
