"""Scenes invented by somebody who had not seen the tracker, each with a trait of real sensors."""

from collections.abc import Callable

import numpy as np
import polars as pl

Array = np.ndarray
Ways = dict[str, tuple[Callable[[float], Array], float, float]]
"""Where each object is at a time, and from when to when it is there [s]."""
NOBODY = ""


def collars(rng: np.random.Generator) -> pl.DataFrame:
    """Return a day of 25 animals in one herd, a fix every ten minutes under each one's name."""
    rows, animals, moments = [], 25, np.arange(0.0, 86400.0, 600.0)
    herd, heading = np.zeros(2), rng.uniform(0.0, 2 * np.pi)
    away = rng.normal(0.0, 120.0, (animals, 2))
    late = rng.uniform(0.0, 60.0, animals)
    for moment in moments:
        heading += rng.normal(0.0, 0.6)
        speed = rng.choice([0.0, 0.1, 0.4, 0.9])
        herd = herd + 600.0 * speed * _ahead(heading)
        away = 0.9 * away + rng.normal(0.0, 60.0, away.shape)
        for animal in np.flatnonzero(rng.random(animals) < 0.94):
            x, y = herd + away[animal] + rng.normal(0.0, 8.0, 2)
            time = moment + late[animal] + rng.uniform(0.0, 20.0)
            rows.append((time, x, y, f"tag{animal}", f"tag{animal}"))
    return _table(rows, ["x", "y", "identity"])


def pilots(rng: np.random.Generator) -> pl.DataFrame:
    """Return twelve vessels under their own names; eight turn hard, three lie at anchor."""
    rows = []
    for vessel in range(12):
        place, heading = rng.uniform(-8e3, 8e3, 2), rng.uniform(0.0, 2 * np.pi)
        speed, pace = (0.0, 180.0) if vessel < 3 else (rng.uniform(4.0, 12.0), 10.0)
        turn, until, report = 0.0, 0.0, rng.uniform(0.0, pace)
        silent = rng.uniform(900.0, 1800.0)
        for second in range(3600):
            if second >= until:
                turns = 3 <= vessel < 11 and rng.random() < 0.3
                turn = np.radians(rng.choice([-2.0, 2.0])) if turns else 0.0
                until = second + (rng.uniform(40.0, 150.0) if turns else rng.uniform(60.0, 300.0))
            heading += turn
            place = place + speed * _ahead(heading) + (rng.normal(0.0, 0.3, 2) if not speed else 0)
            if second < report or (vessel in {0, 5} and 0 < second - silent < 860.0):
                continue
            report = second + pace * rng.choice([1.0, 1.0, 1.0, 2.0])
            x, y = place + rng.normal(0.0, 6.0, 2)
            rows.append((float(second), x, y, f"mmsi{vessel}", f"mmsi{vessel}"))
    return _table(rows, ["x", "y", "identity"])


def stacks(rng: np.random.Generator, ways: Ways | None = None) -> pl.DataFrame:
    """Return two stacks of five that hold under a radar of twelve seconds, and who flies over."""
    ways = {} if ways is None else ways
    rows: list[tuple] = []
    for stack in range(2):
        fix, inbound = rng.uniform(30e3, 60e3, 2) * [1, 1 - 2 * stack], rng.uniform(0, 2 * np.pi)
        for level in range(5):
            name, begun = f"h{stack}{level}", rng.uniform(0.0, 240.0)
            speed = rng.uniform(105.0, 120.0)
            path = _racetrack(fix, inbound, speed, begun)
            ways[name] = path, 0.0, 1200.0
            rows += _plots(rng, name, path, (0.0, 1200.0))
    for number in range(6):
        middle, course = rng.uniform(-40e3, 40e3, 2), rng.uniform(0.0, 2 * np.pi)
        velocity, first = rng.uniform(180.0, 240.0) * _ahead(course), rng.uniform(0.0, 600.0)

        def straight(
            time: float, middle: Array = middle, velocity: Array = velocity, first: float = first
        ) -> Array:
            return np.asarray(middle + velocity * (time - first - 250.0))

        ways[f"o{number}"] = straight, first, first + 500.0
        rows += _plots(rng, f"o{number}", straight, (first, first + 500.0))
    for turn in range(100):
        for _ in range(rng.poisson(2.0)):
            azimuth, away = rng.uniform(0.0, 2 * np.pi), rng.uniform(2e3, 110e3)
            rows.append((12.0 * (turn + azimuth / 2 / np.pi), away, np.degrees(azimuth), NOBODY))
    return _table(rows, ["range_m", "azimuth_deg"])


