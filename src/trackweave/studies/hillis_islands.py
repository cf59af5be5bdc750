"""The patent's search in the island model, beside one population."""

from dataclasses import replace

import numpy as np

from trackweave.association.problem import Answer, AssignmentProblem
from trackweave.solvers import Islands
from trackweave.solvers.resumable import Resumable
from trackweave.studies.hillis_fitness import document_search
from trackweave.studies.hillis_search import full_window, least_cost
from trackweave.studies.writing import Table

__all__ = ["on_islands"]

ISLANDS = 4
WITHOUT_END = 10**9
"""A limit that the number of evaluations comes before."""


def on_islands(rng: np.random.Generator, size: int, n_windows: int) -> tuple[Table, bool]:
    """Return what islands find, beside one population, in full windows.

    Parameters
    ----------
    rng
        Source of randomness.
    size, n_windows
        Number of objects, and how many windows.

    Returns
    -------
    The mean excess of each way to spread the search; whether each answer was the same on any
    number of threads.
    """
    population = replace(
        document_search(), spread=0.0, generations=WITHOUT_END, evaluations=WITHOUT_END
    )
    several = Islands((population,), ISLANDS, threads=1, epochs=WITHOUT_END, patience=WITHOUT_END)
    ways: dict[str, Resumable] = {
        "one population": population,
        "one that keeps its fittest": replace(population, elite=1),
        f"{ISLANDS} islands": several,
        f"{ISLANDS} islands, nothing sent": replace(several, neighbours=0),
    }
    excess: dict[str, list[float]] = {name: [] for name in ways}
    are_same = True
    for own in rng.spawn(n_windows):
        problem, seed = full_window(own, size), int(own.integers(2**31))
        least = least_cost(problem, own, lone=True)
        answers = {name: _searched(search, problem, seed) for name, search in ways.items()}
        for name, answer in answers.items():
            excess[name].append(max(answer.cost - least, 0.0))
        for threads in (2, ISLANDS):
            again = _searched(replace(several, threads=threads), problem, seed)
            are_same &= _told(again) == _told(answers[f"{ISLANDS} islands"])
    rows = [(name, float(np.mean(found)), max(found)) for name, found in excess.items()]
    return Table(("search", "excess [nats]", "greatest [nats]"), tuple(rows)), are_same


def _searched(search: Resumable, problem: AssignmentProblem, seed: int) -> Answer:
    """Return the answer after as many evaluations as the preset's population has."""
    preset = document_search()
    state = search.start(problem, rng=np.random.Generator(np.random.PCG64(seed)))
    state = search.advance(state, evaluations=preset.population * preset.generations)
    return search.answer(state)


def _told(answer: Answer) -> tuple[object, ...]:
    return answer.nodes.tolist(), answer.certificate, answer.evaluations
