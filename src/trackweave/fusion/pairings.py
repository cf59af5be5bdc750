"""Which local track was of which object, from when to when, and why that ended."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from trackweave.fusion.associator import Association

__all__ = ["Pairing", "Pairings"]


@dataclass(slots=True)
class Pairing:
    """A local track's time with one object.

    From ``begin`` to ``end`` [s]; the reason says why it ended, and is empty where it lasted to
    the end of the run.
    """

    object: int
    sensor: str
    track: int
    begin: float
    end: float
    reason: str = ""


@dataclass(slots=True)
class Pairings:
    """Pairings as they come and go; ``common`` objects are those of several tracks, ever."""

    common: set[int] = field(default_factory=set)
    _ended: list[Pairing] = field(default_factory=list)
    _open: dict[tuple[str, int], Pairing] = field(default_factory=dict)

    def add(self, association: Association, there: Mapping[str, set[int]]) -> None:
        """Go on with pairings that hold, and end those that do not."""
        # ``there`` are the tracks that each sensor had when it last spoke.
        now = {
            (association.names[sensor], track): number
            for sensor, track, number in zip(
                association.sensor.tolist(), association.track.tolist(),
                association.object.tolist(), strict=True,
            )
        }  # fmt: skip
        self.common |= {number for number, count in Counter(now.values()).items() if count > 1}
        for key, pairing in list(self._open.items()):
            if now.get(key) == pairing.object:
                pairing.end = association.time
                continue
            pairing.reason = _why(key, (pairing.object, now.get(key)), association, there)
            self._ended.append(self._open.pop(key))
        for key, number in now.items():
            if key not in self._open:
                name, track = key
                self._open[key] = Pairing(number, name, track, association.time, association.time)

    def all(self) -> tuple[Pairing, ...]:
        """Return all pairings: object by object, then by their beginnings."""
        every = [*self._ended, *self._open.values()]
        return tuple(sorted(every, key=lambda one: (one.object, one.begin, one.sensor, one.track)))


def _why(
    key: tuple[str, int],
    objects: tuple[int, int | None],
    association: Association,
    there: Mapping[str, set[int]],
) -> str:
    """Return why a track left one object for another, or for none."""
    (name, track), (old, new) = key, objects
    if new is None:
        is_silent = track in there.get(name, set())
        return "its sensor is silent" if is_silent else "its track ended"
    for change in association.changes:
        if change.kind == "merged" and change.object == new and old in change.others:
            return f"joined object {new}: {change.reason}"
        if change.kind == "split" and change.object == old and new in change.others:
            return f"left for object {new}: {change.reason}"
    return f"now of object {new}"
