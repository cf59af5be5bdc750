"""Learns from reports what nobody has said: noise, clutter, detection, speed."""

from trackweave.estimation.estimate import Estimates, SensorEstimate, estimate

__all__ = ["Estimates", "SensorEstimate", "estimate"]
