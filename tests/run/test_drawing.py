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
    assert assigned_per_scan(scans, np.array([0.0, 1.0]), table).tolist() == [2.0, 1.0]
