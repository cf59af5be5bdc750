"""How far reports lie from where tracks expect them. Nothing here checks or raises."""

import math

from trackweave.arrays import FloatArray, IntArray
from trackweave.association._nodes import Nodes, ScanInput, State
from trackweave.association._scoring import (
    compare,
    expect,
    room_for_expectation,
    room_for_state,
)
from trackweave.association._tails import compare_either
from trackweave.filters._kernels import distance_of, invert_sum, predict
from trackweave.filters._states import advance
from trackweave.jit import jit
from trackweave.models.motion import MotionRule


@jit
def squared_distances(
    nodes: Nodes,
    child: IntArray,
    scan: ScanInput,
    motion: MotionRule,
    distance_out: FloatArray,
    general: State | None,
) -> None:
    """Write νᵀS⁻¹ν between each child's report and its parent, from the nearest mode.

    With tails it is less by what the wide part adds to twice the log density, and no more than
    the gate, which lets through what is near in either part. ``general`` is as for
    ``_growth.propose``.
    """
    state = room_for_state(motion)
    expected = room_for_expectation(motion, scan.measurement.shape[1])
    mean, covariance, inverse = state.mean[0], state.covariance[0], expected.inverse[0]
    for row in range(child.shape[0]):
        node, index = nodes.parent[child[row]], nodes.report[child[row]]
        setting = scan.setting[index]
        interval = scan.moment[index] - nodes.time[node]
        if general is None:
            predict(
                nodes.mean[node, 0], nodes.covariance[node, 0], interval, motion.noise[0, 0],
                mean, covariance,
            )  # fmt: skip
            invert_sum(covariance, scan.noise, setting, inverse)
            distance_out[row] = distance_of(scan.measurement, index, mean, inverse)
        else:
            advance(
                nodes.mean[node], nodes.covariance[node], nodes.weight[node], interval, motion,
                state.mean, state.covariance, state.weight,
            )  # fmt: skip
            expect(
                scan.kind, scan.noise[setting], scan.platform[setting], state,
                motion.dim, motion.unscented, expected,
            )  # fmt: skip
            distance_out[row], narrow = compare(
                scan.kind, scan.measurement, index, state.weight, expected.mean,
                expected.inverse, expected.log_determinant, expected.innovation,
            )  # fmt: skip
            if scan.tail_share > 0.0 and distance_out[row] > 0.0:
                _, either = compare_either(
                    scan.kind, scan.measurement, index, state.weight, expected,
                    scan.noise[setting], scan.tail_share, scan.tail_scale,
                )  # fmt: skip
                likelier = either - narrow - math.log1p(-scan.tail_share)
                distance_out[row] = min(max(distance_out[row] - 2.0 * likelier, 0.0), scan.gate)
