"""How often objects are where no sensor can see them, and for how long, as tracks tell."""

from collections.abc import Sequence

import numpy as np

from trackweave.arrays import FloatArray, IntArray

__all__ = ["long_pauses", "silences"]

# Pauses so long that among all of them chance would make fewer than this many.
BY_CHANCE = 0.05
# What is believed beforehand: the share as of a twentieth of a silence, and how long one lasts as
# of one, as few tell little of it (of logarithms, as one may last ten times as long as another).
USUAL_SHARE, USUAL_SILENCE, BELIEVED = 0.01, 60.0, 0.05
SHARES, LEAST_SILENCE, LONGEST_SILENCE = (0.003, 0.3), 5.0, 600.0


def long_pauses(pauses: IntArray, chances: int, *, are_most: bool = False) -> np.ndarray:
    """Tell which pauses are longer than misses one by one would make them."""
    # Pauses are the chances missed in a row before each report, 0 for none, ``chances`` those in
    # all. Where long ones may make up most of the misses they would hide one another; then the
    # share of pauses that are none comes first, in which each counts once, however long.
    long = np.zeros(pauses.shape[0], dtype=np.bool_)
    if pauses.size == 0:
        return long
    if are_most:
        once = (np.count_nonzero(pauses) + 1.0) / (pauses.size + 2.0)
        seeming = _beyond_chance(pauses, once)
        share = _missed_share(pauses, seeming, chances)
        long = seeming & _beyond_chance(pauses, share)
    while True:
        # Those found so far are no misses of an object in sight.
        found = _beyond_chance(pauses, _missed_share(pauses, long, chances))
        if np.array_equal(found | long, long):
            return long
        long |= found


def _missed_share(pauses: IntArray, long: np.ndarray, chances: int) -> float:
    """Return the share of chances that were missed, those of long pauses left out."""
    missed = int(pauses[~long].sum())
    return (missed + 1.0) / (max(chances - int(pauses[long].sum()), missed) + 2.0)


def _beyond_chance(pauses: IntArray, share: float) -> np.ndarray:
    """Tell which pauses are longer than chance makes any of them, where such a share is missed."""
    beyond: np.ndarray = pauses * np.log(share) < np.log(BY_CHANCE / pauses.size)
    return beyond


def silences(gaps: Sequence[tuple[FloatArray, IntArray]]) -> tuple[float, float]:
    """Return the share of their time for which objects are hidden, and how long on average [s]."""
    # Gaps are, for each object, the time from report to report [s] and the chances missed between.
    # Both are near the usual ones where there are few tracks.
    times = np.concatenate([np.empty(0), *(time for time, _ in gaps)])
    pauses = np.concatenate([np.empty(0, dtype=np.int64), *(pause for _, pause in gaps)])
    if times.size == 0:
        return USUAL_SHARE, USUAL_SILENCE
    long = long_pauses(pauses, int(pauses.sum()) + pauses.size)
    interval = float(np.median(times))
    hidden = float(np.sum(times[long] - interval))
    believed, n_long = BELIEVED * USUAL_SILENCE, int(long.sum())
    mean = USUAL_SILENCE
    if n_long and hidden > 0.0:
        mean *= (hidden / n_long / USUAL_SILENCE) ** (n_long / (n_long + 1.0))
    share = (believed + hidden) / (believed / USUAL_SHARE + float(times.sum()))
    mean = float(np.clip(mean, LEAST_SILENCE * interval, max(LONGEST_SILENCE, 10 * interval)))
    return float(np.clip(share, *SHARES)), mean
