"""Which points of a sweep are tried: drawn at random, or proposed by an estimator that learns."""

from collections.abc import Generator, Iterator
from typing import Any, TypeAlias

import numpy as np

from trackweave.errors import InvalidInputError
from trackweave.experiments.sweeps import Point, Sweep

__all__ = ["SAMPLERS", "Proposals", "proposals"]

SAMPLERS = ("random", "tpe")
Proposals: TypeAlias = Generator[list[Point], list[float], None]
"""Points to be tried next, to which the score of each is sent back; more is better."""

BATCH = 4
"""So many points are proposed at a time, however many workers there are: it decides which."""
MOST_REPEATS = 20
"""After so many proposals in succession of what has been tried, a point is drawn at random."""


def proposals(sampler: str, sweep: Sweep, count: int, rng: np.random.Generator) -> Proposals:
    """Yield different points of a sweep, ``count`` in all, or every one where there are fewer.

    Parameters
    ----------
    sampler
        "random", or "tpe" for the tree-structured Parzen estimator [1]_ of Optuna.
    sweep
        The keys and their values.
    count
        How many points, at least 1.
    rng
        The only source of randomness.

    Returns
    -------
    Batches of points; scores are sent back in their order, -inf for a point that failed.

    Raises
    ------
    InvalidInputError
        If the estimator is asked for and Optuna is missing.

    References
    ----------
    .. [1] J. Bergstra, R. Bardenet, Y. Bengio, B. Kégl, *Algorithms for hyper-parameter
       optimization*, NeurIPS 2011, section 4.
    """
    estimator = _Estimator(sweep, int(rng.integers(2**32))) if sampler == "tpe" else None
    if estimator is None or len(sweep) <= count:
        return _at_random(sweep, count, rng)
    return _by_estimator(estimator, count, rng)


def _at_random(sweep: Sweep, count: int, rng: np.random.Generator) -> Proposals:
    points = list(sweep.points())
    if len(points) > count:
        chosen = np.sort(rng.choice(len(points), count, replace=False))
        points = [points[place] for place in chosen]
    yield points


def _by_estimator(estimator: "_Estimator", count: int, rng: np.random.Generator) -> Proposals:
    tried: set[tuple[int, ...]] = set()
    while len(tried) < count:
        places = list(estimator.asked(min(BATCH, count - len(tried)), tried, rng))
        scores = yield [estimator.point(place) for place in places]
        estimator.tell(places, scores)


class _Estimator:
    """Optuna's, over the places of values in their lists."""

    def __init__(self, sweep: Sweep, seed: int) -> None:
        try:
            import optuna
        except ModuleNotFoundError as err:
            raise InvalidInputError(
                "tune.sampler: 'tpe' needs Optuna, which is not installed; expected pip install "
                "'trackweave[tune]', or the sampler random"
            ) from err
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        self._trial, self._keys = optuna.trial.create_trial, sweep.keys
        # Numbers have an order, of which the estimator makes use; words have none.
        self._space: dict[str, Any] = {
            str(number): (
                optuna.distributions.IntDistribution(0, len(values) - 1)
                if all(isinstance(value, int | float) for value in values)
                else optuna.distributions.CategoricalDistribution(range(len(values)))
            )
            for number, values in enumerate(sweep.keys.values())
        }
        sampler = optuna.samplers.TPESampler(seed=seed)
        self._study = optuna.create_study(direction="maximize", sampler=sampler)

    def asked(
        self, count: int, tried: set[tuple[int, ...]], rng: np.random.Generator
    ) -> Iterator[tuple[int, ...]]:
        """Yield places that have not been tried, and enter them."""
        for _ in range(count):
            place, repeats = self._proposed(), 0
            while place in tried:
                repeats += 1
                place = self._proposed() if repeats < MOST_REPEATS else self._drawn(rng)
            tried.add(place)
            yield place

    def point(self, place: tuple[int, ...]) -> Point:
        """Return the values at a place."""
        return {
            key: values[at] for (key, values), at in zip(self._keys.items(), place, strict=True)
        }

    def tell(self, places: list[tuple[int, ...]], scores: list[float]) -> None:
        """Take what the points at some places are worth."""
        for place, score in zip(places, scores, strict=True):
            params = dict(zip(self._space, place, strict=True))
            self._study.add_trial(
                self._trial(params=params, distributions=self._space, value=score)
            )

    def _proposed(self) -> tuple[int, ...]:
        return tuple(self._study.ask(self._space).params[name] for name in self._space)

    def _drawn(self, rng: np.random.Generator) -> tuple[int, ...]:
        return tuple(int(rng.integers(len(values))) for values in self._keys.values())
