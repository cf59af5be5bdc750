"""States of sequences at a time, whatever the modes of motion."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._beliefs import average_states, move_states
from trackweave.association._nodes import Nodes, WindowRule, n_modes_and_size
from trackweave.association.foreign_growth import moved
from trackweave.association.tree import AssociationTree

__all__ = ["average_at", "shown", "states_at"]


def states_at(
    tree: AssociationTree, node: IntArray, time: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return mean (sequences, size) and covariance of states, averaged over modes of motion."""
    # They are those at a time [s], or at each one's last report; meaningless for an object on a
    # line.
    _, size = n_modes_and_size(tree.rule.motion)
    nodes = tree.nodes
    if time is not None and tree.rule.way is not None:
        nodes = moved(nodes, tree.n_nodes, time, tree.rule)
    moments = nodes.time[node] if time is None else np.full(node.shape[0], time)
    mean, covariance = np.empty((node.shape[0], size)), np.empty((node.shape[0], size, size))
    move_states(nodes, node, moments, tree.rule.motion, mean, covariance, tree.general)
    return mean, covariance


def average_at(
    source: tuple[Nodes, int, int],
    node: IntArray,
    time: float,
    tree: AssociationTree,
    *,
    by_belief: bool,
) -> tuple[FloatArray, FloatArray]:
    """Return the states of sequences of another room, or of their families."""
    # ``source`` is the room, how many nodes it has and how many families; ``node`` one of each
    # family. By belief, a state is the average over its family's sequences, else the node's own.
    # The tree's rule and room to work in apply. Means and covariances are as of ``states_at``.
    nodes, n_nodes, n_families = source
    if tree.rule.way is not None:
        nodes = moved(nodes, n_nodes, time, tree.rule)
    count, (_, size) = node.shape[0], n_modes_and_size(tree.rule.motion)
    mean, covariance = np.empty((count, size)), np.empty((count, size, size))
    if not by_belief or not count:
        moments = np.full(count, time)
        move_states(nodes, node, moments, tree.rule.motion, mean, covariance, tree.general)
        return mean, covariance
    number = np.full(n_families, -1, dtype=np.int64)
    number[nodes.family[node]] = np.arange(count)
    own = number[nodes.family[:n_nodes]]
    weight = np.where(own >= 0, nodes.belief[:n_nodes], 0.0)
    average_states(
        nodes._replace(family=np.maximum(own, 0)), n_nodes, count, weight, time,
        tree.rule.motion, np.empty(count), mean, covariance, tree.general,
    )  # fmt: skip
    return mean, covariance


def shown(
    mean: FloatArray, covariance: FloatArray, rule: WindowRule
) -> tuple[FloatArray, FloatArray]:
    """Return positions and velocities of states, shape (sequences, 2 dim), and covariances."""
    size = 2 * rule.motion.dim
    if rule.way is None:
        return mean[:, :size], covariance[:, :size, :size]
    return rule.way.shown(mean, covariance, rule.motion.dim)
