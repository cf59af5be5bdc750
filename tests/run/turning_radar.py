"""A turning radar that twelve aircraft fly about."""

import numpy as np
import polars as pl

TURN = 4.0


def radar(n_turns=60):
    """Return four minutes of twelve aircraft, and four false alarms a turn."""
    rng, rows = np.random.default_rng(3), []
    course = rng.uniform(0, 2 * np.pi, 12)
    begin, way = rng.uniform(-60e3, 60e3, (12, 2)), rng.uniform(80, 250, (12, 1))
    way = way * np.stack([np.sin(course), np.cos(course)], axis=1)
    for turn in range(n_turns):
        for each in np.flatnonzero(rng.random(12) < 0.93):
            now = TURN * turn
            for _ in range(3):
                place = begin[each] + now * way[each]
                azimuth = np.arctan2(*place) % (2 * np.pi)
                now = TURN * (turn + azimuth / (2 * np.pi))
            told = np.degrees(azimuth) + rng.normal(0, 0.12)
            rows.append((now, np.hypot(*place) + rng.normal(0, 60), told % 360, str(each)))
        for share in rng.random(4):
            rows.append((TURN * (turn + share), 9e4 * np.sqrt(rng.random()), 360 * share, ""))
    return pl.DataFrame(rows, ["time", "range_m", "azimuth_deg", "target"], orient="row")


def on_a_plane(table, east=4e5, north=5.2e6):
    """Return the reports as positions on a plane that counts from elsewhere."""
    angle = pl.col("azimuth_deg") * np.pi / 180
    return table.select(
        "time",
        x=east + pl.col("range_m") * angle.sin(),
        y=north + pl.col("range_m") * angle.cos(),
        target="target",
    )
