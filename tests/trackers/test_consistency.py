"""The tracker's own idea of its errors against the errors it makes."""

import numpy as np
import pytest
from scipy.stats import chi2

from oracles import kalman
from oracles.scenes import run, scan, sensor, tracker
from trackweave.models.motion import ConstantVelocity

RUNS, SCANS, NOISE, SIGMA = 40, 25, 0.5, 10.0


def simulate(seed, detection=0.9):
    """Return true states and scans of one object that moves as the model says."""
    rng = np.random.default_rng(seed)
    moving, noise = kalman.matrices(1.0, NOISE, 2)
    state = np.concatenate([rng.uniform(-100, 100, size=2), rng.normal(size=2) * 10.0])
    truth, scans = [], []
    for time in range(SCANS):
        seen = rng.random() < detection or time == 0
        place = state[:2] + rng.normal(size=2) * SIGMA
        scans.append(scan(float(time), [place] if seen else []))
        truth.append(state)
        state = rng.multivariate_normal(moving @ state, noise)
    return truth, scans


@pytest.mark.slow
@pytest.mark.parametrize("estimate", ["average", "best"])
def test_errors_are_as_large_as_their_covariances_say(estimate):
    """NEES, ch. 5.4 of Bar-Shalom, Li, Kirubarajan (2001), and NIS of the reports to come."""
    nees, nis = [], []
    for seed in range(RUNS):
        truth, scans = simulate(seed)
        target = tracker(
            sensor(clutter_density=1e-8, sigma=SIGMA),
            motion=ConstantVelocity(NOISE, 40.0),
            estimate=estimate,
        )
        hypotheses = run(target, scans)
        for time in range(8, SCANS - 1):
            tracks = hypotheses[time].tracks
            assert len(tracks) == 1
            error = tracks.mean[0] - truth[time]
            nees.append(error @ np.linalg.inv(tracks.covariance[0]) @ error)
            for position in scans[time + 1].measurement:
                ahead = kalman.predict(tracks.mean[0], tracks.covariance[0], 1.0, NOISE)
                nis.append(kalman.squared_distance(*ahead, position, np.full(2, SIGMA)))
    # Errors of one run go together over a few scans: a quarter of them counts as independent.
    for values, freedom in ((nees, 4), (nis, 2)):
        count = len(values) // 4
        low, high = chi2.ppf([0.0005, 0.9995], count * freedom) / count
        assert low < np.mean(values) < high


def test_a_coasting_track_knows_that_it_knows_less():
    _, scans = simulate(1, detection=1.0)
    scans = scans[:15] + [scan(float(time), []) for time in range(15, 17)]
    target = tracker(sensor(clutter_density=1e-8), motion=ConstantVelocity(NOISE, 40.0))
    hypotheses = run(target, scans)
    spread = [np.trace(each.tracks.covariance[0][:2, :2]) for each in hypotheses[14:]]
    assert np.all(np.diff(spread) > 0)
