"""What is run so that kernels come compiled."""

import pytest

from trackweave.association import inactive
from trackweave.domain.measurements import MeasurementKind
from trackweave.run import track
from trackweave.run.small_recordings import recording_of, recording_of_radars
from trackweave.solvers import METHODS
from trackweave.warming.covering import KINDS, PARTS, tasks_of


def test_the_first_look_comes_first_and_all_has_every_kind_and_solver() -> None:
    first, everything = map(tasks_of, PARTS)
    names = [name for name, _ in everything]
    assert [name for name, _ in first] == names[: len(first)]
    assert len(set(names)) == len(names)
    assert {kind for kind, _, _ in KINDS} >= {"position", "range-azimuth", "bearing"}
    assert all(f"solve by {method}" in names for method in METHODS)


@pytest.mark.parametrize(("kind", "n_sensors", "dim"), KINDS)
def test_recordings_are_the_same_at_each_call_and_can_be_tracked(kind, n_sensors, dim) -> None:
    one, other = (recording_of(kind, n_sensors=n_sensors, dim=dim) for _ in range(2))
    assert one.reports.equals(other.reports)
    assert one.reports["sensor"].n_unique() == n_sensors
    assert one.config == other.config


def test_objects_of_a_recording_are_found() -> None:
    seen = recording_of("position")
    assert track(seen.reports, seen.config).run["totals"]["tracks"] >= 5


def test_every_kind_of_measurement_is_covered() -> None:
    covered = {kind for kind, _, _ in KINDS}
    kinds = {kind.name.lower().replace("_", "-") for kind in MeasurementKind}
    # Of a range rate alone there are no reports: it is a part of others.
    assert kinds - {"range-rate"} == covered


def test_two_turning_radars_leave_clusters_that_no_scan_concerns(monkeypatch) -> None:
    seen = recording_of_radars()
    assert seen.reports.equals(recording_of_radars().reports)
    asked = []
    real = inactive.locate
    monkeypatch.setattr(inactive, "locate", lambda *told: asked.append(None) or real(*told))
    tasks = dict(tasks_of("all"))
    tasks["track two turning radars"]()
    assert asked
