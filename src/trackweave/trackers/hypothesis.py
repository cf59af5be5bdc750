"""What a tracker says after a scan."""

from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.problem import Certificate, Status
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TrackTable

__all__ = ["Amendment", "Assignments", "Hypothesis", "left_out"]


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
    """Reports and the tracks that they are given to.

    Parameters
    ----------
    report
        Numbers of the reports, as in ``Hypothesis``, shape (reports,).
    track
        Identifier of each one's track, -1 for a false alarm.
    probability
        How probable that assignment is; NaN where the method tells none.
    """

    report: IntArray
    track: IntArray
    probability: FloatArray

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
    is_crowded: bool = False
    deadline_gap: float | None = None


def left_out(scan: Scan, last: Hypothesis | None, dim: int) -> Hypothesis:
    """Return the last hypothesis after a scan that came too late.

    Parameters
    ----------
    scan
        The scan, its reports numbered.
    last
        The hypothesis after the scan before; None where there was none.
    dim
        Number of dimensions of the tracking space.

    Returns
    -------
    The last hypothesis, with nothing new but the reports that are left out.
    """
    late, nobody = tuple(scan.report.tolist()), np.empty(0, dtype=np.int64)
    final = Assignments(report=nobody, track=nobody, probability=np.empty(0))
    if last is None:
        nothing, tracks = Certificate(0.0, 0.0, Status.OPTIMAL), TrackTable.empty(dim)
        return Hypothesis(scan.time, tracks, 0, (), final, late, nothing, 0, "late scan", 0, 0)
    return replace(
        last, amendments=(), final=final, late=late, evaluations=0,
        stop_reason="late scan", n_pruned=0, n_pruned_by_deadline=0, is_crowded=False,
        deadline_gap=None,
    )  # fmt: skip
