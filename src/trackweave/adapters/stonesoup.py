"""Stone Soup both ways: its detections and truths in, its tracks out, our tracker as one of its.

Needs the package: ``pip install 'trackweave[stonesoup]'``. States of Stone Soup are x, vx, y, vy
(then z, vz), as its constant-velocity models have them.
"""

from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np
import polars as pl
from stonesoup.base import Property
from stonesoup.models.measurement.nonlinear import CartesianToBearingRange
from stonesoup.tracker.base import Tracker
from stonesoup.types.hypothesis import SingleHypothesis
from stonesoup.types.prediction import GaussianStatePrediction
from stonesoup.types.track import Track
from stonesoup.types.update import GaussianStateUpdate

from trackweave.arrays import FloatArray
from trackweave.domain.scans import Scan
from trackweave.domain.tracks import TENTATIVE, TrackTable
from trackweave.errors import InvalidInputError
from trackweave.io.reports import ONLY_SENSOR, reports_in
from trackweave.io.tables import load_table
from trackweave.randomness import generator_of
from trackweave.run.result import TrackingResult
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker

__all__ = ["StoneSoupTracker", "reports_of", "tracks_of", "truth_of"]

_AXES = ("x", "y", "z")


def reports_of(detections: Iterable[Any]) -> pl.DataFrame:
    """Return detections as a table of reports, in their order.

    Parameters
    ----------
    detections
        Stone Soup's ``Detection``, positions or ranges with bearings from where their measurement
        model stands. ``metadata["sensor"]`` names the sensor.

    Returns
    -------
    A table for ``trackweave.track``.

    Raises
    ------
    InvalidInputError
        If a detection has no time, or its model is another.
    """
    rows = [_row(each) for each in _listed(detections)]
    return pl.DataFrame(rows, infer_schema_length=None) if rows else pl.DataFrame()


def truth_of(paths: Iterable[Any]) -> pl.DataFrame:
    """Return ground truth paths as a table of truth: ``time,target,x,y``."""
    rows = [
        {"time": _moment(state.timestamp), "target": str(path.id), **_position(state, (0, 2))}
        for path in paths
        for state in path
    ]
    return pl.DataFrame(rows)


def tracks_of(result: TrackingResult[Any], detections: Iterable[Any] = ()) -> set[Track]:
    """Return smoothed tracks of a run as Stone Soup's.

    Parameters
    ----------
    result
        What ``trackweave.track`` found of ``reports_of(detections)``.
    detections
        The detections again; a state at which a track has one is an update with it, any other a
        prediction.

    Returns
    -------
    Tracks with states of Gaussian uncertainty.

    Raises
    ------
    InvalidInputError
        If there are fewer detections than reports, or they are none of Stone Soup's.
    """
    every, values = _listed(detections), result.values
    times, numbers = values.reports.time, values.reports.row
    count = len(times) if numbers is None else int(numbers.max(initial=0))
    if every and len(every) < count:
        raise InvalidInputError(
            f"detections: {len(every):,} of them, of {count:,} reports; expected all detections "
            "that the reports were made of, in their order, or none"
        )
    owned: dict[tuple[int, float], Any] = {}
    for row, track in values.assignment.items():
        record = row if numbers is None else int(numbers[row]) - 1
        if record < len(every):
            owned[track, float(times[row])] = every[record]
    found: dict[int, Track] = {}
    history = values.history
    for place in np.flatnonzero(history.status != TENTATIVE):
        number, time = int(history.track[place]), float(history.time[place])
        state = _state(history, int(place), owned.get((number, time)))
        found.setdefault(number, Track(id=str(number))).append(state)
    return set(found.values())


class StoneSoupTracker(Tracker):  # type: ignore[misc]
    """A multi-hypothesis tracker that iterates over a detector, as Stone Soup's trackers do.

    Every set of detections is one scan of the sensor that the configuration names.
    """

    detector: Iterable[Any] = Property(doc="Yields times and sets of detections of positions.")
    config: Mapping[str, Any] = Property(
        doc="A configuration that leaves neither noise nor clutter open, as tracker.toml has it."
    )
    seed: int = Property(default=0, doc="Seed of the random numbers.")

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._tracker: Any = MultiHypothesisTracker.from_config(self.config)
        self._rng = generator_of(self.seed)
        self._steps: Iterator[tuple[datetime, set[Any]]] = iter(self.detector)
        self._known: dict[int, Track] = {}
        self._live: set[Track] = set()
        self._last = -np.inf

    @property
    def tracks(self) -> set[Track]:
        """The confirmed tracks that are alive."""
        return self._live

    def __iter__(self) -> Iterator[tuple[datetime, set[Track]]]:
        return self

    def __next__(self) -> tuple[datetime, set[Track]]:
        """Return the next time and the tracks then."""
        time, detections = next(self._steps)
        moment = _moment(time).timestamp()
        if moment < self._last:
            raise InvalidInputError(
                f"detector: time {time}, {self._last - moment:.6g} s before the one yielded last; "
                "expected times that do not go backwards"
            )
        self._last = moment
        ordered = _listed(detections)
        hypothesis = self._tracker.step(_scan(moment, ordered), rng=self._rng)
        table: TrackTable = hypothesis.tracks
        self._live = set()
        for place in np.flatnonzero(table.status != TENTATIVE):
            number = int(table.track[place])
            track = self._known.setdefault(number, Track(id=str(number)))
            is_update = table.last_update[place] == table.time[place]
            near = _nearest(ordered, table.mean[place]) if is_update else None
            track.append(_state(table, int(place), near))
            self._live.add(track)
        return time, self._live


