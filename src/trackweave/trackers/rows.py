"""The rows of the live tracks, those of inactive clusters included."""

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._nodes import Families, Nodes, WindowRule
from trackweave.association.inactive import InactiveClusters
from trackweave.association.states import average_at, shown
from trackweave.association.tree import AssociationTree
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable

__all__ = ["live_leaves", "live_rows"]

FOLLOWED = 0.5
"""A track is shown while its object more probably than not lives and is in sight."""


def live_leaves(
    tree: AssociationTree, inactive: InactiveClusters, time: float, *, by_belief: bool
) -> tuple[IntArray, IntArray]:
    """Return the last nodes of live tracks' chosen sequences: in the tree, and inactive."""
    # How probable it is that objects live is told by all sequences, or by the chosen ones alone.
    rooms = (tree.nodes, tree.families, tree.n_nodes), (
        inactive.nodes, inactive.families, inactive.n_rows
    )  # fmt: skip
    found = []
    for nodes, families, count in rooms:
        leaf = np.flatnonzero(nodes.chosen[:count])
        found.append(leaf[_is_live(nodes, families, (leaf, time), tree.rule, by_belief=by_belief)])
    return found[0], found[1]


def live_rows(
    tree: AssociationTree, inactive: InactiveClusters, time: float, *, by_belief: bool
) -> TrackTable:
    """Return a row for each live track, in order of identifier."""
    # By belief, states are averages over all sequences; else those of the chosen ones alone.
    dim, chosen = tree.dim, live_leaves(tree, inactive, time, by_belief=by_belief)
    rooms = (tree.nodes, tree.families, tree.n_nodes), (
        inactive.nodes, inactive.families, inactive.n_rows
    )  # fmt: skip
    parts = []
    for (nodes, families, count), leaf in zip(rooms, chosen, strict=True):
        if leaf.size or nodes is tree.nodes:
            source = (nodes, count, families.track.shape[0])
            states = average_at(source, leaf, time, tree, by_belief=by_belief)
            known = _rows(nodes, families, leaf, states)
            parts.append(
                (*known, *_chances(nodes, families, leaf, tree.rule, by_belief=by_belief))
            )
    rows = [np.concatenate(column) for column in zip(*parts, strict=True)]
    order = np.argsort(rows[0], kind="stable")
    track, status, mean, covariance, score, hits, last_update, *chances = (
        row[order] for row in rows
    )
    ahead = tree.rule.motion.acceleration_at
    place, spread = shown(mean, covariance, tree.rule)
    return TrackTable(
        time=np.full(track.shape[0], time),
        track=track,
        status=status,
        mean=place,
        covariance=spread,
        score=score,
        hits=hits,
        last_update=last_update,
        acceleration=mean[:, ahead : ahead + dim] if ahead >= 0 else mean[:, :0],
        existence=chances[0],
        visible=chances[1],
    )


def _is_live(
    nodes: Nodes,
    families: Families,
    shown: tuple[IntArray, float],
    rule: WindowRule,
    *,
    by_belief: bool,
) -> np.ndarray:
    """Tell of which chosen sequences the tracks are shown at a time."""
    leaf, time = shown
    lives, in_sight = _chances(nodes, families, leaf, rule, by_belief=by_belief)
    live = (in_sight * lives >= FOLLOWED) & (time - nodes.time[leaf] <= rule.max_shown)
    told: np.ndarray = live & (nodes.is_line[leaf] == 0)
    return told


def _chances(
    nodes: Nodes, families: Families, leaf: IntArray, rule: WindowRule, *, by_belief: bool
) -> tuple[FloatArray, FloatArray]:
    """Return how probable it is that objects live, and that one that lives is in sight."""
    if by_belief:
        lives = families.existence[nodes.family[leaf]]
    else:
        lives = 1.0 / (1.0 + np.exp(nodes.tail[leaf] - rule.end_cost))
    return lives, 1.0 - nodes.hidden[leaf]


def _rows(
    nodes: Nodes,
    families: Families,
    leaf: IntArray,
    states: tuple[FloatArray, FloatArray],
) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray, IntArray, FloatArray]:
    """Return the columns of a row for each chosen sequence, its identifier first."""
    family = nodes.family[leaf]
    seen = np.where(nodes.misses[leaf] >= 0.5, COASTING, CONFIRMED)
    return (
        families.name[family],
        np.where(families.confirmed[family], seen, TENTATIVE),
        *states,
        families.score[family] + nodes.cost[leaf],
        nodes.hits[leaf],
        nodes.time[leaf],
    )
