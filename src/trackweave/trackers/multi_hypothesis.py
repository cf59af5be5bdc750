"""The multi-hypothesis tracker: a sliding window over an association tree, with N-scan pruning."""

import copy
from collections.abc import Sequence
from typing import ClassVar, Literal

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association.beliefs import Beliefs, believe
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.inactive import InactiveClusters
from trackweave.association.initial_tracks import InitialTracks
from trackweave.association.problem import Answer, Status
from trackweave.association.pruned import forget_negligible, judged
from trackweave.association.tree import AssociationTree
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.fields import checked_choice, checked_flag
from trackweave.models.foreign_motion import AnyMotion, MotionModel
from trackweave.models.sensors import Sensor
from trackweave.randomness import RandomSource
from trackweave.solvers.auto import Auto
from trackweave.solvers.protocol import Hint, Solver, Stop, answered
from trackweave.trackers._arguments import (
    checked_dim,
    checked_priors,
    checked_sensors,
    checked_window,
    in_order,
    merged,
    period_of,
    reference_of,
    require_haste,
    require_parts,
    slowest_of,
    tells_place,
    with_dimensions,
)
from trackweave.trackers.clock_guard import MAX_AHEAD, Arrival, ClockGuard
from trackweave.trackers.clusters import Clusters, clusters_of
from trackweave.trackers.fixed_history import FixedHistory
from trackweave.trackers.hypothesis import Assignments, Hypothesis
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.live import Haste, ScanByScan
from trackweave.trackers.pacing import Pace, Pacer
from trackweave.trackers.report_index import ReportIndex
from trackweave.trackers.rows import live_rows, n_live
from trackweave.trackers.scan_preparation import USUAL_MISSES, ScanPreparation, begun, rule_of
from trackweave.trackers.track_manager import TrackManager
from trackweave.trackers.undetected import Undetected
from trackweave.trackers.used_numbers import UsedNumbers
from trackweave.trackers.window import OpenScan, OpenScans, Window

__all__ = ["MultiHypothesisTracker"]


