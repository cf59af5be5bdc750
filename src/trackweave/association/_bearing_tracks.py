"""Objects seen by their bearing alone, until a second report says where. Nothing here checks.

A bearing puts its object on a line; a report from elsewhere at about the same time fixes the
place, and the cost is then that of both reports together: minus the log of the integral of their
likelihoods over the plane, which for two bearings is r₁ r₂ / |sin Δ|.
"""

import math

from trackweave.arrays import FloatArray
from trackweave.association._nodes import Nodes, ScanInput, WindowRule
from trackweave.domain.measurements import MeasurementKind
from trackweave.jit import jit

BEARING = int(MeasurementKind.BEARING)
SHALLOWEST = 4.0
"""Bearings that cross within so many standard deviations of parallel do not say where.

An object's motion from one bearing to the other is part of them: a sensor that is not much faster
than its objects cannot tell where they are by its own bearings alone."""


@jit
def wrapped(angle: float) -> float:
    """Return an angle from -π to π."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@jit
def begin_line(nodes: Nodes, node: int, scan: ScanInput, index: int, log_density: float) -> None:
    """Write a new object that has been seen by its bearing alone."""
    platform = scan.platform[scan.setting[index]]
    nodes.is_line[node] = 1
    nodes.mean[node, 0, 0] = platform[0]
    nodes.mean[node, 0, 1] = platform[1]
    nodes.mean[node, 0, 2] = scan.measurement[index, 0]
    nodes.mean[node, 0, 3] = math.sqrt(scan.noise[scan.setting[index], 0, 0])
    base = (
        scan.log_clutter - math.log(scan.detection_probability) - log_density
        - scan.evidence[index]
    )  # fmt: skip
    nodes.covariance[node, 0, 0, 0] = base
    # By itself it is a false alarm: an object of which nobody knows where it is helps nobody.
    nodes.cost[node] = max(base - scan.log_begin[index], 1.0)


@jit
def cross_line(
    nodes: Nodes, node: int, scan: ScanInput, index: int, rule: WindowRule,
    mean_out: FloatArray, covariance_out: FloatArray,
) -> float:  # fmt: skip
    """Write where a report puts an object that is on a line; return both reports' log evidence.

    The evidence is relative to that of the densities alone [ln m²]; minus infinity where they do
    not meet. The state is that of one mode.
    """
    interval = abs(scan.moment[index] - nodes.time[node])
    if interval > rule.crossing_time:
        return -math.inf
    if scan.is_located:
        return _locate(nodes, node, scan, index, rule, mean_out, covariance_out)
    if scan.kind != BEARING:
        return -math.inf
    platform = scan.platform[scan.setting[index]]
    line = nodes.mean[node, 0]
    first, second = line[2], scan.measurement[index, 0]
    first_sigma = line[3]
    second_sigma = math.sqrt(scan.noise[scan.setting[index], 0, 0])
    turn = math.sin(first - second)
    if turn == 0.0:
        return -math.inf
    east, north = platform[0] - line[0], platform[1] - line[1]
    near = (east * math.cos(second) - north * math.sin(second)) / turn
    far = (east * math.cos(first) - north * math.sin(first)) / turn
    if not (0.0 < near <= scan.reach and 0.0 < far <= scan.reach):
        return -math.inf
    # How far either line is off across itself; the first is of where the object was.
    drift = rule.motion.prior[2] * interval * interval
    first_off = (near * first_sigma) ** 2 + drift
    second_off = (far * second_sigma) ** 2
    blur = math.sqrt(first_off / near**2 + second_off / far**2)
    if abs(turn) < math.sin(min(0.5 * math.pi, SHALLOWEST * blur)):
        return -math.inf
    # Information across each line, turned over.
    a, b = 1.0 / first_off, 1.0 / second_off
    c1, s1, c2, s2 = math.cos(first), math.sin(first), math.cos(second), math.sin(second)
    xx, yy = a * c1 * c1 + b * c2 * c2, a * s1 * s1 + b * s2 * s2
    xy = -a * c1 * s1 - b * c2 * s2
    determinant = xx * yy - xy * xy
    _write_still(line[0] + near * s1, line[1] + near * c1, rule, mean_out, covariance_out)
    covariance_out[0, 0] = yy / determinant
    covariance_out[1, 1] = xx / determinant
    covariance_out[0, 1] = covariance_out[1, 0] = -xy / determinant
    return math.log(near * far / abs(turn))


@jit
def _locate(
    nodes: Nodes, node: int, scan: ScanInput, index: int, rule: WindowRule,
    mean_out: FloatArray, covariance_out: FloatArray,
) -> float:  # fmt: skip
    """Do the same for a report that says by itself where its object is."""
    line = nodes.mean[node, 0]
    east = scan.position[index, 0] - line[0]
    north = scan.position[index, 1] - line[1]
    square = east * east + north * north
    covariance = scan.position_covariance[index]
    drift = rule.motion.prior[2] * (scan.moment[index] - nodes.time[node]) ** 2
    # The gradient of a bearing is (north, -east) / r².
    across = (
        north * north * covariance[0, 0]
        + east * east * covariance[1, 1]
        - 2.0 * north * east * covariance[0, 1]
    ) / max(square, 1e-12)
    variance = line[3] ** 2 + (across + drift) / max(square, 1e-12)
    off = wrapped(line[2] - math.atan2(east, north))
    if not off * off <= scan.gate * variance:
        return -math.inf
    _write_still(scan.position[index, 0], scan.position[index, 1], rule, mean_out, covariance_out)
    gain_x = (covariance[0, 0] * north - covariance[0, 1] * east) / max(square, 1e-12) / variance
    gain_y = (covariance[0, 1] * north - covariance[1, 1] * east) / max(square, 1e-12) / variance
    mean_out[0] += gain_x * off
    mean_out[1] += gain_y * off
    # Joseph's form, with what of the variance is not the position's own.
    slope_x, slope_y = north / max(square, 1e-12), -east / max(square, 1e-12)
    xx, xy = 1.0 - gain_x * slope_x, -gain_x * slope_y
    yx, yy = -gain_y * slope_x, 1.0 - gain_y * slope_y
    rest = line[3] ** 2 + drift / max(square, 1e-12)
    first_x = xx * covariance[0, 0] + xy * covariance[0, 1]
    first_y = xx * covariance[0, 1] + xy * covariance[1, 1]
    second_x = yx * covariance[0, 0] + yy * covariance[0, 1]
    second_y = yx * covariance[0, 1] + yy * covariance[1, 1]
    covariance_out[0, 0] = first_x * xx + first_y * xy + gain_x * gain_x * rest
    covariance_out[1, 1] = second_x * yx + second_y * yy + gain_y * gain_y * rest
    covariance_out[0, 1] = first_x * yx + first_y * yy + gain_x * gain_y * rest
    covariance_out[1, 0] = covariance_out[0, 1]
    log_density = -0.5 * (off * off / variance + math.log(2.0 * math.pi * variance))
    return float(log_density + scan.log_begin[index])


@jit
def _write_still(
    x: float, y: float, rule: WindowRule, mean_out: FloatArray, covariance_out: FloatArray
) -> None:
    """Write a state at a place of which nothing else is known."""
    mean_out[:] = 0.0
    covariance_out[:, :] = 0.0
    mean_out[0] = x
    mean_out[1] = y
    for component in range(rule.motion.prior.shape[0]):
        covariance_out[component, component] = rule.motion.prior[component]
