"""Random windows: association problems as a tracker meets them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.domain.scans import Scan
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor
from trackweave.solvers import Dual, Hint, Stop
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.window import Window

SIGMA, DETECTION, PROCESS_NOISE, MAX_SPEED = 10.0, 0.9, 0.05, 20.0
MARGIN = 100.0


@dataclass
class Keeper:
    """A solver that hands problems on to ``Dual`` and keeps the last one."""

    problem: AssignmentProblem | None = None

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: np.random.Generator,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the answer of ``Dual``."""
        self.problem = problem
        return Dual()(problem, rng=rng, hint=hint, stop=stop)


@dataclass(frozen=True)
class Place:
    """A square in which targets move and sensors see."""

    targets: int
    sensors: int
    side: float
    scans: int

    @property
    def clutter_density(self) -> float:
        """False alarms per m²: as many in a scan as there are targets."""
        return self.targets / (self.side + 2 * MARGIN) ** 2


def scans_of(place: Place, rng: np.random.Generator) -> list[Scan]:
    """Return simulated scans, one second apart."""
    position = rng.uniform(0, place.side, (place.targets, 2))
    speed = rng.uniform(5, MAX_SPEED, place.targets)
    course = rng.uniform(0, 2 * np.pi, place.targets)
    velocity = speed[:, np.newaxis] * np.column_stack([np.cos(course), np.sin(course)])
    scans = []
    for second in range(place.scans):
        for sensor in range(place.sensors):
            seen = position[rng.random(place.targets) < DETECTION]
            own = seen + SIGMA * rng.standard_normal(seen.shape)
            n_false = rng.poisson(place.targets)
            false = rng.uniform(-MARGIN, place.side + MARGIN, (n_false, 2))
            scans.append(Scan(float(second), str(sensor), np.concatenate([own, false])))
        velocity = velocity + np.sqrt(PROCESS_NOISE) * rng.standard_normal(velocity.shape)
        position = position + velocity
    return scans


def grown(
    place: Place, scans: list[Scan], depth: int, limits: GrowthLimits, **options: Any
) -> tuple[AssignmentProblem, int]:
    """Return the last window's problem, and how many sequences the last scan left out."""
    keeper = Keeper()
    tracker = MultiHypothesisTracker(
        motion=ConstantVelocity(PROCESS_NOISE, MAX_SPEED),
        sensors=[
            Sensor(str(k), SIGMA, DETECTION, place.clutter_density, scan_period=1.0)
            for k in range(place.sensors)
        ],
        window=Window(depth, max_scans=depth * place.sensors),
        search=keeper,
        lifecycle=Lifecycle(new_target_density=1e-7, initial_target_density=1e-4),
        limits=limits,
        **options,
    )
    n_pruned = 0
    for scan in scans:
        n_pruned += tracker.step(scan, rng=np.random.default_rng(0)).n_pruned
    assert keeper.problem is not None
    return keeper.problem, n_pruned
