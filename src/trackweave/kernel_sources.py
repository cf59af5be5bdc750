"""On which sources a compiled kernel depends: its module, and whatever that imports from here.

Imports nothing but the standard library, so that tests can ask before the compiler is imported.
"""

import hashlib
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

__all__ = ["digest_of", "kernel_files", "sources_of"]

PACKAGE = Path(__file__).parent
IMPORT = re.compile(r"^from (trackweave[\w.]*) import (?:\(([^)]*)\)|(.*))$", re.MULTILINE)
MARK = re.compile(r"^@jit$", re.MULTILINE)


def kernel_files() -> list[Path]:
    """Return the modules that hold kernels, sorted."""
    files = sorted(PACKAGE.rglob("*.py"))
    return [file for file in files if MARK.search(file.read_text(encoding="utf-8"))]


@cache
def sources_of(file: Path) -> tuple[Path, ...]:
    """Return a module and what it imports from this package, directly or not, sorted."""
    # Where a file cannot be read it stands there all the same.
    waiting, found = [file], set[Path]()
    while waiting:
        file = waiting.pop()
        if file not in found:
            found.add(file)
            waiting += _imported_by(file)
    return tuple(sorted(found))


def digest_of(files: Iterable[Path]) -> str:
    """Return a digest of files' places in the package and of what they hold, in any order."""
    digest = hashlib.sha256()
    for file in sorted(files):
        content = file.read_bytes()
        name = file.relative_to(PACKAGE).as_posix()
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


@cache
def _imported_by(file: Path) -> tuple[Path, ...]:
    """Return the files that a module imports from this package by itself."""
    try:
        text = file.read_text(encoding="utf-8")
    except OSError:
        return ()
    return tuple(path for path in _candidates(text) if Path(path).is_file())


def _candidates(text: str) -> Iterator[Path]:
    """Yield where the modules that a text imports may lie: modules, packages and their parts."""
    for module, many, few in IMPORT.findall(text):
        place = PACKAGE.parent.joinpath(*module.split("."))
        for name in ("", *(part.split(" as ")[0].strip() for part in (many or few).split(","))):
            yield place.joinpath(name).with_suffix(".py")
        if place != PACKAGE:
            yield place / "__init__.py"
