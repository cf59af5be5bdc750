"""What a scan's report costs a sequence, and what its silence. Nothing here checks or raises.

What is done for all nodes is done in one call, and what is done for one takes no whole tables: a
call hands over each array of a table, and between kernels that costs more than the arithmetic.
"""

import math

from trackweave.arrays import FloatArray
from trackweave.association._nodes import Misses, Nodes, ScanInput, WindowRule
from trackweave.jit import jit


@jit
def begin_misses(nodes: Nodes, n_nodes: int, scan: ScanInput, missed: Misses) -> None:
    """Write what nodes are as the scan begins: time has passed, and nobody has looked."""
    for node in range(n_nodes):
        hidden = nodes.hidden[node]
        hidden += (1.0 - hidden) * scan.hiding - hidden * scan.showing
        missed.tail[node], missed.hidden[node] = nodes.tail[node], hidden
        missed.unseen[node] = 0.0 if scan.column < 0 else nodes.unseen[node, scan.column]
        missed.seen[node] = scan.detection_probability
        missed.misses[node] = nodes.misses[node]
        missed.counted[node] = 0.0 if scan.new_instant else nodes.counted[node]


@jit
def look_at(
    hidden: float, unseen: FloatArray, node: int, seen: float, whole: float, fading: float,
    clearing: float,
) -> float:  # fmt: skip
    """Return how probably the scan reports a node, in sight with a probability to be seen.

    ``whole`` is that probability where the scan looks, and ``seen`` the node's own.
    """
    if fading + clearing > 0.0:
        gone = unseen[node]
        unseen[node] = gone + seen / whole * ((1.0 - gone) * fading - gone * clearing)
    chance: float = seen * (1.0 - hidden) * (1.0 - unseen[node])
    return chance


@jit
def report_cost(
    spent: float, log_likelihood: float, log_clutter: float, chance: float, evidence: float
) -> float:
    """Return what a sequence that cost ``spent`` costs with a report of such a chance [nats]."""
    cost: float = spent - log_likelihood + log_clutter - math.log(chance) - evidence
    return cost


@jit
def end_misses(
    nodes: Nodes, n_nodes: int, scan: ScanInput, rule: WindowRule, missed: Misses
) -> None:
    """Write what nodes become if the scan has no report of them."""
    for node in range(n_nodes):
        if nodes.tail[node] == math.inf:
            continue
        missed.tail[node] += scan.survival_cost
        if scan.is_silence_telling:
            seen = missed.seen[node]
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
