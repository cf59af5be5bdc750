"""The methods that the study of Huo and others sets side by side."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.chain_rule import track_chains
from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.practice import nearest_neighbour, pairwise_sequential
from trackweave.fusion.statistic import Statistic
from trackweave.presets.huo_2008 import CONFIGURATION
from trackweave.solvers import Exact, Greedy, ListGenetic
from trackweave.solvers.protocol import Solver
from trackweave.studies.scenes import TrackScene

__all__ = [
    "COMPLETE",
    "METHODS",
    "best_by_generation",
    "document_search",
    "groups",
    "successive",
]

COMPLETE = ("document", "exact")
"""Methods that need every sensor to see every object."""
METHODS = (*COMPLETE, "pairwise", "nearest", "default")


def document_search() -> ListGenetic:
    """Return the genetic search of the preset."""
    options = {key: value for key, value in CONFIGURATION["search"].items() if key != "method"}
    return ListGenetic(**options)


def groups(method: str, scene: TrackScene, rng: np.random.Generator) -> list[IntArray]:
    """Return the group of each track of each sensor, by the last time.

    Parameters
    ----------
    method
        One of ``METHODS``.
    scene
        The tracks.
    rng
        Source of randomness.

    Returns
    -------
    Groups, sensor by sensor.
    """
    if method == "pairwise":
        return pairwise_sequential(scene.estimates)
    if method == "nearest":
        return nearest_neighbour(scene.estimates)
    associator = TrackAssociator(sensors=scene.names)
    last = scene.estimates[0].n_times - 1
    if method in COMPLETE:
        # What earlier associations say does not enter the last one's.
        associator = _complete(scene, Greedy())
    for time in range(last + 1):
        if time == last and method in COMPLETE:
            associator.search = document_search() if method == "document" else Exact()
        found = associator.step(float(time), scene.pictures(time), rng=rng)
    return [found.object[found.sensor == number] for number in range(len(scene.names))]


def successive(
    scene: TrackScene, rng: np.random.Generator, *, memory: str
) -> list[frozenset[tuple[int, ...]]]:
    """Return what the document's method pairs at each time.

    Parameters
    ----------
    scene
        The tracks.
    rng
        Source of randomness.
    memory
        "full", the document's, or "one time": each time is judged alone.

    Returns
    -------
    The tuples of each association, those of tracks alone left out.
    """
    statistic = Statistic(**CONFIGURATION["statistic"])
    if memory == "one time":
        statistic = replace(statistic, memory="sliding", length=1)
    associator = _complete(scene, document_search(), statistic)
    outcomes = []
    for time in range(scene.estimates[0].n_times):
        found = associator.step(float(time), scene.pictures(time), rng=rng)
        outcomes.append(frozenset(each for each in found.tuples() if min(each) >= 0))
    return outcomes


def best_by_generation(
    scene: TrackScene, generations: Sequence[int], rng: np.random.Generator
) -> FloatArray:
    """Return by what share the best fitness exceeds the least J after so many generations.

    Parameters
    ----------
    scene
        The tracks; every sensor sees every object.
    generations
        The numbers of generations.
    rng
        Source of randomness.

    Returns
    -------
    Shares from 0, shape (generations,).
    """
    problem = track_chains(scene.estimates).problem()
    least = Exact()(problem, rng=rng).cost
    most = max(generations)
    search = replace(document_search(), patience=most, evaluations=10**9)
    seed = int(rng.integers(2**31))
    excess = []
    for number in generations:
        # The same numbers again: each run goes on where the shorter one ended.
        again = np.random.Generator(np.random.PCG64(seed))
        answer = replace(search, generations=number)(problem, rng=again)
        excess.append(max(0.0, answer.cost / least - 1.0))
    return np.array(excess)


def _complete(
    scene: TrackScene, search: Solver, statistic: Statistic | None = None
) -> TrackAssociator:
    """Return the document's associator, without its rule of confirmation."""
    if statistic is None:
        statistic = Statistic(**CONFIGURATION["statistic"])
    return TrackAssociator(sensors=scene.names, statistic=statistic, search=search, complete=True)
