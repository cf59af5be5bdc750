"""Whether objects give several reports a look, and how far these lie apart.

Where they do, tracks take one report and leave the others to false alarms and to tracks of
nobody. A stretch of reports is tracked as it is, and with all of a look that lie near one another
as one; what is beside the one then costs what a piece costs of so many an object, normal about
it. If the whole is clearly likelier so, objects have that extent. Groups that keep together are
told apart by the same: who merges them loses tracks that cost less than pieces would.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config import Configuration
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.measurements import MeasurementKind
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates, digits
from trackweave.run.diagnostics.repeats import BY_CHANCE, are_named_apart, beside
from trackweave.run.observing import positions_in
from trackweave.run.pieces import pieces_of, seen_from_sensor, with_extent
from trackweave.run.polar_to_cartesian import laid, placed
from trackweave.run.stretches import Stretch, Tracked, middle_part

__all__ = ["likeliest_extent"]

# Of so many reports such a share must lie as near another of their look as chance puts a tenth.
FEWEST, BESIDE, MOST_LOOKED_AT = 100, 0.3, 20_000
# Of another sensor so many times as many lie within the extent as chance puts there.
BEYOND_CHANCE = 5.0
# So many reports are tracked at each trial. Extents grow by such steps, from where few
# reports are beside another to what is beyond that of most.
MOST, STEP, FEW, MANY, WIDER = 1500, 2.25, 0.06, 0.9, 2.0
# So many trials in succession that cost more than tracks alone are the last.
MOST_WORSE = 2
# Tracks and pieces must be so much likelier, by the cost of tracks and by so much a report [nats].
SURE, A_REPORT = 0.03, 0.05
# What has so many pieces on one track has a shape of its own.
OWN_SHAPE = 12
# So many times less clutter than where all are tracked alone is doubted.
RARER = 10.0
# Pieces lie about their objects within such a part of how far a sensor sees them all.
MOST_OF_VIEW = 0.35
# Nor is a report that is farther off its track's way, in deviations, one that noise explains: what
# is no object jumps from one to the next of those that it takes in.
FARTHEST = 5.0
# They scatter by such a part of the extent at least.
LEAST = 0.01


def likeliest_extent(
    reports: ReportTable, look: IntArray | FloatArray, configuration: Configuration
) -> tuple[float, list[str]]:
    """Return how far pieces of an object are from the next [m], and the sensors that report any.

    Parameters
    ----------
    reports
        All of a run.
    look
        Number of each one's look, shape (reports,).
    configuration
        What is told.

    Returns
    -------
    No sensor where tracks and pieces are not clearly likelier than tracks alone.
    """
    if not np.array_equal(look, reports.look):
        # Turns are scans, or each of their reports would be a look of its own.
        reports = replace(reports, scan=np.asarray(look, dtype=np.int64))
    chosen = _crowded(reports, configuration)
    if not chosen:
        return 0.0, []
    trials = _Trials(_middle_of(reports, chosen), configuration)
    extent = trials.best()
    if not extent:
        return 0.0, []
    return extent, [*trials.names, *_alike(reports, configuration, extent, chosen)]


def _middle_of(reports: ReportTable, names: Sequence[str]) -> ReportTable:
    """Return reports of some sensors alone, in the middle of the time."""
    indices = [reports.sensors.index(name) for name in names]
    part = middle_part(reports.part(np.flatnonzero(np.isin(reports.sensor, indices))), MOST)
    found, sensor = np.unique(part.sensor, return_inverse=True)
    return replace(
        part,
        sensor=sensor,
        sensors=tuple(part.sensors[index] for index in found),
        kinds=tuple(part.kinds[index] for index in found) if part.kinds else (),
    )


def _giving_places(
    reports: ReportTable, configuration: Configuration
) -> Iterator[tuple[str, IntArray]]:
    """Yield the sensors of whose objects an extent may be learned, with rows of theirs."""
    for index, name in enumerate(reports.sensors):
        kind, said = reports.kind_of(index), configuration.sensor(name)
        rows = np.flatnonzero(reports.sensor == index)[:MOST_LOOKED_AT]
        if "extent" in said or said.get("scans") is False or rows.size < FEWEST:
            continue
        if isinstance(kind, ForeignKind) or not kind.gives_position(reports.dim):
            continue
        if kind.needs_place and len(reports.sensors) > 1 and not _is_placed(reports, index, said):
            continue
        if not are_named_apart(reports, rows):
            yield name, rows


def _crowded(reports: ReportTable, configuration: Configuration) -> list[str]:
    """Return the sensors of whose reports many lie beside another of their look."""
    chosen = []
    for name, rows in _giving_places(reports, configuration):
        apart, near = _beside(reports, rows)
        if np.mean(apart <= near) >= BESIDE:
            chosen.append(name)
    return chosen


def _alike(
    reports: ReportTable, configuration: Configuration, extent: float, chosen: Sequence[str]
) -> list[str]:
    """Return the other sensors that see the same objects give several reports, too."""
    found = []
    for name, rows in _giving_places(reports, configuration):
        apart, near = _beside(reports, rows)
        chance = 1.0 - (1.0 - BY_CHANCE) ** ((extent / near) ** reports.dim)
        share = float(np.mean(apart <= extent))
        if name not in chosen and share >= max(FEW, BEYOND_CHANCE * chance):
            found.append(name)
    return found


def _is_placed(reports: ReportTable, index: int, said: Mapping[str, Any]) -> bool:
    """Tell whether it is known where a sensor stands, or is."""
    if "position" in said or reports.platform is None:
        return "position" in said
    return not np.isnan(reports.platform[reports.sensor == index, 0]).any()


def _beside(reports: ReportTable, rows: IntArray) -> tuple[FloatArray, float]:
    """Return how far a sensor's reports are from the next of their look, and what is near [m]."""
    look = np.unique(reports.look[rows], return_inverse=True)[1]
    return beside(look, _seen(reports, rows))


