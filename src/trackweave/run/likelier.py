"""Whether what threads tell of lone reports makes tracks likely, and what makes them likelier.

Where objects keep together, a convoy or a ward round, a thread goes from one to the next: their
distance seems to be noise, and one object to report as often as all of them. A stretch of the
reports is tracked as though there were less noise, less process noise and more objects, each of
which reports more seldom; while that makes its tracks clearly likelier, it goes on so. The tracks
are threads then, which tell everything anew.
"""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config import Configuration
from trackweave.config.fill import known_sigma
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates, bounded, positive
from trackweave.estimation.lone import middle_of
from trackweave.estimation.lone_values import AS_TOLD, NOT_SCANNING, seldomer
from trackweave.estimation.plausibility import without_stale
from trackweave.estimation.threads import Threads
from trackweave.run.kept import Kept
from trackweave.run.refining import Looking, estimates_for
from trackweave.run.stretches import Stretch, Tracked, middle_part

__all__ = ["likelier", "told_by_tracks"]

# Reports come one by one of which more than so many have an instant of their own.
ONE_BY_ONE = 0.95
# From look to look it is the same time but for such a share; seldom are so many missed.
EVENLY, FEW_MISSED = 0.1, 4.5
# So many reports in the middle are tracked at each trial, and in the end for their tracks.
MOST_TRIED, MOST_REPORTS, FEWEST = 250, 1500, 60
# Trials of noise and process noise, by how much less, and of how many times as many objects.
LESS, LESS_PROCESS, MORE = 3.0, 9.0, 2.0
# Trials are worth looking at that cost less by such a share, steps that do by so much; and in the
# end so much makes tracks clearly likelier.
CLEAR, ANY, SURE = 0.05, 0.003, 0.12
MOST_STEPS, MOST_ROUNDS = 5, 3
# A window among objects that keep together is so many times as long, and of so many instants at
# most.
LONGER, LONGEST = 2, 80

_Factors = tuple[float, float, float]
"""How many times less noise and process noise, and how many times more objects threads tell of."""
_AS_TOLD = 1.0, 1.0, 1.0


@dataclass(frozen=True, slots=True)
class _Trials:
    """What came of a stretch under less noise, for each trial."""

    stretch: Stretch
    estimates: Estimates
    beside: Estimates  # Whose false alarms instead of tracks the costs are beside
    is_told: bool  # Whether the noise of all sensors is, so that it is not tried
    found: dict[_Factors, Tracked] = field(default_factory=dict)

    def at(self, factors: _Factors) -> Estimates:
        """Return the estimates with so much less noise and so many more objects."""
        noise, process, objects = factors
        sensors = {
            name: replace(sensor, sigma=bounded(sensor.plane_sigma / noise, 1e-9))
            for name, sensor in self.estimates.sensors.items()
        }
        less = positive(self.estimates.process_noise / process)
        return seldomer(replace(self.estimates, sensors=sensors, process_noise=less), objects)

    def cost(self, factors: _Factors) -> float:
        """Return what tracks cost under such values [nats]."""
        if factors not in self.found:
            self.found[factors] = self.stretch.tracked(self.at(factors))
        return self.found[factors].cost - self._likelier_false_alarms()

    def _likelier_false_alarms(self) -> float:
        """Return by how much likelier all reports are as false alarms than beside [nats]."""
        reports, more = self.stretch.reports, 0.0
        for name, sensor in self.estimates.sensors.items():
            count = np.count_nonzero(reports.sensor == reports.sensors.index(name))
            before = self.beside.sensors[name].clutter_density
            more += count * math.log(sensor.clutter_density / before)
        return more

    def as_told(self) -> float:
        """Return what tracks cost under the estimates as they are [nats]."""
        return self.cost(_AS_TOLD)

    def best(self) -> Estimates:
        """Return the estimates with as much less noise as makes tracks clearly likelier."""
        here, before = _AS_TOLD, None
        for _ in range(MOST_STEPS):
            before, here = here, self._next(here)
            if here == before:
                break
        gain = self.as_told() - self.cost(here)
        # Beside a noise that is told little is left to win.
        least = ANY if self.is_told else CLEAR
        return self.at(here) if gain > least * abs(self.as_told()) else self.estimates

    def _next(self, here: _Factors) -> _Factors:
        """Return the best step from some factors, the same where none is better."""
        noise, process, objects = here
        less = 1.0 if self.is_told else LESS
        noises, processes = (noise, less * noise), [process, LESS_PROCESS * process]
        if self.is_told:
            # What goes from one to the next may seem to move less beside it.
            processes.append(process / LESS_PROCESS)
        every = itertools.product(noises, processes, (objects, MORE * objects))
        steps = [step for step in every if step != here]
        # Of a pack half of whose objects are told apart nothing may be likelier than of one.
        leaps = [(less**2 * noise, each, MORE**2 * objects) for each in processes]
        for some in (steps, leaps):
            best = min(some, key=self.cost)
            if self.cost(best) < self.cost(here) - ANY * abs(self.cost(here)):
                return best
        return here


