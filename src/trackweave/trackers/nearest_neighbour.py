"""The nearest-neighbour Kalman tracker: each scan decided at once."""

from collections.abc import Sequence
from functools import cache
from typing import ClassVar, Literal

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association._nodes import ScanInput
from trackweave.association.foreign_growth import distances_of
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.states import states_at
from trackweave.association.tree import AssociationTree
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.fields import checked_choice, checked_flag, checked_number
from trackweave.models.foreign_motion import AnyMotion, MotionModel
from trackweave.models.sensors import Sensor
from trackweave.randomness import RandomSource
from trackweave.solvers.protocol import Stop
from trackweave.trackers._arguments import (
    checked_dim,
    checked_priors,
    checked_sensors,
    period_of,
    require_parts,
    require_step,
)
from trackweave.trackers.clock_guard import MAX_AHEAD, Arrival, ClockGuard
from trackweave.trackers.hypothesis import (
    Assignments,
    Hypothesis,
    nothing_final,
)
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.live import Haste, ScanByScan
from trackweave.trackers.pairing import Offers, Pairing, nearest, one_to_one
from trackweave.trackers.scan_preparation import USUAL_MISSES, ScanPreparation, begun, rule_of
from trackweave.trackers.single_hypothesis import SingleHypothesisManager
from trackweave.trackers.undetected import Undetected
from trackweave.trackers.used_numbers import UsedNumbers

__all__ = ["NearestNeighbourTracker"]

GATE_PROBABILITY = 0.9999
"""How many of an object's own reports the gate lets through, unless it is told otherwise."""
# One scan is grown and decided at a time: there is nothing to prune but in impossible crowds.
_ALL = GrowthLimits(
    margin=np.inf, keep=2**62, new_margin=np.inf, new_keep=2**62, new_ceiling=np.inf,
    max_nodes=2_000_000,
)  # fmt: skip


