"""The document's own problem: every track in exactly one tuple with one of each sensor."""

from itertools import pairwise

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.association.chain_rule import complete_chains
from trackweave.errors import InvalidInputError
from trackweave.fusion._statistic import evaluate_all
from trackweave.fusion.grouping import Groups, Scene, labelled, nothing_to_choose
from trackweave.fusion.statistic import Statistic
from trackweave.solvers.auto import Auto
from trackweave.solvers.protocol import Solver

__all__ = ["group_completely", "require_equal_lists"]


def require_equal_lists(counts: dict[str, int]) -> None:
    """Refuse sensors that do not see equally many objects."""
    if len(set(counts.values())) > 1:
        said = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise InvalidInputError(
            f"pictures: tracks {said}; expected equally many of each where tuples are complete "
            "(the preset huo takes any; so does complete = false)"
        )


def group_completely(
    scene: Scene, statistic: Statistic, search: Solver | None, rng: np.random.Generator
) -> Groups:
    """Return the tuples of least total statistic J, each track in one of them."""
    # Huo and others, 2008, eqs. (10) to (12). A tuple beyond its threshold is of several objects,
    # so its tracks are alone. The certificate is that of J = Σ b.
    live = scene.live
    places = [np.flatnonzero(live.sensor == number) for number in np.unique(live.sensor)]
    n_tracks = live.row.shape[0]
    if len(places) < 2:
        return nothing_to_choose(n_tracks)
    size = live.mean.shape[1] * len(scene.slots) * len(places)
    form = statistic.form(scene.slots, size)
    distances: list[FloatArray] = []
    for first, second in pairwise(places):
        rows = np.stack(np.meshgrid(live.row[first], live.row[second], indexing="ij"), axis=-1)
        value, limit = np.empty((2, first.shape[0] * second.shape[0]))
        evaluate_all(scene.rings, form, rows.reshape(-1, 2), value, limit)
        distances.append(value.reshape(rows.shape[:2]))
    chains = complete_chains(distances)
    problem = chains.problem()
    answer = (search or Auto())(problem, rng=rng)
    assert problem.row is not None
    chosen: IntArray = chains.tuples[problem.row[answer.nodes]]
    member = np.stack([mine[chosen[:, column] - 1] for column, mine in enumerate(places)], axis=1)
    value, limit = np.empty((2, member.shape[0]))
    evaluate_all(scene.rings, form, live.row[member], value, limit)
    same = value <= limit
    label, values, limits = labelled(member[same], value[same], limit[same], n_tracks)
    return Groups(label, values, limits, answer.certificate, len(chains.costs), 0)
