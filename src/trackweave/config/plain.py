"""Values of NumPy in a mapping, as those of a file would be."""

from collections.abc import Mapping
from typing import Any

__all__ = ["plain"]


def plain(value: Any) -> Any:
    """Return a value with numbers, truth values and arrays of NumPy as Python's own.

    Parameters
    ----------
    value
        Of any kind; what mappings and sequences hold is looked at too.

    Returns
    -------
    The same where nothing is of NumPy; tuples are lists.
    """
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    # Reading a file waits for no import of NumPy.
    is_of_numpy = type(value).__module__ == "numpy" and hasattr(value, "dtype")
    return value.tolist() if is_of_numpy else value
