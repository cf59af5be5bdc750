"""The multi-scan tracker: a sliding window over an association tree."""

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter
from typing import Literal

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.beliefs import believe
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.problem import Answer
from trackweave.association.tree import AssociationTree, Beginning
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable
from trackweave.errors import InvalidInputError
from trackweave.models.motion import Motion
from trackweave.models.sensors import Sensor
from trackweave.solvers.auto import Auto
from trackweave.solvers.protocol import Hint, Solver
from trackweave.trackers._arguments import (
    checked_dim,
    checked_priors,
    checked_scan,
    checked_sensors,
    checked_window,
    merged,
    period_of,
    require_parts,
    require_step,
    slowest_of,
    tells_place,
    with_dimensions,
)
from trackweave.trackers.hypothesis import Assignments, Hypothesis, left_out
from trackweave.trackers.ledger import Ledger
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.opening import Opener, begun, rooted, rule_of
from trackweave.trackers.undetected import Undetected
from trackweave.trackers.window import OpenScan, OpenScans, Window

__all__ = ["MultiScanTracker"]


class MultiScanTracker:
    """Tracks objects by choosing the best explanation of the last few scans, again at each scan.

    A fixed hypothesis holds what lies before the window; what lies in it may be amended by later
    scans [1]_.

    Parameters
    ----------
    motion
        How objects move.
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

    Raises
    ------
    InvalidInputError
        If an argument is of another kind than it has to be, if there is no sensor, or two have
        one name, or two priors.

    References
    ----------
    .. [1] D. B. Hillis, US patent 6,055,523, 2000, "The Tracker Program".
    """

    def __init__(  # noqa: PLR0913 all by name, and each a part of what a tracker is
        self,
        *,
        motion: Motion,
        sensors: Sequence[Sensor],
        window: Window | int | None = None,
        search: Solver | None = None,
        lifecycle: Lifecycle | None = None,
        priors: TrackTable | None = None,
        limits: GrowthLimits | None = None,
        estimate: Literal["average", "best"] = "average",
        dim: int | None = None,
        unscented: bool = False,
    ) -> None:
        require_parts(motion, search, lifecycle, limits)
        if estimate not in ("average", "best"):
            raise InvalidInputError(f"estimate: {estimate!r}; expected 'average' or 'best'")
        self._sensors = checked_sensors(sensors)
        self._motion = motion
        self._lifecycle = lifecycle or Lifecycle()
        self._search: Solver = search if search is not None else Auto()
        by_bearings = not any(map(tells_place, self._sensors.values()))
        usual = GrowthLimits.of_bearings() if by_bearings else GrowthLimits()
        self._limits = limits or usual
        self._averaging = estimate == "average"
        self._priors = checked_priors(priors)
        slowest = slowest_of(self._sensors.values())
        self._period = period_of(self._sensors.values())
        self._opener = Opener(motion, self._sensors, self._period)
        self._open = OpenScans(checked_window(window), *_reference(slowest))
        initial = self._lifecycle.initial_target_density
        new = self._lifecycle.new_target_density
        if initial is None or self._priors is not None:
            initial = new
        self._undetected = Undetected(
            initial,
            new,
            motion.max_speed,
            self._period,
            by_bearings=by_bearings,
        )
        self._undetected_before = self._undetected.copy()
        self._ledger = Ledger(self._lifecycle)
        # None until priors, a report or a sensor's noise tell it; a tree of before holds nothing.
        self._dim = checked_dim(dim, self._priors, self._sensors)
        self._unscented = bool(unscented)
        self._tree: AssociationTree | None = None
        self._beginning: Beginning | None = None
        self._prices: FloatArray = np.empty(0)
        self._last: Hypothesis | None = None
        self._next_report = 0
        self._is_whole = True

    def pending(self) -> Assignments:
        """Return the assignments of the window's reports, which later scans may amend."""
        return self._assignments(self._open.reports())

    def step(
        self, scan: Scan, *, rng: np.random.Generator, deadline: float | None = None
    ) -> Hypothesis:
        """Take in a scan and return the hypothesis after it.

        Parameters
        ----------
        scan
            Reports of one sensor, none for an empty scan. A scan that is older than the last one
            but not older than the window is put into its place.
        rng
            The only source of randomness.
        deadline
            Seconds of wall clock after which the best hypothesis so far is returned, above 0;
            None for none.

        Returns
        -------
        The hypothesis. After a scan that came too late for the window it is the last one.

        Raises
        ------
        InvalidInputError
            If an argument is of another kind than it has to be, the sensor is unknown, the number
            of dimensions changes or a report's number was used before: the tracker is then as it
            was. Any other error, such as one of the search, leaves it halfway through the scan,
            and every later step is refused by this error.
        """
        require_step(scan, rng, deadline)
        if not self._is_whole:
            raise InvalidInputError("tracker: a step failed midway; expected a new tracker")
        end = None if deadline is None else perf_counter() + deadline
        scan = self._checked(scan)
        if self._is_late(scan):
            return self._unchanged(scan)
        self._is_whole = False
        pruned = self._tree.n_pruned if self._tree else 0
        final = self._slide(scan)
        tree = self._take_in(scan)
        problem = tree.problem(self._open.instants())
        answer = self._search(
            problem,
            rng=rng,
            hint=self._hint(tree, problem.n_items),
            stop=None if end is None else lambda: perf_counter() >= end,
        )
        self._remember(tree, answer)
        time, report_of = self._open.last_time, self._open.reports()
        beliefs = None
        if self._averaging:
            beliefs = believe(tree, time, report_of.shape[0], answer.node_probability)
        tracks, amendments = self._ledger.update(tree, answer.nodes, report_of, time, beliefs)
        self._last = Hypothesis(
            time=time,
            tracks=tracks,
            amendments=amendments,
            final=final,
            late=(),
            certificate=answer.certificate,
            evaluations=answer.evaluations,
            stop_reason=answer.stop_reason,
            n_sequences=tree.n_nodes,
            n_pruned=max(0, tree.n_pruned - pruned),
        )
        self._is_whole = True
        return self._last

    def _is_late(self, scan: Scan) -> bool:
        """Tell whether a scan lies before the window, or before the tracks known beforehand."""
        if scan.time <= self._open.fixed_until:
            return True
        return self._priors is not None and scan.time < float(self._priors.time.max())

    def _checked(self, scan: Scan) -> Scan:
        """Return the scan with dimensions, and with numbers for its reports."""
        report, dim = checked_scan(
            scan, self._sensors, self._dim, self._open.reports(), self._next_report
        )
        self._next_report = max(self._next_report, int(report.max(initial=-1)) + 1)
        self._dim = dim
        likely = dim or (self._tree.dim if self._tree else 2)
        return replace(with_dimensions(scan, self._sensors[scan.sensor], likely), report=report)

    def _begin(self, dim: int) -> AssociationTree:
        """Return the tree before the first scan."""
        self._rule = rule_of(
            self._motion, self._lifecycle, self._sensors, dim, unscented=self._unscented
        )
        priors = self._priors if self._priors is not None else TrackTable.empty(dim)
        self._ledger.begin(priors)
        self._beginning = begun(priors, self._rule)
        return self._planted()

    def _planted(self) -> AssociationTree:
        """Return a tree of the tracks from before the window alone, and make it the tracker's."""
        assert self._beginning is not None
        self._tree = AssociationTree(self._rule, self._limits)
        self._tree.add_tracks(self._beginning)
        return self._tree

    def _take_in(self, scan: Scan) -> AssociationTree:
        """Return the tree grown by a scan; a scan that is not the latest grows it anew."""
        dim = self._dim or (self._tree.dim if self._tree else 2)
        tree = self._tree or self._begin(dim)
        if tree.dim != dim:
            tree = self._begun_anew(dim)
        same = self._open.find(scan.sensor, scan.time)
        last = self._open.last_time
        if scan.time >= last and same is None:
            self._open.insert(self._opener.open(scan, dim))
            newest = self._looked(len(self._open.scans) - 1, last, self._undetected)
            tree.grow(newest.data, newest.log_density)
            self._prices = np.concatenate([self._prices, np.zeros(len(scan))])
            return tree
        if same is not None:
            scan = merged(self._open.remove(same).scan, scan, self._sensors[scan.sensor])
        self._open.insert(self._opener.open(scan, dim))
        return self._grown_anew()

    def _begun_anew(self, dim: int) -> AssociationTree:
        """Return the tree after empty scans that did not tell their number of dimensions."""
        for place, known in enumerate(self._open.scans):
            scan = with_dimensions(known.scan, self._sensors[known.sensor], dim)
            self._open.scans[place] = self._opener.open(scan, dim)
        self._begin(dim)
        return self._grown_anew()

    def _grown_anew(self) -> AssociationTree:
        """Return the tree grown by the window's scans as if they had come in order."""
        assert self._beginning is not None
        self._undetected = self._undetected_before.copy()
        tree, last = self._planted(), self._open.fixed_until
        for place in range(len(self._open.scans)):
            known = self._looked(place, last, self._undetected)
            tree.grow(known.data, known.log_density)
            last = known.data.time
        self._prices = np.zeros(self._open.n_slots)
        return tree

    def _looked(self, place: int, last: float, undetected: Undetected) -> OpenScan:
        """Return a scan of the window, ready to grow by; ``last`` is when the one before was."""
        known = self._open.scans[place]
        waited = max(0.0, known.data.time - last) if np.isfinite(last) else 0.0
        living = -np.log(self._lifecycle.survival) * min(waited / self._period, 1e6)
        data = known.data._replace(survival_cost=float(living))
        density = undetected.look(data, waited)
        self._open.scans[place] = replace(known, data=data, log_density=density)
        return self._open.scans[place]

    def _slide(self, scan: Scan) -> Assignments:
        """Fix what leaves the window before a scan comes in; return its assignments."""
        count = 0
        if scan.time > self._open.last_time and self._tree is not None:
            count = self._open.n_closing(scan.sensor, scan.time)
        if count == 0 or self._tree is None:
            return self._assignments(np.empty(0, dtype=np.int64))
        n_fixed = sum(known.report.shape[0] for known in self._open.scans[:count])
        final = self._assignments(self._open.reports()[:n_fixed])
        for lost in self._ledger.fix(self._tree, self._chosen(self._tree), n_fixed):
            for undetected in (self._undetected, self._undetected_before):
                undetected.lose(lost.position, lost.spread, lost.time, self._open.last_time)
        last = self._open.fixed_until
        for place in range(count):
            last = self._looked(place, last, self._undetected_before).data.time
        closing = [known.data for known in self._open.scans[:count]]
        assert self._beginning is not None
        self._beginning = rooted(self._tree, self._beginning, closing)
        self._open.close(count)
        self._prices = self._prices[n_fixed:]
        return final

    def _assignments(self, report: IntArray) -> Assignments:
        """Return what the last hypothesis says of reports of the window."""
        known = [self._ledger.assignment.get(number, (-1, np.nan)) for number in report.tolist()]
        return Assignments(
            report=report,
            track=np.array([track for track, _ in known], dtype=np.int64),
            probability=np.array([probability for _, probability in known], dtype=np.float64),
        )

    def _remember(self, tree: AssociationTree, answer: Answer) -> None:
        """Keep what starts the next search: the answer and the reports' prices."""
        tree.nodes.chosen[: tree.n_nodes] = 0
        tree.nodes.chosen[answer.nodes] = 1
        self._prices = answer.prices[: self._open.n_slots]

    def _chosen(self, tree: AssociationTree) -> IntArray:
        """Return the last answer's nodes, as far as they are still there."""
        return np.flatnonzero(tree.nodes.chosen[: tree.n_nodes])

    def _hint(self, tree: AssociationTree, n_items: int) -> Hint:
        """Return what the last window's answer says of this one."""
        prices = np.zeros(n_items)
        prices[: self._prices.shape[0]] = self._prices
        return Hint(prices=prices, nodes=self._chosen(tree))

    def _unchanged(self, scan: Scan) -> Hypothesis:
        """Return the last hypothesis after a scan that came too late."""
        return left_out(scan, self._last, self._dim or 2)


def _reference(slowest: Sensor | None) -> tuple[str | None, float]:
    """Return whose scans the window counts, and how far the sectors of one may lie apart [s]."""
    if slowest is None:
        return None, 0.0
    return slowest.name, (slowest.scan_period or 0.0) if slowest.rotation else 0.0
