"""One run: reports in, the configuration filled, every scan stepped through, results out."""

from trackweave.run.result import RunValues, TrackingResult
from trackweave.run.tracking import settings_for, track

__all__ = ["RunValues", "TrackingResult", "settings_for", "track"]
