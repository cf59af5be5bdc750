"""How the patent's search converges and stops, window by window."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers import Exact
from trackweave.solvers.protocol import Stop
from trackweave.studies.hillis_fitness import alone_as_tracks, document_search, sequence
from trackweave.studies.hillis_scenes import dense_scene, follow

__all__ = ["Evolution", "evolve", "full_window", "interrupted", "least_cost"]


def full_window(
    rng: np.random.Generator, n_objects: int, depth: int = 5, n_scans: int = 7
) -> AssignmentProblem:
    """Return a full window's problem, what lies before it rightly fixed as far as is possible.

    Parameters
    ----------
    rng
        Source of randomness.
    n_objects, depth, n_scans
        Objects of the scene, scans in the window, and of the scene.

    Returns
    -------
    The problem after the last scan.
    """
    followed = follow(dense_scene(rng, n_objects, n_scans), Exact(), depth, rng)
    return followed.asked.problems[-1]


def least_cost(problem: AssignmentProblem, rng: np.random.Generator, *, lone: bool) -> float:
    """Return what the best hypothesis costs, proven by branch and bound.

    Parameters
    ----------
    problem
        The window's problem.
    rng
        Source of randomness.
    lone
        Whether a report that joins nothing is a track of its own, as the patent has it; it is a
        false alarm otherwise.

    Returns
    -------
    The cost [nats].
    """
    return Exact()(alone_as_tracks(problem) if lone else problem, rng=rng).cost


ROUNDING = 1e-9
"""Costs that differ by no more are equal [nats]."""


@dataclass(frozen=True, slots=True, eq=False)
class Evolution:
    """A search, generation by generation.

    Parameters
    ----------
    best
        The least cost found up to each generation, above the best there is [nats].
    mean
        The mean cost of each generation's individuals, likewise.
    spread
        Mean less least cost within each generation [nats].
    reports
        Length of the permutations.
    """

    best: FloatArray
    mean: FloatArray
    spread: FloatArray
    reports: int


def evolve(problem: AssignmentProblem, rng: np.random.Generator) -> Evolution:
    """Return how the preset's search goes on for all its generations.

    Parameters
    ----------
    problem
        The window's problem.
    rng
        Source of randomness.

    Returns
    -------
    Cost against the best there is.
    """
    least = least_cost(problem, rng, lone=True)
    search = replace(document_search(), spread=0.0)
    n_generations = search.generations
    # One more generation, and no end of evaluations, so that the last one wanted is still there.
    search = replace(search, generations=n_generations + 1, evaluations=10**9)
    state = search.start(problem, rng=rng)
    best: list[float] = []
    mean: list[float] = []
    spread: list[float] = []
    while not state.done and len(best) < n_generations:
        state = search.advance(state, evaluations=search.population)
        if state.search is not None:
            best.append(state.search.best)
            mean.append(float(state.search.cost.mean()))
            spread.append(state.search.spread())
    if not best:
        best, mean, spread = [least], [least], [0.0]
    # A search that is proven best ends before its time: it stays as it is.
    more = n_generations - len(best)
    columns = [np.array(each + each[-1:] * more) for each in (best, mean, spread)]
    above = [np.where(column - least > ROUNDING, column - least, 0.0) for column in columns[:2]]
    return Evolution(above[0], above[1], columns[2], problem.n_items)


def interrupted(
    problem: AssignmentProblem, looks: Sequence[int], seed: int
) -> tuple[list[float], bool]:
    """Return what the search says when it is interrupted after so many looks at the clock.

    Parameters
    ----------
    problem
        The window's problem.
    looks
        After how many looks the next scan is there, at least 1, ascending.
    seed
        Seed of the random numbers, the same for each.

    Returns
    -------
    The cost of each answer, and whether each is a whole hypothesis: the search says that it was
    stopped, and every report is in exactly one track.
    """
    search, costs, whole = document_search(), [], True
    for most in looks:
        # The same numbers again: each answer is what a longer search would have passed.
        again = np.random.Generator(np.random.PCG64(seed))
        answer = search(problem, rng=again, stop=_after(most))
        taken = [item for node in answer.nodes for item in sequence(problem, int(node))]
        free = np.setdiff1d(np.arange(problem.n_items), np.flatnonzero(problem.must_cover))
        whole &= len(taken) == len(set(taken)) and set(free.tolist()) <= set(taken)
        whole &= answer.stop_reason == "stopped"
        costs.append(answer.cost)
    return costs, whole


def _after(looks: int) -> Stop:
    """Return what says to stop when it has been asked so many times before."""
    asked = count()
    return lambda: next(asked) >= looks
