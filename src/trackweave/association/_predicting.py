"""The state of a sequence at another time. Nothing here checks or raises."""

from trackweave.arrays import FloatArray
from trackweave.association._nodes import Nodes, State
from trackweave.filters._kernels import predict
from trackweave.filters._states import advance, combine
from trackweave.jit import jit
from trackweave.models.motion import MotionRule


@jit
def move_state(
    nodes: Nodes,
    node: int,
    time: float,
    motion: MotionRule,
    general: State | None,
    mean_out: FloatArray,
    covariance_out: FloatArray,
) -> None:
    """Write a node's state as of a time, averaged over modes; it tells a place."""
    interval = time - nodes.time[node]
    if general is None:
        predict(
            nodes.mean[node, 0], nodes.covariance[node, 0], interval, motion.noise[0, 0],
            mean_out, covariance_out,
        )  # fmt: skip
    else:
        advance(
            nodes.mean[node], nodes.covariance[node], nodes.weight[node], interval, motion,
            general.mean, general.covariance, general.weight,
        )  # fmt: skip
        combine(general.mean, general.covariance, general.weight, mean_out, covariance_out)
