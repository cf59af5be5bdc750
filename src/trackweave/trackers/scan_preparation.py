"""Scans as they come become scans that a tree grows by."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._levels import SIZE as LEVEL_SIZE
from trackweave.association._nodes import Families, ScanInput, WindowRule, part_of
from trackweave.association._rhythm import SIZE as RHYTHM_SIZE
from trackweave.association.initial_tracks import InitialTracks
from trackweave.association.missed_detections import waited
from trackweave.association.tree import AssociationTree
from trackweave.association.window_rule import Context, scan_input, window_rule
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.models.foreign_motion import AnyMotion, ForeignMotion
from trackweave.models.rotation import Rotation
from trackweave.models.sensors import Sensor
from trackweave.trackers._arguments import period_of
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.live_beam import LiveBeam, beam_with, rotation_by
from trackweave.trackers.persistence import last_scans, repeats
from trackweave.trackers.window import OpenScan, OpenScans

__all__ = [
    "ScanPreparation",
    "begin_of_sweep",
    "begun",
    "longest_unseen",
    "rooted",
    "rule_of",
]

UNSEEN_WITHOUT_PERIOD, UNSEEN_PERIODS = 600.0, 10.0
"""For so long an object is followed that no sensor looks at [s], or for so many times the misses
after which a track ends, in scan periods. While none looks at anything, that does not count."""
MOST_SILENCES = 3.0
"""Its name stays open for so many usual silences at least."""
GONE = math.log(1000.0)
"""… or when it is so much more probable that its object is gone [nats]."""
USUAL_MISSES = 5
"""… or of a tracker that decides scan by scan, after so many misses."""

MOST_BEFORE = 500
"""So many scans of a sensor are known to those that follow, sectors of a turn each by itself."""
LEAST_SHARE = 0.02
"""A report that comes by itself is this share of a scan at least, or a window holds thousands."""
MOST_TURNED = 1.1
"""Ends of sweeps that follow one another lie at most so many turns apart; no motor is exact."""


def _with_silences(sensors: Mapping[str, Sensor]) -> list[Sensor]:
    """Return the sensors that do not see some objects for a while."""
    # Where there is one sensor, that is what the lifecycle tells of.
    every = sensors.values() if len(sensors) > 1 else ()
    return [each for each in every if each.hidden_share > 0.0 and each.scan_period is not None]


class ScanPreparation:
    """Opens scans, and remembers what a scan is seen against; misses count per period [s]."""

    def __init__(self, motion: AnyMotion, sensors: Mapping[str, Sensor], period: float) -> None:
        self._motion = motion
        self._period = period
        self._is_periodic = any(each.scan_period is not None for each in sensors.values())
        self._sensors = sensors
        self._number = {name: number for number, name in enumerate(sensors)}
        self._column = {each.name: at for at, each in enumerate(_with_silences(sensors))}
        self._identities: frozenset[int] = frozenset()
        self._ends: dict[str, float] = {}
        self._beams: dict[str, LiveBeam | None] = {}
        self._before: dict[str, list[ScanInput]] = {}
        self._pauses: list[tuple[float, float]] = []

    def __getstate__(self) -> dict[str, Any]:
        changing = ("_ends", "_beams", "_before", "_pauses")
        return {**self.__dict__, **{name: getattr(self, name).copy() for name in changing}}

    def open(self, scan: Scan, dim: int) -> OpenScan:
        """Return a scan of the window before it is known what came before it."""
        # Its reports are in the order in which the tree takes them.
        if scan.identity is not None:
            named = set(scan.identity[scan.identity >= 0].tolist())
            if not named <= self._identities:
                self._identities |= named
        sensor = self._as_it_turns(scan)
        context = Context(
            motion=self._motion,
            dim=dim,
            sensor=self._number[scan.sensor],
            column=self._column.get(scan.sensor, -1),
            n_identities=max(1, len(self._identities)),
            start=self._start(scan, sensor.rotation),
            period=self._period,
        )
        data, order = scan_input(scan, sensor, 0.0, context)
        share = self._share(data, scan.sensor, sensor.rotation, context.start)
        repeat = self._repeats(data, sensor)
        return OpenScan(scan, data, scan.report[order], np.zeros(len(scan)), repeat, share)

    def _share(
        self, data: ScanInput, name: str, rotation: Rotation | None, start: float | None
    ) -> float:
        """Return how much of a scan it is: a sector, or what comes by itself beside scans."""
        if rotation is not None and start is not None:
            turns = float(rotation.turned(data.time) - rotation.turned(start))
            return min(1.0, max(1e-3, turns))
        if data.is_silence_telling or not self._is_periodic:
            return 1.0
        last = self._ends.get(name, -np.inf)
        self.pass_over(name, data.time)
        return min(1.0, max(LEAST_SHARE, (data.time - last) / self._period))

    def _repeats(self, data: ScanInput, sensor: Sensor) -> FloatArray:
        """Return what each report says for a false alarm that came again [nats]."""
        if sensor.clutter_persistence == 0.0:
            return np.zeros(data.slot.shape[0])
        held = self._before.get(sensor.name, [])
        before = last_scans(data.time, held, sensor.scan_period)
        # A late scan stands before others, and one of the same time in its place.
        others = [each for each in held[-MOST_BEFORE:] if each.time != data.time]
        self._before[sensor.name] = sorted([*others, data], key=lambda each: each.time)
        return repeats(data, before, sensor)

    def put_in(self, late: Scan, window: OpenScans, dim: int) -> None:
        """Put a late scan into the window; what comes again may come from it."""
        window.insert(self.open(late, dim))
        sensor, held = self._sensors[late.sensor], self._before.get(late.sensor, [])
        for place, known in enumerate(window.scans if held else ()):
            if known.sensor == late.sensor and known.data.time > late.time:
                before = last_scans(known.data.time, held, sensor.scan_period)
                told = repeats(known.data, before, sensor)
                window.scans[place] = replace(known, repeat=told)

    def opened(self, scans: Sequence[Scan], window: OpenScans, dim: int) -> list[OpenScan]:
        """Return the scans of a step opened; none of a single one, or where the first is late."""
        # A scan alone, or one that is put into its place in time, is opened when its turn comes.
        first = scans[0]
        if len(scans) == 1 or first.time < window.last_time:
            return []
        if window.find(first.sensor, first.time) is not None:
            return []
        return [self.open(scan, dim) for scan in scans]

    def patient(self, rule: WindowRule, last: float, time: float) -> WindowRule:
        """Return a rule that gives nobody up for the pauses in which no sensor looked."""
        # ``last`` is when the last scan was, minus infinity for none, and ``time`` when this one
        # is; a window that grows anew comes to known ones again.
        is_known = bool(self._pauses) and last < self._pauses[-1][1]
        is_long = np.inf > time - last > UNSEEN_PERIODS * self._period
        if self._is_periodic and is_long and not is_known:
            self._pauses.append((last, time))
        paused = 0.0
        for number, (begin, end) in reversed(list(enumerate(self._pauses))):
            if time - end - paused > rule.max_unseen:
                del self._pauses[: number + 1]
                break
            paused += end - begin
        if paused == 0.0:
            return rule
        return rule._replace(
            max_unseen=rule.max_unseen + paused, max_shown=rule.max_shown + paused
        )

    def _as_it_turns(self, scan: Scan) -> Sensor:
        """Return a scan's sensor, of a turning one where its reports show the beam."""
        sensor = self._sensors[scan.sensor]
        if sensor.rotation is None:
            return sensor
        known = self._beams.get(scan.sensor)
        if scan.time > self._ends.get(scan.sensor, -np.inf):
            known = self._beams[scan.sensor] = beam_with(known, sensor, scan)
        turning = rotation_by(known, sensor.rotation)
        return sensor if turning is sensor.rotation else replace(sensor, rotation=turning)

    def pass_over(self, sensor: str, until: float) -> None:
        """Take it that a sensor looked elsewhere until a time [s]."""
        self._ends[sensor] = max(until, self._ends.get(sensor, -np.inf))

    def _start(self, scan: Scan, rotation: Rotation | None) -> float | None:
        """Return when the sweep of a turning sensor began that ends with a scan."""
        last = self._ends.get(scan.sensor, -np.inf)
        begin = begin_of_sweep(scan, rotation, last)
        if begin is not None:
            self._ends[scan.sensor] = scan.time
        return begin


