"""Getting ready for deadlines: what is slow only once is done before the first of them."""

import copy
import gc
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from trackweave.association._pruning import behind_best
from trackweave.association.crowding import give_way
from trackweave.domain.scans import Scan
from trackweave.run.course import Course
from trackweave.solvers.protocol import Solver
from trackweave.solvers.warming import warm_up

__all__ = ["few_of", "prepare", "without_pauses"]

STEPS, REPORTS = 20, 20
"""Steps that are rehearsed, and reports of each scan: enough for a window to fill and slide."""


def prepare(course: Course, search: Solver, rng: np.random.Generator) -> None:
    """Compile, or load from the disk, the kernels that a run needs; the run is left as it is."""
    # Solves a small problem, and lets a copy of the tracker take the first steps with few reports.
    own = copy.deepcopy(rng)
    warm_up(search, own)
    nobody = np.empty(0, dtype=np.int64)
    behind = behind_best(nobody, np.empty(0), nobody == 0)
    give_way(nobody == 0, nobody, behind, 0)
    rehearsal = replace(course, tracker=copy.deepcopy(course.tracker))
    for scans in course.steps[:STEPS]:
        rehearsal.take(tuple(few_of(scan) for scan in scans), own, None, tracks=True)


def few_of(scan: Scan) -> Scan:
    """Return a scan with its first 20 reports at most."""
    return scan if len(scan) <= REPORTS else scan.part(np.arange(REPORTS))


@contextmanager
def without_pauses() -> Iterator[None]:
    """Keep the garbage collector from going through all that is there before."""
    # A full collection takes as long as a whole scan may. What lives already is set aside; what
    # comes later is collected as ever.
    if gc.get_freeze_count():
        # Somebody else has set things aside, whose they stay.
        yield
        return
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