def _seen(reports: ReportTable, rows: IntArray) -> FloatArray:
    """Return where a sensor's reports are, seen from it [m]."""
    kind = reports.kind_of(int(reports.sensor[rows[0]]))
    assert isinstance(kind, MeasurementKind)
    return seen_from_sensor(kind, reports.measurement[rows, : kind.n_components(reports.dim)])


def _width(places: FloatArray) -> float:
    """Return how far places are from their middle, as a root mean square [m]."""
    return float(np.sqrt(places.var(axis=0).sum()))


class _Trials:
    """What tracks and pieces cost, by the extent of objects."""

    def __init__(self, part: ReportTable, configuration: Configuration) -> None:
        self._part, self._configuration = part, configuration
        self._places = positions_in(part, configuration)
        self._position = self._placed(part)
        self.names: tuple[str, ...] = ()
        """Sensors whose reports may be pieces."""
        self._told: dict[float, Estimates] = {}
        self._n_tracks: dict[float, int] = {}
        of_sensors = [np.flatnonzero(part.sensor == k) for k in range(len(part.sensors))]
        self._view = max(_width(_seen(part, rows)) for rows in of_sensors if rows.size)

    def best(self) -> float:
        """Return the extent under which all is likeliest, 0 where it is not clearly likelier."""
        sensors = self._part.sensors
        looking = dict.fromkeys(() if self._part.scan is None else sensors, True)
        alone = self._alone = estimate(self._position, {}, looking)
        # Objects that report by themselves give no pieces, however often two do at once.
        self.names = tuple(each for each in sensors if alone.sensors[each].scans is not False)
        if not self.names:
            return 0.0
        first, tracked = self._tracked(self._position, alone)
        costs, worse = {0.0: first}, 0
        for extent in self._extents():
            costs[extent] = self._cost(extent)
            worse = worse + 1 if costs[extent] > first else 0
            if worse == MOST_WORSE:
                break
        best = min(costs, key=costs.__getitem__)
        if best:
            # Two that keep together spoil what is told of them for each itself, not of the pair.
            first = min(first, self._tracked(self._position, self._told[best])[0])
        if first - costs[best] < max(SURE * abs(tracked.cost), A_REPORT * len(self._part)):
            return 0.0
        best = self._of_fewest(costs)
        between = [digits(best * step, 3) for step in (math.sqrt(STEP), 1.0 / math.sqrt(STEP))]
        return self._of_fewest(costs | {extent: self._cost(extent) for extent in between})

    def _of_fewest(self, costs: Mapping[float, float]) -> float:
        """Return the extent under which there are the fewest tracks, of those about as likely."""
        most = min(costs.values()) + A_REPORT * len(self._part)
        likely = [extent for extent, cost in costs.items() if extent and cost <= most]
        return min(likely, key=lambda extent: (self._n_tracks[extent], costs[extent]))

    def _extents(self) -> list[float]:
        """Return the extents to be tried, from where a few reports are beside others [m]."""
        part = self._part
        of_sensors = [np.flatnonzero(part.sensor == part.sensors.index(n)) for n in self.names]
        apart = np.concatenate([_beside(part, rows)[0] for rows in of_sensors if rows.size])
        low, high = np.quantile(apart, [FEW, MANY])
        if not high > 0.0:
            return []
        low = max(float(low), 1e-3 * float(high))
        count = math.ceil(math.log(WIDER * float(high) / low) / math.log(STEP))
        return [digits(low * STEP**step, 3) for step in range(count + 1)]

    def _placed(self, reports: ReportTable) -> ReportTable:
        """Return reports as positions, which all of them tell."""
        return placed(laid(reports, self._places)[0], self._places)

    def _tracked(self, reports: ReportTable, estimates: Estimates) -> tuple[float, Tracked]:
        """Return what tracks and false alarms cost [nats], and what came of the reports."""
        tracked = Stretch.of_positions(reports, Configuration()).tracked(estimates)
        cost = tracked.cost
        for index, name in enumerate(reports.sensors):
            own = reports.sensor == index
            sensor, looks = estimates.sensors[name], np.unique(reports.look[own]).size
            # Costs of tracks are beside all as false alarms, of which there is a Poisson number.
            cost -= np.count_nonzero(own) * math.log(sensor.clutter_density)
            cost += sensor.clutter_density * sensor.covered * looks
        sigma = np.array([estimates.sensors[name].plane_sigma for name in reports.sensors])
        return cost - _gain_of_own_noise(reports, tracked.track, sigma), tracked

    def _cost(self, extent: float) -> float:
        """Return what tracks and pieces cost where objects have such an extent [nats]."""
        configuration = with_extent(self._configuration, self.names, extent)
        pieces = pieces_of(self._part, self._part.look, configuration)
        reports = self._placed(pieces.joined)
        aside = self._position.measurement - reports.measurement[pieces.place]
        many = np.bincount(pieces.place)[pieces.place] > 1
        if many.any() and _width(aside[many]) > MOST_OF_VIEW * self._view:
            # All that is seen at a time is no object.
            return math.inf
        told = estimate(reports, {}, dict.fromkeys(self.names, True))
        costs = []
        for each in self._with_clutter(told):
            cost, tracked = self._tracked(reports, each)
            cost += _cost_of_pieces(aside, pieces.place, tracked.track, LEAST * extent)
            costs.append((cost, each, np.unique(tracked.track[tracked.track >= 0]).size))
        cost, self._told[extent], self._n_tracks[extent] = min(costs, key=lambda one: one[0])
        return cost

    def _with_clutter(self, told: Estimates) -> list[Estimates]:
        """Return estimates; where hardly any clutter is left, also with that of tracks alone."""
        # Joined, plots that were false alarms seem to be objects' too, and then all the others.
        before = {name: self._alone.sensors[name].clutter_density for name in self.names}
        if all(told.sensors[name].clutter_density * RARER > before[name] for name in self.names):
            return [told]
        sensors = {
            name: replace(each, clutter_density=before.get(name, each.clutter_density))
            for name, each in told.sensors.items()
        }
        return [told, replace(told, sensors=sensors)]