def begin_of_sweep(scan: Scan, rotation: Rotation | None, last: float) -> float | None:
    """Return when the sweep of a turning sensor began that ends with a scan [s].

    Parameters
    ----------
    scan
        The scan.
    rotation
        How its sensor turns, None where it does not.
    last
        When the sensor's scan before it ended [s], minus infinity for none.

    Returns
    -------
    The time, None where nothing is known of a sweep.
    """
    if scan.moments is None or rotation is None or scan.time <= last:
        return None
    first = float(scan.moments.min(initial=scan.time))
    # What was not handed over was not looked at; a turn is as much as there is.
    turned = float(rotation.turned(scan.time))
    if not np.isfinite(last) or turned - float(rotation.turned(last)) > MOST_TURNED:
        return first
    return min(max(last, float(rotation.when(turned - 1.0))), first)


def longest_unseen(lifecycle: Lifecycle, sensors: Sequence[Sensor]) -> tuple[float, float]:
    """Return for how long an object without reports is shown, and followed at most [s]."""
    misses = lifecycle.delete_after_misses or USUAL_MISSES
    periodic = any(sensor.scan_period is not None for sensor in sensors)
    shown = UNSEEN_WITHOUT_PERIOD
    if periodic:
        shown = UNSEEN_PERIODS * misses * period_of(sensors)
    return shown, lifecycle.rejoin or max(shown, MOST_SILENCES * lifecycle.mean_silence)


