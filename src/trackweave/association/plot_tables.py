"""The plots of all sensors as kernels read them."""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.association._plot_sets import PlotTable
from trackweave.association._plot_views import Views
from trackweave.association.sensor_plots import SensorPlots
from trackweave.errors import InvalidInputError
from trackweave.models.coverage import everywhere

__all__ = ["common_dimension", "plot_table", "views_of"]


def common_dimension(sensors: Sequence[SensorPlots]) -> int:
    """Return how many dimensions, the same for all, plots have, 2 or 3; bearings have two."""
    if not sensors:
        raise InvalidInputError("sensors: none; expected at least one")
    dims = {2 if sensor.is_bearing else sensor.value.shape[1] for sensor in sensors}
    if len(dims) > 1:
        raise InvalidInputError(
            "sensors: plots of two dimensions, or bearings, and of three; expected one of them"
        )
    return dims.pop()


def plot_table(sensors: Sequence[SensorPlots], dim: int, *, with_evidence: bool) -> PlotTable:
    """Return all plots as kernels read them; a sensor has to say what its price needs."""
    # With evidence they are priced against the density of false alarms, else against one in the
    # whole field of view.
    n_plots = [sensor.value.shape[0] for sensor in sensors]
    first = np.concatenate([[0], np.cumsum(n_plots)]).astype(np.int64)
    value, place = np.zeros((first[-1], dim)), np.zeros((first[-1], 2))
    covariance = np.tile(np.eye(dim), (first[-1], 1, 1))
    number, hit = np.empty(first[-1], dtype=np.int64), np.empty(first[-1])
    drift = np.zeros(first[-1])
    moves = np.zeros(len(sensors), dtype=np.bool_)
    widest, farthest = np.zeros(len(sensors)), np.zeros(len(sensors))
    for index, sensor in enumerate(sensors):
        own = slice(first[index], first[index + 1])
        n_columns = 1 if sensor.is_bearing else dim
        values = sensor.value.reshape(-1, n_columns)
        order = np.argsort(values[:, 0], kind="stable")
        value[own, :n_columns] = values[order]
        covariance[own, :n_columns, :n_columns] = _covariances(sensor, n_columns)[order]
        number[own] = order + 1
        log_clutter = _log_clutter(sensor, f"sensors[{index}]", with_evidence=with_evidence)
        # What a plot is worth against a false alarm; ½ ln|2πΣ| follows below.
        hit[own] = log_clutter[order] - math.log(sensor.detection_probability)
        widest[index] = math.sqrt(covariance[own, 0, 0].max(initial=0.0))
        if sensor.is_bearing:
            drift[own] = np.broadcast_to(sensor.drift, order.shape)[order]
            farthest[index] = drift[own].max(initial=0.0)
            places = np.broadcast_to(np.asarray(sensor.place), (order.shape[0], 2))
            place[own] = places[order]
            moves[index] = bool(np.any(places != places[:1]))
    log_spread = np.linalg.slogdet(covariance)[1]
    hit += 0.5 * log_spread
    for index, sensor in enumerate(sensors):
        n_columns = 1 if sensor.is_bearing else dim
        hit[first[index] : first[index + 1]] += 0.5 * n_columns * math.log(2.0 * math.pi)
    # What may be nothing, where a sensor does not cover the place, is nothing here.
    miss = np.array(
        [
            -math.log1p(-sensor.detection_probability) if sensor.coverage is None else 0.0
            for sensor in sensors
        ]
    )
    best = [hit[a:b].min(initial=np.inf) for a, b in itertools.pairwise(first)]
    gains = np.minimum(0.0, np.array(best) - miss)
    return PlotTable(
        first=first,
        value=value,
        covariance=covariance,
        information=np.asarray(np.linalg.inv(covariance), dtype=np.float64),
        log_spread=log_spread,
        drift_squared=drift**2,
        place=place,
        number=number,
        hit=hit,
        miss=miss,
        promise=np.append(np.cumsum(gains[::-1])[::-1], 0.0),
        is_bearing=np.array([sensor.is_bearing for sensor in sensors]),
        moves=moves,
        widest=widest,
        farthest=farthest,
        drifts=bool(np.any(drift > 0.0)),
    )


def views_of(sensors: Sequence[SensorPlots]) -> Views:
    """Return what each sensor covers as kernels read it."""
    given = [sensor.coverage for sensor in sensors]
    coverages = [everywhere() if view is None else view.coverage() for view in given]
    is_bounded = np.array([not coverage.everywhere for coverage in coverages])
    n_corners = [coverage.polygon.shape[0] for coverage in coverages]
    return Views(
        any_bounded=bool(np.any(is_bounded)),
        is_bounded=is_bounded,
        detection=np.array([float(sensor.detection_probability) for sensor in sensors]),
        position=np.array([coverage.position for coverage in coverages]),
        bounds=np.array([coverage.bounds for coverage in coverages]),
        first_corner=np.concatenate([[0], np.cumsum(n_corners)]).astype(np.int64),
        corner=np.concatenate([coverage.polygon for coverage in coverages]),
    )


def _covariances(sensor: SensorPlots, n_columns: int) -> FloatArray:
    """Return the covariance of each plot; of bearings the variance without drift."""
    if sensor.covariance is None:
        sigmas = np.asarray(sensor.sigma, dtype=np.float64).reshape(-1, n_columns)
        covariance = sigmas[:, :, None] ** 2 * np.eye(n_columns)
    else:
        covariance = np.asarray(sensor.covariance)
    if sensor.is_bearing:
        return covariance
    drift = np.broadcast_to(sensor.drift, covariance.shape[:1])
    summed: FloatArray = covariance + drift[:, None, None] ** 2 * np.eye(n_columns)
    return summed


def _log_clutter(sensor: SensorPlots, name: str, *, with_evidence: bool) -> FloatArray:
    """Return the logarithm of the density of false alarms at each plot."""
    n_plots = sensor.value.shape[0]
    volume = None if sensor.volume is None else np.asarray(sensor.volume, dtype=np.float64)
    if not with_evidence:
        if volume is None:
            raise InvalidInputError(
                f"{name}: volume: None; expected the field of view's for cost='equation-1', "
                "which a bound on the field of view would give"
            )
        density = 1.0 / volume
    elif sensor.clutter_density is not None:
        density = np.asarray(sensor.clutter_density, dtype=np.float64)
    elif volume is None or sensor.false_alarms is None:
        raise InvalidInputError(
            f"{name}: no clutter_density, nor false_alarms and volume; expected one for evidence"
        )
    else:
        density = sensor.false_alarms / volume
    logs: FloatArray = np.log(np.broadcast_to(density, (n_plots,)))
    return logs