def crossing(rng: np.random.Generator, ways: Ways | None = None) -> pl.DataFrame:
    """Return a lidar's 60 s of a road, ten reports a second: cars in two lanes and on foot."""
    rows, ways = [], {} if ways is None else ways
    for frame in range(600):
        for _ in range(rng.poisson(1.0)):
            rows.append((frame / 10, rng.uniform(-60, 60), rng.uniform(-20, 20), NOBODY))
    for car in range(24):
        lane, first, speed = car % 2, rng.uniform(0.0, 50.0), rng.uniform(8.0, 14.0)
        drive = _drive(car, 1.0 - 2.0 * lane, speed, first)
        ways[f"car{car}"] = drive, first - 0.1, first + 120.0 / speed
        for frame in range(int(first * 10), 600):
            x, y = drive(frame / 10)
            if abs(x) <= 60.0 and rng.random() < 0.9:
                y += rng.normal(0.0, 0.2)
                rows.append((frame / 10, x + rng.normal(0.0, 0.2), y, f"car{car}"))
    for walker in range(8):
        first, x, side = rng.uniform(0.0, 40.0), rng.uniform(-30.0, 30.0), rng.choice([-1, 1])
        walk = _walk(x, side, first)
        ways[f"walker{walker}"] = walk, first - 0.1, first + 25.0
        for frame in range(int(first * 10), min(600, int(first * 10) + 250)):
            if rng.random() < 0.85:
                x, y = walk(frame / 10)
                rows.append((frame / 10, x + rng.normal(0.0, 0.15), y + rng.normal(0.0, 0.15),
                             f"walker{walker}"))  # fmt: skip
    return _table(rows, ["x", "y"])


def drifting_clock(rng: np.random.Generator) -> pl.DataFrame:
    """Return two radars, the second's clock a second late after twenty minutes."""
    rows: list[tuple] = []
    for craft in range(30):
        middle, course = rng.uniform(-50e3, 50e3, 2), rng.uniform(0.0, 2 * np.pi)
        velocity, height = rng.uniform(120.0, 240.0) * _ahead(course), rng.uniform(3e3, 11e3)
        first = rng.uniform(0.0, 700.0)
        for radar, place in (("a", np.array([-20e3, 0.0])), ("b", np.array([20e3, 5e3]))):

            def path(
                time: float, begin: Array = middle - place, velocity: Array = velocity,
                first: float = first, height: float = height,
            ) -> Array:  # fmt: skip
                return np.append(begin + velocity * (time - first - 250.0), height)

            for time, *plot, name in _plots(
                rng, f"c{craft}", path, (first, first + 500.0), period=4.0
            ):
                drift = time / 1200.0 if radar == "b" else 0.0
                rows.append((time + drift, radar, *plot, height, name))
    return _table(rows, ["sensor", "range_m", "azimuth_deg", "height_m"])


def stage_jump(rng: np.random.Generator) -> pl.DataFrame:
    """Return sixty cells a minute apart; at the fortieth of eighty frames the stage jumps."""
    rows = []
    cells, jump = rng.uniform(0.0, 600.0, (60, 2)), np.array([30.0, -18.0])
    velocity = rng.normal(0.0, 0.4, cells.shape)
    for frame in range(80):
        velocity = 0.8 * velocity + rng.normal(0.0, 0.25, cells.shape)
        cells = cells + velocity
        seen = cells + rng.normal(0.0, 0.5, cells.shape) + (jump if frame >= 40 else 0.0)
        for cell in np.flatnonzero(rng.random(60) < 0.95):
            rows.append((60.0 * frame, *seen[cell], f"cell{cell}"))
        for _ in range(rng.poisson(1.0)):
            rows.append((60.0 * frame, *rng.uniform(0.0, 600.0, 2), NOBODY))
    return _table(rows, ["x", "y"])


def drones(rng: np.random.Generator) -> pl.DataFrame:
    """Return three minutes of a radar that sees four drones and six birds in much clutter.

    Drones hover and dart, birds wander at 8 m/s and are seen at three looks of ten.
    """
    rows = []
    for number in range(10):
        is_drone = number < 4
        place = np.array([rng.uniform(-800, 800), rng.uniform(400, 1700), rng.uniform(40, 140)])
        heading, speed, left = rng.uniform(0, 2 * np.pi), 0.0 if is_drone else 8.0, 0
        velocity, seen = np.zeros(3), rng.uniform(0.5, 0.7) if is_drone else 0.3
        for second in range(180):
            left -= 1
            if is_drone and left <= 0:
                heading, speed = rng.uniform(0, 2 * np.pi), (0.0 if speed else rng.uniform(12, 18))
                left = int(rng.integers(10, 30))
            heading += 0.0 if is_drone else rng.normal(0.0, 0.25)
            wanted = speed * np.append(_ahead(heading), 0.0)
            velocity = velocity + np.clip(wanted - velocity, -5.0, 5.0)
            place = place + velocity
            if rng.random() < seen:
                away = float(np.linalg.norm(place))
                angles = np.arctan2(place[0], place[1]), np.arcsin(place[2] / away)
                noise = rng.normal(0.0, (6.0, 0.7, 0.9))
                seen_at = np.array([away, *np.degrees(angles)]) + noise
                seen_at[1:] = seen_at[1] + 360.0 * (seen_at[1] < -180.0), min(seen_at[2], 90.0)
                rows.append((float(second), *seen_at, str(number)))
    for second in range(180):
        for _ in range(rng.poisson(12)):
            away = float(np.sqrt(rng.uniform(100.0**2, 2200.0**2)))
            rows.append((float(second), away, rng.uniform(-60, 60), rng.uniform(0, 15), NOBODY))
    return _table(rows, ["range_m", "azimuth_deg", "elevation_deg"])


