"""Whether the reports of each object keep one name, all identities hidden."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl

from trackweave import TrackingResult, track
from trackweave.metrics import assignment_quality

HIDDEN = ("target", "mode_3a", "radar_track")
HEAD = ["IDF1", "switches", "false reports in tracks", "on no track", "CPU s"]


def judged(reports: pl.DataFrame, told: Mapping[str, Any]) -> list[str]:
    """Return what the head names, in words."""
    begun = time.process_time()
    result = track(reports.drop(HIDDEN, strict=False), told, rng=np.random.default_rng(0))
    spent = time.process_time() - begun
    idf1, switches, found = names_of(result, reports)
    is_false = (reports["target"].fill_null("") == "").to_numpy()
    return [
        f"{idf1:.3f}",
        str(switches),
        f"{int((is_false & (found >= 0)).sum())} of {int(is_false.sum())}",
        f"{int((~is_false & (found < 0)).sum())} of {int((~is_false).sum())}",
        f"{spent:.0f}",
    ]


def names_of(result: TrackingResult, reports: pl.DataFrame) -> tuple[float, int, np.ndarray]:
    """Return IDF1, how often names of objects change, and each report's track, -1 for none."""
    true = reports["target"].fill_null("").to_list()
    found = result.assignments["track"].fill_null(-1).to_numpy()
    last: dict[str, int] = {}
    switches = 0
    for whose, number in zip(true, found.tolist(), strict=True):
        if whose and number >= 0:
            switches += last.get(whose, number) != number
            last[whose] = number
    return assignment_quality(true, found).idf1 or 0.0, switches, found
