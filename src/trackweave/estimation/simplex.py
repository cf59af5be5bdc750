"""The simplex search of Nelder and Mead: a least value of a function of few numbers."""

from collections.abc import Callable

import numpy as np

from trackweave.arrays import FloatArray

__all__ = ["least_by_simplex"]

# SciPy's choices. Importing SciPy's search takes longer than all searches of a short run.
FURTHER, FROM_ZERO = 0.05, 0.00025
NEAR = 1e-4


def least_by_simplex(
    function: Callable[[FloatArray], float], start: FloatArray, *, rounds: int, within: float
) -> FloatArray:
    """Return where a function is least, as far as so many rounds find it.

    Source: Nelder, Mead (1965), with the coefficients 1, 2, ½ and ½.

    Parameters
    ----------
    function
        Takes numbers, shape (dim,); may return infinity.
    start
        Where the search begins, shape (dim,).
    rounds
        After so many it ends.
    within
        It ends where values at all corners are as near as this, and corners as 0.0001.

    Returns
    -------
    The best corner, shape (dim,).
    """
    corner = np.tile(start, (start.size + 1, 1))
    for axis in range(start.size):
        moved = corner[axis + 1, axis]
        corner[axis + 1, axis] = (1.0 + FURTHER) * moved if moved != 0.0 else FROM_ZERO
    value = np.array([function(each) for each in corner])
    corner, value = _sorted(corner, value)
    for _ in range(rounds - 1):
        if np.abs(corner[1:] - corner[0]).max() <= NEAR and np.ptp(value) <= within:
            break
        _turn(function, corner, value)
        corner, value = _sorted(corner, value)
    best: FloatArray = corner[0]
    return best


def _sorted(corner: FloatArray, value: FloatArray) -> tuple[FloatArray, FloatArray]:
    order = np.argsort(value)
    return corner[order], value[order]


def _turn(function: Callable[[FloatArray], float], corner: FloatArray, value: FloatArray) -> None:
    """Replace the worst corner, the last, by a better one, or draw all towards the best."""
    middle, worst = np.add.reduce(corner[:-1], 0) / (len(corner) - 1), corner[-1].copy()
    reflected = 2.0 * middle - worst
    at_reflected = function(reflected)
    if at_reflected < value[0]:
        expanded = 3.0 * middle - 2.0 * worst
        at_expanded = function(expanded)
        if at_expanded < at_reflected:
            corner[-1], value[-1] = expanded, at_expanded
        else:
            corner[-1], value[-1] = reflected, at_reflected
        return
    if at_reflected < value[-2]:
        corner[-1], value[-1] = reflected, at_reflected
        return
    is_outside = at_reflected < value[-1]
    contracted = 1.5 * middle - 0.5 * worst if is_outside else 0.5 * middle + 0.5 * worst
    at_contracted = function(contracted)
    if at_contracted <= at_reflected if is_outside else at_contracted < value[-1]:
        corner[-1], value[-1] = contracted, at_contracted
        return
    for row in range(1, len(corner)):
        corner[row] = corner[0] + 0.5 * (corner[row] - corner[0])
        value[row] = function(corner[row])
