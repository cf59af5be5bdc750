"""A first run is told from later ones."""

import os
import subprocess
import sys
from pathlib import Path

TELL = "from trackweave.run.kernels import kernels_are_kept; print(kernels_are_kept())"
COMPILE = (
    "import numpy as np; from trackweave.filters import _kernels; "
    "_kernels.squared_distance(np.zeros(2), np.zeros(2), np.eye(2))"
)


def run(code: str, **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_kernels_are_kept_from_the_first_use_on(tmp_path: Path) -> None:
    cache = {"NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_DISABLE_JIT": "0"}
    assert run(TELL, **cache) == "False"
    run(COMPILE, **cache)
    assert run(TELL, **cache) == "True"


def test_nothing_is_compiled_where_compiling_is_off(tmp_path: Path) -> None:
    assert run(TELL, NUMBA_CACHE_DIR=str(tmp_path), NUMBA_DISABLE_JIT="1") == "True"
