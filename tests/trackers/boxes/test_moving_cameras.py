"""Boxes seen from cameras that move, and in 3-D."""

import numpy as np

import trackweave as tw
from oracles.boxes import SURE, Array, box, followed, solid


def pan(seed: int = 2) -> Array:
    """Return by how much a camera has panned in each frame: further than a box is wide."""
    return np.cumsum(np.random.default_rng(seed).uniform(-90, 90, (30, 2)), axis=0)


def test_a_camera_that_pans_loses_nobody_when_it_is_told() -> None:
    told, not_told = tw.BoxTracker(), tw.BoxTracker()
    for k, shift in enumerate(pan()):
        places = [(2.0 * k, 0.0), (90.0 - 2.0 * k, 60.0), (200.0, 30.0)]
        boxes = np.array([box(*place) for place in places]) - np.tile(shift, 2)
        matrix = np.column_stack([np.eye(2), shift])
        frame = told.update(boxes, [SURE] * 3, camera=matrix)
        other = not_told.update(boxes, [SURE] * 3)
    assert frame.identifiers.tolist() == [1, 2, 3]
    assert other.identifiers.tolist() != [1, 2, 3]
    assert np.allclose([track.box for track in frame.tracks], boxes)


def test_a_hidden_object_is_told_as_this_frames_camera_would_see_it() -> None:
    tracker = followed(20)
    zoom = np.array([[2.0, 0.0, 10.0], [0.0, 2.0, 0.0]])  # this frame shows all at half the size
    (track,) = tracker.update([], camera=zoom).tracks
    assert np.allclose(track.box, [5.0 + 5.0, -10.0, 15.0 + 10.0 - 5.0, 10.0], atol=1.0)


def test_a_turning_car_sees_standing_cars_stand() -> None:
    tracker = tw.BoxTracker(period=0.1)
    cars = np.array([[20.0, 5.0], [30.0, -8.0], [12.0, -3.0]])
    for k in range(20):
        angle, place = 0.06 * k, np.array([1.0 * k, 0.2 * k])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        camera = np.eye(4)
        camera[:2, :2], camera[:2, 3] = turn, place
        seen = (cars - place) @ turn
        frame = tracker.update(
            [solid(*row, 0.3 - angle) for row in seen], [SURE] * 3, camera=camera
        )
    assert frame.identifiers.tolist() == [1, 2, 3]
    (first, *_) = tracker.update(np.empty((0, 7)), camera=np.eye(4)).tracks
    assert np.allclose(first.box[:2], cars[0], atol=0.2)
    assert abs(first.box[6] - 0.3) < 0.05


def test_a_heading_that_flips_by_half_a_turn_is_the_same_cars() -> None:
    tracker = tw.BoxTracker(period=0.1)
    for k in range(20):
        yaw = 0.4 + np.pi * (k % 2)
        frame = tracker.update([solid(0.5 * k, 0.0, yaw), solid(9.0, 5.0)], [SURE, SURE])
    assert frame.identifiers.tolist() == [1, 2]


def test_two_cars_in_one_place_are_told_apart_by_height() -> None:
    tracker = tw.BoxTracker(period=0.1)
    for _ in range(6):
        below, above = solid(0.0, 0.0), solid(0.0, 0.0)
        above[2] += 4.0
        frame = tracker.update([below, above], [SURE, SURE])
    assert frame.identifiers.tolist() == [1, 2]
