"""SORT, ByteTrack and norfair on the same boxes, with their defaults or documented values."""

import warnings
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np
from boxes_data import Found, Sequence


def peers() -> dict[str, Callable[[Sequence], list[Found]]]:
    """Return every peer that is installed, by name with its version."""
    found: dict[str, Callable[[Sequence], list[Found]]] = {}
    for name, package, call in (
        ("SORT", "trackers", _sort),
        ("SORT, as published", "trackers", _sort_published),
        ("ByteTrack", "supervision", _bytetrack),
        ("ByteTrack", "trackers", _bytetrack_newer),
        ("norfair", "norfair", _norfair),
    ):
        try:
            found[f"{name} ({package} {version(package)})"] = call
        except ImportError:
            continue
    return found


def _sort(one: Sequence) -> list[Found]:
    from trackers import SORTTracker

    return _supervised(one, SORTTracker(frame_rate=1.0 / one.period).update)


def _sort_published(one: Sequence) -> list[Found]:
    """SORT with its authors' values: ended after one frame without a box, named after three."""
    from trackers import SORTTracker

    tracker = SORTTracker(
        lost_track_buffer=1, frame_rate=30.0, minimum_consecutive_frames=3,
        minimum_iou_threshold=0.3, track_activation_threshold=-np.inf,
    )  # fmt: skip
    return _supervised(one, tracker.update)


def _bytetrack(one: Sequence) -> list[Found]:
    import supervision

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        tracker = supervision.ByteTrack(frame_rate=round(1.0 / one.period))
    return _supervised(one, tracker.update_with_detections)


def _bytetrack_newer(one: Sequence) -> list[Found]:
    from trackers import ByteTrackTracker

    return _supervised(one, ByteTrackTracker(frame_rate=1.0 / one.period).update)


def _supervised(one: Sequence, update: Callable[[Any], Any]) -> list[Found]:
    """Follow boxes by what takes and returns supervision's detections."""
    import supervision

    found = []
    for frame, seen in enumerate(one.frames):
        kinds = np.zeros(len(seen.box), dtype=int)
        given = supervision.Detections(
            xyxy=seen.box.reshape(-1, 4), confidence=seen.score, class_id=kinds
        )
        named = update(given)
        if named.tracker_id is None:
            continue
        for who, box in zip(named.tracker_id, named.xyxy, strict=True):
            if who >= 0:
                found.append(Found(frame, int(who), box))
    return found


def _norfair(one: Sequence) -> list[Found]:
    """Norfair as its documentation's MOTChallenge demo has it, which writes all tracks."""
    from norfair import Detection, Tracker
    from norfair.filter import FilterPyKalmanFilterFactory

    tracker = Tracker(
        distance_function="iou_opt", distance_threshold=0.9, detection_threshold=0.5,
        pointwise_hit_counter_max=3, hit_counter_max=8,
        filter_factory=FilterPyKalmanFilterFactory(),
    )  # fmt: skip
    found = []
    for frame, seen in enumerate(one.frames):
        given = [
            Detection(box.reshape(2, 2), scores=np.array([score, score]))
            for box, score in zip(seen.box, seen.score, strict=True)
        ]
        for track in tracker.update(detections=given):
            found.append(Found(frame, int(track.id), track.estimate.reshape(4)))
    return found
