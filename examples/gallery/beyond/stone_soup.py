"""
Stone Soup, side by side
========================

The same detections, as Stone Soup's own objects, go to its Kalman filter with global nearest
neighbours and to our tracker; the same metric, its GOSPA, judges both. Theirs is set as its
tutorials set it, and could be tuned; ours is told nothing. Theirs is of what was known at each
time; ours is drawn smoothed, and the title says both. Nothing has to be converted by hand:
``trackweave.adapters.stonesoup`` takes its objects and gives them back.
"""

from datetime import datetime, timedelta

import matplotlib.pyplot as plt
import numpy as np
from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
from stonesoup.deleter.time import UpdateTimeStepsDeleter
from stonesoup.hypothesiser.distance import DistanceHypothesiser
from stonesoup.initiator.simple import MultiMeasurementInitiator
from stonesoup.measures import Mahalanobis
from stonesoup.metricgenerator.ospametric import GOSPAMetric
from stonesoup.models.measurement.linear import LinearGaussian
from stonesoup.models.transition.linear import (
    CombinedLinearGaussianTransitionModel,
    ConstantVelocity,
)
from stonesoup.predictor.kalman import KalmanPredictor
from stonesoup.tracker.simple import MultiTargetTracker
from stonesoup.types.detection import Detection
from stonesoup.types.groundtruth import GroundTruthPath, GroundTruthState
from stonesoup.types.state import GaussianState
from stonesoup.updater.kalman import KalmanUpdater

import trackweave as tw
from trackweave.adapters.stonesoup import reports_of, tracks_of, truth_of

rng, begin = np.random.default_rng(3), datetime(2026, 5, 1, 12)
model = LinearGaussian(4, (0, 2), np.diag([25.0, 25.0]))
paths, scans = [GroundTruthPath() for _ in range(4)], []
for k in range(50):
    now, seen = begin + timedelta(seconds=k), set()
    for number, path in enumerate(paths):
        state = [
            8.0 * k,
            8.0,
            160.0 - 80.0 * number + (number - 1.5) * 3.2 * k,
            (number - 1.5) * 3.2,
        ]
        path.append(GroundTruthState(state, timestamp=now))
        if rng.random() < 0.9:
            place = model.function(path[-1], noise=rng.normal(0.0, 5.0, (2, 1)))
            seen.add(Detection(place, timestamp=now, measurement_model=model))
    for place in rng.uniform((0.0, -200.0), (400.0, 200.0), (6, 2)):
        seen.add(Detection(place.reshape(2, 1), timestamp=now, measurement_model=model))
    scans.append((now, seen))

transition = CombinedLinearGaussianTransitionModel([ConstantVelocity(0.1), ConstantVelocity(0.1)])
updater, predictor = KalmanUpdater(model), KalmanPredictor(transition)
associator = GNNWith2DAssignment(
    DistanceHypothesiser(predictor, updater, Mahalanobis(), missed_distance=3)
)
deleter = UpdateTimeStepsDeleter(5)
prior = GaussianState([0, 0, 0, 0], np.diag([0, 100, 0, 100]))
initiator = MultiMeasurementInitiator(prior, deleter, associator, updater, model, min_points=4)
theirs = set()
for _, tracks in MultiTargetTracker(initiator, deleter, scans, associator, updater):
    theirs |= tracks
seen = sorted(
    (each for _, scan in scans for each in scan),
    key=lambda each: (each.timestamp, each.state_vector[0]),
)
result = tw.track(reports_of(seen))
ours = tracks_of(result, seen)
known_then = result.evaluate(truth_of(paths), cutoff=30.0).gospa

figure, panels = plt.subplots(1, 2, sharex=True, sharey=True, figsize=(10, 4.4))
for axes, (name, tracks) in zip(
    panels, {"Stone Soup, GNN": theirs, "trackweave": ours}.items(), strict=True
):
    metric = GOSPAMetric(p=2.0, c=30.0)
    judged = metric.compute_over_time(
        *metric.extract_states(tracks, True), *metric.extract_states(set(paths), True)
    )
    mean = np.mean([each.value["distance"] for each in judged.value])
    axes.plot(
        *np.array([each.state_vector.ravel() for each in seen], float).T, ".", color="0.8", ms=3
    )
    for path in paths:
        axes.plot(*np.array([each.state_vector[[0, 2]].ravel() for each in path]).T, "k--", lw=1)
    for track in sorted(tracks, key=lambda each: float(each[-1].state_vector[2])):
        axes.plot(
            *np.array([state.state_vector[[0, 2]].ravel() for state in track], float).T, lw=1.8
        )
    said = f"{name}: {len(tracks)} tracks of {len(paths)} objects\nmean GOSPA "
    said += (
        f"{known_then:.1f} m then, {mean:.1f} m smoothed" if tracks is ours else f"{mean:.1f} m"
    )
    axes.set(title=said, xlabel="x [m]")
panels[0].set_ylabel("y [m]")
figure.savefig("stone_soup.png")
