"""How many reports of each scan a picture counts as assigned."""

import numpy as np

from trackweave.io.run_files import AssignedReports
from trackweave.run.drawing import assigned_per_scan


def test_scans_of_several_sensors_count_the_reports_of_each() -> None:
    scans = [{"sensor": "A+B", "time": 0.0}, {"sensor": "A", "time": 1.0}]
    table = AssignedReports(
        report=np.array(["1", "2", "3", "4"], dtype=object),
        time=np.array([0.0, 0.0, 0.0, 1.0]),
        sensor=np.array(["A", "B", "B", "A"], dtype=object),
        track=np.array([1, 1, -1, 1]),
    )
    record = {"scans": scans}
    assert assigned_per_scan(record, np.array([0.0, 1.0]), table).tolist() == [2.0, 1.0]


def test_copies_are_no_reports_of_a_scan() -> None:
    record = {
        "scans": [{"sensor": "A", "time": 0.0}, {"sensor": "A", "time": 1.0}],
        "doubles": [{"report": "2", "of": "1"}, {"report": "3", "of": "1"}],
    }
    table = AssignedReports(
        report=np.array(["1", "2", "3", "4"], dtype=object),
        time=np.array([0.0, 0.0, 1.0, 1.0]),
        sensor=np.array(["A"] * 4, dtype=object),
        track=np.array([1, 1, 1, 2]),
    )
    assert assigned_per_scan(record, np.array([0.0, 1.0]), table).tolist() == [1.0, 1.0]
