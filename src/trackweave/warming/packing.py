"""Kernels that were compiled, put together into the folder that a wheel holds."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from numba.core.bytecode import FunctionIdentity
from numba.core.environment import Environment
from numba.core.serialize import dumps

from trackweave.kernel_cache import STAMP, environment_of, machine, name_of
from trackweave.kernel_sources import PACKAGE, digest_of, kernel_files, sources_of

__all__ = ["forget_places", "kernels", "pack"]

# Loads all kernels of a folder without what a compiler needs besides: a code that asks for more
# ends the process.
CHECK = """
import pickle, sys
from pathlib import Path
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from trackweave.kernel_cache import rebuilt
rtsys.initialize(cpu_target.target_context)
for file in Path(sys.argv[1]).glob("*.kernel"):
    for payload in pickle.loads(file.read_bytes()).values():
        rebuilt(cpu_target.target_context, *pickle.loads(payload))
"""
ENVIRONMENT, ANNOTATION, ENVIRONMENTS = 2, 6, 8
"""Where, in what numba keeps of a kernel, what it knows of its surroundings stands, the text with
its types, which names files, and what the functions within it know."""


class _Surroundings:
    """An environment of numba's, which comes back without an import of its module."""

    def __init__(self, whole: Environment) -> None:
        self.whole = whole

    def __reduce__(self) -> tuple[Any, ...]:
        whole = self.whole
        return environment_of, (whole.globals["__name__"], whole.consts, whole.env_name)


def kernels() -> Iterator[tuple[Callable[..., Any], Any]]:
    """Yield each kernel of the package: the function, and what it was compiled to."""
    for file in kernel_files():
        parts = file.relative_to(PACKAGE.parent).with_suffix("").parts
        module = import_module(".".join(parts))
        for value in vars(module).values():
            function = getattr(value, "py_func", None)
            if function is not None and function.__module__ == module.__name__:
                yield function, value


def forget_places() -> None:
    """Have numba write, for the rest of the process, files' names alone into what it compiles.

    What may be raised holds the file that raises it, and the folder of the building machine with
    it, in code that is shipped.
    """
    identity: Any = FunctionIdentity  # whose methods numba's types do not let us replace
    whole = identity.from_function.__func__

    def from_function(kind: Any, function: Any) -> Any:
        found = whole(kind, function)
        found.filename = Path(found.filename).name
        return found

    identity.from_function = classmethod(from_function)


def pack(folder: Path) -> int:
    """Write what numba keeps of this package's kernels into a folder.

    Parameters
    ----------
    folder
        A new or empty folder.

    Returns
    -------
    How many versions of kernels it holds.
    """
    folder.mkdir(parents=True, exist_ok=True)
    n_packed = 0
    for function, kernel in kernels():
        versions = dict(_versions(kernel))
        n_packed += len(versions)
        if versions:
            (folder / name_of(function)).write_bytes(dumps(versions))
    files = sorted({source for file in kernel_files() for source in sources_of(file)})
    stamp = {
        "machine": machine(),
        "files": [file.relative_to(PACKAGE).as_posix() for file in files],
        "digest": digest_of(files),
        "alone": _load_alone(folder),
    }
    (folder / STAMP).write_text(json.dumps(stamp, indent=1) + "\n", encoding="utf-8")
    return n_packed


def _versions(kernel: Any) -> Iterator[tuple[Any, bytes]]:
    """Yield what numba keeps of a kernel: types of arguments, and the code for them."""
    file = kernel._cache.kept._cache_file
    for (signature, *_), name in file._load_index().items():
        kept = list(file._load_data(name))
        kept[ENVIRONMENT] = _Surroundings(kept[ENVIRONMENT])
        kept[ANNOTATION] = ""
        kept[ENVIRONMENTS] = tuple(map(_Surroundings, kept[ENVIRONMENTS]))
        yield signature, dumps(tuple(kept))


def _load_alone(folder: Path) -> bool:
    """Return whether all kernels load without the compiler's own tables."""
    done = subprocess.run(
        [sys.executable, "-c", CHECK, str(folder)], capture_output=True, check=False
    )
    return done.returncode == 0
