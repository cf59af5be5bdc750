"""What a compiled kernel depends on."""

import ast
from pathlib import Path

from trackweave.kernel_sources import PACKAGE, digest_of, kernel_files, sources_of


def imported_by(file: Path) -> set[Path]:
    """Return what a module imports from this package at its top, read off its syntax tree."""
    found: set[Path] = set()
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("trackweave"):
            place = PACKAGE.parent.joinpath(*str(node.module).split("."))
            for path in (place, *(place / alias.name for alias in node.names)):
                found |= {path.with_suffix(".py"), path / "__init__.py"}
    return {path for path in found if path.is_file() and path != PACKAGE / "__init__.py"}


def test_kernels_depend_on_what_their_modules_import_directly_or_not() -> None:
    assert len(kernel_files()) > 40
    for file in kernel_files():
        sources = set(sources_of(file))
        assert file in sources
        assert all(imported_by(source) <= sources for source in sources)
        assert PACKAGE / "jit.py" in sources


def test_what_only_finds_kernels_is_none_of_their_sources() -> None:
    sources = {source.name for file in kernel_files() for source in sources_of(file)}
    assert not sources & {"kernel_cache.py", "kernel_sources.py"}


def test_a_digest_tells_content_and_names_apart(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("trackweave.kernel_sources.PACKAGE", tmp_path)
    one, other = tmp_path / "one.py", tmp_path / "other.py"
    one.write_text("a")
    other.write_text("b")
    digests = {digest_of([one]), digest_of([other]), digest_of([one, other])}
    assert digest_of([other, one]) == digest_of([one, other])
    one.write_text("ab")
    digests |= {digest_of([one]), digest_of([one, other])}
    assert len(digests) == 5
