"""Multilateration: how much farther an aircraft is from some receivers than from the first."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from trackweave import InvalidInputError, Reported

N_RECEIVERS = 5
ORIGIN_RADIUS = 6_378_137.0
STEPS, CLOSE = 25, 1e-3
"""Steps of the search for a place, which ends once none moves farther than this [m]."""


@dataclass(frozen=True, slots=True)
class TimeDifferences:
    """Differences of times of arrival at five receivers, times the speed of light, and a height.

    A report names its own receivers: each row tells where they stand. The error of the first
    receiver's clock is in all differences, so that these depend on one another.

    Parameters
    ----------
    timing_sigma
        Standard deviation of a time of arrival, times the speed of light [m].
    height_sigma
        Standard deviation of the height that the aircraft itself tells [m].

    Raises
    ------
    InvalidInputError
        If a value is not positive.
    """

    timing_sigma: float = 30.0
    height_sigma: float = 50.0

    columns: ClassVar = (*(f"farther_{n}_m" for n in range(2, N_RECEIVERS + 1)), "above_m")
    context: ClassVar = (
        *(f"receiver_{n}_{axis}" for n in range(1, N_RECEIVERS + 1) for axis in "xyz"),
        "center_x", "center_y", "center_z",
    )  # fmt: skip
    dim: ClassVar[int] = 3

    def __post_init__(self) -> None:
        for name in ("timing_sigma", "height_sigma"):
            if not getattr(self, name) > 0:
                raise InvalidInputError(f"{name}: {getattr(self, name)}; expected a number > 0")

    def covariance(self, reported: Reported) -> np.ndarray:
        """Return the covariance of each report's errors: the first clock's is in all."""
        width = N_RECEIVERS - 1
        own = np.zeros((width + 1, width + 1))
        own[:width, :width] = self.timing_sigma**2 * (np.eye(width) + 1.0)
        own[width, width] = self.height_sigma**2
        return np.repeat(own[None], reported.values.shape[0], axis=0)

    def expect(
        self, mean: np.ndarray, platform: np.ndarray, reported: Reported
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the differences and heights expected, and how they change with the place."""
        value, by_place = _seen_from(mean[:, :3], reported.context)
        slope = np.zeros((*value.shape, mean.shape[1]))
        slope[:, :, :3] = by_place
        return value, slope

    def first_state(
        self, platform: np.ndarray, reported: Reported
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the places that fit best, and how surely: Levenberg's way from several starts."""
        weight = np.linalg.inv(reported.covariance)
        center = reported.context[:, -3:]
        receivers = reported.context[:, :-3].reshape(-1, N_RECEIVERS, 3)
        up = _unit(receivers.mean(axis=1) - center)
        east = _unit(np.cross([0.0, 1.0, 0.0], up))
        best, least = np.zeros_like(center), np.full(center.shape[0], np.inf)
        for start in (up * 0.0, east, -east, np.cross(up, east), np.cross(east, up)):
            place = receivers.mean(axis=1) + 1e5 * start
            place = center + _unit(place - center) * (ORIGIN_RADIUS + reported.values[:, -1:])
            place, misfit = _fitted(place, reported, weight)
            better = misfit < least
            best[better], least[better] = place[better], misfit[better]
        slope = _seen_from(best, reported.context)[1]
        known = slope.swapaxes(1, 2) @ weight @ slope
        # Where the receivers see no more than a line, the place is known to some hundred km.
        return best, np.linalg.inv(known + 1e-11 * np.eye(3))


def _fitted(
    place: np.ndarray, reported: Reported, weight: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return places that fit reports, and the squared distances that are left."""
    damping, misfit = np.full(place.shape[0], 1e-2), _misfit(place, reported, weight)
    for _ in range(STEPS):
        value, slope = _seen_from(place, reported.context)
        back = slope.swapaxes(1, 2) @ weight
        known = back @ slope
        known = (
            known + damping[:, None, None] * np.eye(3) * np.trace(known, 0, 1, 2)[:, None, None]
        )
        step = np.linalg.solve(known, back @ (reported.values - value)[:, :, None])[:, :, 0]
        found = _misfit(place + step, reported, weight)
        better = found < misfit
        place, misfit = np.where(better[:, None], place + step, place), np.minimum(found, misfit)
        damping = np.where(better, damping / 10.0, damping * 10.0)
        if np.abs(step).max() < CLOSE:
            break
    return place, misfit


def _misfit(place: np.ndarray, reported: Reported, weight: np.ndarray) -> np.ndarray:
    off = reported.values - _seen_from(place, reported.context)[0]
    return np.einsum("ri,rij,rj->r", off, weight, off)


def _seen_from(place: np.ndarray, context: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return differences of distances and heights at places, and their slopes."""
    apart = place[:, None] - context.reshape(-1, N_RECEIVERS + 1, 3)
    distance = np.linalg.norm(apart, axis=2)
    toward = apart / distance[:, :, None]
    value, slope = distance[:, 1:] - distance[:, :1], toward[:, 1:] - toward[:, :1]
    value[:, -1], slope[:, -1] = distance[:, -1] - ORIGIN_RADIUS, toward[:, -1]
    return value, slope


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector, axis=1, keepdims=True)
