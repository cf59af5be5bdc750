"""Tabu search."""

import copy
from dataclasses import dataclass, replace

import numpy as np

from trackweave.arrays import IntArray
from trackweave.fields import settle
from trackweave.solvers._kernels import Component
from trackweave.solvers.local._moves import cost_of
from trackweave.solvers.local._tabu import seek
from trackweave.solvers.local.starts import CHUNK, SearchStart, search_start
from trackweave.solvers.metaheuristic import Metaheuristic, polish
from trackweave.solvers.protocol import refuse_parameters
from trackweave.solvers.resumable import Start, View

__all__ = ["TabuSearch", "TabuState"]

WINDOWS = (0.02, 0.3)
"""Narrowest and widest window of a move, in typical excesses."""
STEP = 1_000
"""Moves tried between two looks at whether the search got stuck, to whole iterations."""
ELITE = 5
"""How many answers, each the best of a start, later starts may begin with."""
SENT_OFF = 0.2
"""Share of an elite answer's sequences that a start from it is without."""


@dataclass(frozen=True, slots=True, eq=False)
class TabuState:
    """Where a tabu search stands; it is replaced, never changed.

    ``holder`` tells which candidate holds each item at present, ``until`` up to which iteration
    each candidate has to stay as it is. The best answer since the last start is ``own_holder``
    at a cost of ``own``, found in the step that ends with iteration ``found``; the best of all
    is ``selection`` at a cost of ``best``. So many starts as ``unchanged`` counts, in a row,
    found nothing better; -1 when the present one did.
    """

    ground: SearchStart
    holder: IntArray
    current: float
    until: IntArray
    own_holder: IntArray
    own: float
    iteration: int
    found: int
    elite: tuple[IntArray, ...]
    selection: IntArray
    best: float
    starts: int
    unchanged: int
    evaluations: int
    at_rest: bool
    rng: np.random.Generator


