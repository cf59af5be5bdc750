"""What threads tell of objects that rest, and set out: noise at rest, and what they do then."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.chi_squared import quantile_of

__all__ = ["fastest_step", "noise_at_rest", "process_of_starts"]

# Reports in a row that rest where their slope is none, for so many standard deviations of it; so
# many such pieces that are alike tell, where they are this share of all.
PIECE, RESTING, FEWEST_PIECES, LEAST_SHARE = 5, 3.0, 8, 0.05
# A quarter of those that rest has less noise than this part of the usual one.
QUARTER, BELOW_USUAL, ALIKE = 0.25, 0.76, 2.0
# Of steps, so many may be faster; what noise makes of them is left out.
SELDOM, NOISE = 0.002, 3.0
# Of second differences, so many may lie farther off than one in a hundred should.
FAR, INSIDE = 0.014, 0.99


def noise_at_rest(time: FloatArray, position: FloatArray, threads: list[IntArray]) -> float | None:
    """Return the noise along an axis [m] of reports of what rests; None where hardly any does."""
    found, n_pieces = [], 0
    for rows in threads:
        for start in range(0, rows.size - PIECE + 1, PIECE):
            piece = rows[start : start + PIECE]
            centred = time[piece] - time[piece].mean()
            square = float(np.dot(centred, centred))
            places = position[piece] - position[piece].mean(axis=0)
            slope = centred @ places / max(square, 1e-12)
            left = places - np.outer(centred, slope)
            noise = np.sqrt(np.sum(left**2) / ((PIECE - 2) * places.shape[1]))
            n_pieces += 1
            if float(np.linalg.norm(slope)) * square**0.5 < RESTING * noise:
                found.append(float(noise))
    if not found:
        return None
    # What loiters is no noise: the most exact quarter tells.
    noise = float(np.quantile(found, QUARTER)) / BELOW_USUAL
    n_alike = sum(each < ALIKE * noise for each in found)
    return noise or None if n_alike >= max(FEWEST_PIECES, LEAST_SHARE * n_pieces) else None


def fastest_step(
    time: FloatArray, position: FloatArray, threads: list[IntArray], sigma: float, least: float
) -> float:
    """Return a speed [m/s] that hardly any step of at least so long [s] exceeds, 0 without any."""
    speeds = [np.zeros(1)]
    for rows in threads:
        own = time[rows]
        after = np.searchsorted(own, own + least)
        before = np.flatnonzero(after < rows.size)
        after = after[before]
        way = np.linalg.norm(position[rows[after]] - position[rows[before]], axis=1)
        sure = np.maximum(way - NOISE * np.sqrt(2.0) * sigma, 0.0)
        speeds.append(sure / np.maximum(own[after] - own[before], 1e-9))
    return float(np.quantile(np.concatenate(speeds), 1.0 - SELDOM))


def process_of_starts(
    time: FloatArray, position: FloatArray, threads: list[IntArray], sigma: float, least: float
) -> float:
    """Return the process noise [m²/s³] with which hardly any start, stop or turn is far off."""
    # The velocity from the report before to the next one changes by as much over both steps. Over
    # steps shorter than ``least`` [s] it is stamps that were rounded that seem to turn.
    limit = quantile_of(position.shape[1], INSIDE)
    needed = [np.zeros(1)]
    for rows in threads:
        wait = np.maximum(np.diff(time[rows]), 1e-3)
        first, second = wait[:-1], wait[1:]
        ratio = second / first
        step = np.diff(position[rows], axis=0)
        off = np.sum((step[1:] - ratio[:, None] * step[:-1]) ** 2, axis=1)
        noise = sigma**2 * (1.0 + (1.0 + ratio) ** 2 + ratio**2)
        grown = second**2 * (first + second) / 3.0
        is_long = np.minimum(first, second) >= least
        needed.append(((off / limit - noise) / grown)[is_long])
    return max(float(np.quantile(np.concatenate(needed), 1.0 - FAR)), 0.0)
