"""One run: reports in, the configuration filled, every scan stepped through, results out."""

from trackweave.run.result import RunValues, TrackingResult
from trackweave.run.tracking import track

__all__ = ["RunValues", "TrackingResult", "track"]
