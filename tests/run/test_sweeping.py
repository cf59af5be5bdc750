"""A radar that sweeps a sector is tracked, although no column tells its scans."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw

pytestmark = pytest.mark.slow


def sector_radar(seed):
    """Return ten minutes of a radar that sweeps 100 degrees in 4 s and flies back; six walkers."""
    rng = np.random.default_rng(seed)
    rows = []
    for target in range(6):
        place = np.array([rng.uniform(-700, 700), rng.uniform(1200, 2500)])
        speed = rng.uniform(1.0, 3.0) * np.array([np.cos(target), np.sin(target)])
        for sweep in range(150):
            azimuth = np.arctan2(*(place + 4.0 * sweep * speed))
            time = 4.0 * sweep + 3.6 * (np.degrees(azimuth) + 50) / 100
            if abs(azimuth) < np.radians(50) and rng.random() < 0.85:
                there = place + time * speed
                rows.append((time, np.hypot(*there), np.degrees(np.arctan2(*there)), str(target)))
    for time in rng.uniform(0, 600, 450):
        moment = time % 4.0
        if moment < 3.6:
            rows.append((time, rng.uniform(500, 4000), 100 * moment / 3.6 - 50, None))
    table = pl.DataFrame(
        sorted(rows, key=lambda row: row[0]),
        orient="row",
        schema=["time", "range_m", "azimuth_deg", "target"],
    )
    noise = pl.Series(rng.normal(0, 5, len(table))), pl.Series(rng.normal(0, 0.3, len(table)))
    return table.with_columns(
        range_m=pl.col("range_m") + noise[0], azimuth_deg=(pl.col("azimuth_deg") + noise[1]) % 360
    )


@pytest.mark.parametrize("told", [{}, {"rotation": "clockwise", "scan_period": 4.0}])
def test_sweeps_of_a_sector_are_scans(told):
    result = tw.track(sector_radar(1), {"sensors": {"default": told}} if told else None)
    (note,) = [note for note in result.run["notes"] if "sweeps a sector, 4 s a sweep" in note]
    assert ("although rotation = 'clockwise' is told" in note) == bool(told)
    assert result.run["configuration"]["sensors"]["default"]["scan_period"] == pytest.approx(
        4, rel=0.02
    )
    assert tw.evaluate(assignments=result.assignments).report_idf1 > 0.95
