"""Kernels compile, are kept on disk, and do without where nothing can be kept."""

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest
from numba.extending import is_jitted

import trackweave

SOURCE = Path(trackweave.__file__).parent
# A folder below a file cannot be made, not even by the superuser.
NOWHERE = "/dev/null/nowhere"


def kernel_modules():
    """Return the modules that use the decorator."""
    return [
        file
        for file in sorted(SOURCE.rglob("*.py"))
        if re.search(r"^@jit$", file.read_text(encoding="utf-8"), re.MULTILINE)
    ]


def run(code, **environment):
    """Run code in a process of its own; return what it printed."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", textwrap.dedent(code)],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


USE_A_KERNEL = """
    import numpy as np
    from trackweave.filters._kernels import squared_distance
    print(squared_distance(np.array([3.0, 4.0]), np.zeros(2), np.eye(2)))
"""


@pytest.mark.parametrize("file", kernel_modules(), ids=lambda file: file.stem + file.parent.name)
def test_kernels_release_the_lock_keep_their_code_and_round_strictly(file):
    name = ".".join(["trackweave", *file.relative_to(SOURCE).with_suffix("").parts])
    module = __import__(name, fromlist=["_"])
    kernels = [value for value in vars(module).values() if is_jitted(value)]
    assert kernels
    for kernel in kernels:
        assert kernel.targetoptions["nogil"]
        assert not kernel.targetoptions.get("fastmath", False)
        assert kernel.targetoptions["nopython"]


@pytest.mark.slow
def test_code_is_kept_and_found_again(tmp_path):
    first = run(USE_A_KERNEL, NUMBA_CACHE_DIR=str(tmp_path / "kept"))
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "kept").rglob("*.nbc")}
    assert kept
    assert run(USE_A_KERNEL, NUMBA_CACHE_DIR=str(tmp_path / "kept")) == first == "25.0"
    again = {path: path.stat().st_mtime_ns for path in (tmp_path / "kept").rglob("*.nbc")}
    assert again == kept


def test_works_where_nothing_can_be_kept():
    assert run(USE_A_KERNEL, NUMBA_CACHE_DIR=NOWHERE) == "25.0"


def test_a_home_that_cannot_be_written_does_not_matter():
    assert run(USE_A_KERNEL, HOME=NOWHERE, XDG_CACHE_HOME=NOWHERE) == "25.0"


def test_a_user_without_a_home_does_not_matter():
    code = f"""
        from pathlib import Path
        def homeless():
            raise RuntimeError("Could not determine home directory.")
        Path.home = homeless
        {USE_A_KERNEL.strip().replace(chr(10) + "    ", chr(10) + "        ")}
    """
    assert run(code) == "25.0"


def test_a_read_only_package_does_not_matter(tmp_path):
    """Numba finds no place at all: the package pretends to lie where nothing can be written."""
    code = f"""
        import numba.core.caching as caching
        def refuse(self):
            raise OSError("read-only")
        caching._CacheLocator.ensure_cache_path = refuse
        {USE_A_KERNEL.strip().replace(chr(10) + "    ", chr(10) + "        ")}
    """
    assert run(code, HOME=str(tmp_path), XDG_CACHE_HOME=str(tmp_path)) == "25.0"
