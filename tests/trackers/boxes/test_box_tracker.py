"""Boxes keep the names of their objects."""

import copy
import subprocess
import sys
import warnings
from typing import Any

import numpy as np
import pytest

import trackweave as tw
from oracles.boxes import SIZE, SURE, Array, box, followed, solid
from trackweave.errors import InvalidInputError

UNSURE = 0.15


def names_of(frames: list[tw.BoxFrame]) -> list[list[int]]:
    return [frame.identifiers.tolist() for frame in frames]


def all_frames(scene: list[tuple[Array, Array]], **options: Any) -> list[tw.BoxFrame]:
    """Return what a tracker says of each frame, however late."""
    tracker = tw.BoxTracker(**options)
    frames = [tracker.update(*given) for given in scene]
    return [frame for frame in frames if frame.number >= 0] + tracker.rest()


def scene(seed: int = 0) -> list[tuple[Array, Array]]:
    """Return boxes and scores of five walkers, some missed, among false boxes."""
    rng = np.random.default_rng(seed)
    place = np.column_stack([rng.uniform(0, 400, 5), 60.0 * np.arange(5)])
    speed = rng.uniform(-3, 3, 5)
    frames = []
    for _ in range(40):
        place[:, 0] += speed
        found = rng.random(5) < 0.9
        false = rng.uniform([0, 0], [400, 300], (rng.poisson(1.0), 2))
        middle = np.vstack([place[found] + rng.normal(0, 0.5, (found.sum(), 2)), false])
        score = np.concatenate(
            [rng.uniform(0.7, 1.0, found.sum()), rng.uniform(0, 0.4, len(false))]
        )
        frames.append((np.hstack([middle - SIZE / 2, middle + SIZE / 2]), score))
    return frames


# ------------------------------------------------------------------------------------- contract


def test_identifiers_are_in_the_order_of_the_boxes() -> None:
    first, second = tw.BoxTracker(), tw.BoxTracker()
    rng = np.random.default_rng(1)
    same: dict[int, int] = {}
    for boxes, scores in scene():
        order = rng.permutation(len(boxes))
        straight = first.update(boxes, scores).identifiers[order]
        mixed = second.update(boxes[order], scores[order]).identifiers
        assert straight.dtype == mixed.dtype == np.int64
        assert np.array_equal(straight == -1, mixed == -1)
        assert all(same.setdefault(a, b) == b for a, b in zip(straight, mixed, strict=True))
    assert len(same) >= 6


KINDS: list[dict[str, Any]] = [{}, {"window": 2}, {"delay": 3}, {"distance": "iou"}]


@pytest.mark.parametrize("options", KINDS, ids=str)
def test_no_name_stands_twice_in_a_frame_and_each_has_a_track(options: dict[str, Any]) -> None:
    for frame in all_frames(scene(), **options):
        named = frame.identifiers[frame.identifiers >= 0]
        assert np.unique(named).size == named.size
        assert set(named) <= {track.identifier for track in frame.tracks if track.visible}


def test_a_track_carries_the_box_the_class_the_score_and_the_data_of_its_last_box() -> None:
    tracker = tw.BoxTracker()
    tracker.update([box(0.0)], [SURE], ["person"], data=[{"feature": 1}])
    track = tracker.update([box(2.0)], [0.9], ["person"], data=[{"feature": 2}]).tracks[0]
    assert (track.class_, track.score, track.data) == ("person", 0.9, {"feature": 2})
    assert track.box.tolist() == box(2.0)
    assert track.visible
    assert 0.5 < track.existence <= 1.0


def test_rows_of_an_array_may_be_the_data() -> None:
    features = np.array([[1.0, 2.0], [3.0, 4.0]])
    for given in (features, list(features)):
        frame = tw.BoxTracker().update([box(0.0), box(90.0)], [SURE, SURE], data=given)
        assert [track.data.tolist() for track in frame.tracks] == features.tolist()


def test_an_object_without_a_box_is_told_where_it_should_be() -> None:
    frame = followed(20).update(np.empty((0, 4)))
    assert frame.identifiers.shape == (0,)
    (track,) = frame.tracks
    assert not track.visible
    assert track.data is None
    assert np.allclose(track.box, box(40.0), atol=1.0)


def test_what_is_given_is_not_changed() -> None:
    boxes, scores = np.array([box(0.0), box(50.0)]), np.array([SURE, SURE])
    kept = boxes.copy(), scores.copy()
    tracker = tw.BoxTracker()
    frame = tracker.update(boxes, scores)
    frame.tracks[0].box[:] = 0.0
    tracker.update(boxes, scores)
    assert np.array_equal(boxes, kept[0])
    assert np.array_equal(scores, kept[1])


