"""Real files of each format, as far as they lie beside the checkout."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.formats.reading import load

pytestmark = pytest.mark.shared


@pytest.mark.parametrize(
    ("name", "n_reports", "column", "n_different"),
    [
        ("opensky/OpenSky_Plane_States.csv", 6052, "identity", 84),
        ("mot_tud_campus/dets/det/det.txt", 321, "frame", 71),
        ("mot_tud_campus/gt.txt", 359, "target", 8),
        ("kitti/0000/pointrcnn_Car.txt", 1054, "class", 1),
        ("kitti/0000/labels.txt", 711, "target", 15),
        ("ais_pyais/examples/gatehouse.nmea", 2, "identity", 2),
    ],
)
def test_reads_what_is_known_of_each_recording(shared, name, n_reports, column, n_different):
    table = load(shared / "data" / name).columns
    assert (len(table), table[column].n_unique()) == (n_reports, n_different)
    if not name.startswith("ais"):  # whose two ships are an ocean apart
        assert tw.read_reports(shared / "data" / name).undecoded.count == 0


@pytest.mark.parametrize("sequence", ["0000", "0002"])
def test_cars_are_found_where_they_are(shared, sequence):
    folder = shared / "data" / "kitti" / sequence
    reports = load(folder / "pointrcnn_Car.txt").columns
    truth = load(folder / "labels.txt", "kitti?kind=Car").columns
    truth = truth.filter(pl.col("bottom") - pl.col("top") > 25.0)  # those that are not far away
    both = truth.join(reports, on="frame", suffix="_found")
    off = np.hypot(both["x"] - both["x_found"], both["y"] - both["y_found"])
    near = both.filter(off < 1.0).select("frame", "target").unique()
    assert len(near) > 0.85 * len(truth)