def _scan(moment: float, detections: list[Any]) -> Scan:
    if not detections:
        return Scan(time=moment, sensor=ONLY_SENSOR, measurement=np.empty((0, 0)))
    table = reports_of(detections).drop("sensor", strict=False)
    (scan,) = reports_in(load_table(table.with_columns(time=pl.lit(moment)))).scans()
    return Scan(
        time=moment, sensor=ONLY_SENSOR, measurement=scan.measurement, sigma=scan.sigma,
        platform=scan.platform,
    )  # fmt: skip


def _nearest(detections: list[Any], mean: FloatArray) -> Any:
    """Return the detection of a position nearest to a track that took one, None of directions."""
    places = [_row(each) for each in detections]
    near = [each for each, row in zip(detections, places, strict=True) if "x" in row]
    if not near:
        return None
    return min(near, key=lambda each: float(np.hypot(*(_vector(each)[:2] - mean[:2]))))


def _state(table: TrackTable, place: int, detection: Any) -> Any:
    """Return a state in Stone Soup's order, an update where there is a detection of it."""
    dim = table.dim
    order = np.arange(2 * dim).reshape(2, dim).T.ravel()
    time = datetime.fromtimestamp(float(table.time[place]), tz=UTC).replace(tzinfo=None)
    told = {
        "state_vector": table.mean[place][order],
        "covar": table.covariance[place][np.ix_(order, order)],
        "timestamp": time,
    }
    if detection is None:
        return GaussianStatePrediction(**told)
    return GaussianStateUpdate(**told, hypothesis=SingleHypothesis(None, detection))


def _listed(detections: Any) -> list[Any]:
    """Return detections as a list, and refuse what are none."""
    if not isinstance(detections, Iterable):
        raise InvalidInputError(f"detections: {detections!r:.60}; expected several Detections")
    every = list(detections)
    for number, each in enumerate(every):
        for name in ("state_vector", "timestamp", "measurement_model", "metadata"):
            if not hasattr(each, name):
                raise InvalidInputError(
                    f"detections[{number}]: {each!r:.60}, without {name}; expected a Detection of "
                    "Stone Soup"
                )
    return every


def _row(detection: Any) -> dict[str, Any]:
    model, vector = detection.measurement_model, _vector(detection)
    sensor = (detection.metadata or {}).get("sensor", ONLY_SENSOR)
    row: dict[str, Any] = {"time": _moment(detection.timestamp), "sensor": str(sensor)}
    noise = None if model is None else np.sqrt(np.diag(np.asarray(model.covar(), np.float64)))
    if type(model) is CartesianToBearingRange:
        if np.any(np.asarray(model.rotation_offset, np.float64)):
            raise InvalidInputError("detection: a sensor that is turned; expected north upwards")
        bearing, far = vector[:2]
        place = np.asarray(model.translation_offset, np.float64).ravel()
        # Counter-clockwise from east there, clockwise from north here.
        row |= {"range_m": float(far), "azimuth_deg": float(np.degrees(np.pi / 2 - bearing) % 360)}
        row |= {"sensor_x": float(place[0]), "sensor_y": float(place[1])}
        if noise is not None:
            row |= {"sigma_range_m": float(noise[1])}
            row |= {"sigma_azimuth_deg": float(np.degrees(noise[0]))}
        return row
    if vector.size not in (2, 3) or (model is not None and not hasattr(model, "matrix")):
        name = type(model).__name__
        raise InvalidInputError(
            f"detection: {vector.size} numbers of {name}; expected positions, or "
            "CartesianToBearingRange"
        )
    vector, noise = _as_axes(model, vector, noise)
    row |= {axis: float(value) for axis, value in zip(_AXES, vector, strict=False)}
    if noise is not None:
        row |= {f"sigma_{a}": float(s) for a, s in zip(_AXES, noise, strict=False)}
    return row


def _as_axes(
    model: Any, vector: FloatArray, noise: FloatArray | None
) -> tuple[FloatArray, FloatArray | None]:
    """Return what a linear model measures in the order x, y (z), by the states it sees."""
    if model is None or noise is None:
        return vector, noise
    covariance = np.asarray(model.covar(), np.float64)
    if np.any(covariance != np.diag(np.diag(covariance))):
        raise InvalidInputError(
            "detection: noise that is correlated between axes; expected a diagonal covariance"
        )
    order = np.argsort([int(place) for place in model.mapping])
    return vector[order], noise[order]


def _vector(state: Any) -> FloatArray:
    return np.asarray(state.state_vector, np.float64).ravel()


def _position(state: Any, mapping: tuple[int, ...]) -> dict[str, float]:
    vector = _vector(state)
    if vector.size <= max(mapping):
        mapping = (0, 1)
    return {axis: float(vector[place]) for axis, place in zip(_AXES, mapping, strict=False)}


def _moment(time: Any) -> datetime:
    """Return a time of Stone Soup, which is UTC where it has no zone."""
    if not isinstance(time, datetime):
        raise InvalidInputError(f"detection: time {time!r:.40}; expected a datetime")
    return time.replace(tzinfo=UTC) if time.tzinfo is None else time.astimezone(UTC)
