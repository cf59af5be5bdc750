"""Colours and lines by which tracks are told apart, above all from their neighbours."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["COLOURS", "Look", "looks_of"]

# Okabe and Ito's colours, told apart by colour-blind people; dark and light ones take turns so
# that neighbours differ in grey too, and each use of a colour has another kind of line.
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#333333", "#D55E00", "#56B4E9")
LINES: tuple[tuple[float, ...], ...] = ((), (7, 1.6), (9, 1.6, 1.6, 1.6), (3, 1.2))
MOST_COMPARED = 200
POINTS_OF_A_PATH = 24


class Look(NamedTuple):
    """How a track is drawn: its colour and its dashes, none for a solid line."""

    colour: str
    dashes: tuple[float, ...]


def looks_of(paths: list[FloatArray]) -> list[Look]:
    """Return a look for each track, such that no neighbours look alike."""
    # Paths run in one unit along both axes, each of shape (places, 2). The colour is that whose
    # last use lies farthest from the track, the first of equals; of very many tracks, which are
    # hairlines, the colours go in turn.
    if len(paths) > MOST_COMPARED:
        return [Look(COLOURS[number % len(COLOURS)], ()) for number in range(len(paths))]
    drawn: list[list[FloatArray]] = [[] for _ in COLOURS]
    looks = []
    for path in paths:
        places = path[np.linspace(0, len(path) - 1, POINTS_OF_A_PATH).round().astype(int)]
        colour = int(np.argmax([_distance(places, others) for others in drawn]))
        looks.append(Look(COLOURS[colour], LINES[len(drawn[colour]) % len(LINES)]))
        drawn[colour].append(places)
    return looks


def _distance(places: FloatArray, others: list[FloatArray]) -> float:
    """Return how near other paths come, infinity for none."""
    if not others:
        return np.inf
    apart = places[:, None] - np.concatenate(others)[None]
    return float(np.sum(apart**2, axis=2).min())