class MultiHypothesisTracker(ScanByScan):
    """Tracks objects by choosing the best explanation of the last few scans, again at each scan.

    A track-oriented multi-hypothesis tracker (MHT) with N-scan pruning: what lies before the
    window is fixed; what lies in it may be amended by later scans (D. B. Hillis, US patent
    6,055,523, 2000, "The Tracker Program").

    Parameters
    ----------
    motion
        How objects move: a model of ours, or one of your own, see `MotionModel`.
    sensors
        What the sensors report; scans of other sensors are refused.
    window
        How much of the past stays open, or its depth in scans.
    search
        Any solver; None for ``Auto``.
    lifecycle
        When tracks begin to count and end.
    priors
        Tracks known beforehand, confirmed; their times must not lie behind the first scan.
    limits
        What bounds the number of sequences considered; None for what serves such sensors.
    estimate
        What is reported of a track: the "average" over its sequences by their probability, or
        the state of the "best" hypothesis alone. Only the first also tells probabilities.
    dim
        Number of dimensions of the tracking space, 2 or 3; None for what priors, sensors or the
        first report tell.
    unscented
        Whether turns and what is not linear in a measurement are taken by sigma points (the
        unscented filter) instead of Jacobians (the extended one).
    max_ahead
        A scan further ahead of all others than this is held back [s], and told in the hypothesis,
        until three agree with one another or time gets there; 2.5 periods of the slowest sensor
        are never too far. None takes every scan as it comes.

    Raises
    ------
    InvalidInputError
        If an argument is of another kind than it has to be, or two sensors or priors have a name.

    Examples
    --------
    >>> import trackweave as tw
    >>> motion = tw.ConstantVelocity(process_noise=0.1, max_speed=30.0)  # m²/s³, m/s
    >>> tracker = tw.MultiHypothesisTracker(motion=motion, sensors=[tw.Sensor("radar", sigma=5.0)])
    >>> tracker.step(tw.Scan(time=0.0, sensor="radar", measurement=[[20.0, 0.0]])).time
    0.0
    """

    _beliefs: Beliefs | None
    CHANGING: ClassVar = (
        "_fixed_history", "_inactive", "_manager", "_open", "_pacer", "_preparation",
        "_report_index", "_tree", "_undetected", "_used",
    )  # fmt: skip
    SETTINGS: ClassVar = ("_lifecycle", "_limits", "_motion", "_priors", "_search", "_sensors")

    def __init__(  # noqa: PLR0913 all by name, and each a part of what a tracker is
        self,
        *,
        motion: AnyMotion | MotionModel,
        sensors: Sequence[Sensor],
        window: Window | int | None = None,
        search: Solver | None = None,
        lifecycle: Lifecycle | None = None,
        priors: TrackTable | None = None,
        limits: GrowthLimits | None = None,
        estimate: Literal["average", "best"] = "average",
        dim: int | None = None,
        unscented: bool = False,
        max_ahead: float | None = MAX_AHEAD,
    ) -> None:
        self._motion = require_parts(motion, search, lifecycle, limits)
        checked_choice(estimate, "estimate", ("average", "best"))
        self._sensors = checked_sensors(sensors)
        self._lifecycle = lifecycle or Lifecycle()
        self._search: Solver = search if search is not None else Auto()
        self._by_bearings = not any(map(tells_place, self._sensors.values()))
        self._limits = (
            limits or (GrowthLimits.of_bearings if self._by_bearings else GrowthLimits)()
        )
        self._averaging = estimate == "average"
        self._priors = checked_priors(priors)
        self._period = period_of(self._sensors.values())
        self._window = checked_window(window)
        self._guard = ClockGuard.of(max_ahead, self._sensors.values())
        # Until the window is full, what no full one would hold is too late as well.
        self._horizon = self._guard.farthest_back(self._window.depth * self._period)
        self._used, self._pacer, self._widths = UsedNumbers(), Pacer(), {}
        self._dim = checked_dim(dim, self._priors, self._sensors)
        self._unscented = checked_flag(unscented, "unscented")
        self._last: Hypothesis | None = None
        self._know_nothing(TrackManager(self._lifecycle))

    def _know_nothing(self, manager: TrackManager) -> None:
        """Be as before the first scan."""
        lifecycle, slowest = self._lifecycle, slowest_of(self._sensors.values())
        self._preparation = ScanPreparation(self._motion, self._sensors, self._period)
        self._open = OpenScans(self._window, *reference_of(slowest))
        new, initial = lifecycle.new_target_density, lifecycle.initial_target_density
        if initial is None or self._priors is not None:
            initial = new
        speed, by_bearings = self._motion.max_speed, self._by_bearings
        self._undetected = Undetected(initial, new, speed, self._period, by_bearings=by_bearings)
        patience = ((lifecycle.delete_after_misses or USUAL_MISSES) + 1.0) * self._period
        self._fixed_history = FixedHistory(copy.copy(self._undetected), patience)
        self._manager = manager
        self._report_index = ReportIndex()
        self._tree: AssociationTree | None = None
        self._concerned: IntArray = np.empty(0, dtype=np.int64)
        self._gap, self._beliefs = 0.0, None

    def begin_anew(self, *, keeps_priors: bool) -> Assignments:
        """Forget all but which names and numbers were used; see `LiveTracker`."""
        final, self._priors = self.pending(), self._priors if keeps_priors else None
        self._know_nothing(self._manager.anew())
        return final

    def pending(self) -> Assignments:
        """Return ``report``, ``track`` (-1: none) and how probable it is, as things stand."""
        return self._report_index.assignments(self._open.first_slot, self._open.end_slot)

    @property
    def doubts(self) -> dict[int, bool]:
        """Whether live tracks may as well be false alarms that came again; see `LiveTracker`."""
        return self._manager.doubts.copy()

    def clusters(self) -> Clusters:
        """Return what competes for reports in the window after the last scan."""
        held = None if self._tree is None else (self._tree, self._inactive)
        return clusters_of(held, self._report_index)

    def tracks(self) -> TrackTable:
        """Return the live tracks after the last scan, tentative too; before any, the priors."""
        if self._tree is None:
            return TrackTable.empty(self._dim or 2) if self._priors is None else self._priors
        return live_rows(
            self._tree, self._inactive, self._open.last_time, by_belief=self._beliefs is not None
        )

    def step(
        self,
        scan: Scan | Sequence[Scan],
        *,
        rng: RandomSource = 0,
        deadline: float | None = None,
        stop: Stop | None = None,
        tracks: bool = True,
    ) -> Hypothesis:
        """Take in a scan and return the hypothesis after it.

        Parameters
        ----------
        scan
            Reports of one sensor, none for an empty scan. A scan that is older than the last one
            but not older than the window is put into its place. Several, each later than the one
            before, are searched once, after the last.
        rng
            A generator, or a seed, which draws the same numbers at each step.
        deadline
            Seconds of wall clock for all of the step, above 0; None for none.
        stop
            Asked every few milliseconds whether to end.
        tracks
            Whether the hypothesis holds the live tracks, which takes its time.

        Returns
        -------
        The hypothesis. After a scan that came too late for the window, or that is held back, it
        is the last one.

        Raises
        ------
        InvalidInputError
            If an argument is of another kind than it has to be, the sensor is unknown, a number
            of dimensions changes or a report's number was used before. After this or any other
            error, such as one of the search or an interrupt, tracker and generator are as they
            were before the step.
        """
        rng = require_haste(rng, deadline, stop)
        return self._step(in_order(scan), Haste(rng, deadline, stop, tracks))

    def take(self, arrival: Arrival, haste: Haste) -> Hypothesis:
        """Take in a checked scan whenever it is of; see `LiveTracker`."""
        pace, scans = self._pacer.start(haste.deadline, haste.stop), arrival.scans
        if self.is_late(arrival):
            return self.left_out(arrival, haste)
        n_pruned = self._tree.n_pruned if self._tree else 0
        forgotten = forget_negligible(self._tree, self._beliefs)
        final = self._slide(scans[-1])
        opened = self._preparation.opened(scans, self._open, self._dim or 2)
        for number, scan in enumerate(scans):
            ends = number == 0, number == len(scans) - 1
            tree = self._take_in(scan, opened[number:], pace, ends)
        slots, last = tree.slots(), self._open.last_time
        problem = tree.problem(slots, self._report_index.instants(slots[0]))
        hint, alarm = self._hint(tree, slots[0], problem.n_items), pace.alarm(tree.n_nodes)
        answer = answered(self._search, problem, rng=haste.rng, hint=hint, stop=alarm)
        pace.searched(tree.n_nodes)
        self._remember(tree, slots[0], answer)
        self._beliefs = believe(tree, answer.node_probability) if self._averaging else None
        pruned, certificate = judged(tree, self._beliefs, answer.certificate, forgotten)
        amendments = self._manager.update(
            tree, answer.nodes, self._report_index, self._concerned, self._beliefs
        )
        tracks = self.tracks() if haste.tracks else TrackTable.empty(tree.dim)
        self._last = Hypothesis(
            time=last,
            tracks=tracks,
            n_tracks=len(tracks) or n_live(tree, self._inactive, last, by_belief=self._averaging),
            amendments=amendments,
            final=final,
            late=(),
            certificate=self._inactive.certificate(certificate),
            evaluations=answer.evaluations,
            stop_reason=answer.stop_reason,
            n_sequences=tree.n_nodes + self._inactive.n_nodes,
            n_pruned=max(0, tree.n_pruned - n_pruned),
            n_pruned_by_deadline=tree.n_given_way,
            pruned_probability=pruned,
            is_crowded=tree.is_crowded,
            deadline_gap=pace.gap_of(answer),
        )
        pace.done(tree.n_nodes)
        return self._last

    def is_late(self, arrival: Arrival) -> bool:
        """Tell whether a scan lies before the window as well; see `LiveTracker`."""
        oldest = max(self._open.fixed_until, self._open.last_time - self._horizon)
        return self.is_before_all(arrival) or arrival.scans[0].time <= oldest

    def _begin(self, dim: int) -> AssociationTree:
        """Return the tree before the first scan."""
        self._rule = rule_of(
            self._motion, self._lifecycle, self._sensors, dim, unscented=self._unscented
        )
        priors = self._priors if self._priors is not None else TrackTable.empty(dim)
        self._manager.begin(priors)
        return self._planted(begun(priors, self._rule))

    def _planted(self, initial: InitialTracks) -> AssociationTree:
        """Return a tree of the tracks from before the window alone, and make it the tracker's."""
        self._tree = AssociationTree(self._rule, self._limits)
        self._tree.add_tracks(initial)
        self._inactive = InactiveClusters(self._rule, self._period)
        return self._tree

    def _take_in(
        self, scan: Scan, opened: Sequence[OpenScan], pace: Pace, ends: tuple[bool, bool]
    ) -> AssociationTree:
        """Return the tree grown by a scan; a scan that is not the latest grows it anew."""
        # ``opened`` are it and those that follow in its step, see ``ScanPreparation``.
        is_first, is_last = ends
        dim = self._dim or (self._tree.dim if self._tree else 2)
        tree = self._tree or self._begin(dim)
        if tree.dim != dim:
            tree = self._begun_anew(dim, pace)
        same = self._open.find(scan.sensor, scan.time)
        last = self._open.last_time
        if scan.time < last or same is not None:
            return self._taken_late(tree, scan, same, pace)
        self._open.insert(opened[0] if opened else self._preparation.open(scan, dim))
        data, waited = self._open.timed(-1, last, self._lifecycle, self._period)
        tree.rule = self._preparation.patient(self._rule, last, data.time)
        # What a step brings back has to be fixed with all else: at once for all of its scans.
        ahead = [each.data for each in opened[1:]] if is_first or not opened else None
        self._inactive.exchange(tree, data, self._gap, ahead)
        if is_first:
            self._fix(tree, last)
            self._concerned = tree.slots()[0]
        density = self._undetected.look(data, waited)
        self._report_index.add(self._open.scans[-1], self._open.first_slot)
        self._concerned = np.concatenate([self._concerned, data.slot])
        with pace.growth(tree, len(scan)):
            tree.grow(data, density, is_last=is_last)
        return tree

    def _taken_late(
        self, tree: AssociationTree, scan: Scan, same: int | None, pace: Pace
    ) -> AssociationTree:
        """Return the tree grown anew with a scan in its place in time."""
        self._inactive.bring_back(tree, self._open.last_time)
        self._fix(tree, self._open.last_time)
        window = [known.data for known in self._open.scans]
        initial, families = self._fixed_history.initial_tracks(tree, window)
        if same is not None:
            scan = merged(self._open.remove(same).scan, scan, self._sensors[scan.sensor])
        self._preparation.put_in(scan, self._open, tree.dim)
        self._report_index.relay(self._open.first_slot, self._open.scans)
        tree = self._planted(initial)
        tree.families = families
        return self._grown_anew(tree, pace)

    def _begun_anew(self, dim: int, pace: Pace) -> AssociationTree:
        """Return the tree after empty scans that did not tell their number of dimensions."""
        for place, known in enumerate(self._open.scans):
            scan = with_dimensions(known.scan, self._sensors[known.sensor], dim)
            self._open.scans[place] = self._preparation.open(scan, dim)
        return self._grown_anew(self._begin(dim), pace)

    def _grown_anew(self, tree: AssociationTree, pace: Pace) -> AssociationTree:
        """Return a planted tree grown by the window's scans as if they had come in order."""
        self._undetected = copy.copy(self._fixed_history.undetected)
        last, n_scans = self._open.fixed_until, len(self._open.scans)
        with pace.growth(tree, self._open.end_slot - self._open.first_slot, n_scans):
            for place in range(n_scans):
                data, waited = self._open.timed(place, last, self._lifecycle, self._period)
                tree.rule = self._preparation.patient(self._rule, last, data.time)
                self._inactive.exchange(tree, data, 0.0)
                tree.grow(data, self._undetected.look(data, waited))
                last = data.time
            self._inactive.bring_back(tree, last)
        self._concerned = np.arange(self._open.first_slot, self._open.end_slot)
        return tree

    def _slide(self, scan: Scan) -> Assignments:
        """Close what leaves the window before a scan comes in; return its assignments."""
        is_next = scan.time > self._open.last_time and self._tree is not None
        count = self._open.n_closing(scan.sensor, scan.time) if is_next else 0
        before, last = self._open.first_slot, self._open.fixed_until
        self._fixed_history.close(self._open.close(count), last)
        return self._report_index.assignments(before, self._open.first_slot)

    def _fix(self, tree: AssociationTree, last: float) -> None:
        """Make final what the window has left; ``last`` is the time of the last scan [s]."""
        for lost in self._manager.fix(tree, self._open.first_slot, self._report_index):
            for undetected in (self._undetected, self._fixed_history.undetected):
                undetected.lose(lost.position, lost.spread, lost.time, last)

    def _remember(self, tree: AssociationTree, slots: IntArray, answer: Answer) -> None:
        """Keep what starts the next search: the answer and the reports' prices."""
        tree.nodes.chosen[: tree.n_nodes] = 0
        tree.nodes.chosen[answer.nodes] = 1
        self._report_index.price[slots - self._report_index.origin] = answer.prices[: slots.size]
        is_open = answer.status is not Status.OPTIMAL
        self._gap = max(0.0, answer.cost - answer.lower_bound) if is_open else 0.0

    def _hint(self, tree: AssociationTree, slots: IntArray, n_items: int) -> Hint:
        """Return what the last answer says of this problem."""
        prices = np.zeros(n_items)
        prices[: slots.shape[0]] = self._report_index.price[slots - self._report_index.origin]
        return Hint(prices=prices, nodes=tree.chosen)
