"""What a tracker refuses at its border, and that a refused step changes nothing."""

import numpy as np
import pytest

from oracles.scenes import MOTION, groups, run, scan, scene, sensor, tracker
from trackweave.association.growth_limits import GrowthLimits
from trackweave.domain.scans import Scan
from trackweave.errors import InvalidInputError
from trackweave.solvers import Genetic, Greedy
from trackweave.trackers.lifecycle import Lifecycle
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker
from trackweave.trackers.nearest_neighbour import NearestNeighbourTracker
from trackweave.trackers.window import Window


class Failing:
    """A solver that fails when it is told to."""

    fails = False

    def __call__(self, problem, **options):
        if self.fails:
            raise RuntimeError("no answer")
        return Greedy()(problem, **options)


@pytest.mark.parametrize(
    "wrong",
    [
        {"motion": None},
        {"sensors": sensor()},
        {"sensors": ["radar"]},
        {"sensors": None},
        {"window": 2.5},
        {"window": True},
        {"window": "5"},
        {"search": "genetic"},
        {"search": Genetic},
        {"lifecycle": {"survival": 0.9}},
        {"lifecycle": Lifecycle},
        {"limits": 100},
        {"priors": [1]},
    ],
    ids=str,
)
def test_refuses_a_part_of_another_kind(wrong):
    with pytest.raises(InvalidInputError, match=rf"^{next(iter(wrong))}.*; expected"):
        MultiHypothesisTracker(**({"motion": MOTION, "sensors": [sensor()]} | wrong))


@pytest.mark.parametrize("values", [{"depth": 2.5}, {"max_scans": "9"}, {"depth": True}])
def test_refuses_a_window_of_broken_numbers(values):
    with pytest.raises(InvalidInputError, match="expected a whole number"):
        Window(**values)


@pytest.mark.parametrize(
    "values", [{"confirm_hits": 2.5}, {"survival": "0.9"}, {"survival": None}, {"survival": True}]
)
def test_refuses_a_lifecycle_of_broken_numbers(values):
    with pytest.raises(InvalidInputError, match=r"expected a (whole )?number"):
        Lifecycle(**values)


@pytest.mark.parametrize("values", [{"max_nodes": 2.5}, {"margin": "9"}, {"margin": np.nan}])
def test_refuses_limits_of_broken_numbers(values):
    with pytest.raises(InvalidInputError, match=r"expected a (whole )?number"):
        GrowthLimits(**values)


@pytest.mark.parametrize("depth", [3, np.int64(3), Window(depth=3)])
def test_takes_a_window_by_its_depth(depth):
    target = tracker(window=depth)
    run(target, [scan(float(time), []) for time in range(10)])
    assert len(target._open.scans) == 3


@pytest.mark.parametrize(
    "wrong",
    [
        {"rng": 1.5},
        {"rng": None},
        {"rng": np.random.RandomState(1)},
        {"scan": [[1.0, 2.0]]},
        {"scan": None},
        {"scan": scan(6.0, [(0, 0)], "sonar")},
        {"scan": Scan(6.0, "radar", np.zeros((1, 3)))},
        {"deadline": 0},
        {"deadline": -1.0},
        {"deadline": np.inf},
        {"deadline": np.nan},
        {"deadline": "soon"},
        {"deadline": True},
    ],
    ids=lambda wrong: next(iter(wrong)),
)
def test_a_refused_step_changes_nothing(wrong):
    scans = scene(1)
    target, rng = tracker(search=Greedy()), np.random.default_rng(1)
    for each in scans[:6]:
        target.step(each, rng=rng)
    given = {"scan": scans[6], "rng": rng} | wrong
    with pytest.raises(InvalidInputError, match="expected"):
        target.step(given.pop("scan"), **given)
    after = [target.step(each, rng=rng) for each in scans[6:]]
    expected = run(tracker(search=Greedy()), scans)[6:]
    for mine, theirs in zip(after, expected, strict=True):
        np.testing.assert_array_equal(mine.tracks.mean, theirs.tracks.mean)
        np.testing.assert_array_equal(mine.final.report, theirs.final.report)
        assert mine.certificate == theirs.certificate


