"""Two sensors' bearings: how often objects are told from ghosts before and after hindsight.

Objects of 4 to 15 m/s in 3 km before two sensors 3 km apart, a look each second for two minutes,
with 0.2° of noise, 95 % of all chances seen, nothing told. Each is tracked twice: under the names
that are given as it goes (``lifecycle.join = false``), and under those of the whole recording.
"""

import argparse
import time
from typing import NamedTuple

import numpy as np
import polars as pl
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

SENSORS = {"west": (0.0, 0.0), "east": (3000.0, 0.0)}
LOOKS, SIGMA_DEG, SEEN = 120, 0.2, 0.95
HEAD = ["objects", "way", "false a look", "IDF1 as it went", "in hindsight", "worst", "worse in",
        "CPU s each"]  # fmt: skip


class Kind(NamedTuple):
    """What a recording holds."""

    count: int
    way: str
    false: float = 0.0  # Bearings of nobody for each look
    wander: float = 0.0  # Process noise [m²/s³]
    turn_deg: float = 0.0  # By how much each turns for 50 s, to one side [°/s]


KINDS = (
    Kind(2, "straight"), Kind(3, "straight"), Kind(5, "straight"),
    Kind(3, "straight", false=0.5),
    Kind(3, "wanders, 0.02 m²/s³", wander=0.02), Kind(3, "wanders, 0.3 m²/s³", wander=0.3),
    Kind(3, "a turn of 2°/s", turn_deg=2.0),
)  # fmt: skip


def reports_of(kind: Kind, rng: np.random.Generator) -> pl.DataFrame:
    """Return a recording's bearings, with the object of each."""
    rows = []
    for each in range(kind.count):
        heading_, begins = rng.uniform(0.0, 2.0 * np.pi), rng.integers(20, 60)
        turns = np.zeros(LOOKS)
        turns[begins : begins + 50] = rng.choice([-1.0, 1.0]) * np.radians(kind.turn_deg)
        ahead = heading_ + np.cumsum(turns)
        velocity = rng.uniform(4.0, 15.0) * np.stack([np.sin(ahead), np.cos(ahead)], axis=1)
        velocity += np.cumsum(rng.normal(0.0, np.sqrt(kind.wander), velocity.shape), axis=0)
        place = rng.uniform([0.0, 600.0], [3000.0, 3600.0]) + np.cumsum(velocity, axis=0)
        for name, (x, y) in SENSORS.items():
            angle = np.degrees(np.arctan2(place[:, 0] - x, place[:, 1] - y))
            angle += rng.normal(0.0, SIGMA_DEG, LOOKS)
            seen = np.flatnonzero(rng.random(LOOKS) < SEEN)
            rows += [(float(k), name, angle[k] % 360.0, x, y, str(each)) for k in seen]
    for name, (x, y) in SENSORS.items():
        for k in range(LOOKS):
            for _ in range(rng.poisson(kind.false)):
                rows.append((float(k), name, rng.uniform(0.0, 360.0), x, y, ""))
    columns = ["time", "sensor", "bearing_deg", "sensor_x", "sensor_y", "target"]
    return pl.DataFrame(rows, columns, orient="row").sample(
        fraction=1.0, shuffle=True, seed=int(rng.integers(1 << 31))
    ).sort("time", maintain_order=True)  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=1)
    options = parser.parse_args()
    rows = []
    for kind in KINDS:
        found, before = [], time.process_time()
        for seed in range(options.first, options.first + options.seeds):
            reports = reports_of(kind, np.random.default_rng(seed))
            whose = [each or None for each in reports["target"]]
            both = []
            for join in (False, True):
                result = track(reports.drop("target"), {"lifecycle": {"join": join}})
                both.append(assignment_quality(whose, result.reports["track"].to_list()).idf1)
            found.append([each or 0.0 for each in both])
        spent = (time.process_time() - before) / options.seeds / 2
        went, hindsight = np.transpose(found)
        rows.append([f"{kind.count}", kind.way, f"{kind.false:g}", f"{went.mean():.2f}",
                     f"{hindsight.mean():.2f}", f"{hindsight.min():.2f}",
                     f"{np.count_nonzero(hindsight < went - 0.01)} of {options.seeds}",
                     f"{spent:.1f}"])  # fmt: skip
    print(heading(command("ghosts.py")))
    print()
    print(table(HEAD, rows))


if __name__ == "__main__":
    main()
