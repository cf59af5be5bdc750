"""From a configuration to a tracker, for those who begin with the tracker's class.

What reads configurations stands above the trackers and imports them, never the other way round.
So it is looked up by its name, as late as somebody asks, as ``trackweave`` itself does.
"""

from importlib import import_module
from typing import Any, TypeVar

from trackweave.errors import InvalidInputError

__all__ = ["from_config"]

BUILDER = "trackweave.run.configured"

Kind = TypeVar("Kind")


def from_config(kind: type[Kind], config: Any, reports: Any) -> Kind:
    """Return the tracker that a configuration asks for; refuse one that is not of the class."""
    tracker = import_module(BUILDER).configured(config, reports)
    if not isinstance(tracker, kind):
        asked = type(tracker).__name__
        raise InvalidInputError(
            f"tracker.kind: the configuration asks for a {asked}; expected that of a "
            f"{kind.__name__}, or use {asked}.from_config"
        )
    return tracker
