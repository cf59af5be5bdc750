"""Calls of everything public, one argument at a time replaced by what does not belong there."""

import datetime
import inspect
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from fractions import Fraction
from typing import Any

import numpy as np
import polars as pl

import trackweave as tw
from trackweave.errors import TrackweaveError


class Anything:
    """A class that can be called with anything."""

    def __init__(self, *_: Any, **__: Any) -> None: ...


HOSTILE: dict[str, Any] = {
    "None": None,
    "text": "x",
    "no text": "",
    "whole": 3,
    "number": 3.5,
    "NaN": float("nan"),
    "infinity": float("inf"),
    "minus infinity": float("-inf"),
    "minus one": -1,
    "zero": 0,
    "True": True,
    "list": [],
    "nested": [[1.0, 2.0], [3.0]],
    "names": ["a", "b"],
    "dict": {},
    "odd dict": {1: 2},
    "tuple": (),
    "object": object(),
    "class": Anything,
    "function": lambda *_, **__: None,
    "NumPy float": np.float32(0.5),
    "NumPy whole": np.int64(2),
    "NumPy text": np.str_("x"),
    "NumPy date": np.datetime64("2024-01-01T00:00:00", "ns"),
    "array of no dimension": np.array(2.0),
    "array": np.array([1.0, 2.0, 3.0]),
    "empty array": np.empty((0, 3)),
    "cube": np.ones((2, 2, 2)),
    "array of objects": np.array([object(), None]),
    "complex": 1 + 2j,
    "huge": 10**400,
    "large": 2**70,
    "tiny": 5e-324,
    "bytes": b"x",
    "complex array": np.array([1 + 2j]),
    "dates": np.array(["2024-01-01"], dtype="datetime64[ns]"),
    "set": {1.0},
    "date": datetime.datetime(2024, 1, 1),
    "fraction": Fraction(1, 3),
}


@dataclass(frozen=True)
class Call:
    """Something to call, with arguments that it takes."""

    name: str
    call: Callable[..., Any]
    arguments: Mapping[str, Any]

    def with_one_replaced(self) -> Iterator[tuple[str, str, dict[str, Any]]]:
        """Yield the argument, the hostile value's name and all arguments."""
        known = inspect.signature(self.call).parameters
        for argument in [*known]:
            if known[argument].kind is inspect.Parameter.VAR_KEYWORD:
                continue
            for label, value in HOSTILE.items():
                yield argument, label, {**self.arguments, argument: value}


def outcome(call: Callable[..., Any], arguments: Mapping[str, Any]) -> BaseException | None:
    """Return what a call raises that is not ours, None where it raises nothing or ours."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            call(**arguments)
        except TrackweaveError as err:
            return None if str(err) else err
        except Exception as err:
            return err
    return None


def numpy_twins(value: Any) -> Iterator[Any]:
    """Yield what stands for the same value: NumPy's scalars, arrays, lists for tuples."""
    if isinstance(value, Enum):
        return
    if isinstance(value, bool):
        yield from (np.bool_(value), np.array(value))
    elif isinstance(value, int):
        yield from (np.int64(value), np.array(value))
        yield from [np.uint8(value)] if 0 <= value < 256 else []
    elif isinstance(value, float):
        yield from (np.float64(value), np.array(value))
        if float(np.float32(value)) == value:
            yield np.float32(value)
    elif isinstance(value, str):
        yield np.str_(value)
    elif isinstance(value, tuple) and value:
        yield list(value)
        if all(isinstance(item, float) for item in value):
            yield np.array(value)
    elif isinstance(value, list) and value:
        yield tuple(value)


def same(first: Any, second: Any) -> bool:
    """Tell whether two values are the same to the last digit and of the same kinds."""
    if type(first) is not type(second):
        return False
    if is_dataclass(first) and not isinstance(first, type):
        names = [field.name for field in fields(first) if field.init]
        return all(same(getattr(first, n), getattr(second, n)) for n in names)
    if isinstance(first, np.ndarray):
        return first.dtype == second.dtype and np.array_equal(
            first, second, equal_nan=first.dtype.kind == "f"
        )
    if isinstance(first, tuple | list):
        return len(first) == len(second) and all(map(same, first, second))
    return bool(first == second)


# ------------------------------------------------------------------------------------ arguments

