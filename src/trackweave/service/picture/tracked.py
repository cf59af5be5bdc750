"""What reports tell of the tracks that took them: their identities and heights."""

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.plotting.scene import Scene

__all__ = ["heights_of", "identities_of"]


def identities_of(scene: Scene) -> dict[int, str]:
    """Return the identity that most reports of each track told, by the track's number."""
    reports = scene.reports
    if reports is None or reports.identity is None or scene.assignment is None:
        return {}
    counts: dict[int, dict[int, int]] = {}
    for row, track in scene.assignment.items():
        told = int(reports.identity[row])
        if told >= 0:
            own = counts.setdefault(track, {})
            own[told] = own.get(told, 0) + 1
    return {
        track: str(reports.identities[max(own, key=lambda told: (own[told], -told))])
        for track, own in counts.items()
    }


def heights_of(scene: Scene) -> FloatArray | None:
    """Return the height of each row of tracks [m], None where nothing is known of heights."""
    # Tracks of two dimensions have those that their reports told, and between them what lies on a
    # straight line.
    tracks, reports = scene.tracks, scene.reports
    if tracks.dim == 3:
        return tracks.mean[:, 2]
    if reports is None or reports.height is None or not scene.assignment:
        return None
    rows = np.array(sorted(scene.assignment), dtype=np.int64)
    rows = rows[np.isfinite(reports.height[rows])]
    took = np.array([scene.assignment[row] for row in rows.tolist()], dtype=np.int64)
    heights = np.full(len(tracks), np.nan)
    for track in np.unique(took).tolist():
        own, told = np.flatnonzero(tracks.track == track), rows[took == track]
        heights[own] = np.interp(tracks.time[own], reports.time[told], reports.height[told])
    return heights if np.isfinite(heights).any() else None
