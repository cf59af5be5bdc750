"""Rules that hold for every source file."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "trackweave"
SOURCES = sorted(SOURCE.rglob("*.py"))
# Modules that a person imports from; those with an underscore are nobody's business.
PUBLIC = [file for file in SOURCES if not file.name.startswith("_")]
TESTS = sorted((ROOT / "tests").rglob("test_*.py"))
EDGES = ("cli", "config", "config.py", "io", "metrics", "plotting", "run.py",
         "simulation")  # fmt: skip
# One compiles, two find and pack what was compiled, and one is told by numba that it compiles.
COMPILERS = {
    f"src/trackweave/{name}.py"
    for name in ("jit", "kernel_cache", "run/kernels", "warming/packing")
}
CHECKS = ("assert", "check", "fail", "raises", "require", "warns")


def name_of(file: Path) -> str:
    return str(file.relative_to(ROOT))


def calls(tree: ast.AST) -> Iterator[tuple[str, ast.Call]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            yield ast.unparse(node.func), node


def test_no_file_is_longer_than_four_hundred_lines() -> None:
    folders = ("src", "tests", "benchmarks", "scripts")
    files = [file for folder in folders for file in (ROOT / folder).rglob("*.py")]
    lengths = {name_of(file): len(file.read_text().splitlines()) for file in files}
    assert len(lengths) > 10
    assert {name: length for name, length in lengths.items() if length > 400} == {}


@pytest.mark.parametrize("file", PUBLIC, ids=name_of)
def test_exports_exactly_what_it_defines_in_public(file: Path) -> None:
    tree = ast.parse(file.read_text())
    defined = {
        node.name
        for node in tree.body
        if isinstance(node, ast.FunctionDef | ast.ClassDef)
        and not node.name.startswith("_")
        # A command belongs to the program, not to its module.
        and "app.command()" not in [ast.unparse(mark) for mark in node.decorator_list]
    }
    exported: list[str] = []
    for node in tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            exported = ast.literal_eval(node.value)
    assert defined - set(exported) == set(), "defined in public, but not in __all__"
    assert len(set(exported)) == len(exported)


@pytest.mark.slow
def test_kernels_are_compiled_by_one_decorator_without_fast_math() -> None:
    wrong = {}
    for file in SOURCES:
        if name_of(file) in COMPILERS:
            continue
        tree = ast.parse(file.read_text())
        imported = [
            ast.unparse(node)
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom | ast.Import)
        ]
        if any(" numba" in line for line in imported):
            wrong[name_of(file)] = "imports numba itself"
        if any(word.arg == "fastmath" for _, call in calls(tree) for word in call.keywords):
            wrong[name_of(file)] = "asks for fastmath"
    assert wrong == {}


def test_edges_hold_no_kernels() -> None:
    # conftest leaves these out of the key of the cache of compiled kernels.
    edges = [file for file in SOURCES if file.relative_to(SOURCE).parts[0] in EDGES]
    assert edges
    assert [name_of(file) for file in edges if "trackweave.jit" in file.read_text()] == []


@pytest.mark.slow
def test_generators_are_made_of_seeds_in_one_place() -> None:
    # The commands have their own. Estimates alone must follow from the reports, whatever the seed
    # of the run that takes them.
    makers = [
        name_of(file)
        for file in SOURCES
        if file.relative_to(SOURCE).parts[0] != "cli"
        and any(name.endswith("default_rng") for name, _ in calls(ast.parse(file.read_text())))
    ]
    assert makers == ["src/trackweave/randomness.py", "src/trackweave/run/refining.py"]


@pytest.mark.slow
def test_library_raises_its_own_exceptions() -> None:
    foreign = {"Exception", "BaseException", "ValueError", "RuntimeError", "AssertionError"}
    found = [
        f"{name_of(file)}:{node.lineno}"
        for file in SOURCES
        # Pydantic's checks speak in ValueError, which the package translates.
        if file.parent.name != "config"
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.Raise)
        and isinstance(node.exc, ast.Call)
        and ast.unparse(node.exc.func) in foreign
    ]
    assert found == []


@pytest.mark.parametrize("file", TESTS, ids=name_of)
def test_every_test_can_fail(file: Path) -> None:
    idle = []
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            asserts = any(isinstance(inner, ast.Assert) for inner in ast.walk(node))
            checks = any(word in name for name, _ in calls(node) for word in CHECKS)
            if not asserts and not checks:
                idle.append(node.name)
    assert idle == []
