"""What it costs to extend a sequence by a report, in nats against "all false alarms".

The standard track score [1]_. A first report costs −ln(P_D β / λ), where β is the density of
objects not yet seen and λ that of false alarms; a report that joins costs
½νᵀS⁻¹ν + ½ln|2πS| + ln λ − ln P_D; a scan that covered the predicted place without a report
costs −ln(1 − P_D), with P_D averaged over the predicted position; to live on costs −ln p per scan
period, and to end −ln(1 − p), once.

.. [1] S. S. Blackman, *Multiple-Target Tracking with Radar Applications*, 1986, ch. 9.
"""

import math

import numpy as np

from trackweave.arrays import IntArray
from trackweave.association._growth import ScanInput, WindowRule
from trackweave.domain.scans import Scan
from trackweave.models.coverage import everywhere
from trackweave.models.motion import ConstantVelocity
from trackweave.models.sensors import Sensor

__all__ = ["scan_input", "window_rule"]

GATE_PROBABILITY = 0.9997
"""How many of an object's own reports the gate lets through."""


def window_rule(
    motion: ConstantVelocity, lifecycle: tuple[float, float, float], dim: int
) -> WindowRule:
    """Return the rule as kernels read it.

    Parameters
    ----------
    motion
        How objects move.
    lifecycle
        Probability of survival per scan period; number of misses in a row, and seconds without a
        report, after which an object is not looked for any more.
    dim
        Number of spatial dimensions.

    Returns
    -------
    The rule.
    """
    from scipy.stats import chi2

    survival, max_misses, max_unseen = lifecycle
    return WindowRule(
        process_noise=float(motion.process_noise),
        velocity_variance=motion.velocity_variance(dim),
        max_speed=float(motion.max_speed),
        gate=float(chi2.ppf(GATE_PROBABILITY, dim)),
        end_cost=-math.log(1.0 - survival),
        max_misses=float(max_misses),
        max_unseen=float(max_unseen),
    )


def scan_input(scan: Scan, sensor: Sensor, survival_cost: float) -> tuple[ScanInput, IntArray]:
    """Return a scan as kernels read it, and the order in which its reports stand there.

    Parameters
    ----------
    scan
        The scan.
    sensor
        Its sensor.
    survival_cost
        What living on since the last scan costs [nats].

    Returns
    -------
    The scan with its reports sorted along the first axis, slots from 0; the order.
    """
    order = np.argsort(scan.measurement[:, 0], kind="stable")
    dim = scan.measurement.shape[1]
    sigma = np.where(np.isnan(scan.sigma), sensor.sigmas(dim), scan.sigma)
    view = sensor.field_of_view
    return ScanInput(
        time=float(scan.time),
        new_instant=True,
        # A lone report of a sensor that does not scan says nothing of other objects.
        is_silence_telling=sensor.scan_period is not None or len(scan) != 1,
        position=np.ascontiguousarray(scan.measurement[order]),
        sigma=np.ascontiguousarray(sigma[order]),
        slot=np.arange(order.shape[0]),
        detection_probability=float(sensor.detection_probability),
        log_clutter=math.log(sensor.clutter_density),
        survival_cost=float(survival_cost),
        coverage=everywhere() if view is None else view.coverage(),
    ), order
