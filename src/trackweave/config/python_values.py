"""Values of NumPy in a mapping, as those of a file would be."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from trackweave.fields import plain

__all__ = ["python_values"]


def python_values(value: Any) -> Any:
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
        return {key: python_values(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [python_values(each) for each in value]
    return value.tolist() if isinstance(value, np.ndarray) else plain(value)
