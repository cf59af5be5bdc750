"""Ten turning radars whose range nobody tells, over 1,000 aircraft: names kept, beside told.

The sky is that of ``capacity.py``: ten radars that see 140 km, 500 km by 500 km. Told are where
they stand, their periods, sigma and detection probability, and with ``--told`` their range too.
"""

import argparse

import numpy as np
import polars as pl
from capacity_scene import ANGLE_NOISE, DETECTION, RANGE_NOISE, TURN, Radars, Sky
from names_kept import HEAD, judged
from text_tables import command, heading, table

NEAR = 5.0
"""A report within so many standard deviations of an aircraft is that aircraft's."""


def recorded(aircraft: int, turns: int, seed: int) -> tuple[pl.DataFrame, Radars]:
    """Return the radars' reports with their target, "" for false ones, and the radars."""
    sky = Sky(aircraft, seed)
    radars, parts = Radars(sky), []
    for _ in range(turns):
        name, start, velocity = sky.name.copy(), sky.position.copy(), sky.velocity()
        begun = sky.time
        for scan in radars.scans():
            place = radars.place[int(scan.sensor[5:])]
            for time, (away, azimuth) in zip(scan.moments, scan.measurement, strict=True):
                apart = start + velocity * (time - begun) - place
                distance = np.hypot(*apart.T)
                turned = (np.arctan2(*apart.T) - azimuth + np.pi) % (2 * np.pi) - np.pi
                off = np.hypot((distance - away) / RANGE_NOISE, turned / ANGLE_NOISE)
                own = int(np.argmin(off))
                target = f"{name[own]}" if off[own] < NEAR else ""
                degrees = float(np.degrees(azimuth))
                parts.append((float(time), scan.sensor, float(away), degrees, target))
        sky.advance(TURN)
    names = ["time", "sensor", "range_m", "azimuth_deg", "target"]
    return pl.DataFrame(parts, names, orient="row").sort("time", maintain_order=True), radars


def told_of(radars: Radars, *, with_range: bool) -> dict[str, object]:
    """Return a configuration that tells of the radars what a data sheet does."""
    reach = {"field_of_view": {"max_range_m": radars.reach}} if with_range else {}
    sigma = {"range_m": RANGE_NOISE, "azimuth_deg": float(np.degrees(ANGLE_NOISE))}
    known = {"scan_period": TURN, "sigma": sigma, "detection_probability": DETECTION, **reach}
    places = enumerate(radars.place.tolist())
    return {"sensors": {f"radar{number}": {"position": at, **known} for number, at in places}}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--aircraft", type=int, default=1_000)
    parser.add_argument("--turns", type=int, default=30)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--told", choices=["yes", "no", "both"], default="both")
    arguments = parser.parse_args()
    lines = []
    for seed in range(arguments.first, arguments.first + arguments.seeds):
        reports, radars = recorded(arguments.aircraft, arguments.turns, seed)
        for word in ("no", "yes"):
            if arguments.told in (word, "both"):
                told = told_of(radars, with_range=word == "yes")
                lines.append([seed, word, *judged(reports, told)])
                print(*lines[-1], sep="  ", flush=True)
    print(heading(command("ten_radars.py")), end="\n\n")
    print(table(["seed", "range told", *HEAD], lines))


if __name__ == "__main__":
    main()
