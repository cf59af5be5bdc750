"""How far tracks are from the truth. Nothing here uses the project's own solvers."""

from trackweave.metrics.assignments import AssignmentQuality, assignment_quality
from trackweave.metrics.clear_mot import ClearMot, clear_mot
from trackweave.metrics.evaluate import Evaluation, evaluate
from trackweave.metrics.gospa import Gospa, gospa, ospa
from trackweave.metrics.hota import Hota, hota
from trackweave.metrics.identity import Identity, identity
from trackweave.metrics.moments import Moment, Moments, align
from trackweave.metrics.ospa2 import Ospa2, ospa2
from trackweave.metrics.pairing import Pairs, pair_over_time
from trackweave.metrics.targets import TargetRecord, target_records

__all__ = [
    "AssignmentQuality",
    "ClearMot",
    "Evaluation",
    "Gospa",
    "Hota",
    "Identity",
    "Moment",
    "Moments",
    "Ospa2",
    "Pairs",
    "TargetRecord",
    "align",
    "assignment_quality",
    "clear_mot",
    "evaluate",
    "gospa",
    "hota",
    "identity",
    "ospa",
    "ospa2",
    "pair_over_time",
    "target_records",
]
