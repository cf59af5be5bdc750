"""One run: reports in, the configuration filled, every scan stepped through, results out."""

from trackweave.run.tracking import RunValues, TrackingResult, settings_for, track

__all__ = ["RunValues", "TrackingResult", "settings_for", "track"]
