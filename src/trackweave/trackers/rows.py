"""The rows of the live tracks, those of inactive clusters included."""

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._nodes import Families, Nodes, WindowRule
from trackweave.association.inactive import InactiveClusters
from trackweave.association.living import (
    intervals_since,
    log_weights,
    still_lives,
    usual_interval,
)
from trackweave.association.states import average_at, shown
from trackweave.association.tree import AssociationTree
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.trackers.surplus import FOLLOWED, SURE, surplus

__all__ = ["live_rows", "n_live"]

Room = tuple[Nodes, Families, int]
MISSED = 3.0
"""Who reports itself coasts once its reports of so many intervals are missing."""


def n_live(
    tree: AssociationTree, inactive: InactiveClusters, time: float, *, by_belief: bool
) -> int:
    """Return the number of live tracks."""
    usual = _usual_interval(tree, inactive)
    return sum(map(len, _live_leaves(tree, inactive, time, usual, by_belief=by_belief)))


def live_rows(
    tree: AssociationTree, inactive: InactiveClusters, time: float, *, by_belief: bool
) -> TrackTable:
    """Return a row for each live track, in order of identifier."""
    # By belief, states are averages over all sequences; else those of the chosen ones alone.
    dim, usual, parts = tree.dim, _usual_interval(tree, inactive), []
    chosen = _live_leaves(tree, inactive, time, usual, by_belief=by_belief)
    for (nodes, families, count), leaf in zip(_rooms(tree, inactive), chosen, strict=True):
        if leaf.size or nodes is tree.nodes:
            source = (nodes, count, families.track.shape[0])
            states = average_at(source, leaf, time, tree, by_belief=by_belief)
            since = intervals_since(nodes.rhythm, leaf, time, usual)
            known = _rows(nodes, families, leaf, since, states)
            parts.append(
                (*known, *_chances((nodes, families, leaf), since, tree.rule, by_belief=by_belief))
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


def _live_leaves(
    tree: AssociationTree,
    inactive: InactiveClusters,
    time: float,
    usual: float,
    *,
    by_belief: bool,
) -> tuple[IntArray, IntArray]:
    """Return the last nodes of live tracks' chosen sequences: in the tree, and inactive."""
    # How probable it is that objects live is told by all sequences, or by the chosen ones alone.
    found = []
    for room in _rooms(tree, inactive):
        nodes, families, count = room
        leaf = np.flatnonzero(nodes.chosen[:count] == 1)
        since = intervals_since(nodes.rhythm, leaf, time, usual)
        lives, in_sight = _chances((nodes, families, leaf), since, tree.rule, by_belief=by_belief)
        chance = lives * in_sight
        known = (time - nodes.time[leaf] <= tree.rule.max_shown) & (nodes.is_line[leaf] == 0)
        live = known & (chance >= FOLLOWED)
        if by_belief:
            doubtful = known & (chance < SURE) & families.confirmed[nodes.family[leaf]]
            doubts = np.flatnonzero(doubtful)
            if nodes is inactive.nodes and doubts.size:
                # Of the many that rest, only those in doubt are gone over.
                nodes, count, place = inactive.beside(leaf[doubts])
            else:
                place = leaf[doubts]
            source = (nodes, count, families.track.shape[0])
            live[doubts[_too_many(source, place, chance[doubts], time, tree)]] = False
        found.append(leaf[live])
    return found[0], found[1]


def _usual_interval(tree: AssociationTree, inactive: InactiveClusters) -> float:
    """Return within how long nearly every live track's object reports itself again [s]."""
    return usual_interval([
        (nodes.rhythm, np.flatnonzero(nodes.chosen[:count] == 1))
        for nodes, _, count in _rooms(tree, inactive)
    ])  # fmt: skip


def _rooms(tree: AssociationTree, inactive: InactiveClusters) -> tuple[Room, Room]:
    """Return where sequences are: in the tree, and in inactive clusters."""
    return (
        (tree.nodes, tree.families, tree.n_nodes),
        (inactive.nodes, inactive.families, inactive.n_rows),
    )


def _too_many(
    source: tuple[Nodes, int, int],
    leaf: IntArray,
    chance: FloatArray,
    time: float,
    tree: AssociationTree,
) -> NDArray[np.bool_]:
    """Tell of doubtful tracks of a room of which there are too many where they are."""
    # The beliefs are those of the last search.
    if leaf.size < 2 or np.sum(1.0 - chance[chance >= FOLLOWED]) <= 0.5:
        # All doubts together are of no object.
        return np.zeros(leaf.shape[0], dtype=np.bool_)
    states = average_at(source, leaf, time, tree, by_belief=True)
    place, spread = (part[:, : tree.dim] for part in shown(*states, tree.rule))
    return surplus(place, spread[:, :, : tree.dim], chance)


def _chances(
    source: tuple[Nodes, Families, IntArray],
    since: FloatArray,
    rule: WindowRule,
    *,
    by_belief: bool,
) -> tuple[FloatArray, FloatArray]:
    """Return how probable it is that objects live, and that one that lives is in sight."""
    # Since so many of its own intervals each was not heard.
    nodes, families, leaf = source
    if by_belief:
        lives = families.existence[nodes.family[leaf]]
    else:
        lives = log_weights(nodes.cost[leaf], nodes.tail[leaf], rule.end_cost)[1]
    return still_lives(lives, since), 1.0 - nodes.hidden[leaf]


def _rows(
    nodes: Nodes,
    families: Families,
    leaf: IntArray,
    since: FloatArray,
    states: tuple[FloatArray, FloatArray],
) -> tuple[IntArray, IntArray, FloatArray, FloatArray, FloatArray, IntArray, FloatArray]:
    """Return the columns of a row for each chosen sequence, its identifier first."""
    family = nodes.family[leaf]
    is_missed = (nodes.misses[leaf] >= 0.5) | (since > MISSED)
    seen = np.where(is_missed, COASTING, CONFIRMED)
    return (
        families.name[family],
        np.where(families.confirmed[family], seen, TENTATIVE),
        *states,
        families.score[family] + nodes.cost[leaf],
        nodes.hits[leaf],
        nodes.time[leaf],
    )