def told_by_tracks(
    estimates: Estimates | None,
    reports: ReportTable,
    configuration: Configuration,
    kept: Kept,
    scanning: Mapping[str, bool],
) -> Estimates | None:
    """Return estimates as they are, or as tracks tell where no sensor looks.

    Parameters
    ----------
    estimates
        What reports tell so far; None for nothing.
    reports
        All of them, as positions.
    configuration
        What is told.
    kept
        What attempts of one run share.
    scanning
        Whether sensors look, by name, where that is told or known.

    Returns
    -------
    Those that make tracks clearly likelier, if there are any.
    """
    if estimates is None or estimates.of_one_object:
        return estimates
    if all(each.scans is False for each in estimates.sensors.values()):
        found = likelier(estimates, reports, configuration, kept)
        return estimates if found is None else without_stale(estimates, found)
    of_ranges = any(isinstance(each.sigma, tuple) for each in estimates.sensors.values())
    if scanning or of_ranges or np.unique(reports.time).size <= ONE_BY_ONE * len(reports):
        return estimates
    if all(
        _are_even(reports.time[reports.sensor == each]) for each in range(len(reports.sensors))
    ):
        return estimates
    # Of a pack, one report after the other seems to come of one object at which a sensor looks.
    looking = Looking(dict.fromkeys(reports.sensors, False))
    lone = estimates_for(reports, configuration, None, looking, kept)
    if lone is None or lone.sensors.keys() != estimates.sensors.keys():
        return estimates
    lone = replace(lone, notes=tuple(note.replace(AS_TOLD, "") for note in lone.notes))
    return likelier(lone, reports, configuration, kept) or estimates


def _are_even(time: FloatArray) -> bool:
    """Tell whether times are as even as of looks at one object, some missed: a pack's are not."""
    pauses = np.diff(np.unique(time))
    if not pauses.size:
        return True
    looks = pauses / np.median(pauses)
    even = np.abs(looks - np.round(looks)) < EVENLY
    return bool(np.mean(even & (looks > EVENLY) & (looks < FEW_MISSED)) > ONE_BY_ONE)


def likelier(
    estimates: Estimates, reports: ReportTable, configuration: Configuration, kept: Kept
) -> Estimates | None:
    """Return estimates under which tracks of lone reports are clearly likelier, if there are any.

    Parameters
    ----------
    estimates
        As threads of the reports tell, of sensors none of which looks.
    reports
        All of them, as positions.
    configuration
        What is told.
    kept
        What attempts of one run share: those that follow take what the first found.

    Returns
    -------
    None where those of threads are as good. Beside a noise that is told these are without it.
    """
    told = known_sigma(configuration, reports.sensors)
    if len(reports) < FEWEST or reports.identity is not None or reports.kinds:
        return None
    asked = "likelier", told
    known: list[Estimates] | None = kept.known(asked, ())
    if known is None:
        known = _likelier(estimates, reports, configuration, told)
        kept.keep(asked, (), known)
    return known[0] if known else None


