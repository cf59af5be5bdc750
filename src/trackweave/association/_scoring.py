"""How well a report fits a state. Nothing here checks or raises."""

import math

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._levels import level_cost
from trackweave.association._nodes import Expectation, Nodes, ScanInput, State
from trackweave.domain.measurements import MeasurementKind
from trackweave.filters._kernels import correct, update
from trackweave.filters._measuring import innovation, invert, measure
from trackweave.filters._relinearising import relinearise
from trackweave.jit import jit
from trackweave.models._kernels import covered_share
from trackweave.models.coverage import Coverage
from trackweave.models.motion import MotionRule

POSITION = int(MeasurementKind.POSITION)
RANGE_RATE = int(MeasurementKind.RANGE_RATE)
LOG_TWO_PI = math.log(2.0 * math.pi)


@jit
def room_for_state(motion: MotionRule) -> State:
    """Return room for a state."""
    modes, size = motion.kind.shape[0], motion.prior.shape[0]
    return State(np.empty((modes, size)), np.empty((modes, size, size)), np.ones(modes))


@jit
def room_for_expectation(motion: MotionRule, n_components: int) -> Expectation:
    """Return room for what a state expects of a report of so many numbers."""
    modes, size = motion.kind.shape[0], motion.prior.shape[0]
    m = n_components
    return Expectation(
        np.empty((modes, m)), np.empty((modes, m, m)), np.empty(modes),
        np.empty((modes, size, m)), np.empty((modes, m, m)), np.empty(m),
    )  # fmt: skip


@jit
def _foresee(
    kind: int,
    noise: FloatArray,
    platform: FloatArray,
    mode: int,
    state: State,
    dim: int,
    unscented: bool,
    out: Expectation,
) -> None:
    """Write what one mode expects of a report, and how widely that spreads."""
    n_components = out.innovation.shape[0]
    if kind == POSITION:
        for row in range(n_components):
            out.mean[mode, row] = state.mean[mode, row]
            for column in range(n_components):
                out.spread[mode, row, column] = (
                    state.covariance[mode, row, column] + noise[row, column]
                )
        return
    measure(
        kind, state.mean[mode], state.covariance[mode], platform, dim, unscented,
        out.mean[mode], out.spread[mode], out.cross[mode],
    )  # fmt: skip
    for row in range(n_components):
        for column in range(n_components):
            out.spread[mode, row, column] += noise[row, column]


@jit
def expect(
    kind: int,
    noise: FloatArray,
    platform: FloatArray,
    state: State,
    dim: int,
    unscented: bool,
    out: Expectation,
) -> None:
    """Write what each mode expects of a report with the given noise, from the given platform."""
    for mode in range(state.weight.shape[0]):
        _foresee(kind, noise, platform, mode, state, dim, unscented, out)
        out.log_determinant[mode] = invert(out.spread[mode], out.inverse[mode])


@jit
def compare(
    kind: int,
    measurement: FloatArray,
    index: int,
    weight: FloatArray,
    expected: FloatArray,
    inverse: FloatArray,
    log_determinant: FloatArray,
    off: FloatArray,
) -> tuple[float, float]:
    """Return the least squared distance of a report from any mode, and its log likelihood.

    Takes arrays one by one: handing over whole scans costs more than comparing.
    """
    modes, n_components = expected.shape
    constant = n_components * LOG_TWO_PI
    nearest, largest, total = math.inf, -math.inf, 0.0
    for mode in range(modes):
        if kind == POSITION:
            for row in range(n_components):
                off[row] = measurement[index, row] - expected[mode, row]
        else:
            innovation(kind, measurement[index], expected[mode], off)
        distance = 0.0
        for row in range(n_components):
            partial = 0.0
            for column in range(n_components):
                partial += inverse[mode, row, column] * off[column]
            distance += partial * off[row]
        nearest = min(nearest, distance)
        log_likelihood = -0.5 * (distance + log_determinant[mode] + constant)
        if modes == 1:
            return nearest, log_likelihood
        if weight[mode] > 0.0:
            value = log_likelihood + math.log(weight[mode])
            if value > largest:
                total = total * math.exp(largest - value) + 1.0
                largest = value
            else:
                total += math.exp(value - largest)
    return nearest, largest + math.log(total)


