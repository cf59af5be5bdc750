"""Learns from reports what nobody has said: noise, clutter, detection, speed, turns."""

from trackweave.estimation.coverage import covered, fields_of_view
from trackweave.estimation.directions import bearing_sensor, with_components
from trackweave.estimation.echoes import without_echoes
from trackweave.estimation.estimate import estimate
from trackweave.estimation.estimates import Estimates, SensorEstimate, digits
from trackweave.estimation.plausibility import believable
from trackweave.estimation.refine import (
    Followed,
    refined,
    stretch_of,
    sure_tracks,
)
from trackweave.estimation.standing import with_standing
from trackweave.estimation.strengths import with_strengths
from trackweave.estimation.tails import with_tails

__all__ = [
    "Estimates",
    "Followed",
    "SensorEstimate",
    "bearing_sensor",
    "believable",
    "covered",
    "digits",
    "estimate",
    "fields_of_view",
    "refined",
    "stretch_of",
    "sure_tracks",
    "with_components",
    "with_standing",
    "with_strengths",
    "with_tails",
    "without_echoes",
]
