"""What kernels need of NumPy, as loops. Nothing here checks or raises.

Numba's own versions are general: ``target[:] = source`` compiles the words of its error message
into every kernel that holds it, ``np.partition`` and ``np.argsort`` each take seconds to compile.
"""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit

BLOCK = 16
"""So many values are sorted by insertion, which is faster than merging."""


@jit
def overwrite(target: np.ndarray, source: np.ndarray) -> None:
    """Write the values of one row over those of another of the same length."""
    for index in range(target.shape[0]):
        target[index] = source[index]


@jit
def overwrite_rows(target: FloatArray, source: FloatArray) -> None:
    """Write the values of one matrix over those of another of the same shape."""
    for row in range(target.shape[0]):
        for column in range(target.shape[1]):
            target[row, column] = source[row, column]


@jit
def total_of(values: FloatArray) -> float:
    """Return the sum of the values, added one after the other."""
    total = 0.0
    for index in range(values.shape[0]):
        total += values[index]
    return total


@jit
def largest(values: FloatArray) -> int:
    """Return the index of the largest value, the first of equals."""
    found = 0
    for index in range(1, values.shape[0]):
        if values[index] > values[found]:
            found = index
    return found


@jit
def with_label(label: IntArray, wanted: int) -> IntArray:
    """Return the indices of the entries that have a label."""
    found, n_found = np.empty(label.shape[0], dtype=np.int64), 0
    for index in range(label.shape[0]):
        if label[index] == wanted:
            found[n_found] = index
            n_found += 1
    return found[:n_found]


@jit
def ascending(values: FloatArray | IntArray) -> IntArray:
    """Return the indices of the values in ascending order; equal ones stay as they were."""
    n = values.shape[0]
    order, merged = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64)
    for first in range(0, n, BLOCK):
        for index in range(first, min(first + BLOCK, n)):
            place = index
            while place > first and values[order[place - 1]] > values[index]:
                order[place] = order[place - 1]
                place -= 1
            order[place] = index
    width = BLOCK
    while width < n:
        for first in range(0, n, 2 * width):
            middle, end = min(first + width, n), min(first + 2 * width, n)
            left, right = first, middle
            for place in range(first, end):
                if right == end or (left < middle and values[order[left]] <= values[order[right]]):
                    merged[place] = order[left]
                    left += 1
                else:
                    merged[place] = order[right]
                    right += 1
        order, merged = merged, order
        width *= 2
    return order


@jit
def kth_least(values: FloatArray, k: int) -> float:
    """Return the k-th least of the values, from 0; rearranges them."""
    first, last = 0, values.shape[0] - 1
    while first < last:
        # The middle one, so that rows in order, which are usual, are halved each time.
        pivot = values[(first + last) // 2]
        left, right = first, last
        while left <= right:
            while values[left] < pivot:
                left += 1
            while values[right] > pivot:
                right -= 1
            if left <= right:
                values[left], values[right] = values[right], values[left]
                left += 1
                right -= 1
        if k <= right:
            last = right
        elif k >= left:
            first = left
        else:
            break
    return float(values[k])