@jit
def take_in(
    kind: int,
    measurement: FloatArray,
    noise: FloatArray,
    platform: FloatArray,
    state: State,
    dim: int,
    unscented: bool,
    expected: Expectation,
    mean_out: FloatArray,
    covariance_out: FloatArray,
    weight_out: FloatArray,
) -> float:
    """Write the state after a report; return its log likelihood."""
    modes, n_components = expected.mean.shape
    constant = 0.5 * n_components * LOG_TWO_PI
    largest = -math.inf
    for mode in range(modes):
        _foresee(kind, noise, platform, mode, state, dim, unscented, expected)
        log_determinant = invert(expected.spread[mode], expected.inverse[mode])
        innovation(kind, measurement, expected.mean[mode], expected.innovation)
        if kind == POSITION:
            update(
                state.mean[mode], state.covariance[mode], measurement, noise,
                mean_out[mode], covariance_out[mode],
            )  # fmt: skip
        else:
            correct(
                state.mean[mode], state.covariance[mode], expected.innovation,
                expected.spread[mode], expected.cross[mode], mean_out[mode], covariance_out[mode],
            )  # fmt: skip
            if not unscented:
                relinearise(
                    kind, measurement, noise, platform, dim, state.mean[mode],
                    state.covariance[mode], mean_out[mode], covariance_out[mode],
                )  # fmt: skip
        distance = 0.0
        for row in range(n_components):
            for column in range(n_components):
                distance += (
                    expected.innovation[row] * expected.inverse[mode, row, column]
                    * expected.innovation[column]
                )  # fmt: skip
        weight_out[mode] = -0.5 * (distance + log_determinant)
        if modes == 1:
            weight_out[0] = 1.0
            return float(-0.5 * (distance + log_determinant) - constant)
        if state.weight[mode] > 0.0:
            weight_out[mode] += math.log(state.weight[mode])
        else:
            weight_out[mode] = -math.inf
        largest = max(largest, weight_out[mode])
    total = 0.0
    for mode in range(modes):
        weight_out[mode] = math.exp(weight_out[mode] - largest)
        total += weight_out[mode]
    for mode in range(modes):
        weight_out[mode] /= total
    return float(largest + math.log(total) - constant)


@jit
def take_rate(
    scan: ScanInput, index: int, mean: FloatArray, covariance: FloatArray, dim: int
) -> None:
    """Let a report's range rate, its last number, tell of a new object's velocity, in place."""
    if scan.kind != 2 and scan.kind != 4:
        return
    size = mean.shape[0]
    setting, last = scan.setting[index], scan.measurement.shape[1] - 1
    predicted, off, cross = np.empty(1), np.empty(1), np.empty((size, 1))
    spread = np.empty((1, 1))
    measure(
        RANGE_RATE, mean, covariance, scan.platform[setting], dim, False,
        predicted, spread, cross,
    )  # fmt: skip
    spread[0, 0] += scan.noise[setting, last, last]
    innovation(RANGE_RATE, scan.measurement[index, last:], predicted, off)
    correct(mean, covariance, off, spread, cross, mean, covariance)


@jit
def share_covered(state: State, coverage: Coverage) -> float:
    """Return how probable it is that the object lies in the field of view."""
    if coverage.everywhere:
        return 1.0
    share = 0.0
    for mode in range(state.weight.shape[0]):
        if state.weight[mode] > 0.0:
            share += state.weight[mode] * covered_share(
                state.mean[mode], state.covariance[mode], coverage
            )
    return share


@jit
def identity_cost(
    claimed: int, identity: int, other: int, identity_gain: float, identity_loss: float
) -> float:
    """Return what it costs that a report is of somebody, as a sequence is or is not [nats]."""
    if claimed < 0 or identity < 0:
        return 0.0
    if claimed == identity:
        return -identity_gain
    # What a name costs that changes for good is paid once.
    return 0.0 if claimed == other else identity_loss


@jit
def naming_cost(nodes: Nodes, node: int, scan: ScanInput, index: int) -> float:
    """Return what it costs that a report has its identity and its height [nats]."""
    by_name = identity_cost(
        scan.identity[index], nodes.identity[node], nodes.other[node],
        scan.identity_gain, scan.identity_loss,
    )  # fmt: skip
    heard = scan.level[index], scan.moment[index], scan.sigma_level
    return by_name + level_cost(nodes.level, node, heard, scan.sensor)


@jit
def take_identity(nodes: Nodes, node: int, claimed: int) -> None:
    """Take in of whom a sequence's last report says it is: twice in a row makes it so."""
    if nodes.identity[node] < 0 or claimed == nodes.other[node]:
        nodes.identity[node] = claimed
    nodes.other[node] = -1 if claimed == nodes.identity[node] else claimed


@jit
def is_too_soon(nodes: Nodes, node: int, sensor: int, moment: float, separation: float) -> bool:
    """Tell whether the sensor has reported the object less than a separation before or after."""
    climb = node
    while climb >= 0:
        if nodes.sensor[climb] == sensor:
            return bool(abs(moment - nodes.time[climb]) < separation)
        climb = nodes.parent[climb]
    return False
