"""Two radars over one sky that see no object together are said to."""

import numpy as np
import polars as pl
import pytest

from trackweave import track

PLACES = {"A": (0.0, 0.0), "B": (30e3, 0.0)}
TOLD = {"sensors": {n: {"position": [*at], "scan_period": 5.0} for n, at in PLACES.items()}}


def seen(aircraft, names, seed):
    """Return what some radars see of aircraft that fly straight."""
    rng, rows = np.random.default_rng(seed), []
    for start, way in aircraft:
        for name in names:
            for turn in range(24):
                time = 5.0 * turn
                for _ in range(3):
                    east, north = np.array(start) + time * np.array(way) - PLACES[name]
                    azimuth = np.degrees(np.arctan2(east, north)) % 360.0
                    time = 5.0 * (turn + azimuth / 360.0)
                told = np.hypot(east, north) + rng.normal(0, 20.0), azimuth + rng.normal(0, 0.03)
                rows.append((time, name, told[0], told[1] % 360.0))
    return rows


def sky(n, seed):
    """Return where aircraft begin about both radars, and how they fly."""
    rng = np.random.default_rng(seed)
    heading = rng.uniform(0.0, 2.0 * np.pi, n)
    way = 150.0 * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    return list(zip(rng.uniform((-2e4, -3e4), (5e4, 3e4), (n, 2)), way, strict=True))


def notes(rows):
    frame = pl.DataFrame(sorted(rows), ["time", "sensor", "range_m", "azimuth_deg"], orient="row")
    told = track(frame, TOLD).run["diagnostics"]
    return [each["sentence"] for each in told if each["cause"] == "unshared"]


def test_radars_that_see_no_object_together_are_told():
    rows = seen(sky(8, 1), "A", 1) + seen(sky(9, 2), "B", 2)
    (said,) = notes(rows)
    assert said.startswith("sensors A and B: ")
    assert " are where both look, and 0 of them of both; each sees others, or what is " in said


@pytest.mark.parametrize("alone", [0, 4])
def test_radars_that_share_objects_are_not(alone):
    rows = seen(sky(8, 1), "AB", 1) + (seen(sky(alone, 3), "A", 3) if alone else [])
    assert notes(rows) == []


def test_radars_that_look_elsewhere_are_not():
    far = [((x - 3e5, y), way) for (x, y), way in sky(9, 2)]
    assert notes(seen(sky(8, 1), "A", 1) + seen(far, "B", 2)) == []
