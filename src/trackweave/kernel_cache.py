"""Where compiled kernels come from: the package itself, then the user's disk, then the compiler.

A wheel holds a folder of kernels that were compiled when it was built, and a stamp that says from
which sources, with which compiler and for which machine. Only where all of that is what runs here
is anything taken from the folder, and never from anywhere else: what lies in it is unpickled.
Whatever does not fit is compiled, as if the folder were not there.
"""

import inspect
import json
import os
import pickle
import re
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import llvmlite
import numba
from llvmlite import binding
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache, _Cache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult
from numba.core.environment import Environment, lookup_environment
from numba.core.runtime.nrt import rtsys

from trackweave.errors import TrackweaveError
from trackweave.kernel_sources import PACKAGE, digest_of, sources_of

__all__ = [
    "FOLDER",
    "STAMP",
    "KernelCache",
    "environment_of",
    "machine",
    "name_of",
    "rebuilt",
    "why_not_shipped",
]

FOLDER = PACKAGE / "_compiled"
STAMP = "stamp.json"
# Code for every processor of its kind does what the sources say; these ask for other code.
ASKED_OTHERWISE = (
    "NUMBA_BOUNDSCHECK", "NUMBA_CPU_FEATURES", "NUMBA_CPU_NAME", "NUMBA_DEBUGINFO",
    "NUMBA_ENABLE_AVX", "NUMBA_LOOP_VECTORIZE", "NUMBA_OPT", "NUMBA_SLP_VECTORIZE",
)  # fmt: skip


class KernelCache(_Cache):
    """Finds a kernel's code in the package, or else in what numba keeps on the disk.

    Parameters
    ----------
    function
        The kernel, not compiled.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function
        self.came: Counter[str] = Counter()
        """How many versions of the kernel were shipped, kept on the disk, and compiled here."""

    @cached_property
    def kept(self) -> Any:
        """What numba keeps; nothing where it finds no folder that can be written."""
        # Made when first needed: it looks for a folder, and tries to write there.
        try:
            return _Kept(self.function)
        except RuntimeError:
            return NullCache()

    @property
    def cache_path(self) -> Any:
        """The folder of what was compiled here."""
        return self.kept.cache_path

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return a version of the kernel, or None where it has to be compiled."""
        found, where = _shipped(self.function, sig, target_context), "shipped"
        if found is None:
            found, where = self.kept.load_overload(sig, target_context), "kept"
        if found is not None:
            self.came[where] += 1
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled."""
        self.came["compiled"] += 1
        self.kept.save_overload(sig, data)

    def enable(self) -> None:
        """Keep from now on what is compiled."""
        self.kept.enable()

    def disable(self) -> None:
        """Keep no more."""
        self.kept.disable()

    def flush(self) -> None:
        """Forget what is kept on the disk."""
        self.kept.flush()


class _Kept(FunctionCache):
    """What numba keeps, outdated also by an edit of what the kernel's module imports."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        file = self._cache_file
        try:
            digest = digest_of(sources_of(Path(inspect.getfile(function))))
        except (OSError, ValueError):
            return
        self._cache_file = IndexDataCacheFile(
            self._cache_path, self._impl.filename_base, (file._source_stamp, digest)
        )


class _Shipped(JITCodeLibrary):
    """Code that came with the package; LLVM's form of it is read where another kernel needs it."""

    bitcode: bytes

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = binding.parse_bitcode(self.bitcode)
            self._codegen._engine._load_defined_symbols(self._shared_module)
        return self._shared_module


def machine() -> dict[str, str]:
    """Return what code has to be compiled with, and for, to run here."""
    return {
        "python": f"{sys.implementation.name} {sys.version_info.major}.{sys.version_info.minor}",
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        # A later macOS runs what an earlier one does.
        "platform": re.sub(r"(darwin|macosx)[\d.]+", r"\1", binding.get_process_triple()),
    }


