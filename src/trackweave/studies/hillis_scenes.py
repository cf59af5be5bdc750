"""Scenes of two sensors, and what a tracker makes of them."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from trackweave.association.growth_limits import GrowthLimits
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.metrics import evaluate
from trackweave.metrics.assignments import assignment_quality
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.run.record import Assigned, Rows
from trackweave.run.scans import complete_scans
from trackweave.simulation import (
    Area,
    Crossing,
    RandomTargets,
    Scenario,
    SimulatedSensor,
    simulate,
)
from trackweave.solvers.protocol import Solver
from trackweave.studies.hillis_fitness import Recorded, document_growth
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.window import Window

__all__ = ["Followed", "TwoSensors", "dense_scene", "follow", "lone_reports", "meeting_scene"]

SIDE = 1000.0
PERIOD = 1.0
CUTOFF = 50.0
"""Five times the better sensor's noise [m]."""
SENSORS = (
    SimulatedSensor("A", 10.0, PERIOD, detection_probability=0.85, clutter_per_scan=2.0),
    SimulatedSensor("B", 12.0, PERIOD, detection_probability=0.80, clutter_per_scan=2.0),
)
PROCESS_NOISE = 1.0
DENSITY = 1e-8
"""Objects newly present per m² and scan: the scenes have none."""
ALONE = Sensor("C", 10.0, 0.9, 1e-6)
"""It does not scan: a report of it says nothing of other objects."""
SHARE_OF_FALSE, LATEST = 0.1, 2.0
PRIOR = np.diag([10.0**2, 10.0**2, 2.0**2, 2.0**2])


@dataclass(frozen=True, slots=True, eq=False)
class TwoSensors:
    """Two sensors' scans of some objects, and the truth."""

    scans: tuple[Scan, ...]
    sensors: tuple[Sensor, ...]
    target: tuple[str, ...]
    truth: TruthTable
    priors: TrackTable

    def late(self, rng: np.random.Generator) -> "TwoSensors":
        """Return the same scans, lone reports arriving up to two seconds late, in any order."""
        wait = [rng.uniform(0.0, LATEST) * (scan.sensor == ALONE.name) for scan in self.scans]
        arrival = [scan.time + more for scan, more in zip(self.scans, wait, strict=True)]
        order = np.argsort(arrival, kind="stable").tolist()
        return replace(self, scans=tuple(self.scans[place] for place in order))

    def names(self) -> list[str]:
        """Return the objects in the order of their tracks."""
        return [str(name) for name in self.truth.target[self.truth.time == self.truth.time.min()]]


def _priors(truth: TruthTable, rng: np.random.Generator) -> TrackTable:
    """Return a track of each object at the beginning, off by chance as it says it may be."""
    first = np.flatnonzero(truth.time == truth.time.min())
    assert truth.velocity is not None  # simulated
    state = np.column_stack([truth.position[first], truth.velocity[first]])
    count, time = first.shape[0], truth.time[first]
    return TrackTable(
        time, np.arange(count), np.full(count, CONFIRMED),
        state + rng.normal(size=state.shape) * np.sqrt(np.diag(PRIOR)),
        np.broadcast_to(PRIOR, (count, 4, 4)).copy(),
        np.zeros(count), np.full(count, 3), time,
    )  # fmt: skip


def meeting_scene(rng: np.random.Generator, n_scans: int) -> TwoSensors:
    """Return a scene of objects that cross and that pass close to one another."""
    middle, last = 0.5 * (n_scans - 1), n_scans - 1.0
    headings = rng.uniform(0.0, 360.0, 2).tolist()
    return _scene(
        Scenario(
            area=Area((0.0, 0.0), (SIDE, SIDE)),
            duration=last,
            sensors=SENSORS,
            crossings=(
                Crossing((350.0, 400.0), 0.9 * middle, 40.0, 3, 45.0, headings[0]),
                Crossing((650.0, 600.0), 1.1 * middle, 40.0, 2, 30.0, headings[1]),
            ),
            process_noise=PROCESS_NOISE,
        ),
        rng,
    )