EYE = np.eye(4)[None] * 9.0
STATE = np.array([[10.0, 20.0, 1.0, 0.0]])


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def table() -> tw.TrackTable:
    """Return two rows of one confirmed track."""
    return tw.TrackTable(
        time=np.array([0.0, 1.0]), track=np.array([1, 1]), status=np.array([1, 1]),
        mean=np.repeat(STATE, 2, axis=0), covariance=np.repeat(EYE, 2, axis=0),
        score=np.array([-3.0, -5.0]), hits=np.array([3, 4]), last_update=np.array([0.0, 1.0]),
    )  # fmt: skip


def truth() -> tw.TruthTable:
    return tw.TruthTable.from_columns([0.0, 1.0], ["a", "a"], [[10.0, 20.0], [11.0, 20.0]])


def picture(sensor: str = "A", time: float = 0.0) -> tw.LocalPicture:
    return tw.LocalPicture(sensor, time, np.array([1]), STATE, EYE)


def sensor() -> tw.Sensor:
    return tw.Sensor("radar", sigma=(5.0, 5.0), scan_period=1.0)


def scan(time: float = 0.0) -> tw.Scan:
    return tw.Scan(time=time, sensor="radar", measurement=[[10.0, 20.0]])


MOTION = {"process_noise": 0.5, "max_speed": 20.0}
TUPLES = {"tuples": [[1, 1], [1, 2], [2, 1]], "costs": [-1.0, -2.0, -1.5], "alone": 0.0}
COLUMNS: dict[str, list[Any]] = {
    "time": [0.0, 0.0, 1.0, 1.0], "sensor": ["a", "a", "a", "a"],
    "x": [0.0, 50.0, 1.0, 51.0], "y": [0.0, 10.0, 0.0, 10.0],
}  # fmt: skip


def parameters(kind: type) -> dict[str, Any]:
    """Return the defaults of a dataclass that has one for each field."""
    value = kind()
    return {field.name: getattr(value, field.name) for field in fields(value) if field.init}


def problem() -> tw.AssignmentProblem:
    return tw.AssignmentProblem.from_tuples(**TUPLES)


def plots() -> tw.SensorPlots:
    return tw.SensorPlots(value=np.array([[0.0, 0.0]]), sigma=1.0, volume=1e4, false_alarms=1.0)


def tracker(**options: Any) -> tw.MultiHypothesisTracker:
    given: dict[str, Any] = {"motion": tw.ConstantVelocity(**MOTION), "sensors": [sensor()]}
    return tw.MultiHypothesisTracker(**{**given, **options})


def box_frame(boxes: Any, scores: Any, classes: Any, time: Any, data: Any, camera: Any) -> Any:
    """Return what a box tracker says of its first frame."""
    return tw.BoxTracker().update(boxes, scores, classes, time, data, camera)


def constructors() -> list[Call]:
    """Return the public classes whose objects users make, with arguments."""
    simple = [
        tw.Annealing, tw.AntSystem, tw.Auto, tw.BiasModel, tw.Combination, tw.Confirmation,
        tw.Dual, tw.Exact, tw.FieldOfView, tw.Genetic, tw.GrowthLimits, tw.Greedy, tw.Islands,
        tw.Lifecycle, tw.ListGenetic, tw.MBest, tw.Sampling, tw.Statistic,
        tw.TabuSearch, tw.TrackAssociator, tw.TrackFuser, tw.Window,
    ]  # fmt: skip
    modes = (tw.ConstantVelocity(**MOTION), tw.CoordinatedTurn(0.1, 1e-3, 20.0, 0.2))
    rows = {name: getattr(table(), name) for name in tw.TrackTable.__dataclass_fields__}
    named: dict[type, dict[str, Any]] = {
        tw.ConstantVelocity: MOTION,
        tw.ConstantAcceleration: {**MOTION, "max_acceleration": 2.0},
        tw.CoordinatedTurn: {**MOTION, "turn_noise": 1e-3, "max_turn_rate": 0.2},
        tw.RandomWalk: MOTION,
        tw.Imm: {"models": modes, "sojourn_time": (30.0, 10.0)},
        tw.Rotation: {"period": 4.0, "phase": 0.0, "direction": 1},
        tw.StrengthModel: {
            "target_mean": 10.0, "target_sigma": 2.0, "clutter_mean": 3.0, "clutter_sigma": 2.0,
        },
        tw.Sensor: {
            "name": "radar", "sigma": (5.0, 5.0), "detection_probability": 0.5,
            "clutter_density": 0.25, "scan_period": 4.0, "position": (0.0, 1.0),
            "identity_error": 0.5, "measurement": tw.MeasurementKind.POSITION,
        },
        tw.Scan: {"time": 1.0, "sensor": "radar", "measurement": [[1.0, 2.0]]},
        tw.LocalPicture: {
            "sensor": "A", "time": 1.0, "track": [1], "mean": STATE, "covariance": EYE,
        },
        tw.TrackTable: rows,
        tw.TrackEstimates: {"mean": STATE, "covariance": EYE},
        tw.SharedPrior: {
            "mean": STATE, "covariance": EYE, "local_mean": STATE, "local_covariance": EYE,
        },
        tw.SensorPlots: {
            "value": [[0.0, 0.0]], "sigma": 1.0, "volume": 1e4, "false_alarms": 1.0,
            "detection_probability": 0.5,
        },
        tw.PlotsRule: {"object_density": 1e-4, "gate": 16.0, "max_tuples": 1000},
        tw.ObjectFinder: {"cutoff": 50.0, "least_probability": 0.5},
        tw.PlotFuser: {"sensors": [sensor()], "rule": tw.PlotsRule(object_density=1e-4)},
        tw.AssignmentProblem: {
            "parent": [-1, 0], "item": [0, 1], "cost": [-1.0, -2.0], "total": [-1.0, -2.0],
            "must_cover": [0, 0], "instant": [0, 1], "base_cost": 0.5, "unit": 1.0,
        },
    }  # fmt: skip
    return [Call(kind.__name__, kind, parameters(kind)) for kind in simple] + [
        Call(kind.__name__, kind, arguments) for kind, arguments in named.items()
    ]


