"""Boxes about places, and a tracker that knows somebody."""

from typing import Any

import numpy as np

import trackweave as tw

Array = np.ndarray[Any, Any]
SIZE = np.array([20.0, 40.0])
SURE = 0.95  # a score


def box(x: float, y: float = 0.0) -> list[float]:
    """Return a box in the image about a place."""
    return [x - SIZE[0] / 2, y - SIZE[1] / 2, x + SIZE[0] / 2, y + SIZE[1] / 2]


def solid(x: float, y: float, yaw: float = 0.0) -> list[float]:
    """Return a car's box about a place [m]."""
    return [x, y, 0.8, 4.0, 1.8, 1.6, yaw]


def followed(n_frames: int = 10, **options: Any) -> tw.BoxTracker:
    """Return a tracker that knows of an object at x = n_frames · 2, two pixels on each frame."""
    tracker = tw.BoxTracker(**options)
    for k in range(n_frames):
        tracker.update([box(2.0 * k)], scores=[SURE])
    return tracker
