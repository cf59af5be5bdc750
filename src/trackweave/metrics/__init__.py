"""How far tracks are from the truth. Nothing here uses the project's own solvers."""

from trackweave.metrics.assignments import AssignmentQuality, assignment_quality
from trackweave.metrics.clear_mot import ClearMot, clear_mot
from trackweave.metrics.evaluate import Evaluation, evaluate
from trackweave.metrics.gospa import Gospa, gospa
from trackweave.metrics.hota import Hota, hota
from trackweave.metrics.identity import Identity, identity
from trackweave.metrics.moments import Moment, Moments, align
from trackweave.metrics.ospa import ospa

__all__ = [
    "AssignmentQuality",
    "ClearMot",
    "Evaluation",
    "Gospa",
    "Hota",
    "Identity",
    "Moment",
    "Moments",
    "align",
    "assignment_quality",
    "clear_mot",
    "evaluate",
    "gospa",
    "hota",
    "identity",
    "ospa",
]
