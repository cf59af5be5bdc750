"""Values under which anything is tracked, where those that reports tell track nothing.

Objects that turn within a few looks, that are missed as often as seen or that are few and far
apart line up by no more than chance does. A stretch of the reports is tracked as though objects
went so far from look to look, for one distance after another, and then with more and less noise
and process noise as long as tracks become likelier.
"""

import itertools
import math
from dataclasses import dataclass, field, replace

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import Estimates, bounded, positive
from trackweave.estimation.looking import is_filled_evenly, line_up
from trackweave.estimation.trees import tree_of
from trackweave.run.stretches import Stretch

__all__ = ["widely_searched"]

MOST_SCANS, MOST_REPORTS, FEWEST_SCANS = 60, 1500, 5
"""So much of the middle of a recording is tracked at each trial."""
COARSE, MOST_DISTANCES, NEAREST, CROWDED = 2.5, 8, 0.05, 2.0
"""Distances are so many times each other, from where so few successors are nearer to where so many
are by chance."""
NOISE, PROCESS, FASTER, DETECTION = 0.125, 0.01, 1.25, 0.7
"""The first noise and the square of a change of speed, as shares of the distance, with the
greatest speed and the chance of detection."""
OTHER_NOISE, OTHER_PROCESS, MOST_STEPS = 3.0, 20.0, 5
# Tracks are so much likelier than false alarms where there are any, and so much for each report:
# of reports that are all false the best trial is likelier by 0.02 each [nats].
SURE, SURE_OF_EACH = 20.0, 0.04
# … and so many times as much likelier than what is tracked already, where anything is.
FAR_LIKELIER = 2.5
FEW = 0.05  # So many of the reports are false at most where looks have equally many

_Trial = tuple[float, float, float]
"""How far objects go [m], and how many times the first noise and process noise."""


@dataclass(frozen=True, slots=True)
class _Trials:
    """What tracks cost for each trial."""

    stretch: Stretch
    estimates: Estimates
    period: float
    found: dict[_Trial, float] = field(default_factory=dict)

    def at(self, trial: _Trial) -> Estimates:
        """Return estimates of objects that go so far, and so on."""
        distance, noise, process = trial
        sigma = bounded(NOISE * noise * distance, 1e-9)
        sensors = {
            name: replace(each, sigma=sigma, detection_probability=DETECTION)
            for name, each in self.estimates.sensors.items()
        }
        return replace(
            self.estimates,
            sensors=sensors,
            process_noise=positive(PROCESS * process * distance**2 / self.period**3),
            max_speed=bounded(FASTER * distance / self.period),
        )

    def cost(self, trial: _Trial) -> float:
        """Return what tracks cost [nats]."""
        if trial not in self.found:
            self.found[trial] = self.stretch.tracked(self.at(trial)).cost
        return self.found[trial]

    def as_before(self) -> float:
        """Return what tracks cost of objects that go as the estimates say [nats]."""
        return self.stretch.tracked(self.estimates).cost

    def best(self, distances: FloatArray, straight: tuple[float, float] | None) -> _Trial:
        """Return the trial under which tracks are likeliest."""
        starts = [(each, 1.0, 1.0) for each in distances.tolist()]
        if straight is not None and min(straight) > 0.0:
            # As far and as exactly as reports of three looks lie on a straight way.
            distance, noise = straight
            starts.append((distance, noise / (NOISE * distance), 1.0 / OTHER_PROCESS**2))
        here = min(starts, key=self.cost)
        for _ in range(MOST_STEPS):
            distance, noise, process = here
            steps = [(distance, noise * f, process) for f in (OTHER_NOISE, 1 / OTHER_NOISE)]
            steps += [(distance, noise, process * f) for f in (OTHER_PROCESS, 1 / OTHER_PROCESS)]
            best = min([here, *steps], key=self.cost)
            if best == here:
                break
            here = best
        return here