@dataclass(frozen=True, slots=True)
class TabuSearch(Metaheuristic):
    """Tabu search [1]_ [2]_ with moves that force a sequence in and repair what it breaks.

    Moves are those of ``Annealing``. Each iteration tries a sample of them and makes the best,
    however much it adds to the cost; but a sequence that came may not be sent off, nor one that
    went come back, for some iterations. A move that leads to a new best may be made all the
    same. When the search gets stuck it starts anew: in turn with nothing taken, with the best
    answer, and with one of the best of earlier starts less a fifth of its sequences.

    Parameters
    ----------
    evaluations
        How many moves are tried per component, to whole steps of some thousand.
    sample
        How many moves an iteration tries, at least 1.
    tenure
        For how many iterations, at least, a sequence stays as it is; at most twice as many.
        At least 0.
    links
        Greatest number of sequences that a move forces in, at least 1.
    moves_per_item
        The search starts anew after so many moves for each item without a better answer.
    patience
        Starts without a better answer after which the search ends, at least 1.
    improvement
        Whether the best answer of a start is improved locally: by ejecting, inserting and
        repairing, and by assigning one list of items anew, exactly.
    seeded
        Whether bounds, prices and answers of the dual start the search. All items count as worth
        nothing where not.
    decompose
        Whether components are searched apart.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] F. Glover, *Tabu search – part I*, 1989. doi:10.1287/ijoc.1.3.190
    .. [2] F. Glover, *Tabu search – part II*, 1990. doi:10.1287/ijoc.2.1.4

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> problem = tw.AssignmentProblem.from_tuples([[1, 1], [1, 2], [2, 2]], [-4.0, -6.0, -3.0])
    >>> answer = tw.solve(problem, tw.TabuSearch(evaluations=1000), rng=np.random.default_rng(1))
    >>> answer.cost, answer.lower_bound
    (-7.0, -7.0)
    >>> answer.tuples
    array([[1, 1],
           [2, 2]])
    """

    evaluations: int = 1_000_000
    sample: int = 20
    tenure: int = 5
    links: int = 2
    moves_per_item: int = 100
    patience: int = 30
    improvement: bool = True
    seeded: bool = True
    decompose: bool = True

    def __post_init__(self) -> None:
        settle(self)
        wrong = [
            (not self.evaluations >= 1, "evaluations", "a whole number ≥ 1"),
            (not self.sample >= 1, "sample", "a whole number ≥ 1"),
            (not self.tenure >= 0, "tenure", "a whole number ≥ 0"),
            (not self.links >= 1, "links", "a whole number ≥ 1"),
            (not self.moves_per_item >= 1, "moves_per_item", "a whole number ≥ 1"),
            (not self.patience >= 1, "patience", "a whole number ≥ 1"),
        ]
        refuse_parameters(self, wrong)

    @property
    def iterations(self) -> int:
        """Iterations of one step."""
        return -(-STEP // self.sample)

    def _begin(self, view: View, start: Start) -> TabuState:
        ground = search_start(view, start, seeded=self.seeded)
        holder = ground.holding(view.component, None)
        cost = cost_of(ground.moves, holder)
        return TabuState(
            ground=ground,
            holder=holder,
            current=cost,
            until=np.zeros(ground.moves.node.shape[0], dtype=np.int64),
            own_holder=holder,
            own=cost,
            iteration=0,
            found=0,
            elite=(ground.holder,),
            selection=ground.selection(view.component, ground.holder),
            best=ground.cost,
            starts=1,
            unchanged=0,
            evaluations=0,
            at_rest=False,
            rng=start.rng,
        )

    def _go_on(self, view: View, search: TabuState, evaluations: int) -> TabuState:
        ground, length = search.ground, self.iterations
        step_end = (search.iteration // length + 1) * length
        last = min(step_end, search.iteration + -(-evaluations // self.sample))
        holder, own_holder = search.holder.copy(), search.own_holder.copy()
        until, rng = search.until.copy(), copy.deepcopy(search.rng)
        current, own = seek(
            ground.moves, ground.scale * np.array(WINDOWS), self.links, self.sample, self.tenure,
            (search.iteration, last), rng, until, holder, search.current, own_holder, search.own,
        )  # fmt: skip
        moved = replace(
            search,
            holder=holder,
            current=current,
            until=until,
            own_holder=own_holder,
            own=own,
            iteration=last,
            found=step_end if own < search.own else search.found,
            evaluations=search.evaluations + (last - search.iteration) * self.sample,
            at_rest=last == step_end,
            rng=rng,
        )
        if own < search.best:
            moved = _with_best(moved, view.component, own_holder)
        if not moved.at_rest:
            return moved
        stuck = (last - moved.found) * self.sample
        moved = replace(moved, current=cost_of(ground.moves, holder))
        if stuck < self.moves_per_item * view.component.n_items:
            return moved
        return self._restarted(view.component, moved)

    def admit(self, view: View, search: TabuState, selection: IntArray, cost: float) -> TabuState:
        """Return the search at another's better answer, as though it had come there by a move."""
        held = search.ground.held(view.component, selection, cost, search.best)
        if held is None:
            return search
        holder, cost = held
        moved = replace(
            search, holder=holder, current=cost, own_holder=holder, own=cost,
            found=search.iteration,
        )  # fmt: skip
        return _with_best(moved, view.component, holder)

    def _restarted(self, component: Component, search: TabuState) -> TabuState:
        """Return the search at its next start: nothing, the best, a part of an elite in turn."""
        ground, own_holder, own = search.ground, search.own_holder, search.own
        if self.improvement:
            selection = ground.selection(component, own_holder)
            polish(component, ground.lists, selection, search.starts)
            own_holder = ground.holding(component, selection)
            own = cost_of(ground.moves, own_holder)
        ended = _with_best(search, component, own_holder) if own < search.best else search
        pool = [own_holder, *(old for old in search.elite if not np.array_equal(old, own_holder))]
        pool.sort(key=lambda holder: cost_of(ground.moves, holder))
        elite, rng = tuple(pool[:ELITE]), copy.deepcopy(search.rng)
        selection = np.full_like(search.selection, -1)
        if search.starts % 3 == 1:
            selection = ended.selection
        elif search.starts % 3 == 2:
            selection = ground.selection(component, elite[int(rng.integers(len(elite)))])
            selection[rng.random(selection.shape[0]) < SENT_OFF] = -1
        holder = ground.holding(component, selection)
        cost = cost_of(ground.moves, holder)
        return replace(
            ended,
            holder=holder,
            current=cost,
            until=np.zeros_like(search.until),
            own_holder=holder,
            own=cost,
            found=search.iteration,
            elite=elite,
            starts=search.starts + 1,
            unchanged=ended.unchanged + 1,
            rng=rng,
        )

    def _chunk(self, view: View) -> int:
        return min(CHUNK, self.sample * self.iterations)

    def _why_over(self, search: TabuState) -> str:
        if search.evaluations >= self.evaluations:
            return "evaluations"
        return "converged" if search.unchanged >= self.patience else ""


def _with_best(search: TabuState, component: Component, holder: IntArray) -> TabuState:
    """Return the search with this answer as its best."""
    ground = search.ground
    return replace(
        search, selection=ground.selection(component, holder), best=cost_of(ground.moves, holder),
        unchanged=-1,
    )  # fmt: skip