@pytest.mark.parametrize("options", KINDS, ids=str)
def test_the_same_boxes_give_the_same_bytes(options: dict[str, Any]) -> None:
    runs = []
    for _ in range(2):
        frames = all_frames(scene(), **options)
        tracks = [(t.identifier, t.box.tobytes(), t.existence) for f in frames for t in f.tracks]
        runs.append((names_of(frames), tracks))
    assert runs[0] == runs[1]


def test_a_frame_prints_as_a_line() -> None:
    frame = tw.BoxTracker().update([box(50.0 * k) for k in range(9)], [SURE] * 9)
    assert repr(frame) == "BoxFrame(number=0, time=0.0, identifiers=array of 9, tracks=tuple of 9)"


def test_nothing_is_compiled_where_each_frame_is_decided_by_itself() -> None:
    code = (
        "import sys, trackweave as tw; tw.BoxTracker().update([[0, 0, 1, 1]], [0.9]);"
        "print('numba' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


# ---------------------------------------------------------------------------------------- names


def test_objects_that_cross_keep_their_names() -> None:
    rng = np.random.default_rng(3)
    tracker, found = tw.BoxTracker(), []
    for k in range(40):
        places = [(3.0 * k, 0.0), (120.0 - 3.0 * k, 12.0)]
        boxes = np.array([box(*place) for place in places]) + rng.normal(0, 0.5, (2, 4))
        found.append(tracker.update(boxes, [SURE, SURE]))
    assert names_of(found)[1:] == [names_of(found)[1]] * 39


def test_an_object_that_comes_back_has_its_old_name_while_that_is_open() -> None:
    for seconds, expected in ((0.8, [1]), (2.5, [2])):
        tracker = followed(20, period=0.04, rejoin=2.0)
        for _ in range(round(seconds / 0.04)):
            tracker.update([])
        places = 2.0 * (20 + round(seconds / 0.04)) + 2.0 * np.arange(4)
        frames = [tracker.update([box(x)], [SURE]) for x in places]
        assert frames[-1].identifiers.tolist() == expected


def test_a_name_that_is_closed_is_told_no_more() -> None:
    tracker = followed(20, period=0.04, rejoin=2.0)
    assert len(tracker.update([], time=2.0).tracks) == 1
    assert tracker.update([], time=3.0).tracks == ()


def test_a_low_score_goes_on_with_a_track_but_begins_none() -> None:
    tracker = followed(20)
    for k in range(20, 30):
        frame = tracker.update([box(2.0 * k), box(300.0 + 70.0 * (k % 2))], [UNSURE, UNSURE])
        assert frame.identifiers.tolist() == [1, -1]


def test_boxes_without_scores_are_named_once_they_go_on() -> None:
    tracker = tw.BoxTracker()
    frames = [tracker.update([box(2.0 * k), box(200.0)]) for k in range(6)]
    assert frames[-1].identifiers.tolist() == [1, 2]
    assert frames[-1].tracks[0].score is None


def test_any_scale_of_scores_will_do() -> None:
    tracker = tw.BoxTracker(scores="log-odds")
    for k in range(10):
        frame = tracker.update([box(2.0 * k), box(300.0 * (k % 2))], [9.5, -3.0])
    assert frame.identifiers.tolist() == [1, -1]


def test_classes_are_kept_apart() -> None:
    tracker = tw.BoxTracker()
    for _ in range(5):
        frame = tracker.update([box(0.0), box(1.0)], [SURE, SURE], ["person", "bicycle"])
    assert {t.identifier: t.class_ for t in frame.tracks} == {1: "person", 2: "bicycle"}
    for _ in range(3):
        frame = tracker.update([box(0.0)], [SURE], ["dog"])
    assert frame.identifiers.tolist() == [3]


def test_classes_may_be_whole_numbers_in_a_column_of_floats() -> None:
    tracker = tw.BoxTracker()
    tracker.update([box(0.0), box(90.0)], [SURE, SURE], np.array([2.0, 7.0]))
    frame = tracker.update([box(0.0), box(90.0)], [SURE, SURE], np.array([2, 7]))
    assert [track.class_ for track in frame.tracks] == [2, 7]
    assert frame.identifiers.tolist() == [1, 2]


def test_frames_may_come_at_any_time() -> None:
    tracker = tw.BoxTracker()
    rng = np.random.default_rng(5)
    times = np.cumsum(rng.uniform(0.01, 0.3, 40))
    frames = [tracker.update([box(50.0 * t), box(90.0, 50.0)], [SURE] * 2, time=t) for t in times]
    assert names_of(frames)[1:] == [[1, 2]] * 39
    assert [frame.time for frame in frames] == times.tolist()


def test_what_does_not_overlap_is_not_linked_where_overlap_is_asked_for() -> None:
    for distance, after in (("centre", [1]), ("iou", [2])):
        tracker = tw.BoxTracker(distance=distance)
        tracker.update([box(0.0)], [SURE])
        assert tracker.update([box(0.0)], [SURE], time=0.04).identifiers.tolist() == [1]
        frame = tracker.update([box(25.0)], [0.999], time=0.6)
        assert frame.identifiers.tolist() == after


# ---------------------------------------------------------------------------------------- delay


def test_a_delay_tells_of_earlier_frames_and_at_last_of_the_rest() -> None:
    given = scene()
    tracker = tw.BoxTracker(delay=3, period=0.5)
    told = [tracker.update(*one) for one in given]
    assert [frame.number for frame in told] == [-1, -1, -1, *range(len(given) - 3)]
    assert told[0].tracks == ()
    frames = [*told[3:], *tracker.rest()]
    assert [frame.time for frame in frames] == [0.5 * k for k in range(len(given))]
    for (boxes, _), frame in zip(given, frames, strict=True):
        assert frame.identifiers.size == len(boxes)
        for track in frame.tracks:
            where = np.flatnonzero(frame.identifiers == track.identifier)
            assert not where.size or np.array_equal(track.box, boxes[where[0]])


def test_a_delay_names_an_object_from_its_first_box() -> None:
    given = [(np.empty((0, 4)), np.empty(0))] * 3
    given += [(np.array([box(2.0 * k)]), np.array([0.7])) for k in range(8)]
    at_once, later = all_frames(given), all_frames(given, delay=3)
    assert names_of(at_once)[3:5] == [[-1], [1]]
    assert names_of(later)[3:] == [[1]] * 8


def test_a_delay_longer_than_the_film_tells_all_at_the_end() -> None:
    tracker = tw.BoxTracker(delay=9)
    assert tracker.rest() == []
    for k in range(4):
        assert tracker.update([box(2.0 * k)], [SURE]).number == -1
    assert names_of(tracker.rest()) == [[1]] * 4


def test_several_explanations_keep_up_with_those_who_cross() -> None:
    rng = np.random.default_rng(4)
    given = []
    for k in range(40):
        places = np.array([[3.0 * k, 0.0], [120.0 - 3.0 * k, 10.0]])
        seen = places[rng.random(2) < 0.8]
        middle = seen + rng.normal(0, 0.5, seen.shape)
        given.append((np.hstack([middle - SIZE / 2, middle + SIZE / 2]), np.full(len(seen), SURE)))
    given.append((np.array([box(120.0), box(0.0, 10.0)]), np.array([SURE, SURE])))
    for options in KINDS[:3]:
        frames = all_frames(given, **options)
        last = {track.identifier for track in frames[-1].tracks}
        assert last == {1, 2}


# ---------------------------------------------------------------------------------- what is odd


def test_frames_without_boxes_are_fine_from_the_first_on() -> None:
    for empty in ([], np.empty((0, 4))):
        tracker = tw.BoxTracker()
        assert tracker.update(empty, []).tracks == ()
        for k in range(3):
            frame = tracker.update([box(2.0 * k)], [SURE])
        assert frame.identifiers.tolist() == [1]


@pytest.mark.parametrize("n_columns", [0, 5, 6])
def test_a_frame_without_boxes_may_have_a_detectors_columns(n_columns: int) -> None:
    tracker, other = followed(), followed()
    frame = tracker.update(np.empty((0, n_columns)))
    assert frame.identifiers.size == 0
    assert np.array_equal(frame.tracks[0].box, other.update([]).tracks[0].box)
    assert tw.BoxTracker().update(np.empty((0, n_columns))).tracks == ()


def test_boxes_cut_to_nothing_are_taken() -> None:
    tracker = tw.BoxTracker()
    for _ in range(4):
        frame = tracker.update([[0.0, 0.0, 0.0, 30.0], box(60.0)], [0.3, SURE])
    assert frame.identifiers[1] == 1


def test_scores_that_are_all_alike_say_something_still() -> None:
    rng = np.random.default_rng(6)
    tracker = tw.BoxTracker()
    for _ in range(700):
        frame = tracker.update([box(*rng.uniform(0, 900, 2)), box(0.0)], [0.05, 0.9])
    assert frame.identifiers.tolist() == [-1, 1]


def test_places_times_and_scores_of_any_size_are_borne() -> None:
    for scale in (1e-12, 1e12, 1e80):
        tracker = tw.BoxTracker(scores="log-odds")
        for k, time in enumerate((0.0, 0.04, 0.08, 1e20, 1e300)):
            boxes = scale * np.array([box(2.0 * k), box(100.0)])
            frame = tracker.update(boxes, [1e308, 5.0], time=time)
        assert all(np.isfinite(track.existence) for track in frame.tracks)
        assert np.array_equal(frame.tracks[0].box, boxes[0])


def test_times_in_milliseconds_are_asked_about_once() -> None:
    tracker = tw.BoxTracker()
    tracker.update([box(0.0)], time=1000.0)
    with pytest.warns(
        UserWarning, match=r"time: 40 s after .* 1,000 periods of 0.04 s; .*millisec"
    ):
        tracker.update([box(1.0)], time=1040.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tracker.update([box(2.0)], time=1080.0)
        slow = tw.BoxTracker(period=40.0)
        for k in range(3):
            slow.update([box(0.0)], time=40.0 * k)
        paused = tw.BoxTracker()
        for time in (0.0, 0.04, 100.0):
            paused.update([box(0.0)], time=time)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"boxes": [[0.0, 0.0, 1.0]]}, "boxes: 3 columns; expected 4 as in earlier frames"),
        ({"boxes": [[*box(0.0), 0.9]]},
         r"boxes: 5 columns; .*\. Scores are the second .*: update\(a\[:, :4\], a\[:, 4\]\)"),
        ({"boxes": [[*box(0.0), 0.9, 2.0]]}, r"boxes: 6 columns; .* update\(.*, a\[:, 5\]\)"),
        ({"boxes": [[0.0] * 7]}, "boxes: 7 columns; expected 4 as in earlier frames"),
        ({"boxes": [0.0, 0.0, 1.0, 1.0]}, r"boxes: an array of shape \(4,\); expected shape"),
        ({"boxes": [[0.0, 0.0, np.nan, 1.0]]}, r"boxes\[0, 2\]: nan; expected a finite number"),
        ({"boxes": [box(0.0), [5.0, 0.0, 1.0, 1.0]]},
         r"boxes\[1\]: \[5.0, 0.0, 1.0, 1.0\]; expected x1 ≤ x2 and y1 ≤ y2"),
        ({"boxes": [[0.0, 0.0, 1e200, 1e200]]},
         r"boxes\[0\]: \[0.0, 0.0, 1e\+200, 1e\+200\]; expected numbers from -1e\+100 to 1e\+100"),
        ({"scores": [0.5, 0.5]}, r"scores: an array of shape \(2,\); expected shape \(1\)"),
        ({"scores": [np.nan]}, r"scores\[0\]: nan; expected a finite number"),
        ({"scores": [2.5]}, r"scores\[0\]: 2.5; expected a probability .*log-odds"),
        ({"classes": ["a", "b"]}, "classes: 2 of them; expected 1, one a box"),
        ({"classes": [0.5]}, "classes: 0.5; expected texts or whole numbers"),
        ({"data": "feature"}, "data: 'feature'; expected one for each box"),
        ({"time": 0.0}, "time: 0.0; expected after 0.36.*, the last frame's"),
        ({"time": np.inf}, "time: inf; expected a finite number"),
        ({"camera": np.eye(4)}, r"camera: an array of shape \(4, 4\); expected shape \(2, 3\)"),
        ({"camera": np.eye(3)}, r"shape \(3, 3\); expected shape \(2, 3\): camera\[:2\], without"),
        ({"camera": [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]}, "camera: a determinant of -1; expected"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused_and_changes_nothing(
    given: dict[str, Any], message: str
) -> None:
    tracker, other = followed(), followed()
    before = copy.deepcopy(tracker)
    with pytest.raises(InvalidInputError, match=message):
        tracker.update(**{"boxes": [box(20.0)], **given})
    after = [one.update([box(20.0)], [SURE]) for one in (tracker, before, other)]
    assert len({frame.tracks[0].box.tobytes() for frame in after}) == 1
    assert len({frame.tracks[0].existence for frame in after}) == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"delay": -1}, "delay: -1; expected a whole number ≥ 0"),
        ({"window": 2.5}, "window: 2.5; expected a whole number ≥ 0"),
        ({"period": 0.0}, "period: 0.0; expected a number above 0"),
        ({"confirm": 1.0}, "confirm: 1.0; expected a number between 0 and 1"),
        ({"distance": "area"}, "distance: 'area'; expected one of centre, iou"),
        ({"scores": "percent"}, "scores: 'percent'; expected one of probability, log-odds"),
    ],
)
def test_options_out_of_range_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        tw.BoxTracker(**options)


def test_a_pose_without_its_last_row_is_refused_by_name() -> None:
    with pytest.raises(InvalidInputError, match=r"shape \(3, 4\); .* last row 0, 0, 0, 1"):
        tw.BoxTracker().update([solid(0.0, 0.0)], camera=np.eye(4)[:3])


def test_extents_below_zero_are_refused_in_3_d() -> None:
    bad = solid(0.0, 0.0)
    bad[3] = -4.0
    with pytest.raises(InvalidInputError, match="expected extents of at least 0"):
        tw.BoxTracker().update([bad])
