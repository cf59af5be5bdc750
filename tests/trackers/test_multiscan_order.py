"""What the order, the names and the place of things must not change."""

import numpy as np
import pytest

from oracles.scenes import WIDE, all_assignments, groups, run, scan, scene, sensor, tracker
from trackweave.domain.scans import Scan
from trackweave.models.coverage import FieldOfView

NORTH = [(-1e4, 0.0), (1e4, 0.0), (1e4, 1e4), (-1e4, 1e4)]
SOUTH = [(-1e4, 0.0), (1e4, 0.0), (1e4, -1e4), (-1e4, -1e4)]


def totals(target):
    """Return what each set of reports of the tracker's window costs."""
    tree, slots = target._tree, target._report_index
    costs = {}
    for node, total in enumerate(tree.totals()):
        track = int(tree.track[tree.nodes.family[node]])
        reports = set()
        while node >= 0:
            if tree.nodes.report[node] >= 0:
                reports.add(int(slots.report[tree.nodes.report[node] - slots.origin]))
            node = int(tree.nodes.parent[node])
        costs[track, frozenset(reports)] = float(total)
    return costs


def pair(**changed):
    return (
        sensor("a", detection_probability=0.8, clutter_density=3e-6, sigma=7.0, **changed),
        sensor("b", detection_probability=0.6, clutter_density=1e-6, sigma=15.0),
    )


@pytest.mark.parametrize("seed", range(6))
def test_the_order_of_simultaneous_sensors_changes_no_total(seed):
    scans = scene(seed, times=range(3), names=("a", "b"), objects=2, clutter=1, area=200.0)
    swapped = [scans[place] for place in (1, 0, 3, 2, 5, 4)]
    one, other = tracker(*pair(), limits=WIDE), tracker(*pair(), limits=WIDE)
    first, second = run(one, scans), run(other, swapped)
    mine, theirs = totals(one), totals(other)
    shared = mine.keys() & theirs.keys()
    # The gate may stand between a report and a sequence in one order only.
    assert len(shared) > 0.7 * max(len(mine), len(theirs))
    for key in shared:
        assert mine[key] == pytest.approx(theirs[key], abs=1e-6)
    assert first[-1].certificate.cost == pytest.approx(second[-1].certificate.cost, abs=1e-6)


def test_a_sensor_that_looks_elsewhere_says_nothing_of_a_new_object():
    """North and south share no place, so that either's first report costs the same."""
    sensors = (
        sensor("north", field_of_view=FieldOfView(polygon=NORTH)),
        sensor("south", field_of_view=FieldOfView(polygon=SOUTH)),
    )
    costs = []
    for order in (("north", "south"), ("south", "north")):
        target = tracker(*sensors, limits=WIDE)
        for time in range(3):
            for name in order:
                place = 500.0 if name == "north" else -500.0
                run(target, [scan(float(time), [(0.0, place)], name, [2 * time + (place > 0)])])
        costs.append(totals(target))
    assert costs[0].keys() == costs[1].keys()
    for key, cost in costs[0].items():
        assert cost == pytest.approx(costs[1][key], abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_renaming_the_sensors_changes_nothing(seed):
    scans = scene(seed, names=("a", "b"))
    renamed = [
        Scan(s.time, {"a": "z", "b": "c"}[s.sensor], s.measurement, s.sigma, s.report)
        for s in scans
    ]
    one = tracker(sensor("a"), sensor("b"))
    other = tracker(sensor("c"), sensor("z"))
    mine = all_assignments(one, run(one, scans))
    assert groups(mine) == groups(all_assignments(other, run(other, renamed)))


@pytest.mark.parametrize(("shift", "later"), [(2.0**20, 0.0), (0.0, 2.0**20), (-1e8, 0.0)])
def test_moving_all_places_or_times_changes_nothing(shift, later):
    scans = scene(4)
    moved = [
        Scan(s.time + later, s.sensor, s.measurement + shift, s.sigma, s.report) for s in scans
    ]
    one, other = tracker(), tracker()
    first, second = run(one, scans), run(other, moved)
    assert all_assignments(one, first) == all_assignments(other, second)
    for mine, theirs in zip(first, second, strict=True):
        assert mine.tracks.track.tolist() == theirs.tracks.track.tolist()
        assert mine.tracks.status.tolist() == theirs.tracks.status.tolist()
        np.testing.assert_allclose(
            mine.tracks.mean[:, :2], theirs.tracks.mean[:, :2] - shift, atol=1e-3
        )
        assert mine.certificate.cost == pytest.approx(theirs.certificate.cost, abs=1e-4)


@pytest.mark.parametrize("seed", range(3))
def test_the_order_of_a_scans_reports_changes_nothing(seed):
    scans = scene(seed)
    rng = np.random.default_rng(seed)
    mixed = []
    for s in scans:
        order = rng.permutation(len(s))
        mixed.append(Scan(s.time, s.sensor, s.measurement[order], s.sigma[order], s.report[order]))
    one, other = tracker(), tracker()
    assert all_assignments(one, run(one, scans)) == all_assignments(other, run(other, mixed))


def test_the_sum_of_a_sequence_is_the_same_in_any_axis():
    """Reports are sorted along x inside: turning the plane must not be seen."""
    scans = scene(7)
    turned = [
        Scan(s.time, s.sensor, s.measurement[:, ::-1].copy(), s.sigma, s.report) for s in scans
    ]
    one, other = tracker(), tracker()
    first, second = run(one, scans), run(other, turned)
    assert groups(all_assignments(one, first)) == groups(all_assignments(other, second))
    for mine, theirs in zip(first, second, strict=True):
        assert mine.certificate.cost == pytest.approx(theirs.certificate.cost, abs=1e-8)