class NearestNeighbourTracker(ScanByScan):
    """Tracks objects by the reports nearest to where they are expected, each scan decided at once.

    A Kalman filter per track predicts, takes the closest of the validated reports, and is updated
    by it [1]_. Reports are validated by their squared distance νᵀS⁻¹ν, with the covariance S of
    the innovation ν (eq. 8), from where the track is expected at their own moment, and by whether
    an object no faster than the motion's ``max_speed`` can have come there. Every report that no
    track takes starts a tentative track, unless it does not say where its object is: bearings
    update tracks and start none. Nothing is ever amended; for decisions that later scans may
    correct see `MultiHypothesisTracker`, whose motions, sensors and costs these are.

    Parameters
    ----------
    motion
        How objects move: a model of ours, or one of your own, see `MotionModel`.
    sensors
        What the sensors report; scans of other sensors are refused.
    lifecycle
        When tracks begin to count and end. A track ends when it is not confirmed within the
        ``confirm_opportunities`` from its first report. What it needs to be confirmed,
        ``confirm_probability``, is judged by its score alone, so that 0 leaves M of N;
        ``certain_probability`` confirms nobody, because the score of reports chosen for being
        near is too sure.
    priors
        Tracks known beforehand, confirmed; their times must not lie behind the first scan.
    pairing
        "one-to-one" gives each report to one track at most, at least total cost. The cost of a
        pair is the score's: half the squared distance and ln|2πS|, with what identity and strength
        say. By the distance alone tracks that know little of where they are would be near to
        everything and take the reports of those that know it well. A pair that costs more than a
        miss and a false alarm is none: among many false alarms the gate is narrower than it says.
        "nearest" is the source to the letter: every track takes the report at the least squared
        distance, whoever else takes it too.
    gate
        Greatest squared distance of a validated report; None for what lets through 99.99 % of an
        object's own.
    dim
        Number of dimensions of the tracking space, 2 or 3; None for what priors, sensors or the
        first report tell.
    unscented
        Whether turns and what is not linear in a measurement are taken by sigma points (the
        unscented filter) instead of Jacobians (the extended one).
    max_ahead
        A scan further ahead of all others than this is held back [s], as in
        `MultiHypothesisTracker`.

    Raises
    ------
    InvalidInputError
        If an argument is of another kind than it has to be, if there is no sensor, or two have
        one name, or two priors.

    References
    ----------
    .. [1] I. Wiranto, Z. Bonok, *Application of Ant System and Nearest Neighbor Kalman Filter for
       Multi Target Tracking in Multi Sensor Radar System*, 2018, eqs. (8)–(10).

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> tracker = tw.NearestNeighbourTracker(
    ...     motion=tw.ConstantVelocity(process_noise=0.1, max_speed=30.0),  # m²/s³, m/s
    ...     sensors=[tw.Sensor("radar", sigma=5.0, clutter_density=1e-6, scan_period=1.0)],
    ... )
    >>> scan = tw.Scan(time=0.0, sensor="radar", measurement=[[20.0, 5.0]])
    >>> tracker.step(scan, rng=np.random.default_rng(1)).n_tracks
    1
    """

    CHANGING: ClassVar = ("_manager", "_preparation", "_tree", "_undetected", "_used")
    SETTINGS: ClassVar = ("_lifecycle", "_motion", "_priors", "_sensors")

    def __init__(  # noqa: PLR0913 all by name, and each a part of what a tracker is
        self,
        *,
        motion: AnyMotion | MotionModel,
        sensors: Sequence[Sensor],
        lifecycle: Lifecycle | None = None,
        priors: TrackTable | None = None,
        pairing: Literal["one-to-one", "nearest"] = "one-to-one",
        gate: float | None = None,
        dim: int | None = None,
        unscented: bool = False,
        max_ahead: float | None = MAX_AHEAD,
    ) -> None:
        self._motion = require_parts(motion, None, lifecycle, None)
        checked_choice(pairing, "pairing", ("one-to-one", "nearest"))
        if gate is not None:
            expected = "a finite number > 0, or None"
            gate = checked_number(gate, "gate", expected)
            if not gate > 0:
                raise InvalidInputError(f"gate: {gate}; expected {expected}")
        self._sensors = checked_sensors(sensors)
        self._lifecycle = lifecycle or Lifecycle()
        self._priors = checked_priors(priors)
        self._is_shared = pairing == "nearest"
        self._gate = gate
        self._period = period_of(self._sensors.values())
        self._guard = ClockGuard.of(max_ahead, self._sensors.values())
        # None until priors, a report or a sensor's noise tell it; a tree of before holds nothing.
        self._dim = checked_dim(dim, self._priors, self._sensors)
        self._unscented = checked_flag(unscented, "unscented")
        self._used, self._widths = UsedNumbers(), {}
        self._last: Hypothesis | None = None
        self._rows: TrackTable | None = None
        self._next_track = 1
        self._know_nothing()

    def _know_nothing(self) -> None:
        """Be as before the first scan."""
        self._preparation = ScanPreparation(self._motion, self._sensors, self._period)
        self._undetected = self._unseen()
        self._tree: AssociationTree | None = None
        self._last_time = -np.inf
        self._served: dict[int, tuple[int, ...]] = {}
        """Which tracks each sensor has reported at the last instant."""

    def begin_anew(self, *, keeps_priors: bool) -> Assignments:
        """Forget all but which names and numbers were used; see `LiveTracker`."""
        final = self.pending()
        if not keeps_priors:
            self._priors = None
        if self._tree is not None:
            self._next_track = self._manager.next_track
        self._know_nothing()
        return final

    def pending(self) -> Assignments:
        """Return no assignments: none is ever amended."""
        return nothing_final()

    def tracks(self) -> TrackTable:
        """Return the live tracks after the last scan, tentative too; before any, the priors."""
        known = self._priors if self._rows is None else self._rows
        return TrackTable.empty(self._dim or 2) if known is None else known

    def step(
        self,
        scan: Scan,
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
            Reports of one sensor, none for an empty scan. Another scan of the same sensor and
            time holds more reports of the same look: of objects that have one already it has
            none, and nobody is charged a miss again.
        rng
            Not used: a scan is decided without chance. Here so that trackers can be exchanged.
        deadline, stop
            Not used either: what is decided at once takes no time to speak of.
        tracks
            Whether the hypothesis holds the live tracks, or only their number.

        Returns
        -------
        The hypothesis; all its assignments are final. After a scan older than the last one, or
        that is held back, it is the last one. A report that several tracks share is said to be
        of the closest. With "one-to-one" the certificate's cost is that of the tracks' reports
        and misses, proven least. With "nearest" it is half the squared distances, a track that
        holds no report of its own being as far as the gate, and the bound says how much of that
        another one-to-one pairing could save at most.

        Raises
        ------
        InvalidInputError
            If an argument is of another kind than it has to be, the sensor is unknown, the number
            of dimensions changes or a report's number was used before. After this or any other
            error the tracker is as it was before the step.
        """
        rng = require_step(scan, rng, deadline, stop)
        return self._step((scan,), Haste(rng, deadline, stop, tracks))

    def take(self, arrival: Arrival, haste: Haste) -> Hypothesis:
        """Take in a checked scan whenever it is of; see `LiveTracker`."""
        (scan,) = arrival.scans
        if self.is_late(arrival):
            return self.left_out(arrival, haste)
        tree = self._planted(self._dim or 2)
        opened = self._preparation.open(scan, tree.dim)
        data, waited = self._charged(opened.data)
        tree.rule = self._preparation.patient(self._rule, self._last_time, data.time)
        n_tracks = tree.n_nodes
        tree.grow(data, self._undetected.look(data, waited))
        n_sequences = tree.n_nodes
        children = self._children(tree, data, n_tracks)
        pairing = self._paired(tree, data, children, n_tracks)
        track = self._settle(tree, data, children, pairing)
        self._rows = rows = self._manager.rows(tree, scan.time)
        self._last_time = scan.time
        self._last = Hypothesis(
            time=scan.time,
            tracks=rows if haste.tracks else TrackTable.empty(tree.dim),
            n_tracks=len(rows),
            amendments=(),
            final=Assignments(opened.report, track, np.full(track.shape[0], np.nan)),
            late=(),
            certificate=pairing.certificate,
            evaluations=1,
            stop_reason="decided at once",
            n_sequences=n_sequences,
            n_pruned=0,
            is_crowded=tree.is_crowded,
        )
        return self._last

    def _unseen(self) -> Undetected:
        """Return where objects may be before the first scan."""
        new, initial = self._lifecycle.new_target_density, self._lifecycle.initial_target_density
        if initial is None or self._priors is not None:
            initial = new
        # Bearings begin no track: what they see stays undetected.
        return Undetected(initial, new, self._motion.max_speed, self._period, by_bearings=False)

    def is_late(self, arrival: Arrival) -> bool:
        """Tell whether a scan lies before the last one as well; see `LiveTracker`."""
        return self.is_before_all(arrival) or arrival.time < self._last_time

    def _planted(self, dim: int) -> AssociationTree:
        """Return the tree, a node for each live track."""
        if self._tree is None or self._tree.dim != dim:
            # The dimensions can only change as long as there is no track.
            rule = rule_of(
                self._motion, self._lifecycle, self._sensors, dim, unscented=self._unscented
            )
            # What is decided scan by scan goes by misses alone.
            misses = self._lifecycle.delete_after_misses or USUAL_MISSES
            rule = self._rule = rule._replace(most_tail=np.inf, max_misses=float(misses))
            priors = self._priors if self._priors is not None else TrackTable.empty(dim)
            self._manager = SingleHypothesisManager(self._lifecycle, priors, self._next_track)
            self._tree = AssociationTree(rule, _ALL)
            self._tree.add_tracks(begun(priors, rule))
        return self._tree

    def _charged(self, data: ScanInput) -> tuple[ScanInput, float]:
        """Return a scan as it is seen after the last one, and how long ago that was [s]."""
        waited = data.time - self._last_time if np.isfinite(self._last_time) else 0.0
        living = -np.log(self._lifecycle.survival) * min(waited / self._period, 1e6)
        is_new = data.time > self._last_time
        if is_new:
            self._served = {}
        return data._replace(
            survival_cost=float(living),
            gate=_gate(data.measurement.shape[1]) if self._gate is None else self._gate,
            new_instant=is_new,
            is_silence_telling=data.is_silence_telling and data.sensor not in self._served,
        ), waited

    def _children(self, tree: AssociationTree, data: ScanInput, n_tracks: int) -> IntArray:
        """Return the nodes that are a track and a report of the scan that it may take."""
        # The tree holds the tracks' own nodes first, then these, then a new object per report.
        children = np.arange(n_tracks, tree.n_nodes - data.slot.shape[0])
        served = self._served.get(data.sensor)
        if not served:
            return children
        return children[~np.isin(self._manager.track[tree.nodes.family[children]], served)]

    def _paired(
        self, tree: AssociationTree, data: ScanInput, children: IntArray, n_tracks: int
    ) -> Pairing:
        """Return which tracks take which children."""
        nodes = tree.nodes
        track, report = nodes.parent[children], nodes.report[children]
        n_reports = data.slot.shape[0]
        if self._is_shared:
            distance = distances_of((nodes, children, tree.rule), data, tree.general)
            alone = np.full(n_tracks, 0.5 * data.gate)
            return nearest(Offers(track, report, 0.5 * distance, alone, n_reports))
        # That a report may be of a new object does not count: what could be a known one's is.
        alone = np.minimum(nodes.tail[:n_tracks], tree.rule.end_cost)
        return one_to_one(Offers(track, report, nodes.cost[children], alone, n_reports))

    def _settle(
        self, tree: AssociationTree, data: ScanInput, children: IntArray, pairing: Pairing
    ) -> IntArray:
        """Make a pairing final in the tree and the books; return the track of each report."""
        nodes, manager = tree.nodes, self._manager
        n_tracks, n_reports = pairing.taken.shape[0], data.slot.shape[0]
        has_hit = pairing.taken >= 0
        leaf = np.arange(n_tracks)
        leaf[has_hit] = children[pairing.taken[has_hit]]
        first = tree.n_nodes - n_reports
        is_born = np.full(n_reports, data.is_located)
        is_born[nodes.report[leaf[has_hit]]] = False
        manager.enter(is_born)
        seen = np.concatenate([leaf[has_hit], first + np.flatnonzero(is_born)])
        family = nodes.family[seen]
        manager.hit(family, nodes.chances[seen], nodes.cost[seen])
        track = manager.track[manager.track.shape[0] - n_reports :].copy()
        is_held = pairing.holder >= 0
        track[is_held] = manager.track[nodes.family[pairing.holder[is_held]]]
        root = np.full(tree.n_families, -1, dtype=np.int64)
        root[family] = seen
        served = self._served.get(data.sensor, ())
        self._served = {**self._served, data.sensor: (*served, *manager.track[family].tolist())}
        waiting = self._waiting(tree, np.flatnonzero(~has_hit), data.time)
        root[nodes.family[waiting]] = waiting
        tree.fix(root, manager.track, n_reports)
        manager.keep(tree.track)
        return track

    def _waiting(self, tree: AssociationTree, missed: IntArray, time: float) -> IntArray:
        """Return of the tracks' nodes that got no report those that live on; mourn the others."""
        nodes, manager = tree.nodes, self._manager
        family = nodes.family[missed]
        chances = nodes.chances[missed] + nodes.misses[missed]
        if len(self._sensors) > 1:
            # Another sensor may yet see at this instant what this one has not seen.
            chances -= nodes.counted[missed]
        is_over = np.isinf(nodes.tail[missed])
        for lost in missed[is_over & manager.is_confirmed[family]]:
            mean, covariance = states_at(tree, np.array([lost]))
            place, spread = mean[0, : tree.dim], covariance[0, : tree.dim, : tree.dim]
            self._undetected.lose(
                place, 3.0 * float(np.sqrt(np.trace(spread))), float(nodes.time[lost]), time
            )
        return missed[~is_over & ~manager.is_hopeless(family, chances)]


@cache
def _gate(size: int) -> float:
    """Return the squared distance that hardly any own report of so many numbers exceeds."""
    from scipy.stats import chi2

    return float(chi2.ppf(GATE_PROBABILITY, size))
