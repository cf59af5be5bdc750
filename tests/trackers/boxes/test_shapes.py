"""Boxes as parts and back, and as cameras see them."""

import numpy as np
import pytest

from trackweave.trackers.boxes.shapes import Camera, boxes_of, overlaps, parts_of

IMAGE = np.array([[10.0, 20.0, 30.0, 60.0], [-5.0, 0.0, 5.0, 8.0]])
SOLID = np.array([[1.0, 2.0, 0.5, 4.0, 1.8, 1.5, 0.4], [9.0, -3.0, 0.8, 0.6, 0.5, 1.7, -3.0]])
AFFINE = np.array([[1.1, -0.2, 30.0], [0.2, 1.1, -7.0]])
POSE = np.eye(4)
POSE[:3] = [[0.8, -0.6, 0.0, 5.0], [0.6, 0.8, 0.0, -2.0], [0.0, 0.0, 1.0, 0.3]]


@pytest.mark.parametrize("boxes", [IMAGE, SOLID])
def test_boxes_come_back_from_their_parts(boxes: np.ndarray) -> None:
    assert np.allclose(boxes_of(parts_of(boxes)), boxes)


@pytest.mark.parametrize(("boxes", "matrix"), [(IMAGE, AFFINE), (SOLID, POSE)])
def test_a_camera_and_back_changes_nothing(boxes: np.ndarray, matrix: np.ndarray) -> None:
    camera, parts = Camera(matrix), parts_of(boxes)
    there = camera.to_first(parts)
    assert not np.allclose(there, parts)
    assert np.allclose(camera.from_first(there), parts)


def test_a_pose_turns_places_and_yaws_alike() -> None:
    along = np.array([np.cos(0.4), np.sin(0.4), 0.0])
    there = Camera(POSE).to_first(parts_of(SOLID))[0]
    turned = POSE[:3, :3] @ along
    assert np.allclose([np.cos(there[6]), np.sin(there[6])], turned[:2])
    assert np.allclose(there[:3], POSE[:3, :3] @ SOLID[0, :3] + POSE[:3, 3])


def test_overlaps_are_shares_of_the_union() -> None:
    boxes = np.array([[0.0, 0.0, 2.0, 2.0], [1.0, 0.0, 3.0, 2.0], [5.0, 5.0, 6.0, 6.0]])
    assert np.allclose(overlaps(boxes[:1], boxes), [[1.0, 1.0 / 3.0, 0.0]])
