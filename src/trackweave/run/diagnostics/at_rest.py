"""Tracks that stay at one place all the time beside others that move: echoes, or objects."""

from collections.abc import Iterator

import numpy as np

from trackweave.arrays import IntArray
from trackweave.run.diagnostics.case import Case, Finding

__all__ = ["tracks_at_rest"]

# So many tracks are there for such a share of the time, and their middles early and late lie this
# near, in standard deviations of a middle.
FEWEST, THROUGHOUT, STILL = 5, 0.8, 4.0
# They are seen at less than this share of the rate at which those that move are.
SELDOMER = 0.9
WEIGHT = 40.0


def tracks_at_rest(case: Case) -> Iterator[Finding]:
    """Yield how many tracks stay where they are, and are seen more seldom than those that move."""
    if case.settings.values["lifecycle"].get("at_rest") == "echoes":
        return
    resting: list[float] = []
    moving: list[float] = []
    for own in case.groups:
        rate = _rate(case, own)
        if rate is not None:
            (resting if _stays(case, own) else moving).append(rate)
    if len(resting) < FEWEST or not moving:
        return
    seen, others = float(np.median(resting)), float(np.median(moving))
    if seen < SELDOMER * others:
        yield Finding(
            "at rest",
            None,
            f"{len(resting)} tracks stay at one place from the first scan to the last, and are "
            f"seen in {seen:.0%} of the scans, those that move in {others:.0%}; where these are "
            'fixed echoes, at_rest = "echoes" in [lifecycle] takes them for false alarms',
            weight=WEIGHT,
            told=others,
            seen=seen,
        )


def _rate(case: Case, own: IntArray) -> float | None:
    """Return in which share of the scans of its time a track is seen, None if nobody looks."""
    time, sensor = case.reports.time[own], case.reports.sensor[own]
    looks = 0
    for index in np.unique(sensor):
        name = case.reports.sensors[index]
        if case.sensors[index].scans is False or name not in case.looks:
            return None
        # A beam that turns looks in sectors: of a turn an object is in one.
        moments = case.looks[name]
        turn = case.sensors[index].rotation
        inside = int(np.count_nonzero((moments >= time[0]) & (moments <= time[-1])))
        looks += inside if turn is None else int((time[-1] - time[0]) / turn.period) + 1
    return own.size / max(looks, 1)


def _stays(case: Case, own: IntArray) -> bool:
    """Tell whether a track is where it was, nearly all the time."""
    time, place = case.reports.time[own], case.position[own]
    if time[-1] - time[0] < THROUGHOUT * np.ptp(case.reports.time) or np.isnan(place).any():
        return False
    half = own.size // 2
    scatter = float(np.sqrt(place.var(axis=0).sum()))
    sigma = max(case.plane_sigma(index) for index in np.unique(case.reports.sensor[own]).tolist())
    off = float(np.linalg.norm(place[:half].mean(axis=0) - place[half:].mean(axis=0)))
    return scatter < 2.0 * sigma and off < STILL * sigma * np.sqrt(2.0 / half)
