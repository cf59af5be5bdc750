"""A sky of aircraft under turning radars, with what may be wrong with these."""

import numpy as np
import polars as pl

RADARS = {"east": ((60e3, 10e3), 5.0), "north": ((20e3, 70e3), 4.0), "west": ((0.0, 0.0), 5.0)}
SIGMA_M, SIGMA_DEG = 30.0, 0.05


def told(names=tuple(RADARS)):
    """Where radars stand and how they turn."""
    places = {name: RADARS[name] for name in names}
    return {"sensors": {n: {"position": [*at], "scan_period": s} for n, (at, s) in places.items()}}


def sky(seed=3, minutes=3.0, n_aircraft=24, names=tuple(RADARS)):
    """Aircraft that fly straight, each seen four times in five, and false alarms."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(-6e4, 1e5, (n_aircraft, 2))
    heading = rng.uniform(0, 2 * np.pi, n_aircraft)
    velocity = rng.uniform(120, 240, (n_aircraft, 1)) * np.c_[np.sin(heading), np.cos(heading)]
    height = rng.uniform(2e3, 11e3, n_aircraft)
    parts = []
    for name in names:
        place, period = RADARS[name]
        turn = np.repeat(np.arange(int(60 * minutes / period)), n_aircraft)
        who = np.tile(np.arange(n_aircraft), turn.size // n_aircraft)
        time = (turn + 0.5) * period
        for _ in range(4):
            away = start[who] + velocity[who] * time[:, None] - place
            azimuth = np.degrees(np.arctan2(*away.T)) % 360
            time = (turn + azimuth / 360) * period
        slant = np.hypot(np.hypot(*away.T), height[who]) + rng.normal(0, SIGMA_M, who.size)
        azimuth = (azimuth + rng.normal(0, SIGMA_DEG, who.size)) % 360
        columns = {"time": time, "range_m": slant, "azimuth_deg": azimuth, "height_m": height[who]}
        true = pl.DataFrame({**columns, "target": who}).filter(rng.random(who.size) < 0.8)
        n_false = true.height // 20
        when = rng.uniform(0, 60 * minutes, n_false)
        false = {
            "time": when,
            "range_m": 1.2e5 * np.sqrt(rng.random(n_false)),
            "azimuth_deg": (when / period % 1.0) * 360.0,
        }
        one = pl.concat([true, pl.DataFrame(false)], how="diagonal")
        parts.append(one.with_columns(sensor=pl.lit(name)))
    return pl.concat(parts).sort("time").with_row_index("report")


def off(reports, sensor, range_m=0.0, azimuth_deg=0.0, clock=0.0):
    """Reports of which a sensor's are biased."""
    whose = (pl.col("sensor") == sensor).cast(pl.Float64)
    return reports.with_columns(
        time=pl.col("time") + clock * whose,
        range_m=pl.col("range_m") + range_m * whose,
        azimuth_deg=(pl.col("azimuth_deg") + azimuth_deg * whose) % 360.0,
    ).sort("time")


def on_plane(reports):
    """The same as positions."""
    east, north = (
        pl.col("sensor").replace_strict({n: at[axis] for n, (at, _) in RADARS.items()})
        for axis in (0, 1)
    )
    ground = (pl.col("range_m") ** 2 - pl.col("height_m") ** 2).clip(1.0).sqrt()
    azimuth = pl.col("azimuth_deg").radians()
    return reports.filter(pl.col("height_m").is_not_null()).select(
        "time",
        "sensor",
        x=east + ground * azimuth.sin(),
        y=north + ground * azimuth.cos(),
    )
