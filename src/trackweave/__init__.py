"""Turns reports of many sensors into tracks of many objects.

Names are imported when they are first used, so that ``import trackweave`` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from trackweave.association.certificate import Certificate as Certificate
    from trackweave.association.certificate import Status as Status
    from trackweave.association.chain_rule import TrackEstimates as TrackEstimates
    from trackweave.association.chain_rule import track_chains as track_chains
    from trackweave.association.growth_limits import GrowthLimits as GrowthLimits
    from trackweave.association.plots_rule import PlotsRule as PlotsRule
    from trackweave.association.plots_rule import SensorPlots as SensorPlots
    from trackweave.association.problem import Answer as Answer
    from trackweave.association.problem import AssignmentProblem as AssignmentProblem
    from trackweave.association.sampling import Sampling as Sampling
    from trackweave.association.scan_plots import plots_of as plots_of
    from trackweave.domain.foreign_kind import Measurement as Measurement
    from trackweave.domain.foreign_kind import Reported as Reported
    from trackweave.domain.foreign_kind import slope_of as slope_of
    from trackweave.domain.measurements import MeasurementKind as MeasurementKind
    from trackweave.domain.reports import ReportTable as ReportTable
    from trackweave.domain.scans import Scan as Scan
    from trackweave.domain.tracks import TrackTable as TrackTable
    from trackweave.domain.truth import TruthTable as TruthTable
    from trackweave.engine import EngineError as EngineError
    from trackweave.errors import DataFormatError as DataFormatError
    from trackweave.errors import InvalidInputError as InvalidInputError
    from trackweave.errors import NumericalError as NumericalError
    from trackweave.errors import OutputError as OutputError
    from trackweave.errors import TrackweaveError as TrackweaveError
    from trackweave.experiments import StudyResult as StudyResult
    from trackweave.experiments import TuningResult as TuningResult
    from trackweave.experiments import study as study
    from trackweave.experiments import tune as tune
    from trackweave.formats.reading import read_reports as read_reports
    from trackweave.fusion.associator import Association as Association
    from trackweave.fusion.associator import TrackAssociator as TrackAssociator
    from trackweave.fusion.bias import BiasModel as BiasModel
    from trackweave.fusion.bias_fit import NotObservableError as NotObservableError
    from trackweave.fusion.combine import Combination as Combination
    from trackweave.fusion.combine import SharedPrior as SharedPrior
    from trackweave.fusion.combine import combine as combine
    from trackweave.fusion.confirmation import Confirmation as Confirmation
    from trackweave.fusion.fuser import FusedPicture as FusedPicture
    from trackweave.fusion.fuser import TrackFuser as TrackFuser
    from trackweave.fusion.pictures import LocalPicture as LocalPicture
    from trackweave.fusion.registration import Registration as Registration
    from trackweave.fusion.registration import register as register
    from trackweave.fusion.statistic import Statistic as Statistic
    from trackweave.io.problem_file import read_problem as read_problem
    from trackweave.io.tracks_in import LocalTracks as LocalTracks
    from trackweave.io.tracks_in import read_local_tracks as read_local_tracks
    from trackweave.io.truth import read_tracks as read_tracks
    from trackweave.io.truth import read_truth as read_truth
    from trackweave.metrics import Evaluation as Evaluation
    from trackweave.models.coverage import FieldOfView as FieldOfView
    from trackweave.models.foreign_motion import MotionModel as MotionModel
    from trackweave.models.motion import ConstantAcceleration as ConstantAcceleration
    from trackweave.models.motion import ConstantVelocity as ConstantVelocity
    from trackweave.models.motion import CoordinatedTurn as CoordinatedTurn
    from trackweave.models.motion import Imm as Imm
    from trackweave.models.motion import RandomWalk as RandomWalk
    from trackweave.models.rotation import Rotation as Rotation
    from trackweave.models.sensors import Sensor as Sensor
    from trackweave.models.strength import StrengthModel as StrengthModel
    from trackweave.run import TrackingResult as TrackingResult
    from trackweave.run import track as track
    from trackweave.run.fusing import FusionResult as FusionResult
    from trackweave.run.fusing import fuse as fuse
    from trackweave.run.judging import evaluate as evaluate
    from trackweave.run.linking import link as link
    from trackweave.solvers import Annealing as Annealing
    from trackweave.solvers import AntSystem as AntSystem
    from trackweave.solvers import Auto as Auto
    from trackweave.solvers import Dual as Dual
    from trackweave.solvers import Exact as Exact
    from trackweave.solvers import Genetic as Genetic
    from trackweave.solvers import Greedy as Greedy
    from trackweave.solvers import Hint as Hint
    from trackweave.solvers import Islands as Islands
    from trackweave.solvers import ListGenetic as ListGenetic
    from trackweave.solvers import MBest as MBest
    from trackweave.solvers import Ranking as Ranking
    from trackweave.solvers import TabuSearch as TabuSearch
    from trackweave.solvers.solving import solve as solve
    from trackweave.trackers.boxes.box_tracker import BoxTracker as BoxTracker
    from trackweave.trackers.boxes.frames import BoxFrame as BoxFrame
    from trackweave.trackers.boxes.frames import BoxTrack as BoxTrack
    from trackweave.trackers.clock_guard import HeldScan as HeldScan
    from trackweave.trackers.fused_plots import FusedPlotsTracker as FusedPlotsTracker
    from trackweave.trackers.hypothesis import Amendment as Amendment
    from trackweave.trackers.hypothesis import Hypothesis as Hypothesis
    from trackweave.trackers.lifecycle import Lifecycle as Lifecycle
    from trackweave.trackers.multi_hypothesis import (
        MultiHypothesisTracker as MultiHypothesisTracker,
    )
    from trackweave.trackers.nearest_neighbour import (
        NearestNeighbourTracker as NearestNeighbourTracker,
    )
    from trackweave.trackers.plot_fusion import PlotFuser as PlotFuser
    from trackweave.trackers.static_objects import FoundObjects as FoundObjects
    from trackweave.trackers.static_objects import ObjectFinder as ObjectFinder
    from trackweave.trackers.window import Window as Window

# Where each public name lives.
_HOMES = {
    "Amendment": "trackweave.trackers.hypothesis",
    "Annealing": "trackweave.solvers",
    "Answer": "trackweave.association.problem",
    "AntSystem": "trackweave.solvers",
    "AssignmentProblem": "trackweave.association.problem",
    "Association": "trackweave.fusion.associator",
    "Auto": "trackweave.solvers",
    "BiasModel": "trackweave.fusion.bias",
    "BoxFrame": "trackweave.trackers.boxes.frames",
    "BoxTrack": "trackweave.trackers.boxes.frames",
    "BoxTracker": "trackweave.trackers.boxes.box_tracker",
    "Certificate": "trackweave.association.certificate",
    "Combination": "trackweave.fusion.combine",
    "Confirmation": "trackweave.fusion.confirmation",
    "ConstantAcceleration": "trackweave.models.motion",
    "ConstantVelocity": "trackweave.models.motion",
    "CoordinatedTurn": "trackweave.models.motion",
    "DataFormatError": "trackweave.errors",
    "Dual": "trackweave.solvers",
    "EngineError": "trackweave.engine",
    "Evaluation": "trackweave.metrics",
    "Exact": "trackweave.solvers",
    "FieldOfView": "trackweave.models.coverage",
    "FoundObjects": "trackweave.trackers.static_objects",
    "FusedPicture": "trackweave.fusion.fuser",
    "FusedPlotsTracker": "trackweave.trackers.fused_plots",
    "FusionResult": "trackweave.run.fusing",
    "Genetic": "trackweave.solvers",
    "Greedy": "trackweave.solvers",
    "GrowthLimits": "trackweave.association.growth_limits",
    "HeldScan": "trackweave.trackers.clock_guard",
    "Hint": "trackweave.solvers",
    "Hypothesis": "trackweave.trackers.hypothesis",
    "Imm": "trackweave.models.motion",
    "InvalidInputError": "trackweave.errors",
    "Islands": "trackweave.solvers",
    "Lifecycle": "trackweave.trackers.lifecycle",
    "ListGenetic": "trackweave.solvers",
    "LocalPicture": "trackweave.fusion.pictures",
    "LocalTracks": "trackweave.io.tracks_in",
    "MBest": "trackweave.solvers",
    "Measurement": "trackweave.domain.foreign_kind",
    "MeasurementKind": "trackweave.domain.measurements",
    "MotionModel": "trackweave.models.foreign_motion",
    "MultiHypothesisTracker": "trackweave.trackers.multi_hypothesis",
    "NearestNeighbourTracker": "trackweave.trackers.nearest_neighbour",
    "NotObservableError": "trackweave.fusion.bias_fit",
    "NumericalError": "trackweave.errors",
    "ObjectFinder": "trackweave.trackers.static_objects",
    "OutputError": "trackweave.errors",
    "PlotFuser": "trackweave.trackers.plot_fusion",
    "PlotsRule": "trackweave.association.plots_rule",
    "RandomWalk": "trackweave.models.motion",
    "Ranking": "trackweave.solvers",
    "Registration": "trackweave.fusion.registration",
    "ReportTable": "trackweave.domain.reports",
    "Reported": "trackweave.domain.foreign_kind",
    "Rotation": "trackweave.models.rotation",
    "Sampling": "trackweave.association.sampling",
    "Scan": "trackweave.domain.scans",
    "Sensor": "trackweave.models.sensors",
    "SensorPlots": "trackweave.association.plots_rule",
    "SharedPrior": "trackweave.fusion.combine",
    "Statistic": "trackweave.fusion.statistic",
    "Status": "trackweave.association.certificate",
    "StrengthModel": "trackweave.models.strength",
    "StudyResult": "trackweave.experiments",
    "TabuSearch": "trackweave.solvers",
    "TrackAssociator": "trackweave.fusion.associator",
    "TrackEstimates": "trackweave.association.chain_rule",
    "TrackFuser": "trackweave.fusion.fuser",
    "TrackTable": "trackweave.domain.tracks",
    "TrackingResult": "trackweave.run",
    "TrackweaveError": "trackweave.errors",
    "TruthTable": "trackweave.domain.truth",
    "TuningResult": "trackweave.experiments",
    "Window": "trackweave.trackers.window",
    "combine": "trackweave.fusion.combine",
    "evaluate": "trackweave.run.judging",
    "fuse": "trackweave.run.fusing",
    "link": "trackweave.run.linking",
    "plots_of": "trackweave.association.scan_plots",
    "read_local_tracks": "trackweave.io.tracks_in",
    "read_problem": "trackweave.io.problem_file",
    "read_reports": "trackweave.formats.reading",
    "read_tracks": "trackweave.io.truth",
    "read_truth": "trackweave.io.truth",
    "register": "trackweave.fusion.registration",
    "slope_of": "trackweave.domain.foreign_kind",
    "solve": "trackweave.solvers.solving",
    "study": "trackweave.experiments",
    "track": "trackweave.run",
    "track_chains": "trackweave.association.chain_rule",
    "tune": "trackweave.experiments",
}

__all__ = sorted([*_HOMES, "__version__"])


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("trackweave")
    if name not in _HOMES:
        raise AttributeError(f"module 'trackweave' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
