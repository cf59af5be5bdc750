"""From the keys of ``[motion]`` to how objects move."""

from collections.abc import Mapping, Sequence
from typing import Any

from trackweave.config.sections import MODELS
from trackweave.config.sources import Sources, value_at
from trackweave.errors import InvalidInputError
from trackweave.models.motion import (
    ConstantAcceleration,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    Mode,
    Motion,
    RandomWalk,
)

__all__ = ["motion_of"]

_VELOCITY, _ACCELERATION, _TURN, _WALK = MODELS
# What is taken where neither the file nor the reports tell: a vehicle's.
USUAL_SPEED, USUAL_PROCESS = 50.0, 1.0
USUAL_TURN_RATE = 0.2
USUAL_STAY, USUAL_MANOEUVRE = 60.0, 15.0
# An object reaches its greatest speed in about so many seconds, and a manoeuvre fades in so many.
SPEED_UP, FADE = 10.0, 10.0


def motion_of(
    sources: Sources,
    estimated: tuple[float | None, float | None],
    period: float,
    ways: Mapping[str, Any] | None = None,
) -> Motion:
    """Return how objects move, and enter each value."""
    # Estimated are the process noise [m²/s³] and the greatest speed [m/s], None for nothing, and
    # the ways between which objects change, with keys as in ``[motion.imm]``; ``period`` is the
    # shortest time from scan to scan [s].
    path = ("motion",)
    model = sources.choose((*path, "model"), ways and "imm", _VELOCITY)
    noise, speed = estimated
    if model in {_VELOCITY, _TURN, "imm"}:
        sources.choose((*path, "process_noise"), noise, USUAL_PROCESS)
    sources.choose((*path, "max_speed"), speed, USUAL_SPEED)
    sources.choose((*path, "trust"), default=False)
    return (
        _imm(sources, period, ways or {})
        if model == "imm"
        else _mode(sources, path, model, period)
    )


def _imm(sources: Sources, period: float, ways: Mapping[str, Any]) -> Imm:
    path = ("motion", "imm")
    names = sources.choose((*path, "models"), ways.get("models"), [_VELOCITY, _TURN])
    if names != ways.get("models"):
        ways = {}
    usual = [USUAL_STAY, *[USUAL_MANOEUVRE] * (len(names) - 1)]
    times = sources.choose((*path, "sojourn_time"), ways.get("sojourn_time"), usual)
    if len(times) != len(names):
        raise InvalidInputError(
            f"motion.imm.sojourn_time: {len(times)} times; expected {len(names)}, one for each "
            "of models"
        )
    models = []
    for name in names:
        own = ways.get(name, {})
        kind = sources.choose((*path, name, "model"), own.get("model"), name)
        noise = own.get("process_noise") if own.get("model") == kind else None
        models.append(_mode(sources, (*path, name), kind, period, noise))
    return Imm(tuple(models), tuple(times))


def _mode(
    sources: Sources, path: Sequence[str], kind: str, period: float, noise: float | None = None
) -> Mode:
    """Return one way to move; what its table leaves out is as in ``[motion]``, or usual."""

    def choose(key: str, usual: float) -> float:
        known = value_at(sources.values, (*path, key)) if len(path) == 1 else None
        if known is not None:
            return float(known)
        above = value_at(sources.values, ("motion", key))
        if above is None:
            above = value_at(sources.file, ("motion", key))
        return float(sources.choose((*path, key), default=usual if above is None else above))

    speed = choose("max_speed", USUAL_SPEED)
    if kind == _VELOCITY:
        return ConstantVelocity(choose("process_noise", USUAL_PROCESS), speed)
    if kind == _TURN:
        rate = choose("max_turn_rate", USUAL_TURN_RATE)
        # A turn rate that is spread evenly up to its greatest and fades has this noise.
        turn_noise = choose("turn_noise", 2 * rate**2 / 3 / FADE)
        return CoordinatedTurn(choose("process_noise", USUAL_PROCESS), turn_noise, speed, rate)
    # The process noise of [motion] is in another unit than these two's, unless it is their own.
    own = ("process_noise",)
    if kind == _ACCELERATION:
        acceleration = choose("max_acceleration", speed / SPEED_UP)
        jerk = 2 * acceleration**2 / 5 / FADE
        shaken = sources.choose((*path, *own), noise, jerk)
        return ConstantAcceleration(float(shaken), speed, acceleration)
    walk = sources.choose((*path, *own), noise, speed**2 * period / 9)
    return RandomWalk(float(walk), speed)
