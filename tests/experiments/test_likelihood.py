"""The likelihood of a scan's reports, against plain loops over SciPy's densities."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest
from scipy import stats

import trackweave as tw
from oracles.small_study import SCENE, TOLD
from trackweave.domain.tracks import TENTATIVE
from trackweave.experiments.likelihood import log_likelihood
from trackweave.simulation import scenario_of, simulate

SENSOR = {"sigma": 5.0, "detection_probability": 0.9, "clutter_density": 8e-6, "scan_period": 2.0}


def result(**changes: float) -> tw.TrackingResult:
    scene = simulate(scenario_of(SCENE, "scene"), 3)
    reports = replace(scene.reports, sigma=np.full_like(scene.reports.sigma, np.nan))
    return tw.track(reports, {**TOLD, "sensors": {"radar": {**SENSOR, **changes}}}, rng=0)


def test_is_that_of_a_poisson_process() -> None:
    values = result().values
    reports, tracks = values.reports, values.tracks
    volume = np.prod(np.ptp(reports.measurement, axis=0))
    wanted = 0.0
    for time in np.unique(reports.time):
        before = tracks.time[(tracks.time < time) & (tracks.status != TENTATIVE)]
        density = {row: 8e-6 for row in np.flatnonzero(reports.time == time)}
        expected = 8e-6 * volume
        for row in np.flatnonzero(
            (tracks.status != TENTATIVE) & (tracks.time == before.max(initial=-1))
        ):
            expected += 0.9
            dt = time - tracks.time[row]
            move = np.block([np.eye(2), dt * np.eye(2)])
            spread = move @ tracks.covariance[row] @ move.T + (0.1 * dt**3 / 3 + 25) * np.eye(2)
            for report in density:
                density[report] += 0.9 * stats.multivariate_normal.pdf(
                    reports.measurement[report], move @ tracks.mean[row], spread
                )
        wanted += np.log(list(density.values())).sum() - expected
    assert log_likelihood(values) == pytest.approx(wanted / len(reports))


def test_is_best_near_the_noise_that_there_is() -> None:
    found = {
        sigma: log_likelihood(result(sigma=sigma, trust=True).values) for sigma in (1.0, 5.0, 40.0)
    }
    assert max(found, key=found.__getitem__) == 5.0


def test_is_none_where_reports_are_no_positions() -> None:
    rows = [(2.0 * k, 1000.0 + 10 * k, 30.0) for k in range(12)]
    frame = pl.DataFrame(rows, schema=["time", "range_m", "azimuth_deg"], orient="row")
    assert log_likelihood(tw.track(frame).values) is None
