"""A radar whose range rates are not what its ranges say is told, and does no harm."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.metrics import assignment_quality

SCANS, INTERVAL = 60, 2.5


def boats(factor: float) -> pl.DataFrame:
    """Return ranges, azimuths and rates (of 0.2 m/s) of boats that turn now and then."""
    rng = np.random.default_rng(8)
    rows = []
    for boat in range(8):
        place, course = rng.uniform(-3_000.0, 3_000.0, 2), rng.uniform(0.0, 2 * np.pi)
        for scan in range(SCANS):
            course += 0.3 * (rng.random() < 0.05)
            velocity = 9.0 * np.array([np.sin(course), np.cos(course)])
            place = place + velocity * INTERVAL
            distance = float(np.linalg.norm(place))
            if rng.random() < 0.9:
                azimuth = np.degrees(np.arctan2(*place)) + rng.normal(0.0, 0.4)
                rate = factor * float(place @ velocity) / distance + rng.normal(0.0, 0.2)
                shown = distance + rng.normal(0.0, 8.0)
                rows.append((scan, INTERVAL * scan, shown, azimuth % 360.0, rate, str(boat)))
    names = ["scan", "time", "range_m", "azimuth_deg", "range_rate_mps", "target"]
    return pl.DataFrame(rows, names, orient="row").sort("time")


def noted(result: tw.TrackingResult[pl.DataFrame]) -> list[str]:
    return [note for note in result.run["notes"] if "range_rate_mps" in note]


def test_the_noise_of_rates_is_estimated() -> None:
    result = tw.track(boats(1.0))
    sensor = result.run["configuration"]["sensors"]["default"]
    assert 0.15 < sensor["sigma"]["range_rate_mps"] < 0.4
    assert not noted(result)


@pytest.mark.parametrize(
    ("factor", "said"), [(-1.0, "they count what comes nearer as positive"), (3.6, "like km/h")]
)
def test_rates_that_contradict_ranges_are_told_and_count_for_little(
    factor: float, said: str
) -> None:
    result = tw.track(boats(factor))
    (note,) = noted(result)
    assert said in note
    found = result.assignments
    quality = assignment_quality(found["target"].to_list(), found["track"].to_list())
    assert quality.idf1 is not None
    assert quality.idf1 > 0.95
