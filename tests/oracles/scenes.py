"""Simple scenes for trackers: objects on straight lines, misses and false alarms."""

import numpy as np

from trackweave.association.growth_limits import GrowthLimits
from trackweave.domain.scans import Scan
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.solvers import Exact
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker

MOTION = ConstantVelocity(process_noise=0.05, max_speed=30.0)
LIFECYCLE = Lifecycle(new_target_density=1e-6)
WIDE = GrowthLimits(
    margin=1e3, keep=10**6, new_margin=1e3, new_keep=10**6, new_ceiling=1e3, max_nodes=10**6
)


def sensor(name="radar", **changed):
    """Return a sensor of ordinary quality."""
    values = {
        "name": name,
        "sigma": 10.0,
        "detection_probability": 0.9,
        "clutter_density": 2e-6,
        "scan_period": 1.0,
    }
    return Sensor(**(values | changed))


def tracker(*sensors, **changed):
    """Return a tracker that solves each window exactly."""
    options = {"motion": MOTION, "sensors": sensors or (sensor(),), "window": 4}
    options["lifecycle"] = LIFECYCLE
    return MultiHypothesisTracker(**(options | {"search": Exact()} | changed))


def scan(time, positions, name="radar", report=()):
    """Return a scan of positions in the plane."""
    return Scan(time, name, np.reshape(np.array(positions, dtype=float), (-1, 2)), report=report)


def scene(
    seed, *, objects=3, times=range(12), names=("radar",), clutter=2, detection=0.9, area=1000.0,
    dim=2, sigma=10.0,
):  # fmt: skip
    """Return scans of objects on straight lines, one per sensor and time."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(0.2 * area, 0.8 * area, size=(objects, dim))
    speed = rng.uniform(-10.0, 10.0, size=(objects, dim))
    scans, number = [], 0
    for time in times:
        for name in names:
            true = start + speed * time
            seen = true[rng.random(objects) < detection]
            reports = seen + rng.normal(size=seen.shape) * sigma
            false = rng.uniform(0.0, area, size=(rng.poisson(clutter), dim))
            both = rng.permutation(np.concatenate([reports, false]))
            numbers = number + np.arange(len(both))
            number += len(both)
            scans.append(Scan(float(time), name, both, report=numbers))
    return scans


def run(target, scans, seed=1, **options):
    """Return the hypothesis after each scan."""
    rng = np.random.default_rng(seed)
    return [target.step(each, rng=rng, **options) for each in scans]


def all_assignments(target, hypotheses):
    """Return every report's track: what left the window, then what is in it."""
    parts = [hypothesis.final for hypothesis in hypotheses] + [target.pending()]
    pairs = [
        (report, track)
        for part in parts
        for report, track in zip(part.report.tolist(), part.track.tolist(), strict=True)
    ]
    assert len({report for report, _ in pairs}) == len(pairs), "a report came twice"
    return dict(pairs)


def groups(assignment):
    """Return which reports share a track, whatever the tracks are called."""
    tracks = {}
    for report, track in assignment.items():
        if track >= 0:
            tracks.setdefault(track, set()).add(report)
    return {frozenset(reports) for reports in tracks.values()}