def rule_of(
    motion: AnyMotion,
    lifecycle: Lifecycle,
    sensors: Mapping[str, Sensor],
    dim: int,
    *,
    unscented: bool,
) -> WindowRule:
    """Return the rule by which a tracker's tree grows."""
    if isinstance(motion, ForeignMotion) and motion.has_kinematics:
        for sensor in sensors.values():
            if sensor.measurement.has_rate or sensor.measurement.is_bearing_only:
                raise InvalidInputError(
                    f"{motion.name}: sensor {sensor.name} measures {sensor.measurement.word}; "
                    "expected states that begin with position and velocity, without kinematics"
                )
    period = period_of(sensors.values())
    shares = [each.hidden_share for each in _with_silences(sensors)]
    shown, unseen = longest_unseen(lifecycle, list(sensors.values()))
    rule = window_rule(
        motion,
        (lifecycle.survival, GONE, lifecycle.delete_after_misses or np.inf, unseen, shown),
        dim,
        unscented=unscented,
        crossing_time=period,
    )
    return rule._replace(unseen=np.array(shares, dtype=np.float64))


def begun(priors: TrackTable, rule: WindowRule) -> InitialTracks:
    """Return tracks known beforehand as they enter a tree."""
    # In their states nothing is known of what the priors do not tell.
    count, known = len(priors), priors.mean.shape[1]
    motion = rule.motion
    modes, size = motion.kind.shape[0], motion.prior.shape[0]
    mean, covariance = np.zeros((count, modes, size)), np.zeros((count, modes, size, size))
    covariance[:] = np.diag(motion.prior)
    if rule.way is not None and count:
        place, spread = priors.mean[:, : motion.dim], priors.covariance[:, : motion.dim]
        begun = rule.way.begin(place, np.ascontiguousarray(spread[:, :, : motion.dim]), size)
        mean[:, 0], covariance[:, 0] = begun
        # Of states that tell velocities in their own way only the place is taken.
        known = 0 if rule.way.has_kinematics else known
        covariance[:, 0, :known], covariance[:, 0, :, :known] = 0.0, 0.0
    mean[:, :, :known] = priors.mean[:, None, :known]
    covariance[:, :, :known, :known] = priors.covariance[:, None, :known, :known]
    zero, nobody = np.zeros(count), np.full(count, -1, dtype=np.int64)
    return InitialTracks(
        track=priors.track,
        time=priors.time,
        mean=mean,
        covariance=covariance,
        weight=np.broadcast_to(motion.share, (count, modes)),
        hits=np.maximum(priors.hits, 1),
        chances=zero,
        tail=zero,
        hidden=zero,
        unseen=np.tile(rule.unseen, (count, 1)),
        misses=zero,
        wild=np.full(count, -1.0),
        rhythm=np.full((count, RHYTHM_SIZE), -1.0),
        level=np.full((count, LEVEL_SIZE), np.nan),
        identity=nobody,
        other=nobody,
        sensor=nobody,
        is_line=np.zeros(count, dtype=np.int64),
        slot=nobody,
    )


def rooted(
    tree: AssociationTree, closed: Sequence[ScanInput], window: Sequence[ScanInput], since: float
) -> tuple[InitialTracks, Families]:
    """Return the tracks, and their families, as they enter the window behind closed scans."""
    # ``closed`` are the last scans that were closed, ``window`` those that the tree has grown by
    # since it was fixed up to them; the last that is closed and not among them was at ``since``
    # [s]. The tracks tell what they missed since their last report.
    nodes, n = tree.nodes, tree.n_nodes
    rows = np.flatnonzero((nodes.parent[:n] < 0) & (nodes.report[:n] < 0))
    families = part_of(tree.families, nodes.family[rows])
    slot = families.fixed_slot
    # A track without a report among those scans has waited through all of them.
    end = np.array([data.slot[-1] + 1 if data.slot.size else -1 for data in closed], dtype=float)
    end = np.maximum.accumulate(end) if end.size else end
    oldest = min((int(data.slot[0]) for data in closed if data.slot.size), default=0)
    first = np.where(slot < oldest, 0, np.searchsorted(end, slot, side="right") + 1)
    nothing = np.zeros(rows.shape[0])
    held = {name: getattr(nodes, name)[rows] for name in InitialTracks.names()}
    begins = InitialTracks(track=families.track, slot=slot, **held)
    begins = replace(begins, tail=nothing, hidden=nothing.copy(), misses=nothing.copy())
    longer = np.flatnonzero((begins.time <= since) & np.isfinite(held["tail"]))
    begins.hidden[longer] = held["hidden"][longer]
    if longer.size:
        # What all scans there are do not account for was missed in those before them.
        told = waited(begins, first, [*closed, *window], tree.rule)
        for name in ("tail", "misses"):
            missed = held[name][longer] - getattr(told, name)[longer]
            getattr(begins, name)[longer] = np.maximum(0.0, missed)
    return waited(begins, first, closed, tree.rule), families
