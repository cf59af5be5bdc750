"""Learns from reports what nobody has said: noise, clutter, detection, speed."""

from trackweave.estimation.estimate import Estimates, SensorEstimate, estimate
from trackweave.estimation.refine import Followed, refined, stretch_of

__all__ = ["Estimates", "Followed", "SensorEstimate", "estimate", "refined", "stretch_of"]
