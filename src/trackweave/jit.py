"""The one decorator that compiles kernels."""

import os
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba

__all__ = ["jit"]

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


def _cache_is_writable() -> bool:
    """Tell whether compiled code can be kept.

    Numba refuses to import a cached function at all where neither the package's folder nor the
    user's cache folder can be written, so a read-only install needs to know beforehand.

    Returns
    -------
    Whether some folder that Numba would use can be written.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    places = [Path(chosen)] if chosen else [Path(__file__).parent, Path.home() / ".cache"]
    for place in places:
        try:
            place.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=place):
                return True
        except OSError:
            continue
    return False


_compile: Callable[..., Any] = partial(numba.njit, nogil=True, cache=_cache_is_writable())


def jit(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """Compile a kernel: no interpreter lock, cached on disk, strict floating point.

    Fast-math is never used: it drops infinity, which is how a gate says no.

    Parameters
    ----------
    function
        The kernel.

    Returns
    -------
    The compiled kernel, called in the same way.
    """
    compiled: Callable[_Parameters, _Result] = _compile(function)
    return compiled
