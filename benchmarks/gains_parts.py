"""Trackers and solvers without one of their parts, and how both ways are timed."""

import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from bench_data import Scene
from runs import CONFIGURATION, configuration_for, priors_of, reports_of

from trackweave import MultiHypothesisTracker, read_reports
from trackweave.association import inactive
from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.association.tree import AssociationTree
from trackweave.config import load_configuration
from trackweave.domain.scans import Scan
from trackweave.io.tracks_in import read_priors
from trackweave.run.course import course_of, rotations_in
from trackweave.run.tracking import settings_for
from trackweave.solvers import Auto, Hint, Stop
from trackweave.trackers.pacing import Pace

Problems = list[tuple[AssignmentProblem, Hint | None]]


class GrownAnew(MultiHypothesisTracker):
    """The tracker that keeps no tree: each scan grows all scans of the window again."""

    def _take_in(self, scan: Scan, pace: Pace) -> AssociationTree:
        tree = self._tree or self._begin(self._dim or 2)
        return self._taken_late(tree, scan, self._open.find(scan.sensor, scan.time), pace)


class WithoutPrices(MultiHypothesisTracker):
    """The tracker whose beliefs do not tell growth which reports others want."""

    def _take_in(self, scan: Scan, pace: Pace) -> AssociationTree:
        if self._tree is not None:
            self._tree.nodes.price[: self._tree.n_nodes] = 0.0
        return super()._take_in(scan, pace)


@dataclass
class Collector:
    """The default solver, which keeps every problem and hint, and its own CPU time [s]."""

    met: Problems
    seconds: float = 0.0

    def __call__(
        self,
        problem: AssignmentProblem,
        *,
        rng: np.random.Generator,
        hint: Hint | None = None,
        stop: Stop | None = None,
    ) -> Answer:
        """Return the default solver's answer."""
        self.met.append((problem, hint))
        begun = time.process_time()
        answer = Auto()(problem, rng=rng, hint=hint, stop=stop)
        self.seconds += time.process_time() - begun
        return answer


class Followed(NamedTuple):
    """What a run of a tracker came to: CPU time [s], and of each scan cost and best tracks."""

    cpu: float
    costs: list[float]
    n_sequences: float
    rows: list[tuple[int, int, float, float]]


def followed(
    kind: type[MultiHypothesisTracker], scene: Scene, depth: int, search: Any = None
) -> Followed:
    """Run a kind of tracker over a scene of the bench, from its priors."""
    table = read_reports(reports_of(scene))
    settings = settings_for(table, load_configuration(configuration_for(scene, CONFIGURATION, {})))
    tracker = kind(
        motion=settings.motion,
        sensors=list(settings.sensors),
        window=replace(settings.window, depth=depth),
        search=search,
        lifecycle=settings.lifecycle,
        priors=read_priors(priors_of(scene), table.frame),
        limits=settings.growth,
        estimate=settings.estimate,
    )
    rng = np.random.default_rng(scene.seed)
    cpu, costs, sizes, rows = 0.0, [], [], []
    for scan in table.scans():
        begun = time.process_time()
        hypothesis = tracker.step(scan, rng=rng)
        cpu += time.process_time() - begun
        costs.append(hypothesis.certificate.cost)
        sizes.append(hypothesis.n_sequences)
        tracks = hypothesis.tracks
        told = zip(tracks.track, tracks.mean, tracks.status, strict=True)
        rows += [
            (round(hypothesis.time), int(track), float(mean[0]), float(mean[1]))
            for track, mean, status in told
            if status != 0
        ]
    return Followed(cpu, costs, float(np.mean(sizes)), rows)


def windows_of(scene: Scene, depth: int = 7) -> Problems:
    """Return the problems of a scene of the bench, scan by scan."""
    collector = Collector([])
    followed(MultiHypothesisTracker, scene, depth, collector)
    return collector.met


class Wide(NamedTuple):
    """Half of a run over sectors: problems, CPU time of all and of solving [s], tracks by scan."""

    problems: Problems
    cpu: float
    solving: float
    n_tracks: list[int]


def wide_run(reports: Any, config: dict[str, Any], *, inactive_clusters: bool = True) -> Wide:
    """Track radars' sectors; the first half fills the window and is not counted."""
    table = read_reports(reports)
    settings = settings_for(table, load_configuration(config))
    collector, little = Collector([]), inactive.LITTLE
    course = course_of(table, replace(settings, search=collector), rotations_in(settings), None)
    rng, n_tracks, half = np.random.default_rng(1), [], len(course.steps) // 2
    begun = spent = 0.0
    inactive.LITTLE = little if inactive_clusters else sys.maxsize
    try:
        for number, (scan,) in enumerate(course.steps):
            if number == half:
                begun, spent = time.process_time(), collector.seconds
            n_tracks.append(course.tracker.step(scan, rng=rng, tracks=False).n_tracks)
    finally:
        inactive.LITTLE = little
    cpu, solving = time.process_time() - begun, collector.seconds - spent
    return Wide(collector.met[half:], cpu, solving, n_tracks[half:])


def paired(ways: Sequence[Callable[[], Any]], times: int) -> list[tuple[float, Any]]:
    """Return each way's least CPU time [s] over so many turns, and what it returned last."""
    least, found = [np.inf] * len(ways), [None] * len(ways)
    for _ in range(times):
        for place, way in enumerate(ways):
            begun = time.process_time()
            found[place] = way()
            least[place] = min(least[place], time.process_time() - begun)
    return list(zip(least, found, strict=True))
