"""Reports by sensor make the scans that a table of them makes."""

import numpy as np
import polars as pl

from trackweave.formats.reading import read_reports
from trackweave.service.blocks import blocks_of, scan_of

TABLE = pl.DataFrame(
    {
        "time": [1.0, 1.0, 1.0],
        "x": [0.0, 10.0, 20.0],
        "y": [5.0, 6.0, 7.0],
        "height_m": [900.0, None, 1500.0],
        "strength": [3.0, 4.0, None],
        "identity": ["A", None, "B"],
    }
)


def test_a_scan_of_the_service_tells_what_a_tables_does() -> None:
    reports = read_reports(TABLE)
    whole = reports.scan_of(np.arange(3), 1.0)
    (block,) = blocks_of(reports, np.arange(3), {}).values()
    scan = scan_of(block, whole.sensor, 1.0, own_times=False)
    for name in ("measurement", "sigma", "report", "identity", "strength", "height"):
        np.testing.assert_array_equal(getattr(scan, name), getattr(whole, name), err_msg=name)
    assert scan.height is not None
    assert np.isnan(scan.height).tolist() == [False, True, False]
