"""Range rates: their noise, and whether they are how fast ranges change."""

import numpy as np
import pytest

from trackweave.arrays import FloatArray
from trackweave.estimation.rates import rate_noise

Track = tuple[FloatArray, FloatArray, FloatArray]
SIGMA_RANGE, INTERVAL = 8.0, 2.5


def tracks(sigma: float, factor: float = 1.0, count: int = 10) -> list[Track]:
    """Return objects of 15 m/s that turn slowly, their ranges and rates."""
    rng = np.random.default_rng(5)
    time = INTERVAL * np.arange(40.0)
    made = []
    for _ in range(count):
        course = rng.uniform(0.0, 2 * np.pi) + np.cumsum(rng.normal(0.0, 0.02, time.size))
        velocity = 15.0 * np.stack([np.sin(course), np.cos(course)], axis=1)
        place = rng.uniform(1_000.0, 4_000.0, 2) + np.cumsum(velocity * INTERVAL, axis=0)
        distance = np.linalg.norm(place, axis=1)
        rate = np.sum(place * velocity, axis=1) / distance
        rate = factor * rate + rng.normal(0.0, sigma, time.size)
        made.append((time, distance + rng.normal(0.0, SIGMA_RANGE, time.size), rate))
    return made


@pytest.mark.parametrize("sigma", [0.3, 1.0, 4.0])
def test_the_noise_of_rates_is_found(sigma: float) -> None:
    found = rate_noise(tracks(sigma), SIGMA_RANGE)
    assert found is not None
    assert not found.doubt
    assert sigma / 1.3 < found.sigma < 1.5 * sigma


@pytest.mark.parametrize(
    ("factor", "said"),
    [(-1.0, "nearer as positive"), (3.6, "km/h"), (1.944, "knots"), (3.281, "feet per second")],
)
def test_rates_in_another_sense_or_unit_are_doubted(factor: float, said: str) -> None:
    found = rate_noise(tracks(0.3, factor), SIGMA_RANGE)
    assert found is not None
    assert said in found.doubt
    # So wide that they contradict no range.
    assert found.sigma > 3.0


def test_rates_that_mean_nothing_are_doubted_without_a_unit() -> None:
    rng = np.random.default_rng(1)
    folded = [(time, distance, rng.uniform(-30, 30, time.size)) for time, distance, _ in tracks(1)]
    found = rate_noise(folded, SIGMA_RANGE)
    assert found is not None
    assert "km/h" not in found.doubt
    assert found.sigma > 10.0


@pytest.mark.parametrize("n_fast", [2, 5])
def test_rates_that_fold_are_said_to(n_fast: int) -> None:
    rng, folded = np.random.default_rng(1), list[Track]()
    for number, (time, *_) in enumerate(tracks(1.0)):
        speed = rng.uniform(35.0, 60.0) if number < n_fast else rng.uniform(-30.0, 30.0)
        away = 5_000.0 + speed * time + rng.normal(0.0, SIGMA_RANGE, time.size)
        rate = (speed + rng.normal(0.0, 0.5, time.size) + 30.0) % 60.0 - 30.0
        folded.append((time, away, rate))
    rates = np.concatenate([rate for *_, rate in folded])
    found = rate_noise(folded, SIGMA_RANGE)
    assert found is not None
    assert f"fold: they lie off how its ranges change by multiples of {np.ptp(rates):.3g} m/s" in (
        found.doubt
    )
    assert found.sigma > 20.0


def test_too_few_reports_tell_nothing() -> None:
    assert rate_noise([], SIGMA_RANGE) is None
    short = [tuple(column[:6] for column in track) for track in tracks(1.0)]
    assert rate_noise(short, SIGMA_RANGE) is None
