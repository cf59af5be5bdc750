"""Where chance comes from: a generator, or the seed of one. Nothing is ever unseeded."""

from typing import Any, TypeAlias

import numpy as np

from trackweave.arrays import is_whole
from trackweave.errors import InvalidInputError

__all__ = ["RandomSource", "generator_for", "generator_of", "seed_of"]

RandomSource: TypeAlias = np.random.Generator | int


def generator_of(rng: RandomSource) -> np.random.Generator:
    """Return a source of randomness as a generator.

    Parameters
    ----------
    rng
        A generator, which is handed back as it is, or a seed: a whole number of at least 0.

    Returns
    -------
    The generator. A seed gives a new one at each call, which draws the same numbers again.

    Raises
    ------
    InvalidInputError
        If it is neither.

    Examples
    --------
    >>> generator_of(7).random() == generator_of(7).random()
    True
    """
    if isinstance(rng, np.random.Generator):
        return rng
    seed: Any = rng  # a caller's types are not to be trusted
    if not is_whole(seed) or seed < 0:
        raise InvalidInputError(
            f"rng: {rng!r:.80}; expected a numpy.random.Generator, or a whole number >= 0 as seed"
        )
    return np.random.default_rng(int(seed))


def generator_for(seed: int, part: str) -> np.random.Generator:
    """Return the source of randomness of one part of what a seed is for, whatever others draw."""
    return np.random.default_rng(np.random.SeedSequence([seed, *part.encode()]))


def seed_of(rng: RandomSource) -> int | None:
    """Return the seed that a source of randomness was given as, None for a generator."""
    return None if isinstance(rng, np.random.Generator) else int(rng)