def _gain_of_own_noise(reports: ReportTable, track: IntArray, sigma: FloatArray) -> float:
    """Return how much likelier tracks are if each has a noise of its own [nats]."""
    # The middle of a long ship's pieces wanders farther than a small one's report. How far each
    # report lies off the way between its neighbours is in units of the noise of all, by axis.
    rows = np.flatnonzero(track >= 0)
    rows = rows[np.lexsort((reports.time[rows], track[rows]))]
    gain = 0.0
    for own in np.split(rows, np.flatnonzero(np.diff(track[rows])) + 1):
        if own.size < OWN_SHAPE:
            continue
        time, place = reports.time[own], reports.measurement[own]
        share = (time[1:-1] - time[:-2]) / np.maximum(time[2:] - time[:-2], 1e-9)
        off = place[1:-1] - place[:-2] - share[:, None] * (place[2:] - place[:-2])
        off /= (np.sqrt(1.0 + share**2 + (1.0 - share) ** 2) * sigma[reports.sensor[own[1:-1]]])[
            :, None
        ]
        square = max(float(np.mean(np.minimum(off**2, FARTHEST**2))), LEAST**2)
        gain += max(0.5 * off.size * (square - 1.0 - math.log(square)) - math.log(off.size), 0.0)
    return gain


def _cost_of_pieces(aside: FloatArray, place: IntArray, track: IntArray, least: float) -> float:
    """Return what pieces cost that lie normally about their objects [nats]."""
    # Each object has a Poisson number of them. ``aside`` is how far each report is from its
    # object, ``place`` the number of that, and ``track`` the object's, by that number. What has
    # many pieces on one track has a shape and a number of its own; ``least`` is how far they
    # scatter at least, as equal ones would be infinitely likely.
    own_track = track[place]
    many = np.bincount(place)[place] > 1
    number, count = np.unique(own_track[many], return_counts=True)
    shapes = [own_track == each for each in number[(number >= 0) & (count >= OWN_SHAPE)]]
    rest = ~np.any(shapes, axis=0) if shapes else np.ones(place.size, dtype=bool)
    return sum(
        _number(place[own]) + _spread(aside[own & many], place[own & many], least)
        for own in [*shapes, rest]
    )


def _number(place: IntArray) -> float:
    """Return what it costs that objects have so many pieces [nats]."""
    objects = np.unique(place).size
    pieces = len(place) - objects
    return pieces * (1.0 + math.log(objects / pieces)) if pieces else 0.0


def _spread(aside: FloatArray, place: IntArray, least: float) -> float:
    """Return what the places of pieces cost beside their objects [nats]."""
    pieces = len(place) - np.unique(place).size
    if pieces == 0:
        return 0.0
    scatter = aside.T @ aside / pieces
    scatter += least**2 * np.eye(len(scatter))
    return 0.5 * pieces * float(np.linalg.slogdet(2.0 * math.pi * math.e * scatter)[1])