def dense_scene(rng: np.random.Generator, n_objects: int, n_scans: int) -> TwoSensors:
    """Return a scene of objects that go anywhere in the area, seen by the first sensor alone."""
    return _scene(
        Scenario(
            area=Area((0.0, 0.0), (SIDE, SIDE)),
            duration=n_scans - 1.0,
            sensors=SENSORS[:1],
            random=RandomTargets(n_objects, (5.0, 15.0)),
            process_noise=PROCESS_NOISE,
        ),
        rng,
    )


def _scene(scenario: Scenario, rng: np.random.Generator) -> TwoSensors:
    found = simulate(scenario, rng)
    sensors = tuple(
        Sensor(
            each.name, each.sigma, each.detection_probability,
            each.clutter_per_scan / SIDE**2, each.scan_period,
        )
        for each in scenario.sensors
    )  # fmt: skip
    periods = {sensor.name: sensor.scan_period for sensor in sensors}
    target = found.reports.carried["target"]
    return TwoSensors(
        tuple(complete_scans(found.reports, periods)),
        sensors,
        tuple(str(name) for name in target),
        found.truth,
        _priors(found.truth, rng),
    )


def lone_reports(scene: TwoSensors, rng: np.random.Generator) -> TwoSensors:
    """Return a scene with reports of a third sensor, which come one by one at any time."""
    times, truth = np.unique(scene.truth.time), scene.truth
    count = int(2 * (times[-1] - times[0]) / 3)
    scans, target = list(scene.scans), list(scene.target)
    for time in rng.uniform(times[0], times[-1], count).tolist():
        name, place = "", rng.uniform(0.0, SIDE, 2)
        if rng.random() >= SHARE_OF_FALSE:
            name = str(rng.choice(scene.names()))
            own = truth.target == name
            course = [np.interp(time, truth.time[own], axis) for axis in truth.position[own].T]
            place = np.array(course) + rng.normal(0.0, float(ALONE.sigmas(2)[0]), 2)
        scans.append(Scan(time, ALONE.name, place[None], report=np.array([len(target)])))
        target.append(name)
    scans.sort(key=lambda scan: scan.time)
    return replace(
        scene, scans=tuple(scans), sensors=(*scene.sensors, ALONE), target=tuple(target)
    )


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """What a tracker made of a scene."""

    is_right: NDArray[np.bool_]
    switches: int
    gospa: float
    asked: Recorded
    amended: int

    @property
    def right(self) -> float:
        """Share of the reports assigned rightly [%]."""
        return 100.0 * float(self.is_right.mean())


def follow(
    scene: TwoSensors,
    solver: Solver,
    depth: int,
    rng: np.random.Generator,
    *,
    ours: bool = False,
) -> Followed:
    """Track a scene's objects from their beginning."""
    asked = Recorded(solver)
    tracker = MultiHypothesisTracker(
        motion=ConstantVelocity(PROCESS_NOISE, max_speed=60.0),
        sensors=scene.sensors,
        window=Window(depth),
        search=asked,
        lifecycle=Lifecycle(new_target_density=DENSITY),
        priors=scene.priors,
        limits=GrowthLimits() if ours else document_growth(),
        estimate="average" if ours else "best",
    )
    rows, assigned, amended = Rows(), Assigned.nothing(len(scene.target)), 0
    for scan in scene.scans:
        found = tracker.step(scan, rng=rng)
        rows.add(found.tracks, found.time)
        assigned.enter(found.final)
        amended += len(found.amendments)
    assigned.enter(tracker.pending())
    table = rows.table(2)
    counts = np.isin(assigned.track, table.track[table.status >= CONFIRMED])
    track = np.where(counts, assigned.track, -1)
    named = {name: number for number, name in enumerate(scene.names())}
    is_right = track == np.array([named.get(name, -1) for name in scene.target])
    figures = evaluate(scene.truth, table, cutoff=CUTOFF)
    return Followed(
        is_right, assignment_quality(scene.target, track).switches,
        float(figures.gospa or 0.0), asked, amended,
    )  # fmt: skip
