"""From what lone reports tell to the values that a tracker takes."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.estimation.estimates import Estimates, digits
from trackweave.estimation.lone import LoneReports
from trackweave.estimation.looking import Looking
from trackweave.estimation.trees import ball_volume
from trackweave.summaries import counted

__all__ = ["AS_TOLD", "NOT_SCANNING", "LoneValues", "note_on_lone", "rhythm_of", "seldomer"]

# No lone report is worth more to a track [nats]: else one that chance puts into the gate of
# another's track outweighs all doubt.
WORTH = 16.0
# What the first of an object's reports costs more than one of nobody, at most [nats].
DEAR = 4.0
# Slow pauses between an object's own reports that a window holds, and instants in any case.
PAUSES, DEPTHS = 2.0, (5, 80)
# Of what reports more seldom than this [s], silences last so many slow pauses on average, and
# objects live for so many at least.
RARE, SILENT, LIVES = 200.0, 2.0, 5.0
# Nothing reports itself more often than after so long [s].
HASTY = 0.01
NOT_SCANNING, AS_TOLD = "taken for one that does not scan", ", as is told"
"""What a note on lone reports says."""
# Process noise in units of σ²/T³, never less.
LEAST_PROCESS = 3e-4
# What stands is told from what moves where, beside it, the silence of a slow one spreads so many
# standard deviations of a report, and each is this share of all; it drifts by this part of one in
# such a silence, and goes on as it does for so long [s].
WANDERED, SOME, DRIFTED, STAY = 3.0, 0.05, 0.25, 1800.0


@dataclass(frozen=True, slots=True)
class LoneValues:
    """What a tracker takes of a sensor that does not look; its second counts as a scan."""

    detection: float  # Chance that an object reports within a second
    clutter: float  # Reports of nobody per m² (m³) and second
    coming: float  # Objects that come per m² (m³) and second
    process: float | None  # Process noise [m²/s³]; None for unknown
    # How objects move beside wandering at that noise, with keys as in ``[motion.imm]``; None for
    # no other way.
    ways: Mapping[str, Any] | None

    @classmethod
    def of(cls, lone: LoneReports, sigma: float, covered: float, dim: int) -> Self:
        """Return the values of a sensor with noise sigma [m], given what is covered [m², m³]."""
        # Of false alarms there are enough that no single report settles anything; and one that no
        # track explains is about as likely a new object's as nobody's, because it may be minutes
        # until its next.
        detection = float(np.clip(-np.expm1(-lone.rate), 1e-6, 0.98))
        process = lone.process_noise
        if process is not None:
            process = max(process, LEAST_PROCESS * sigma**2 / lone.pause**3)
        # A report lies as far off as noise and what the object did since its last one say.
        spread = float(np.hypot(sigma, np.sqrt((process or 0.0) * lone.pause**3 / 3.0)))
        least = detection / float(ball_volume(2.0 * spread, dim)) * np.exp(-WORTH)
        return cls(
            detection=detection,
            clutter=max(lone.false_rate / covered, least),
            coming=max(lone.new_rate / covered, least * np.exp(-DEAR)),
            process=process,
            ways=_ways(lone, sigma, process),
        )


def _ways(lone: LoneReports, sigma: float, process: float | None) -> Mapping[str, Any] | None:
    """Return two ways to move where those that stand would be lost between two reports."""
    # With the noise of those that move, one that is silent for minutes could be anywhere in the
    # harbour, and its neighbours at the quay in its place. Keys are as in ``[motion.imm]``; None
    # where one way does.
    wandered = np.sqrt((process or 0.0) * lone.slow_pause**3 / 3)
    if wandered < WANDERED * sigma or not SOME <= lone.standing <= 1.0 - SOME:
        return None
    drift = float(f"{(DRIFTED * sigma) ** 2 / lone.slow_pause:.4g}")
    return {
        "models": ["standing", "moving"],
        "sojourn_time": [STAY, STAY],
        "standing": {"model": "random-walk", "process_noise": drift},
        "moving": {"model": "constant-velocity"},
    }


def rhythm_of(
    lone: list[tuple[LoneReports, Mapping[str, Any] | None]], time: FloatArray
) -> dict[str, Any]:
    """Return what follows from how often objects report where no sensor looks."""
    # Estimates by name: instants in a window, time between rows, ways to move, and for how long
    # reports are gathered.
    instants = np.unique(time)
    usual = float(np.ptp(instants)) / max(instants.size - 1, 1)
    slow = max(each.slow_pause for each, _ in lone)
    depth = int(np.clip(np.ceil(PAUSES * slow / max(usual, 1e-9)), *DEPTHS))
    rare = {}
    if slow > RARE:
        # Else nobody would be waited for until its next report.
        rare = {
            "mean_silence": float(f"{SILENT * slow:.4g}"),
            "survival": 1.0 - 1.0 / (LIVES * slow),
        }
    return {
        **rare,
        "max_scans": depth,
        "depth": depth,
        "period": float(f"{max(each.pause for each, _ in lone):.4g}"),
        "together": min(each.quick_pause for each, _ in lone),
        "ways": next((ways for _, ways in lone if ways), None),
    }


def seldomer(estimates: Estimates, factor: float) -> Estimates:
    """Return estimates of so many times as many objects that report as much more seldom."""
    sensors = {}
    for name, each in estimates.sensors.items():
        detection = -np.expm1(np.log1p(-each.detection_probability) / factor)
        sensors[name] = replace(
            each, detection_probability=digits(detection), n_objects=each.n_objects * factor
        )
    told: dict[str, Any] = {
        name: digits(factor * value)
        for name in ("initial_target_density", "period", "together")
        if (value := getattr(estimates, name)) is not None
    }
    depth = int(np.clip(round(factor * (estimates.depth or DEPTHS[0])), *DEPTHS))
    return replace(estimates, sensors=sensors, depth=depth, max_scans=depth, **told)


def note_on_lone(lone: LoneReports, seen: Looking, *, is_told: bool) -> str:
    """Return why a sensor is taken for one that does not look, and how surely."""
    doubt, otherwise = "", "" if is_told else "; if it looks, give scans = true"
    if is_told:
        doubt = AS_TOLD
    elif seen.doubt > 0:
        doubt = f" ({100 * seen.doubt:.0f} % of what tells says otherwise)"
    if lone.pause < HASTY:
        otherwise += "; unless its times are in seconds, bring them to those"
    return (
        f"{NOT_SCANNING}{doubt}: objects report by themselves, every {lone.pause:.3g} s as a "
        f"median of {counted(seen.n_objects, 'thread')} of reports, so that no silence counts as "
        f"a miss{otherwise}"
    )