def environment_of(module: str, constants: Any, name: str) -> Environment:
    """Return what compiled code knows of a function's surroundings.

    Numba's own way imports the module, which for its parts is the compiler; code that needs no
    interpreter asks for the constants alone.

    Parameters
    ----------
    module
        The function's module.
    constants
        What the code refers to, in its order.
    name
        By which the code finds it.

    Returns
    -------
    The one that there is, or a new one.
    """
    found = lookup_environment(name)
    if found is None:
        known = sys.modules.get(module)
        found = Environment({"__name__": module} if known is None else vars(known))
        found.consts[:] = constants
        found.env_name = name
        Environment._memo[name] = found
    return found


def why_not_shipped() -> str | None:
    """Return why kernels that came with the package are not used; None where they are."""
    return _stamp()[1]


def name_of(function: Callable[..., Any]) -> str:
    """Return the name of the file that holds a kernel's shipped versions."""
    return f"{function.__module__.partition('.')[2]}.{function.__qualname__}.kernel"


def rebuilt(
    target_context: Any, library: tuple[str, str, tuple[bytes, bytes]], described: Any, *rest: Any
) -> CompileResult:
    """Return a version of a kernel from what numba keeps of it, without LLVM's form of it.

    Reading that takes two thirds of the time, and a call needs the machine code alone.

    Parameters
    ----------
    target_context
        Numba's, of this processor.
    library
        A name, a word and the code: for the machine, and LLVM's bitcode.
    described
        Numba's description of the function.
    rest
        What else numba keeps.

    Returns
    -------
    What can be called.

    Raises
    ------
    TrackweaveError
        If the code has no function of that description.
    """
    name, kind, (code, bitcode) = library
    codegen, called = target_context.codegen(), described.llvm_cpython_wrapper_name
    # Numba reads off the bitcode what there is to call.
    codegen._engine._defined_symbols.add(called)
    none = binding.parse_assembly("").as_bitcode()
    library = (name, kind, (code, none))
    result = CompileResult._rebuild(target_context, library, described, *rest)
    if not result.library.get_pointer_to_function(called):
        raise TrackweaveError(f"{name}: no function {called}")
    result.library.__class__ = _Shipped
    result.library.bitcode, result.library._shared_module = bitcode, None
    return result


@cache
def _stamp() -> tuple[Mapping[str, Any], str | None]:
    """Return what the folder says of itself, and why it is not used."""
    try:
        stamp = json.loads((FOLDER / STAMP).read_bytes())
        wanted, files = dict(stamp["machine"]), [PACKAGE / name for name in stamp["files"]]
        own, is_same = machine(), digest_of(files) == stamp["digest"]
    except FileNotFoundError:
        return {}, "none came with it"
    except (OSError, ValueError, KeyError, TypeError) as err:
        return {}, f"{FOLDER / STAMP} cannot be read ({type(err).__name__})"
    asked = [name for name in ASKED_OTHERWISE if os.environ.get(name)]
    if asked:
        return stamp, f"{', '.join(asked)} asks for other code"
    other = [
        f"{key} {wanted.get(key)}, not {own[key]}" for key in own if wanted.get(key) != own[key]
    ]
    if other:
        return stamp, f"made for {' and '.join(other)}"
    return stamp, None if is_same else "made of other sources"


def _shipped(function: Callable[..., Any], sig: Any, target_context: Any) -> Any:
    """Return a version of a kernel that came with the package, or None."""
    stamp, obstacle = _stamp()
    if obstacle is not None:
        return None
    # Numba's sources may change under its version; then it is compiled, whatever is raised here.
    try:
        with (FOLDER / name_of(function)).open("rb") as file:
            payload = pickle.load(file).get(sig)
        if payload is None:
            return None
        if stamp["alone"]:
            # All that loading needs: the compiler's own tables take a quarter of a second.
            rtsys.initialize(target_context)
        else:
            target_context.refresh()
        return rebuilt(target_context, *pickle.loads(payload))
    except Exception:
        return None
