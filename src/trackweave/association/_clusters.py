"""Splitting a problem into components that share no item. Nothing here checks or raises."""

from typing import NamedTuple

import numpy as np

from trackweave._loops import overwrite
from trackweave.arrays import FloatArray, IntArray
from trackweave.jit import jit


class Partition(NamedTuple):
    """A problem's nodes, families and items, reordered so that each component is a slice.

    ``node`` holds the problem's node numbers, component after component, parents first;
    ``parent``, ``item`` and ``family`` are numbered within the component. Component c owns
    nodes ``node_start[c]:node_start[c + 1]`` and likewise families and items; ``members`` lists
    the component's nodes family after family, ``member_start`` (families + 1 entries for each
    component, so shifted by c) where each family's begin.
    """

    node: IntArray
    node_start: IntArray
    parent: IntArray
    item: IntArray
    family: IntArray
    total: FloatArray
    members: IntArray
    member_start: IntArray
    must: np.ndarray
    family_start: IntArray
    item_of: IntArray
    item_start: IntArray


@jit
def has_repeats(parent: IntArray, item: IntArray) -> bool:
    """Tell whether some sequence has an item twice."""
    for node in range(parent.shape[0]):
        climb = parent[node]
        while climb >= 0:
            if item[climb] == item[node]:
                return True
            climb = parent[climb]
    return False


@jit
def find(leader: IntArray, item: int) -> int:
    """Return the item that stands for the item's component, shortening the way to it."""
    while leader[item] != item:
        leader[item] = leader[leader[item]]
        item = leader[item]
    return item


@jit
def _group(label: IntArray, n_labels: int) -> tuple[IntArray, IntArray]:
    """Return where each label's entries start, and the entries in order of label (stable)."""
    start = np.zeros(n_labels + 1, dtype=np.int64)
    for value in label:
        if value >= 0:
            start[value + 1] += 1
    for index in range(n_labels):
        start[index + 1] += start[index]
    fill = start[:-1].copy()
    entries = np.empty(start[n_labels], dtype=np.int64)
    for entry in range(label.shape[0]):
        if label[entry] >= 0:
            entries[fill[label[entry]]] = entry
            fill[label[entry]] += 1
    return start, entries


@jit
def _label_items(
    parent: IntArray, item: IntArray, must_cover: np.ndarray, whole: bool
) -> tuple[IntArray, int]:
    """Return each item's component, -1 for an item without sequences, and how many there are."""
    n_nodes, n_items = parent.shape[0], must_cover.shape[0]
    leader = np.arange(n_items)
    used = must_cover.copy()
    for node in range(n_nodes):
        used[item[node]] = True
        if parent[node] >= 0:
            first, second = find(leader, item[node]), find(leader, item[parent[node]])
            if first != second:
                leader[max(first, second)] = min(first, second)
    if whole:
        leader[:] = 0
    label = np.full(n_items, -1, dtype=np.int64)
    number = np.full(n_items, -1, dtype=np.int64)
    n_components = 0
    for index in range(n_items):
        if used[index]:
            top = find(leader, index)
            if number[top] < 0:
                number[top] = n_components
                n_components += 1
            label[index] = number[top]
    return label, n_components


@jit
def partition(
    parent: IntArray, item: IntArray, total: FloatArray, must_cover: np.ndarray, whole: bool
) -> Partition:
    """Return the components of a problem whose parents stand before their children.

    ``whole`` makes one component of everything.
    """
    n_nodes, n_items = parent.shape[0], must_cover.shape[0]
    label, n_components = _label_items(parent, item, must_cover, whole)
    item_start, item_of = _group(label, n_components)
    item_local = np.empty(n_items, dtype=np.int64)
    for component in range(n_components):
        for place in range(item_start[component], item_start[component + 1]):
            item_local[item_of[place]] = place - item_start[component]
    node_label = np.empty(n_nodes, dtype=np.int64)
    for node in range(n_nodes):
        node_label[node] = label[item[node]]
    node_start, order = _group(node_label, n_components)
    local = np.empty(n_nodes, dtype=np.int64)
    family = np.empty(n_nodes, dtype=np.int64)
    family_start = np.zeros(n_components + 1, dtype=np.int64)
    must = np.empty(n_nodes, dtype=np.bool_)
    parent_out, item_out = np.empty(n_nodes, dtype=np.int64), np.empty(n_nodes, dtype=np.int64)
    total_out = np.empty(n_nodes)
    members = np.empty(n_nodes, dtype=np.int64)
    member_start = np.zeros(n_nodes + n_components + 1, dtype=np.int64)
    for component in range(n_components):
        begin = node_start[component]
        first_family = family_start[component]
        n_families = 0
        for place in range(begin, node_start[component + 1]):
            node = order[place]
            local[node] = place - begin
            above = parent[node]
            parent_out[place] = local[above] if above >= 0 else -1
            item_out[place] = item_local[item[node]]
            total_out[place] = total[node]
            if above < 0:
                must[first_family + n_families] = must_cover[item[node]]
                family[place] = n_families
                n_families += 1
            else:
                family[place] = family[begin + local[above]]
        family_start[component + 1] = first_family + n_families
        starts, inside = _group(family[begin : node_start[component + 1]], n_families)
        overwrite(members[begin : node_start[component + 1]], inside)
        offset = first_family + component
        overwrite(member_start[offset : offset + n_families + 1], starts)
    n_families = family_start[n_components]
    return Partition(
        order, node_start, parent_out, item_out, family, total_out, members,
        member_start[: n_families + n_components], must[:n_families], family_start,
        item_of, item_start,
    )  # fmt: skip
