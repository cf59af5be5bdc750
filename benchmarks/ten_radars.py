"""Ten turning radars whose range nobody tells, over 1,000 aircraft: names kept, beside told.

The sky is that of ``capacity.py``: ten radars that see 140 km, 500 km by 500 km. Told are where
they stand, their periods, sigma and detection probability, and with ``--told`` their range too.
"""

import argparse

import numpy as np
from capacity_scene import ANGLE_NOISE, DETECTION, RANGE_NOISE, TURN, Radars, Sky, recorded
from names_kept import HEAD, judged
from text_tables import command, heading, table


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
        radars = Radars(Sky(arguments.aircraft, seed))
        reports, _ = recorded(radars, arguments.turns)
        for word in ("no", "yes"):
            if arguments.told in (word, "both"):
                told = told_of(radars, with_range=word == "yes")
                lines.append([seed, word, *judged(reports, told)])
                print(*lines[-1], sep="  ", flush=True)
    print(heading(command("ten_radars.py")), end="\n\n")
    print(table(["seed", "range told", *HEAD], lines))


if __name__ == "__main__":
    main()
