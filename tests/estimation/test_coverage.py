"""Where sensors see is told by what others report and they do not."""

import numpy as np
import pytest

from estimation.test_estimate import table
from trackweave.domain.reports import ReportTable
from trackweave.estimation.coverage import covered, fields_of_view
from trackweave.models.coverage import FieldOfView

PLACES = np.array([[0.0, 0.0], [3000.0, 0.0]])
NAMES = ("a", "b")


def two(reach: float, *, sector: float = 360.0, extra: int = 0) -> ReportTable:
    """Return uniform reports of two sensors; the first within a reach and a sector from north."""
    rng = np.random.default_rng(1)
    place = rng.uniform([-1000, -1000], [4000, 1000], (4000, 2))
    sensor = np.arange(4000) % 2
    offset = place - PLACES[0]
    azimuth = np.degrees(np.arctan2(*offset.T)) % 360
    kept = (sensor == 1) | ((np.linalg.norm(offset, axis=1) < reach) & (azimuth < sector))
    # Errors, or false alarms, far off.
    kept[np.flatnonzero(sensor == 0)[:extra]] = True
    place[np.flatnonzero(sensor == 0)[:extra], 0] = 9e5
    return table(np.arange(4000.0)[kept], place[kept], sensor[kept], NAMES)


def platform(reports: ReportTable) -> np.ndarray:
    return PLACES[reports.sensor]


@pytest.mark.parametrize("extra", [0, 2])
def test_a_reach_is_seen_where_others_go_on(extra: int) -> None:
    reports = two(1500.0, extra=extra)
    (view,) = fields_of_view(reports, platform(reports), NAMES).values()
    assert 1500.0 < view.max_range < 1.03 * 1500.0
    assert view.azimuth_deg == (0.0, 360.0)


def test_a_sector_is_seen_where_others_see_the_rest() -> None:
    reports = two(1500.0, sector=200.0)
    view = fields_of_view(reports, platform(reports), NAMES)["a"]
    start, end = view.azimuth_deg
    assert start == pytest.approx(358, abs=2)
    assert end == pytest.approx(202, abs=2)


def test_all_reports_but_those_that_stand_alone_lie_inside() -> None:
    for standing in (NAMES, ()):
        reports = two(1500.0, sector=200.0)
        view = fields_of_view(reports, platform(reports), standing)["a"]
        own = reports.sensor == 0
        away = platform(reports)[own] if standing else np.zeros((int(own.sum()), 2))
        assert covered(reports.measurement[own], away, view.coverage()).all()


def test_the_hull_counts_where_nobody_knows_the_place() -> None:
    reports = two(1500.0)
    (view,) = fields_of_view(reports, np.zeros((len(reports), 2)), ()).values()
    corners = np.array(view.polygon)
    # A rectangle that the reach cuts at the right.
    assert corners.min() > -1300
    assert 1500 < corners.max() < 1700


def test_sensors_that_see_the_same_have_no_edge() -> None:
    assert fields_of_view(two(1e9), platform(two(1e9)), NAMES) == {}
    assert fields_of_view(two(1e9), platform(two(1e9)), ()) == {}


def test_few_reports_and_those_on_a_line_tell_no_edge() -> None:
    few = two(1500.0).part(np.arange(40))
    assert fields_of_view(few, platform(few), NAMES) == {}
    line = table(
        np.arange(400.0), np.c_[np.arange(400.0) % 100, np.zeros(400)], np.arange(400) % 2, NAMES
    )
    assert fields_of_view(line, platform(line), ()) == {}


def test_a_moving_sensors_reach_goes_with_it() -> None:
    rng = np.random.default_rng(1)
    time = np.arange(4000.0)
    where = np.c_[time, np.zeros(4000)]
    offset = rng.uniform(-500, 500, (4000, 2))
    sensor = np.arange(4000) % 2
    kept = (sensor == 1) | (np.linalg.norm(offset, axis=1) < 200)
    reports = table(time[kept], (where + offset)[kept], sensor[kept], NAMES)
    (view,) = fields_of_view(reports, where[kept], NAMES).values()
    assert view == FieldOfView(max_range=view.max_range)
    assert view.max_range == pytest.approx(203, abs=4)
