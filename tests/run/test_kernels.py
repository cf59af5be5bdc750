"""Compiling that takes long is told; what was compiled before is not compiled again."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from trackweave.run.kernels import COMPILING

COMPILE = """
import numpy as np
from trackweave.run import kernels
kernels.PATIENCE = 0.05
said = []
with kernels.compiling_told(lambda: said.append(1)):
    from trackweave.filters import _kernels
    for _ in range(3):
        _kernels.squared_distance(np.zeros(2), np.zeros(2), np.eye(2))
    _kernels.squared_distance(np.zeros(3), np.zeros(3), np.eye(3))
print(len(said))
"""


WITHIN = COMPILE.replace(
    "with kernels.compiling_told(lambda: said.append(1)):",
    "with kernels.compiling_told(lambda: said.append(1)), "
    "kernels.compiling_told(lambda: said.append(2)):",
)


def ran(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run code in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )


def said(code: str = COMPILE, **environment: str) -> str:
    """Return how often it was told."""
    return ran(code, **environment).stdout.strip()


@pytest.mark.slow
def test_compiling_is_told_once_and_not_where_kernels_are_kept(tmp_path: Path) -> None:
    cache = {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_DISABLE_JIT": "0"}
    assert said(**cache) == "1"
    assert said(**cache) == "0"


def test_nothing_is_told_where_compiling_is_off(tmp_path: Path) -> None:
    assert said(NUMBA_CACHE_DIR=str(tmp_path), NUMBA_DISABLE_JIT="1") == "0"


@pytest.mark.slow
def test_of_blocks_within_one_another_the_outermost_tells(tmp_path: Path) -> None:
    cache = {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_DISABLE_JIT": "0"}
    assert said(WITHIN, **cache) == "1"


@pytest.mark.slow
def test_who_calls_from_python_is_told_on_standard_error(tmp_path: Path) -> None:
    code = COMPILE.replace("compiling_told(lambda: said.append(1))", "compiling_told()")
    done = ran(code, NUMBA_CACHE_DIR=str(tmp_path), NUMBA_DISABLE_JIT="0")
    assert done.stderr == f"{COMPILING}\n"
