"""From the keys of ``[motion]`` to how objects move."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from trackweave.config.sources import Sources, value_at
from trackweave.errors import InvalidInputError
from trackweave.models.motion import (
    MODELS,
    USUAL_PROCESS,
    USUAL_SPEED,
    ConstantVelocity,
    CoordinatedTurn,
    Imm,
    Mode,
    Motion,
)

__all__ = ["motion_of"]

_VELOCITY, _TURN = ConstantVelocity.word, CoordinatedTurn.word
USUAL_STAY, USUAL_MANOEUVRE = 60.0, 15.0


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
    return MODELS[kind].told(_Told(sources, path, period, noise))


@dataclass(frozen=True, slots=True)
class _Told:
    """What the table of a way to move tells, and the process noise estimated for it."""

    sources: Sources
    path: Sequence[str]
    period: float
    noise: float | None

    def above(self, key: str, usual: float) -> float:
        """Return the value of a key, of ``[motion]`` where its own table leaves it out."""
        sources, path = self.sources, self.path
        known = value_at(sources.values, (*path, key)) if len(path) == 1 else None
        if known is not None:
            return float(known)
        above = value_at(sources.values, ("motion", key))
        if above is None:
            above = value_at(sources.file, ("motion", key))
        return float(sources.choose((*path, key), default=usual if above is None else above))

    def own(self, key: str, usual: float) -> float:
        """Return the value of a key whose unit is another than in ``[motion]``."""
        return float(self.sources.choose((*self.path, key), self.noise, usual))
