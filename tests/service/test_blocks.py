"""Reports by sensor make the scans that a table of them makes."""

from dataclasses import replace

import numpy as np
import polars as pl

from trackweave.config import load_configuration
from trackweave.domain.measurements import MeasurementKind
from trackweave.formats.reading import read_reports
from trackweave.run.pieces import pieces_of
from trackweave.service.blocks import blocks_of, scan_of, without_pieces

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


def test_pieces_of_one_object_are_joined_as_in_a_recording() -> None:
    reports = read_reports(TABLE)
    told = load_configuration({"sensors": {"default": {"extent": 11.0}}})
    named = replace(reports, identity=None, identities=())
    (block,) = blocks_of(named, np.arange(3), {}).values()
    joined = without_pieces(block, MeasurementKind.POSITION, 11.0)
    expected = pieces_of(named, named.look, told).joined
    np.testing.assert_array_equal(joined.measurement, expected.measurement)
    assert joined.number.tolist() == [1]  # The strongest stands for all
    assert len(without_pieces(block, MeasurementKind.POSITION, 9.0).time) == 3
