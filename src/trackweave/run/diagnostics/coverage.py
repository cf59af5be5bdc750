"""Where sensors see, against where they are said to."""

from collections.abc import Iterator

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.run.diagnostics.case import Case, Finding
from trackweave.run.diagnostics.chances import covered

__all__ = ["out_of_view", "unseen_range"]

FEWEST_OUTSIDE, OUTSIDE_SHARE, MOST_LOOKED_AT = 10, 0.1, 600
# A range from beyond which nothing comes is told by so many reports, and so many of others there.
FEWEST, BEYOND, BEYOND_SHARE = 50, 1.1, 0.15
WEIGHT = 80.0


def out_of_view(case: Case) -> Iterator[Finding]:
    """Yield sensors whose reports come from outside their own field of view."""
    for index in case.examined:
        sensor, rows = case.sensors[index], case.rows[index]
        rows = rows[~np.isnan(case.position[rows, 0])]
        view = sensor.field_of_view
        if view is None or rows.size == 0:
            continue
        some = rows[:: -(-rows.size // MOST_LOOKED_AT)]
        outside = ~covered(case.position[some], case.platform[some], view.coverage())
        count = int(outside.sum())
        if count < max(FEWEST_OUTSIDE, OUTSIDE_SHARE * some.size):
            continue
        away = np.linalg.norm((case.position - case.platform)[some], axis=1)
        reach = "" if not np.isfinite(view.max_range) else f" of {view.max_range:g} m"
        yield Finding(
            "field of view",
            sensor.name,
            f"sensor {sensor.name}: {count / some.size:.0%} of its {rows.size} reports lie "
            f"outside its own field_of_view{reach}; they come from {np.min(away):.3g} m to "
            f"{np.max(away):.3g} m: correct the field_of_view, or its position",
            weight=90.0 * count / some.size,
            told=float(view.max_range),
            seen=float(np.max(away)),
        )


def unseen_range(case: Case) -> Iterator[Finding]:
    """Yield sensors without a field of view that see less far than the others' reports lie."""
    known = ~np.isnan(case.position[:, 0])
    for index in case.examined:
        sensor, rows = case.sensors[index], case.rows[index]
        if sensor.field_of_view is not None or not case.tells_place(index):
            continue
        time = case.reports.time
        others = known & (case.reports.sensor != index)
        others &= (time >= time[rows[0]]) & (time <= time[rows[-1]])
        beside = np.flatnonzero(others)
        if min(rows.size, beside.size) < FEWEST:
            continue
        centre, reach, is_own = _reach(case, index)
        away = np.linalg.norm(case.position[beside] - centre, axis=1)
        count = int(np.count_nonzero(away > BEYOND * reach))
        if count < max(FEWEST, BEYOND_SHARE * beside.size):
            continue
        of = "it" if is_own else f"({centre[0]:.4g}, {centre[1]:.4g})"
        give = "" if is_own else "its position and "
        yield Finding(
            "coverage",
            sensor.name,
            f"sensor {sensor.name}: no field_of_view is given, so that it is taken to see "
            f"everywhere; but none of its {rows.size} reports comes from beyond {reach:.3g} m of "
            f"{of}, where {count} of the others' {beside.size} lie; give {give}field_of_view = "
            f"{{max_range_m = {_round(reach):g}}}",
            weight=WEIGHT + count / beside.size,
            seen=reach,
        )


def _reach(case: Case, index: int) -> tuple[FloatArray, float, bool]:
    """Return the point about which a sensor sees, how far, and whether it is its own place."""
    rows = case.rows[index]
    place = case.position[rows]
    platform = case.platform[rows]
    is_own = case.sensors[index].position is not None or case.reports.platform is not None
    centre = platform[0] if is_own else (place.min(axis=0) + place.max(axis=0)) / 2
    return centre, float(np.linalg.norm(place - centre, axis=1).max()), is_own


def _round(value: float) -> float:
    """Return a value rounded up to two digits."""
    unit = 10.0 ** (np.floor(np.log10(max(value, 1e-9))) - 1)
    return float(np.ceil(value / unit) * unit)
