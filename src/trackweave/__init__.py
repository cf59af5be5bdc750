"""Turns reports of many sensors into tracks of many objects.

Names are imported when they are first used, so that ``import trackweave`` costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from trackweave.errors import DataFormatError as DataFormatError
    from trackweave.errors import InfeasibleError as InfeasibleError
    from trackweave.errors import InvalidInputError as InvalidInputError
    from trackweave.errors import MissingDependencyError as MissingDependencyError
    from trackweave.errors import NumericalError as NumericalError
    from trackweave.errors import OutputError as OutputError
    from trackweave.errors import TrackweaveError as TrackweaveError

# Where each public name lives.
_HOMES = {
    "DataFormatError": "trackweave.errors",
    "InfeasibleError": "trackweave.errors",
    "InvalidInputError": "trackweave.errors",
    "MissingDependencyError": "trackweave.errors",
    "NumericalError": "trackweave.errors",
    "OutputError": "trackweave.errors",
    "TrackweaveError": "trackweave.errors",
}

__all__ = sorted([*_HOMES, "__version__"])


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("trackweave")
    if name not in _HOMES:
        raise AttributeError(f"module 'trackweave' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
