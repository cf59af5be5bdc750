"""How sequences that a tree left out rank once their reports have prices. Checks nothing."""

from typing import NamedTuple

from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit


class Cut(NamedTuple):
    """What a tree left out at its last scan.

    ``above`` is the node that a sequence goes on from, or ~k where that is the k-th of these
    itself, and ``report`` the slot of its own report beyond it, -1 for none. ``log_weight`` is of
    the sequence without any prices, or of the part of it that was left out.
    """

    family: IntArray
    above: IntArray
    report: IntArray
    log_weight: FloatArray


@jit
def add_above(above: IntArray, priced: FloatArray, along: FloatArray) -> None:
    """Add to the price of each sequence's own report those of the reports before it, in place."""
    for entry in range(above.shape[0]):
        before = above[entry]
        along[entry] += priced[before] if before >= 0 else along[~before]
