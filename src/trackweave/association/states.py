"""States of sequences at a time, whatever the modes of motion."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._beliefs import move_states
from trackweave.association._nodes import n_modes_and_size
from trackweave.association.tree import AssociationTree

__all__ = ["states_at"]


def states_at(
    tree: AssociationTree, node: IntArray, time: float | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return the states of sequences, averaged over modes of motion.

    Parameters
    ----------
    tree
        The sequences.
    node
        Which of them.
    time
        When [s]; None for the time of each one's last report.

    Returns
    -------
    Means and covariances, shapes (sequences, size) and (sequences, size, size); meaningless for
    an object on a line.
    """
    _, size = n_modes_and_size(tree.rule.motion)
    moments = tree.nodes.time[node] if time is None else np.full(node.shape[0], time)
    mean, covariance = np.empty((node.shape[0], size)), np.empty((node.shape[0], size, size))
    move_states(tree.nodes, node, moments, tree.rule.motion, mean, covariance, tree.general)
    return mean, covariance
