"""With what the tracker runs, complete: the content of a record CONFIGURE."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from trackweave.config import load_configuration
from trackweave.config.fill import ANY_SENSOR, Settings
from trackweave.domain.frames import LocalFrame, Projection
from trackweave.run.configured import settings_alone
from trackweave.run.regions.cutting import Region
from trackweave.service.records import as_json, from_json

__all__ = ["Spec", "without_nothing"]

UNNAMED = "(without a name)"
"""What the sensor of reports without one is called where ``[sensors.default]`` is for all."""


@dataclass(frozen=True, slots=True, eq=False)
class Spec:
    """A configuration without gaps, and what a recording would have told beside it.

    Parameters
    ----------
    configuration
        The tables of a tracker.toml, with a table for each sensor.
    dim
        Number of dimensions of the tracking space, 2 or 3.
    frame
        The plane on which places of the Earth are laid, None for plane coordinates.
    iso_time
        Whether times are written as dates.
    together
        For how long lone reports are gathered before they are searched [s]; None for not at all.
    regions
        The plane, cut; None for one tracker.
    margin
        How far beyond itself a region looks [m].
    """

    configuration: Mapping[str, Any]
    dim: int = 2
    frame: LocalFrame | None = None
    iso_time: bool = False
    together: float | None = None
    regions: tuple[Region, ...] | None = None
    margin: float = 0.0

    def unchanged(self, before: "Spec") -> set[str]:
        """Return the sensors whose reports become scans as by an earlier configuration.

        Parameters
        ----------
        before
            The earlier one.

        Returns
        -------
        Their names; none where the plane is another.
        """
        if (self.dim, self.frame) != (before.dim, before.frame):
            return set()
        own, others = self.configuration["sensors"], before.configuration["sensors"]
        return {name for name, told in own.items() if others.get(name) == told}

    def payload(self) -> bytes:
        """Return the record's content."""
        frame = self.frame
        said = {
            "configuration": without_nothing(self.configuration),
            "dim": self.dim,
            "frame": frame and [frame.latitude_deg, frame.longitude_deg, frame.projection],
            "iso_time": self.iso_time,
            "together": self.together,
        }
        if self.regions is not None:
            # Where nothing bounds a region, it says null.
            said["regions"] = [[*each.low.tolist(), *each.high.tolist()] for each in self.regions]
            said["margin"] = self.margin
        return as_json(said)

    @classmethod
    def of(cls, payload: bytes) -> "Spec":
        """Return what a record says."""
        said = from_json(payload)
        frame = said["frame"]
        plane = frame and LocalFrame(frame[0], frame[1], cast("Projection", frame[2]))
        cut = said.get("regions")
        return cls(
            said["configuration"], said["dim"], plane or None, said["iso_time"], said["together"],
            None if cut is None else tuple(map(_region, cut)), said.get("margin", 0.0),
        )  # fmt: skip

    def settings(self) -> Settings:
        """Return everything that a tracker needs; refuse a configuration with gaps."""
        tables = self.configuration.get("sensors", {})
        if len(tables) < 2 or ANY_SENSOR not in tables:
            return settings_alone(load_configuration(self.configuration))
        # Beside others what came without a name is a sensor like them: its keys are its own.
        named = {UNNAMED if name == ANY_SENSOR else name: own for name, own in tables.items()}
        found = settings_alone(load_configuration({**self.configuration, "sensors": named}))
        sensors = [
            replace(each, name=ANY_SENSOR) if each.name == UNNAMED else each
            for each in found.sensors
        ]
        return replace(found, sensors=tuple(sensors))


def _region(corners: Sequence[float | None]) -> Region:
    """Return a region of x and y of its lower corner, then of its upper one [m]."""
    low = [-np.inf if each is None else each for each in corners[:2]]
    high = [np.inf if each is None else each for each in corners[2:]]
    return Region(np.array(low), np.array(high))


def without_nothing(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return nested tables without the keys that have no value."""
    return {
        key: without_nothing(value) if isinstance(value, Mapping) else value
        for key, value in table.items()
        if value is not None
    }
