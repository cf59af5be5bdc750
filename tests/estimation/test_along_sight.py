"""Ranges that are exact tell what objects do where directions hide it."""

import numpy as np
import pytest

from trackweave.domain.reports import ReportTable
from trackweave.estimation.along_sight import process_along_sight
from trackweave.estimation.noise import arrays_of, noise_of_chains

SIGMA = (10.0, 0.01)


def ships(process: float, n_ships: int = 12) -> tuple[ReportTable, list[np.ndarray]]:
    """Return positions of ships 5 to 15 km off, by ranges of 10 m and azimuths of 0.57°."""
    rng = np.random.default_rng(3)
    interval, scans = 3.0, 60
    start = rng.uniform(5_000.0, 10_000.0, (n_ships, 2)) * rng.choice([-1.0, 1.0], (n_ships, 2))
    noise = rng.normal(0.0, np.sqrt(process * interval), (scans, n_ships, 2))
    velocity = rng.normal(0.0, 7.0, (n_ships, 2)) + np.cumsum(noise, axis=0)
    place = start + np.cumsum(velocity * interval, axis=0)
    distance = np.linalg.norm(place, axis=2) + rng.normal(0.0, SIGMA[0], (scans, n_ships))
    azimuth = np.arctan2(place[..., 0], place[..., 1])
    azimuth += rng.normal(0.0, SIGMA[1], azimuth.shape)
    seen = distance[..., None] * np.stack([np.sin(azimuth), np.cos(azimuth)], axis=2)
    count = scans * n_ships
    reports = ReportTable(
        time=np.repeat(interval * np.arange(scans), n_ships),
        sensor=np.zeros(count, dtype=np.int64),
        sensors=("radar",),
        measurement=seen.reshape(count, 2),
        sigma=np.full((count, 2), np.nan),
        report=np.arange(count).astype(str),
    )
    return reports, [np.arange(ship, count, n_ships) for ship in range(n_ships)]


@pytest.mark.parametrize("process", [0.003, 0.03, 0.3])
def test_process_noise_is_found_within_a_factor_of_three(process: float) -> None:
    reports, tracks = ships(process)
    places = [np.zeros((rows.size, 2)) for rows in tracks]
    found = process_along_sight(reports, tracks, places, SIGMA)
    assert found is not None
    assert process / 3.0 < found < process * 3.0


def test_one_noise_for_both_directions_finds_it_far_worse() -> None:
    """What this is for: without it either noise across the line of sight hides small turns."""
    reports, tracks = ships(0.003)
    time, place = arrays_of((reports.time[rows], reports.measurement[rows]) for rows in tracks)
    _, process = noise_of_chains(time, place, 70.0, 1e-9)
    assert process < 0.003 / 5.0 or process > 0.003 * 5.0


def test_few_reports_or_sights_that_turn_at_once_tell_nothing() -> None:
    reports, tracks = ships(0.03)
    few = [rows[:5] for rows in tracks]
    assert process_along_sight(reports, few, [np.zeros((5, 2))] * len(few), SIGMA) is None
    # From a sensor that is now east of a ship and now west each report lies in another direction.
    aside = [reports.measurement[rows].copy() for rows in tracks]
    for places in aside:
        places[::2, 0] += 500.0
        places[1::2, 0] -= 500.0
    assert process_along_sight(reports, tracks, aside, SIGMA) is None
