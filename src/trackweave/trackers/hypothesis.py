"""What a tracker says after a scan."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import Certificate, Status
from trackweave.association.pruned import PrunedProbability
from trackweave.domain.tracks import TrackTable
from trackweave.summaries import summary
from trackweave.trackers.clock_guard import HeldScan

__all__ = ["Amendment", "Assignments", "Hypothesis", "gathered", "nothing_final", "unchanged"]


@dataclass(frozen=True, slots=True)
class Amendment:
    """A report that an earlier hypothesis gave to another track.

    Parameters
    ----------
    report
        Number of the report, as in ``Hypothesis``.
    before, after
        Identifier of the track then and now; None for a false alarm.

    Examples
    --------
    >>> import trackweave as tw
    >>> # Report 12 was of track 3 at first, and is a false alarm now.
    >>> amendment = tw.Amendment(report=12, before=3, after=None)
    >>> amendment.after is None
    True
    """

    report: int
    before: int | None
    after: int | None


@dataclass(frozen=True, slots=True, eq=False)
class Assignments:
    """Reports and the tracks that they are given to; columns of shape (reports,).

    Parameters
    ----------
    report
        Each report's number, as in `Hypothesis`.
    track
        The identifier of its track, -1 for a false alarm.
    probability
        How probable that is by all hypotheses that are kept; NaN where the method tells none.
    """

    report: IntArray
    track: IntArray
    probability: FloatArray

    __repr__ = summary

    def __len__(self) -> int:
        return int(self.report.shape[0])


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """A full explanation of the reports, as of a scan.

    Reports go by their numbers in ``Scan.report``, or by what the tracker counts, from 0, where
    a scan has none. Scans from ``ReportTable.scans()`` number them by the rows of that table,
    from 0; the table is sorted by time, so that is not their place in the file. Files of
    assignments carry ``ReportTable.report[number]`` instead: the report's own identifier, or
    where it has none the number of its record in the file, from 1.

    Parameters
    ----------
    time
        End of the scan [s].
    tracks
        The live tracks at that time, tentative ones too; no rows where the step was told to leave
        them out.
    n_tracks
        How many live tracks there are.
    amendments
        What changed of earlier hypotheses.
    final
        The reports that left the window at this scan: nothing will amend them.
    late
        Numbers of the scan's reports if it came too late to be used.
    held
        The scans that are held back after this step, because their times jump ahead of all others
        (or of a beginning that nothing supports yet): they are taken in once three agree with one
        another or time gets there. Nothing is said of their reports until then.
    set_aside
        The scans that were held back and at this step set aside for good: their reports are of
        no track, finally.
    certificate
        Cost of the window's part, its lower bound and gap over the sequences of the tree; of
        what no scan concerns for a while as of when it was last looked at.
    evaluations
        Answers that the search tried.
    stop_reason
        Why the search ended.
    n_sequences
        Sequences of the tree that the search chose from.
    n_pruned
        Sequences left out of the tree at this scan, which the bound does not cover.
    n_pruned_by_deadline
        How many of them the deadline left no time for.
    pruned_probability
        How much of the probability of each family of sequences they had at this scan, with what
        reports are worth after the search: the worst share and the sum; what was left out
        before is not counted. None where no probabilities are told. Where the worst is above 1 %,
        or not known, or a gate is crowded, an answer is at best "optimal among kept".
    is_crowded
        Whether a gate held more reports than a sequence can look at: only the nearest were tried.
    deadline_gap
        The gap that the search left open because it had to stop; 0 where it ended by itself,
        None without a deadline.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> tracker = tw.MultiHypothesisTracker(
    ...     motion=tw.ConstantVelocity(process_noise=0.1, max_speed=30.0),  # m²/s³, m/s
    ...     sensors=[tw.Sensor("radar", sigma=5.0, clutter_density=1e-6, scan_period=1.0)],
    ... )
    >>> for time in range(4):  # an object at 20 m/s, heading east
    ...     scan = tw.Scan(time=time, sensor="radar", measurement=[[20.0 * time, 0.0]])
    ...     hypothesis = tracker.step(scan, rng=np.random.default_rng(time))
    ...
    >>> hypothesis.time, hypothesis.n_tracks, hypothesis.certificate.status
    (3.0, 1, <Status.OPTIMAL: 'optimal'>)
    >>> hypothesis.tracks.mean.round()  # m, m/s
    array([[59.,  0., 20.,  0.]])
    """

    time: float
    tracks: TrackTable
    n_tracks: int
    amendments: tuple[Amendment, ...]
    final: Assignments
    late: tuple[int, ...]
    certificate: Certificate
    evaluations: int
    stop_reason: str
    n_sequences: int
    n_pruned: int
    n_pruned_by_deadline: int = 0
    pruned_probability: PrunedProbability | None = None
    is_crowded: bool = False
    deadline_gap: float | None = None
    held: tuple[HeldScan, ...] = ()
    set_aside: tuple[HeldScan, ...] = ()

    __repr__ = summary


def unchanged(last: Hypothesis | None, time: float, dim: int, reason: str) -> Hypothesis:
    """Return the last hypothesis, with nothing new, after a step that took nothing in."""
    # Where there was no last one, it is of the given time [s]. The reason is why the step ended.
    final = nothing_final()
    if last is None:
        nothing, tracks = Certificate(0.0, 0.0, Status.OPTIMAL), TrackTable.empty(dim)
        return Hypothesis(time, tracks, 0, (), final, (), nothing, 0, reason, 0, 0)
    return replace(
        last, amendments=(), final=final, late=(), evaluations=0, stop_reason=reason, n_pruned=0,
        n_pruned_by_deadline=0, pruned_probability=None, is_crowded=False, deadline_gap=None,
        held=(), set_aside=(),
    )  # fmt: skip


def nothing_final() -> Assignments:
    """Return no assignments."""
    nobody = np.empty(0, dtype=np.int64)
    return Assignments(report=nobody, track=nobody, probability=np.empty(0))


def gathered(
    steps: Sequence[Hypothesis], known_before: Assignments | None, fresh: frozenset[int]
) -> Hypothesis:
    """Return the last of some hypotheses, with what changed since before the first."""
    # They are of several scans that were taken in at one step. The assignments in ``known_before``
    # were forgotten before, because they were of another time; they are final now. What was said
    # of fresh reports, the scans' own, between is no amendment.
    final = [step.final for step in steps]
    if known_before is not None:
        final.insert(0, known_before)
    if len(final) == 1:
        return steps[0]
    before: dict[int, int | None] = {}
    after: dict[int, int | None] = {}
    for amendment in (each for step in steps for each in step.amendments):
        before.setdefault(amendment.report, amendment.before)
        after[amendment.report] = amendment.after
    told = [step.pruned_probability for step in steps if step.pruned_probability is not None]
    gaps = [step.deadline_gap for step in steps if step.deadline_gap is not None]
    return replace(
        steps[-1],
        amendments=tuple(
            Amendment(report, old, after[report])
            for report, old in before.items()
            if old != after[report] and report not in fresh
        ),
        final=Assignments(
            report=np.concatenate([part.report for part in final]),
            track=np.concatenate([part.track for part in final]),
            probability=np.concatenate([part.probability for part in final]),
        ),
        late=tuple(report for step in steps for report in step.late),
        set_aside=tuple(scan for step in steps for scan in step.set_aside),
        evaluations=sum(step.evaluations for step in steps),
        n_pruned=sum(step.n_pruned for step in steps),
        n_pruned_by_deadline=sum(step.n_pruned_by_deadline for step in steps),
        pruned_probability=PrunedProbability(
            max(each.worst for each in told), sum(each.sum for each in told)
        )
        if told
        else None,
        is_crowded=any(step.is_crowded for step in steps),
        deadline_gap=max(gaps, default=None),
    )
