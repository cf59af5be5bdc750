"""Units and senses of directions that the numbers and the other sensors give away."""

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.run.diagnostics.case import Case, Finding

__all__ = ["NARROW", "azimuths_in_radians", "degrees_as_metres", "sense_of", "senses_of"]

# So many directions that fill all that radians can be, and nothing else, are radians.
FEWEST, FILLED = 60, 0.97
WEIGHT = 130.0


def azimuths_in_radians(case: Case) -> Iterator[Finding]:
    """Yield sensors whose directions lie between 0 and 2π degrees, or -π and π, all over."""
    for index, name in enumerate(case.reports.sensors):
        kind, rows = case.reports.kind_of(index), case.rows[index]
        if kind.azimuth is None or rows.size < FEWEST:
            continue
        angle = case.reports.measurement[rows, kind.azimuth]
        about = (angle + np.pi) % (2 * np.pi) - np.pi
        low, high = np.degrees(about.min()), np.degrees(about.max())
        fits = any(
            begin - 1e-3 <= low <= begin + (1 - FILLED) * 2 * np.pi
            and end - (1 - FILLED) * 2 * np.pi <= high <= end + 1e-3
            for begin, end in ((0.0, 2 * np.pi), (-np.pi, np.pi))
        )
        if fits and np.abs(about).max() < NARROW:
            yield Finding(
                "radians",
                name,
                f"sensor {name}: all {rows.size} of its directions lie from {low:.4g} to "
                f"{high:.4g} degrees, as radians of a full turn do; give them in degrees",
                weight=WEIGHT,
                seen=float(high),
            )


# Degrees taken for metres lie within these, not all about 0, and nothing on Earth moves so many of
# them a second or is placed so coarsely.
LONGITUDE, LATITUDE, NOT_ABOUT_ZERO = 180.0, 90.0, 1.0
FASTEST_DEG, COARSEST_DEG = 5e-3, 1e-3


def degrees_as_metres(case: Case) -> Iterator[Finding]:
    """Yield positions that move and scatter as degrees of longitude and latitude do."""
    reports, known = case.reports, ~np.isnan(case.position[:, 0])
    if reports.frame is not None or not all(
        reports.kind_of(index).is_position for index in range(len(reports.sensors))
    ):
        return
    east, north = np.abs(case.position[known]).T
    speeds = [float(path.speed.max()) for path in case.paths]
    sigma = [case.plane_sigma(index) for index in case.examined]
    fits = (
        np.all(east <= LONGITUDE)
        and np.all(north <= LATITUDE)
        and max(east.max(initial=0.0), north.max(initial=0.0)) > NOT_ABOUT_ZERO
    )
    if fits and speeds and 0.0 < max(speeds) < FASTEST_DEG and max(sigma) < COARSEST_DEG:
        yield Finding(
            "degrees",
            None,
            f"x, y: nothing moves faster than {max(speeds):.2g} m/s or is placed worse than to "
            f"{max(sigma):.2g} m, and all lies within 180 and 90; are they degrees of longitude "
            "and latitude? They are taken for metres; call them lon and lat if they are",
            weight=WEIGHT,
            seen=max(speeds),
        )


# So many directions are compared, with so many positions nearest in time.
MOST_COMPARED, MOST_BESIDE, FEWEST_COMPARED = 300, 40, 20
LONGEST_APART_S = 5.0
CLOSE_SIGMAS, LEAST_SIGMA, LARGEST_SIGMA = 3.0, np.radians(0.5), np.radians(3.0)
# A sense is wrong where another explains so many directions, and so many times more.
FITTING_SHARE, FITTING_TIMES = 0.3, 2.5
# Radians taken for degrees all point about north.
NARROW = np.radians(2 * np.pi + 0.01)
OTHER_SENSES: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "counter-clockwise from north": lambda angle: -angle,
    "counter-clockwise from east": lambda angle: np.pi / 2 - angle,
    "clockwise from south": lambda angle: angle + np.pi,
    "radians": lambda angle: np.degrees(_about_north(angle)),
}


def _about_north(angle: FloatArray) -> FloatArray:
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def senses_of(angle: FloatArray) -> dict[str, FloatArray]:
    """Return directions [rad] clockwise from north, by the sense in which they may be meant."""
    is_narrow = float(np.abs(_about_north(angle)).max(initial=0.0)) < NARROW
    return {
        name: turned(angle)
        for name, turned in OTHER_SENSES.items()
        if name != "radians" or is_narrow
    }


def sense_of(case: Case, index: int) -> tuple[str, float, float] | None:
    """Return the sense in which a sensor's directions fit the others' positions."""
    # With it come the share of directions that fit so, and as they are. It is None where they fit
    # as they are or nothing tells.
    beside = np.flatnonzero((case.reports.sensor != index) & ~np.isnan(case.position[:, 0]))
    rows = case.rows[index]
    rows = rows[:: max(1, rows.size // MOST_COMPARED)]
    if beside.size == 0 or rows.size < FEWEST_COMPARED:
        return None
    at = 1 if case.reports.kind_of(index).has_range else 0
    sigma = float(case.sensors[index].sigmas(case.reports.dim)[at])
    sigma = float(np.clip(sigma, LEAST_SIGMA, LARGEST_SIGMA))
    angle = case.reports.measurement[rows, at]
    senses = senses_of(angle)
    right, shares = _shares(
        (np.stack([angle, *senses.values()]), case.reports.time[rows], case.platform[rows]),
        (case.position[beside], case.reports.time[beside]),
        CLOSE_SIGMAS * sigma,
    )
    best = int(np.argmax(shares))
    if shares[best] <= max(FITTING_SHARE, FITTING_TIMES * right):
        return None
    return list(senses)[best], float(shares[best]), right


def _shares(
    seen: tuple[FloatArray, FloatArray, FloatArray],
    known: tuple[FloatArray, FloatArray],
    close: float,
) -> tuple[float, FloatArray]:
    """Return the share of directions that point to a position, as they are and in each sense."""
    angles, times, platforms = seen
    first = np.clip(
        np.searchsorted(known[1], times) - MOST_BESIDE // 2,
        0, max(known[1].size - MOST_BESIDE, 0),
    )  # fmt: skip
    near = np.minimum(first[:, None] + np.arange(MOST_BESIDE), known[1].size - 1)
    when = np.abs(known[1][near] - times[:, None]) <= LONGEST_APART_S
    offset = known[0][near] - platforms[:, None, :]
    towards = np.arctan2(offset[..., 0], offset[..., 1])
    apart = np.abs(_about_north(towards - angles[..., None]))
    hit = np.any((apart <= close) & when, axis=2)
    count = int(np.count_nonzero(when.any(axis=1)))
    share = hit.sum(axis=1) / max(count, 1) if count >= FEWEST_COMPARED else np.zeros(len(hit))
    return float(share[0]), np.asarray(share[1:])