def widely_searched(
    estimates: Estimates,
    reports: ReportTable,
    configuration: Configuration,
    *,
    is_tracked: bool = False,
) -> Estimates | None:
    """Return estimates under which tracks are likelier than false alarms; None where none are."""
    # Where some are tracked (``is_tracked``), likelier than under these estimates, too.
    periods = [each.scan_period for each in estimates.sensors.values()]
    if None in periods:
        return None
    part = _part(reports)
    if part is None:
        return None
    distances = _distances(part, estimates)
    if not distances.size:
        return None
    stretch = Stretch.of_positions(part, configuration)
    beside, n_even = _of_false_alarms(estimates, part)
    trials = _Trials(stretch, beside, max(filter(None, periods)))
    least = max(SURE, SURE_OF_EACH * len(part))
    # Where objects go as they were found to, but seemed to be false alarms, all these are less
    # likely beside few.
    dearer = n_even * (-math.log(FEW) - (1.0 - FEW))
    before = trials.as_before() if n_even or is_tracked else 0.0
    if n_even and before < -dearer - least:
        return replace(beside, doubts={})
    best = trials.best(distances, line_up(part.look.astype(np.float64), part.measurement))
    if trials.cost(best) > -least:
        return None
    if is_tracked and trials.cost(best) > FAR_LIKELIER * before - least:
        return None
    return replace(trials.at(best), doubts={})


def _of_false_alarms(estimates: Estimates, reports: ReportTable) -> tuple[Estimates, int]:
    """Return estimates as if every report were a false alarm, and as many objects as reports."""
    # With them comes how many reports are of looks that have equally many.
    sensors, present, n_even = {}, 0.0, 0
    for name, each in estimates.sensors.items():
        own = reports.look[reports.sensor == reports.sensors.index(name)]
        density = own.size / max(np.unique(own).size, 1) / each.covered
        present = max(present, density)
        if is_filled_evenly(own):
            # As many at each look are objects', for false alarms come now and then.
            density *= FEW
            n_even += own.size
        sensors[name] = replace(each, clutter_density=positive(density))
    found = replace(
        estimates,
        sensors=sensors,
        new_target_density=positive(0.01 * present),
        initial_target_density=positive(0.3 * present),
    )
    return found, n_even


def _part(reports: ReportTable) -> ReportTable | None:
    """Return some scans of the middle; None where there are too few."""
    number = reports.look
    looks = np.unique(number)
    if looks.size < FEWEST_SCANS:
        return None
    most = max(int(MOST_REPORTS * looks.size / len(reports)), FEWEST_SCANS)
    size = min(MOST_SCANS, most, looks.size)
    first = (looks.size - size) // 2
    inside = (number >= looks[first]) & (number <= looks[first + size - 1])
    return reports.part(np.flatnonzero(inside))


def _distances_to(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return how far points are from the nearest others and the next, ascending."""
    near = min(1 + round(CROWDED), len(other))
    return np.asarray(tree_of(other).query(one, k=near)[0]).reshape(len(one), -1)


def _distances(reports: ReportTable, estimates: Estimates) -> FloatArray:
    """Return how far objects may go from look to look [m], ascending."""
    # Where a sensor's own reports are crowded their neighbours tell: objects may go in a lane.
    nearest, crowded, number = [], math.inf, reports.look
    ball = math.pi if reports.dim == 2 else 4.0 / 3.0 * math.pi
    for name, each in estimates.sensors.items():
        own = np.flatnonzero(reports.sensor == reports.sensors.index(name))
        moments, of = np.unique(number[own], return_inverse=True)
        looks = [reports.measurement[own[of == k]] for k in range(moments.size)]
        pairs = [_distances_to(a, b) for a, b in itertools.pairwise(looks)]
        nearest += [distance[:, 0] for distance in pairs]
        usual = max(own.size / max(moments.size, 1), 1.0)
        room = CROWDED * each.covered / (ball * usual)
        crowded = min(crowded, room ** (1.0 / reports.dim))
        beyond = np.concatenate(
            [*(each[:, -1] for each in pairs if each.shape[1] > 1), np.empty(0)]
        )
        if beyond.size:
            crowded = max(crowded, float(np.median(beyond)))
    every = np.concatenate([*nearest, np.empty(0)])
    every = every[every > 0.0]
    if not every.size:
        return every
    least = max(float(np.quantile(every, NEAREST)), crowded / COARSE**MOST_DISTANCES)
    steps = max(math.ceil(math.log(crowded / least, COARSE)), 0)
    return least * COARSE ** np.arange(min(steps, MOST_DISTANCES) + 1.0)