def tags(rng: np.random.Generator) -> pl.DataFrame:
    """Return 12 hours of six birds that sit for hours and fly for minutes; 3 % are 1 km off."""
    rows = []
    for bird in range(6):
        place, velocity, left = rng.uniform(-300.0, 300.0, 2), np.zeros(2), 20
        for fix in range(144):
            left -= 1
            if left == 0:
                flies = not velocity.any()
                velocity = 10.0 * flies * _ahead(rng.uniform(0.0, 2 * np.pi))
                left = int(rng.integers(1, 4) if flies else rng.integers(12, 40))
            place = place + 300.0 * velocity
            off = 1000.0 if rng.random() < 0.03 else 8.0
            time = 300.0 * fix + 31.0 * bird + rng.uniform(-10.0, 10.0)
            rows.append((time, *(place + rng.normal(0.0, off, 2)), f"b{bird}", f"b{bird}"))
    return _table(rows, ["x", "y", "identity"])


def hall(rng: np.random.Generator) -> pl.DataFrame:
    """Return four minutes of eight people in a hall, tags that name nobody; a tenth is off."""
    rows = []
    for who in range(8):
        place, goal, rest = rng.uniform(1.0, [29.0, 17.0]), rng.uniform(1.0, [29.0, 17.0]), 0.0
        velocity, time = np.zeros(2), rng.uniform(0.0, 0.5)
        while time < 240.0:
            step = max(rng.normal(0.5, 0.02), 0.3)
            rest -= step
            way = goal - place
            if np.linalg.norm(way) < 0.8:
                goal, rest = rng.uniform(1.0, [29.0, 17.0]), rng.exponential(3.0)
            pace = 0.0 if rest > 0 else 1.3
            velocity += 0.5 * (pace * way / np.linalg.norm(way) - velocity)
            place, time = place + step * velocity, time + step
            # Behind the racks in the middle the way of a signal is longer.
            is_off = rng.random() < (0.25 if 10.0 < place[0] < 18.0 else 0.05)
            off = rng.exponential(1.0) * _ahead(rng.uniform(0.0, 2 * np.pi)) * is_off
            if rng.random() < 0.93:
                rows.append((time, *(place + off + rng.normal(0.0, 0.12, 2)), f"p{who}"))
    return _table(rows, ["x", "y"])


def sector(rng: np.random.Generator) -> pl.DataFrame:
    """Return fifteen minutes of a radar that sweeps 120 degrees in 4 s and flies back; walkers."""
    rows = []
    for who in range(8):
        place = np.array([rng.uniform(-1500.0, 1500.0), rng.uniform(1500.0, 4000.0)])
        heading = rng.uniform(0.0, 2 * np.pi)
        for sweep in range(225):
            heading += rng.normal(0.0, 0.05)
            place = place + 4.0 * 1.4 * _ahead(heading)
            azimuth, reach = float(np.degrees(np.arctan2(*place))), float(np.linalg.norm(place))
            if abs(azimuth) < 60.0 and rng.random() < 0.85 * min(1.0, 1.4 - reach / 6000.0):
                time = 4.0 * sweep + 0.1 + 3.6 * (azimuth + 60.0) / 120.0
                rows.append((time, reach, azimuth, f"w{who}"))
    for time in rng.uniform(0.0, 900.0, 900):
        if time % 4.0 < 3.6:
            rows.append(
                (time, rng.uniform(300.0, 5000.0), 120.0 * (time % 4.0) / 3.6 - 60.0, NOBODY)
            )
    rows = [
        (time, reach + rng.normal(0.0, 7.0), (azimuth + rng.normal(0.0, 0.4)) % 360.0, who)
        for time, reach, azimuth, who in rows
    ]
    return _table(rows, ["range_m", "azimuth_deg"])


