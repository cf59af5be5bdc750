"""A component's items as lists, no two items of which share a sequence."""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import IntArray
from trackweave.solvers._kernels import Component, layers

__all__ = ["Lists", "lists_of"]


class Lists(NamedTuple):
    """Items in lists, in the order in which sequences have them.

    ``of`` holds each item's list, numbered from 0; the items of list l are
    ``member[start[l]:start[l + 1]]``, in order of their numbers.
    """

    of: IntArray
    member: IntArray
    start: IntArray


def lists_of(component: Component, instant: IntArray) -> Lists:
    """Return a component's items as lists, none empty, no two items of which share a sequence."""
    # The lists of tuples are those that they were made of, the lists of a window its scans. A list
    # holds items of one instant, and earlier instants come first. Where items of one instant share
    # sequences, as reports of sensors that look at the same time do, the instant has several
    # lists; an item then stands in a later list than those of lower numbers that it shares one
    # with.
    key = np.stack([instant, layers(component, instant)], axis=1)
    lists, of = np.unique(key, axis=0, return_inverse=True)
    of = of.reshape(-1).astype(np.int64)
    member = np.argsort(of, kind="stable")
    return Lists(of, member, np.searchsorted(of[member], np.arange(lists.shape[0] + 1)))
