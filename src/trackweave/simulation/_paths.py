"""Courses of targets: the manoeuvres' exact course plus integrated random acceleration."""

import math
from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.simulation.targets import Manoeuvre, Target

__all__ = ["course", "random_walk"]


class _Piece(NamedTuple):
    """A stretch of time on which the motion keeps one rule, and the state at one time of it."""

    begin: float
    end: float
    at: float
    position: FloatArray
    velocity: FloatArray
    rule: Manoeuvre | None


def course(target: Target, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the position [m] and velocity [m/s] at each time, without process noise."""
    position = np.empty((times.size, target.dim))
    velocity = np.empty((times.size, target.dim))
    for piece in _pieces(target):
        # Half-open stretches, so that each time belongs to one piece.
        inside = (times >= piece.begin) & (times < piece.end)
        position[inside], velocity[inside] = _move(piece, times[inside])
    return position, velocity


def random_walk(
    times: FloatArray, dim: int, process_noise: float, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return what random acceleration adds to position [m] and velocity [m/s]."""
    # Times run away from the first, forwards or backwards; nothing is added there.
    steps = np.diff(times)[:, None]
    draws = rng.standard_normal((2, steps.size, dim))
    # The Cholesky factor of [[dt³/3, dt²/2], [dt²/2, dt]] times the density; |dt| backwards.
    root = np.sqrt(process_noise * np.abs(steps))
    add_velocity = root * draws[0]
    add_position = steps * root * (draws[0] / 2 + draws[1] / math.sqrt(12))
    nothing = np.zeros((1, dim))
    velocity = np.concatenate([nothing, np.cumsum(add_velocity, axis=0)])
    position = np.cumsum(velocity[:-1] * steps + add_position, axis=0)
    return np.concatenate([nothing, position]), velocity


def _pieces(target: Target) -> list[_Piece]:
    """Return stretches that cover all time, the state of each hooked to its neighbour's."""
    stretches: list[tuple[float, float, Manoeuvre | None]] = []
    free_from = -math.inf
    for manoeuvre in target.manoeuvres:
        stretches.append((free_from, manoeuvre.start, None))
        stretches.append((manoeuvre.start, manoeuvre.end, manoeuvre))
        free_from = manoeuvre.end
    stretches.append((free_from, math.inf, None))
    stretches = [stretch for stretch in stretches if stretch[0] < stretch[1]]
    at = target.start if target.at is None else target.at
    home = next(place for place, stretch in enumerate(stretches) if at < stretch[1])
    pieces = {
        home: _Piece(
            *stretches[home][:2],
            at,
            np.array(target.position),
            np.array(target.velocity),
            stretches[home][2],
        )
    }
    for place in range(home + 1, len(stretches)):
        pieces[place] = _hooked(stretches[place], pieces[place - 1], stretches[place][0])
    for place in range(home - 1, -1, -1):
        pieces[place] = _hooked(stretches[place], pieces[place + 1], stretches[place][1])
    return [pieces[place] for place in range(len(stretches))]


def _hooked(
    stretch: tuple[float, float, Manoeuvre | None], neighbour: _Piece, at: float
) -> _Piece:
    position, velocity = _move(neighbour, np.array([at]))
    begin, end, rule = stretch
    return _Piece(begin, end, at, position[0], velocity[0], rule)


def _move(piece: _Piece, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the piece's state at each time, by its rule's closed form."""
    lapse = (times - piece.at)[:, None]
    start, speed = piece.position, piece.velocity
    rule = piece.rule
    if rule is not None and rule.acceleration is not None:
        push = np.array(rule.acceleration)
        return start + lapse * speed + lapse**2 / 2 * push, speed + lapse * push
    if rule is not None and rule.turn_rate_deg_s:
        return _turn(piece, lapse, math.radians(rule.turn_rate_deg_s))
    return start + lapse * speed, np.broadcast_to(speed, (times.size, speed.size))


def _turn(piece: _Piece, lapse: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    """Return the state on a level circle; what is vertical goes on straight."""
    position = piece.position + lapse * piece.velocity
    velocity = np.tile(piece.velocity, (lapse.shape[0], 1))
    angle = rate * lapse[:, 0]
    sine, cosine = np.sin(angle), np.cos(angle)
    east, north = piece.velocity[:2]
    velocity[:, 0] = cosine * east - sine * north
    velocity[:, 1] = sine * east + cosine * north
    # The integral of the turning velocity: (sin, 1 - cos) / rate, well-behaved for small rates.
    along, aside = sine / rate, 2 * np.sin(angle / 2) ** 2 / rate
    position[:, 0] = piece.position[0] + along * east - aside * north
    position[:, 1] = piece.position[1] + aside * east + along * north
    return position, velocity