def _completed(found: Estimates, estimates: Estimates) -> Estimates:
    """Return what was found with what else was told: of heights, and of reports left out."""
    sensors = {
        name: replace(
            sensor,
            sigma_height=estimates.sensors[name].sigma_height,
            height_offset=estimates.sensors[name].height_offset,
        )
        for name, sensor in found.sensors.items()
    }
    others = [note for note in estimates.notes if NOT_SCANNING not in note]
    own = [note for note in found.notes if note not in others]
    # Who of a pack reports is told by more of its reports than of those that are alone.
    depth = min(LONGER * (found.depth or 1), LONGEST)
    notes = (*others, *own)
    return replace(found, sensors=sensors, notes=notes, depth=depth, max_scans=depth)


def _likelier(
    estimates: Estimates,
    reports: ReportTable,
    configuration: Configuration,
    told: Mapping[str, float],
) -> list[Estimates]:
    """Return what is likelier, if anything, with the noise that is told by sensor [m]."""
    stretch = _stretch_of(reports, configuration, MOST_TRIED)
    whole = _stretch_of(reports, configuration, MOST_REPORTS)
    is_told = len(told) == len(reports.sensors)
    first = _Trials(stretch, estimates, estimates, is_told)
    trials = first
    for _ in range(MOST_ROUNDS):
        best = trials.best()
        if best is trials.estimates:
            break
        found = _told_by(whole, whole.tracked(best), told)
        # Where tracks still go from one to the next what was tried may be better than what they
        # tell; beside a noise that is told that is all there is.
        best = replace(best, notes=found.notes)
        tried = [found, _with_noise(found, best), *([best] if is_told else [])]
        trials = min(
            (_Trials(stretch, each, estimates, is_told) for each in tried), key=_Trials.as_told
        )
    if is_told:
        first = _as_untold(reports, configuration, estimates)
    gain = first.as_told() - trials.as_told()
    is_sure = gain > SURE * abs(first.as_told())
    found = _completed(trials.estimates, estimates)
    confirmed = tuple(f"sensors.{name}.sigma" for name in told) if is_told else ()
    return [replace(found, confirmed=confirmed)] if is_sure else []


def _as_untold(reports: ReportTable, configuration: Configuration, beside: Estimates) -> _Trials:
    """Return what comes of a stretch under the noise that threads tell, whatever is told."""
    sensors = {name: dict(table) for name, table in configuration.table("sensors").items()}
    for table in sensors.values():
        table.pop("sigma", None)
    stretch = _stretch_of(reports, configuration.changed(sensors=sensors), MOST_TRIED)
    lone = dict.fromkeys(reports.sensors, False)
    return _Trials(stretch, estimate(reports, {}, lone), beside, is_told=False)


def _told_by(stretch: Stretch, tracked: Tracked, sigma: Mapping[str, float]) -> Estimates:
    """Return what tracks of a stretch tell, and ``sigma`` [m] where it is known, by sensor."""
    reports, configuration = stretch.reports, stretch.configuration
    told = {
        name: False for name in reports.sensors if configuration.sensor(name).get("scans") is False
    }
    return estimate(reports, sigma, told, _threads(reports, tracked.track))


def _with_noise(estimates: Estimates, of: Estimates) -> Estimates:
    """Return estimates with the noise and the process noise of others."""
    sensors = {
        name: replace(sensor, sigma=of.sensors[name].sigma)
        for name, sensor in estimates.sensors.items()
    }
    return replace(estimates, sensors=sensors, process_noise=of.process_noise)


def _stretch_of(reports: ReportTable, configuration: Configuration, most: int) -> Stretch:
    """Return so many reports at most, in the middle of the time."""
    return Stretch.of_positions(middle_part(reports, most), configuration)


def _threads(reports: ReportTable, track: IntArray) -> Mapping[str, Threads]:
    """Return each sensor's reports on tracks, by its name."""
    found = {}
    for index, name in enumerate(reports.sensors):
        rows = middle_of(reports, index)
        numbers = np.unique(track[rows])
        own = [np.flatnonzero(track[rows] == number) for number in numbers[numbers >= 0]]
        found[name] = Threads(sorted(own, key=lambda each: -each.size), rows.size)
    return found
