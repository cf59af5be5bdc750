"""What a scan's report costs a sequence, and what its silence. Nothing here checks or raises."""

import math

from trackweave.association._nodes import Misses, Nodes, ScanInput, WindowRule
from trackweave.association._rhythm import rhythm_cost
from trackweave.association._scoring import identity_cost
from trackweave.jit import jit


@jit
def begin_miss(nodes: Nodes, node: int, scan: ScanInput, missed: Misses) -> None:
    """Write what a node is as the scan begins: time has passed, and nobody has looked."""
    hidden = nodes.hidden[node]
    hidden += (1.0 - hidden) * scan.hiding - hidden * scan.showing
    missed.tail[node], missed.hidden[node] = nodes.tail[node], hidden
    missed.unseen[node] = 0.0 if scan.column < 0 else nodes.unseen[node, scan.column]
    missed.misses[node] = nodes.misses[node]
    missed.counted[node] = 0.0 if scan.new_instant else nodes.counted[node]


@jit
def look_at(node: int, scan: ScanInput, missed: Misses, seen: float) -> float:
    """Return how probably the scan reports a node, in sight with a probability to be seen."""
    if scan.column >= 0:
        unseen, looked = missed.unseen[node], seen / scan.detection_probability
        unseen += looked * ((1.0 - unseen) * scan.fading - unseen * scan.clearing)
        missed.unseen[node] = unseen
    chance: float = seen * (1.0 - missed.hidden[node]) * (1.0 - missed.unseen[node])
    return chance


@jit
def report_cost(
    nodes: Nodes, node: int, scan: ScanInput, index: int, log_likelihood: float, chance: float
) -> float:
    """Return what the sequence costs with a report that came with such a chance [nats]."""
    cost: float = (
        nodes.cost[node]
        + nodes.tail[node]
        + scan.survival_cost
        - log_likelihood
        + scan.log_clutter
        - math.log(chance)
        - scan.evidence[index]
        + identity_cost(
            scan.identity[index], nodes.identity[node], nodes.former[node],
            scan.identity_gain, scan.identity_loss,
        )
    )  # fmt: skip
    if scan.is_heard:
        cost += rhythm_cost(nodes.rhythm, node, scan.sensor, scan.moment[index])
    return cost


@jit
def end_miss(
    nodes: Nodes, node: int, scan: ScanInput, rule: WindowRule, missed: Misses, seen: float
) -> None:
    """Write what a node becomes if the scan has no report of it."""
    missed.tail[node] += scan.survival_cost
    if scan.is_silence_telling:
        silence = 1.0 - seen * (1.0 - missed.hidden[node]) * (1.0 - missed.unseen[node])
        missed.tail[node] -= math.log(silence)
        missed.hidden[node] /= silence
        missed.unseen[node] /= silence
        chance = max(0.0, seen / scan.detection_probability - missed.counted[node])
        missed.counted[node] += chance
        missed.misses[node] += chance * scan.pace
    if (
        missed.tail[node] > rule.most_tail
        or missed.misses[node] >= rule.max_misses
        or scan.time - nodes.time[node] > rule.max_unseen
    ):
        missed.tail[node] = math.inf