@pytest.mark.parametrize("kind", [MultiHypothesisTracker, NearestNeighbourTracker])
@pytest.mark.parametrize("later", [0.0, 1.0])
def test_a_sensor_that_leaves_out_the_height_is_refused_and_nothing_changes(kind, later):
    full = [Scan(0.0, "radar", [[1.0, 2.0, 300.0]]), Scan(1.0, "radar", [[1.0, 2.0, 300.0]])]
    target = kind(motion=MOTION, sensors=[sensor()])
    target.step(full[0])
    with pytest.raises(
        InvalidInputError, match="radar: 2 numbers per report; expected 3, as in its scans before"
    ):
        target.step(Scan(later, "radar", [[1.0, 2.0]]))
    untouched = kind(motion=MOTION, sensors=[sensor()])
    untouched.step(full[0])
    mine, theirs = target.step(full[1]), untouched.step(full[1])
    np.testing.assert_array_equal(mine.tracks.mean, theirs.tracks.mean)
    assert mine.certificate == theirs.certificate


def test_a_lone_sensor_has_to_tell_the_height_in_space():
    target = tracker(dim=3)
    with pytest.raises(InvalidInputError, match="expected 3, as no other sensor tells heights"):
        target.step(Scan(0.0, "radar", [[1.0, 2.0]]))


def test_an_empty_scan_fits_one_of_its_time_that_lacks_the_height():
    target = tracker(sensor("map"), sensor("high"), dim=3)
    whole = [[1.0, 2.0]], [], [[3.0, 4.0]]
    run(target, [Scan(0.0, "map", rows) for rows in ([], *whole)])
    assert target.pending().report.tolist() == [0, 1]


def test_a_noise_for_other_dimensions_is_refused_before_anything_changes():
    target = tracker(sensor("a"), sensor("b", sigma=(1.0, 1.0, 1.0)))
    run(target, [scan(0.0, [(0, 0)], "a")])
    with pytest.raises(InvalidInputError, match="sensor b: sigma for 3 axes; expected 1 or 2"):
        run(target, [scan(1.0, [(0, 0)], "b")])
    (hypothesis,) = run(target, [scan(1.0, [(1, 0)], "a")])
    assert hypothesis.time == 1.0


@pytest.mark.parametrize("dim", [2, 3])
def test_empty_lists_fit_whatever_comes_after(dim):
    scans = scene(1, dim=dim, times=range(4, 12))
    told = [Scan(float(time), "radar", np.empty((0, dim))) for time in range(4)]
    untold = [Scan(float(time), "radar", []) for time in range(4)]
    both = []
    for empty in (told, untold):
        # The first scan of reports has the time of the last empty one: they become one scan.
        whole = [*empty, Scan(3.0, "radar", scans[0].measurement), *scans[1:]]
        whole = [Scan(each.time, each.sensor, each.measurement) for each in whole]
        target = tracker(window=2)
        both.append((run(target, whole), target.pending()))
    for mine, theirs in zip(*(hypotheses for hypotheses, _ in both), strict=True):
        np.testing.assert_array_equal(mine.tracks.track, theirs.tracks.track)
        assert mine.certificate == theirs.certificate
    assert both[0][0][-1].tracks.mean.shape[1] == 2 * dim
    first, second = (dict(zip(p.report, p.track, strict=True)) for _, p in both)
    assert groups(first) == groups(second) != set()


def test_an_empty_list_among_reports_is_a_scan_without_reports():
    filled = [scan(0.0, [(0, 0)]), scan(1.0, [(1, 0)]), scan(3.0, [(3, 0)])]
    runs = [
        run(tracker(), [*filled[:2], Scan(2.0, "radar", empty), filled[2]])
        for empty in ([], np.empty((0, 2)))
    ]
    assert runs[0][2].certificate == runs[1][2].certificate
    np.testing.assert_array_equal(runs[0][3].tracks.mean, runs[1][3].tracks.mean)


def test_a_noise_for_each_axis_tells_the_dimensions_of_empty_lists():
    target = tracker(sensor(sigma=(5.0, 5.0, 9.0)))
    (hypothesis,) = run(target, [Scan(0.0, "radar", [])])
    assert hypothesis.tracks.mean.shape == (0, 6)
    with pytest.raises(InvalidInputError, match="2 dimensions; expected 3"):
        run(target, [scan(1.0, [(0, 0)])])


def test_a_sensor_is_known_by_its_number_as_text():
    for given, told in ((0, "0"), ("0", 0)):
        target = tracker(sensor(given), window=2)
        run(target, [Scan(float(time), told, []) for time in range(5)])
        assert len(target._open.scans) == 2
    with pytest.raises(InvalidInputError, match="names that differ"):
        tracker(sensor(0), sensor("0"))
    with pytest.raises(InvalidInputError, match=r"None; expected a text or a whole number"):
        tracker(sensor(None))
