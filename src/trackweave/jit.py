"""The one decorator that compiles kernels."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any, ParamSpec, TypeVar

import numba

__all__ = ["jit"]

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")

# Nobody calls kernels from C: without the entry for that they compile a tenth sooner.
_OPTIONS: dict[str, Any] = {"nogil": True, "no_cfunc_wrapper": True}
# Numba's types do not list all of its options.
_njit: Any = numba.njit
try:
    from trackweave.kernel_cache import KernelCache as _KernelCache
except ImportError:  # a later numba, whose inner parts have other names
    _KernelCache = None  # type: ignore[assignment,misc]


def jit(function: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """Compile a kernel: no interpreter lock, cached on disk, strict floating point.

    Fast-math is never used: it drops infinity, which is how a gate says no. Code that came
    with the package is used where it fits, and else what an earlier run kept on the disk. Where
    no cache can be written, each process compiles anew.

    Parameters
    ----------
    function
        The kernel.

    Returns
    -------
    The compiled kernel, called in the same way.
    """
    compiled: Any = _njit(**_OPTIONS)(function)
    if _KernelCache is not None and hasattr(compiled, "_cache"):
        compiled._cache = _KernelCache(function)
    elif compiled is not function:
        # Numba refuses a function outright when neither the package's folder nor the user's
        # can be written, or when the user has no home.
        with suppress(RuntimeError):
            compiled.enable_caching()
    kernel: Callable[_Parameters, _Result] = compiled
    return kernel