def stereo(rng: np.random.Generator) -> pl.DataFrame:
    """Return ten seconds of thirty bats before two cameras, whose depth errs with its square."""
    rows, step = [], 1.0 / 30.0
    for who in range(30):
        begun = rng.uniform(0.0, 8.0)
        place = np.array([rng.uniform(-6.0, 6.0), rng.uniform(6.0, 22.0), rng.uniform(-3.0, 3.0)])
        velocity = np.array([*(rng.uniform(3.0, 7.0) * _ahead(rng.uniform(0.0, 6.3))), 0.0])
        for frame in range(int(30 * begun), 300):
            velocity += rng.normal(0.0, np.sqrt(12.0 * step), 3)
            velocity -= 0.02 * (place - [0.0, 14.0, 0.0]) * (np.abs(place) > [6.0, 18.0, 3.0])
            place = place + step * velocity
            noise = place[1] * np.array([0.004, 0.0017 * place[1], 0.004])
            if 4.0 < place[1] < 26.0 and rng.random() < 0.92:
                rows.append((frame * step, *(place + rng.normal(0.0, noise)), f"b{who}"))
    for frame in rng.integers(0, 300, 500):
        rows.append((frame * step, *rng.uniform([-10.0, 4.0, -4.0], [10.0, 26.0, 4.0]), NOBODY))
    return _table(rows, ["x", "y", "z"])


# What is told of each: where sensors stand, as whoever records knows it.
AT = {"position": [0.0, 0.0]}
SCENES: dict[str, tuple[Callable[[np.random.Generator], pl.DataFrame], dict]] = {
    "collars": (collars, {}),
    "pilots": (pilots, {}),
    "stacks": (stacks, {"default": {**AT, "scan_period": 12.0}}),
    "crossing": (crossing, {}),
    "drifting_clock": (
        drifting_clock,
        {
            "a": {"position": [-20e3, 0.0], "scan_period": 4.0},
            "b": {"position": [20e3, 5e3], "scan_period": 4.0},
        },
    ),
    "stage_jump": (stage_jump, {}),
    "drones": (drones, {}),
    "tags": (tags, {}),
    "hall": (hall, {}),
    "sector": (sector, {}),
    "stereo": (stereo, {}),
}


def _ahead(heading: float) -> Array:
    return np.array([np.sin(heading), np.cos(heading)])


def _racetrack(fix: Array, inbound: float, speed: float, begun: float) -> Callable[[float], Array]:
    """Return a path of legs of a minute and turns of 3 deg/s to the right."""
    turn = np.radians(3.0)
    radius, ahead = speed / turn, _ahead(inbound)
    right, leg = np.array([ahead[1], -ahead[0]]), 60.0 * speed

    def place(time: float) -> Array:
        phase = (time + begun) % 240.0
        part, into = divmod(phase, 60.0)
        angle = turn * into
        bow = radius * (1.0 - np.cos(angle)), radius * np.sin(angle)
        if part == 0:  # towards the fix
            return np.asarray(fix - ahead * (leg - speed * into))
        if part == 1:
            return np.asarray(fix + right * bow[0] + ahead * bow[1])
        far = fix + right * 2 * radius
        if part == 2:
            return np.asarray(far - ahead * speed * into)
        return np.asarray(far - ahead * leg - right * bow[0] - ahead * bow[1])

    return place


def _drive(car: int, side: float, speed: float, first: float) -> Callable[[float], Array]:
    """Return a car's way along its lane, from its first second on."""

    def place(time: float) -> Array:
        y = side * 1.6 + 0.2 * np.sin(time / 3 + car)
        return np.array([side * (speed * (time - first) - 60.0), y])

    return place


def _walk(x: float, side: float, first: float) -> Callable[[float], Array]:
    """Return the way over the road of somebody on foot."""
    return lambda time: np.array([x, side * (1.3 * (time - first) - 15.0)])


def _plots(
    rng: np.random.Generator, name: str, path: Callable[[float], Array], span: tuple[float, float],
    *, period: float = 12.0,
) -> list[tuple]:  # fmt: skip
    """Return what a turning radar in the middle reports, each when its beam passes."""
    rows, (first, last) = [], span
    for turn in np.arange(first - first % period, last, period):
        azimuth = np.arctan2(*path(turn)[:2]) % (2 * np.pi)
        time = turn + azimuth / 2 / np.pi * period
        if not first <= time < last or rng.random() > 0.92:
            continue
        place = path(time)
        away = np.linalg.norm(place) + rng.normal(0.0, 70.0)
        measured = np.degrees(np.arctan2(*place[:2])) + rng.normal(0.0, 0.08)
        rows.append((time, away, measured % 360.0, name))
    return rows


def _table(rows: list[tuple], names: list[str]) -> pl.DataFrame:
    return pl.DataFrame(sorted(rows), ["time", *names, "target"], orient="row")