def functions() -> list[Call]:
    """Return the public functions and methods, with arguments."""
    both = [picture("A"), picture("B")]
    later = [picture("A", 1.0), picture("B", 1.0)]
    return [
        Call("AssignmentProblem.from_tuples", tw.AssignmentProblem.from_tuples, TUPLES),
        Call("AssignmentProblem.from_array", tw.AssignmentProblem.from_array,
             {"costs": [[1.0, 2.0], [3.0, 4.0]], "alone": 0.0}),
        Call("solve", tw.solve,
             {"problem": problem(), "solver": tw.Greedy(), "rng": rng(), "time_limit": 10.0}),
        *(Call(f"{solver.__name__}()", solver(), {"problem": problem(), "rng": rng()})
          for solver in (tw.Greedy, tw.Dual, tw.Exact, tw.Auto, tw.Annealing, tw.MBest)),
        Call("Annealing.start", tw.Annealing().start, {"problem": problem(), "rng": rng()}),
        Call("Hint", lambda prices, nodes: tw.solve(
            problem(), tw.Dual(), rng=rng(), hint=tw.Hint(prices, nodes)),
             {"prices": None, "nodes": None}),
        Call("MBest.rank", tw.MBest().rank, {"problem": problem(), "rng": rng()}),
        Call("PlotsRule()", tw.PlotsRule(object_density=1e-4), {"sensors": [plots(), plots()]}),
        Call("slope_of", tw.slope_of, {"function": np.sin, "states": [[1.0, 2.0]]}),
        Call("plots_of", tw.plots_of, {
            "scan": scan(), "sensor": sensor(), "dim": 2, "time": 1.0, "speed": 2.0, "start": 0.0,
            "volume": 1e4,
        }),
        Call("combine", tw.combine, {
            "mean": np.stack([STATE[0], STATE[0]]), "covariance": np.concatenate([EYE, EYE]),
            "method": "convex",
        }),
        Call("track_chains", tw.track_chains, {
            "sensors": [tw.TrackEstimates(STATE, EYE)] * 2, "false_rejection": 0.25,
            "max_tuples": 100,
        }),
        Call("register", tw.register, {
            "reference": [both[0], later[0]], "other": [both[1], later[1]], "process_noise": 1.0,
            "model": tw.BiasModel(estimate=("translation",)), "pairs": [[1, 1]],
        }),
        Call("TrackFuser.step", lambda time, pictures, rng: tw.TrackFuser().step(
            time, pictures, rng=rng),
             {"time": 1.0, "pictures": {"A": both[0], "B": both[1]}, "rng": rng()}),
        Call("TrackAssociator.step", lambda time, pictures, rng: tw.TrackAssociator().step(
            time, pictures, rng=rng),
             {"time": 1.0, "pictures": {"A": both[0], "B": both[1]}, "rng": rng()}),
        Call("link", tw.link, {
            "features": pl.DataFrame({"frame": [0, 1], "x": [1.0, 2.0], "y": [1.0, 1.0]}),
            "search_range": 3.0, "memory": 0, "pos_columns": ["x", "y"], "t_column": "frame",
        }),
        Call("LocalPicture.predicted", both[0].predicted, {"time": 1.0, "process_noise": 1.0}),
        Call("LocalPicture.empty", tw.LocalPicture.empty, {"sensor": "A", "time": 1.0, "dim": 2}),
        Call("SharedPrior.common", tw.SharedPrior.common,
             {"mean": STATE[0], "covariance": EYE[0], "n_local": 2}),
        Call("Confirmation.parse", tw.Confirmation.parse, {"text": "3/4"}),
        Call("Sensor.sigmas", sensor().sigmas, {"dim": 2}),
        Call("TruthTable.from_columns", tw.TruthTable.from_columns, {
            "time": [0.0, 1.0], "target": ["a", "b"], "position": [[0.0, 1.0], [2.0, 3.0]],
        }),
        Call("TrackTable.empty", tw.TrackTable.empty, {"dim": 2}),
        Call("evaluate", tw.evaluate, {
            "truth": truth(), "tracks": table(), "cutoff": 50.0, "order": 2.0, "window": 10,
        }),
        Call("read_reports", tw.read_reports, {"source": COLUMNS_FRAME, "told": None}),
        Call("read_truth", tw.read_truth, {"source": TRUTH_FRAME}),
        Call("read_tracks", tw.read_tracks, {"source": LOCAL_FRAME}),
        Call("read_problem", tw.read_problem, {"source": PROBLEM_FRAME}),
        Call("read_local_tracks", tw.read_local_tracks, {"source": LOCAL_FRAME}),
        Call("fuse", tw.fuse, {"tracks": {"A": LOCAL_FRAME, "B": LOCAL_FRAME}, "rng": rng()}),
        Call("MultiHypothesisTracker", tw.MultiHypothesisTracker, {
            "motion": tw.ConstantVelocity(**MOTION), "sensors": [sensor()], "window": 3, "dim": 2,
        }),
        Call("MultiHypothesisTracker.step", lambda scan, rng, deadline, stop: tracker().step(
            scan, rng=rng, deadline=deadline, stop=stop),
             {"scan": scan(), "rng": rng(), "deadline": 9.0, "stop": None}),
        Call("ObjectFinder()", tw.ObjectFinder(cutoff=50.0), {
            "scored": tw.PlotsRule(object_density=1e-4)([plots(), plots()]), "rng": rng(),
        }),
        Call("PlotFuser()", tw.PlotFuser([sensor()], tw.PlotsRule(object_density=1e-4)), {
            "scans": [scan()], "rng": rng(),
        }),
        Call("BoxTracker", tw.BoxTracker, {
            "period": 0.5, "distance": "centre", "scores": "probability", "coming": 1.0,
            "confirm": 0.5, "rejoin": 2.0, "window": 2, "delay": 1,
        }),
        Call("BoxTracker.update", box_frame, {
            "boxes": [[0.0, 0.0, 2.0, 4.0]], "scores": [0.5], "classes": ["a"], "time": 2.0,
            "data": ["x"], "camera": [[1.0, 0.0, 2.0], [0.0, 1.0, 3.0]],
        }),
        Call("BoxTracker.update (3-D)", box_frame, {
            "boxes": [[0.0, 0.0, 0.0, 4.0, 2.0, 1.5, 0.5]], "scores": None, "classes": [3],
            "time": None, "data": None, "camera": np.eye(4),
        }),
        Call("NearestNeighbourTracker", tw.NearestNeighbourTracker, {
            "motion": tw.ConstantVelocity(**MOTION), "sensors": [sensor()], "gate": 9.0, "dim": 2,
        }),
        Call("FusedPlotsTracker", tw.FusedPlotsTracker, {
            "fuser": tw.PlotFuser([sensor()], tw.PlotsRule(object_density=1e-4)),
            "tracker": tracker(),
        }),
    ]  # fmt: skip


def _frames() -> tuple[Any, ...]:
    state = {"x": 10.0, "y": 20.0, "vx": 1.0, "vy": 0.0}
    spread = {f"p_{a}_{b}": 9.0 * (a == b) for k, a in enumerate(state) for b in list(state)[k:]}
    return (
        pl.DataFrame({"time": [0.0], "track": [1], "status": ["confirmed"]}).with_columns(
            **{name: pl.lit(value) for name, value in (state | spread).items()}
        ),
        pl.DataFrame(COLUMNS),
        pl.DataFrame({"time": [0.0], "target": ["a"], "x": [1.0], "y": [2.0]}),
        pl.DataFrame({"i1": [1], "i2": [1], "cost": [-1.0]}),
    )


LOCAL_FRAME, COLUMNS_FRAME, TRUTH_FRAME, PROBLEM_FRAME = _frames()
