"""What ``import trackweave`` offers."""

import ast
import builtins
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import trackweave


def test_every_public_name_resolves() -> None:
    for name in trackweave.__all__:
        assert getattr(trackweave, name) is not None


def test_names_for_type_checkers_are_those_at_run_time() -> None:
    tree = ast.parse(Path(trackweave.__file__).read_text())
    imported = {
        (alias.asname, node.module)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("trackweave")
        for alias in node.names
    }
    assert imported == set(trackweave._HOMES.items())


def test_public_names_are_sorted_and_listed() -> None:
    assert list(trackweave._HOMES) == sorted(trackweave._HOMES)
    assert dir(trackweave) == trackweave.__all__


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'tracks'"):
        _ = trackweave.tracks


def test_every_error_that_a_public_name_says_it_raises_is_public_and_explained() -> None:
    values = [getattr(trackweave, name) for name in trackweave.__all__]
    documented = [
        *values,
        *(m for v in values if inspect.isclass(v) for m in vars(v).values() if callable(m)),
    ]
    raised = {
        error
        for value in documented
        for error in re.findall(r"^ +(\w+Error)$", value.__doc__ or "", re.MULTILINE)
        if not hasattr(builtins, error)
    }
    assert raised <= set(trackweave.__all__)
    page = Path(__file__).parents[2] / "docs/reference/messages.md"
    kinds = page.read_text().partition("## Tables")[0]
    assert [error for error in raised if f"| `{error}` |" not in kinds] == []


def test_importing_the_package_imports_nothing_else() -> None:
    code = (
        "import sys; import trackweave; trackweave.__all__;"
        "print([m for m in sys.modules if m.startswith('trackweave.') or m in {'numpy', 'numba'}])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
