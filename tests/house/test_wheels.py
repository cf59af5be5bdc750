"""What builds wheels has all that it compiles with."""

import importlib.util
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


@pytest.fixture
def backend(monkeypatch):
    """Return the build's backend; hatchling, which only builds have, is left out."""
    functions = [
        f"{kind}_{what}"
        for kind in ("build", "get_requires_for_build")
        for what in ("editable", "sdist", "wheel")
    ]
    build, hooks = ModuleType("hatchling.build"), ModuleType("interface")
    for name in functions:
        setattr(build, name, lambda *_: ["hatchling"])
    hooks.BuildHookInterface = object
    names = ("", ".builders", ".builders.hooks", ".builders.hooks.plugin")
    for name in names:
        monkeypatch.setitem(sys.modules, f"hatchling{name}", ModuleType(f"hatchling{name}"))
    monkeypatch.setitem(sys.modules, "hatchling.build", build)
    monkeypatch.setitem(sys.modules, f"hatchling{names[-1]}.interface", hooks)
    spec = importlib.util.spec_from_file_location("build_wheels", ROOT / "build_wheels.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_all_kernels_are_compiled_with_every_dependency_and_the_very_compiler(
    backend, monkeypatch
) -> None:
    monkeypatch.setenv("TRACKWEAVE_KERNELS", "all")
    needed = backend.get_requires_for_build_wheel()
    assert set(needed) >= {*PROJECT["dependencies"], "hatchling"}
    assert set(needed) >= set(PROJECT["optional-dependencies"]["compiled"])


def test_a_first_look_is_compiled_without_what_draws(backend, monkeypatch) -> None:
    monkeypatch.delenv("TRACKWEAVE_KERNELS", raising=False)
    left_out = set(PROJECT["dependencies"]) - set(backend.get_requires_for_build_wheel())
    assert [name.partition(">")[0] for name in left_out] == ["matplotlib"]


def test_a_wheel_without_kernels_needs_hatchling_alone(backend, monkeypatch) -> None:
    monkeypatch.setenv("TRACKWEAVE_KERNELS", "none")
    assert backend.get_requires_for_build_wheel() == ["hatchling"]
