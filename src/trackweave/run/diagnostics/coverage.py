"""Where sensors see, against where they are said to."""

from collections.abc import Iterator

import numpy as np

from trackweave.estimation import covered
from trackweave.run.diagnostics.case import Case, Finding

__all__ = ["out_of_view"]

FEWEST_OUTSIDE, OUTSIDE_SHARE, MOST_LOOKED_AT = 10, 0.1, 600


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
