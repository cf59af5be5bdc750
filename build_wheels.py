"""Builds wheels that hold compiled kernels: hatchling's backend, and a hook that compiles them.

A wheel from a checkout holds what a first look reaches; TRACKWEAVE_KERNELS=all, as for releases,
makes one with all of them, and TRACKWEAVE_KERNELS=none one without, for any Python and machine.
An editable installation has none: what is edited has to be compiled anew.
"""

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import Any

from hatchling.build import (
    build_editable,
    build_sdist,
    build_wheel,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
)
from hatchling.build import get_requires_for_build_wheel as requires_of_hatchling
from hatchling.builders.hooks.plugin.interface import BuildHookInterface

__all__ = [
    "KernelHook",
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
]

ROOT = Path(__file__).resolve().parent
PART = "TRACKWEAVE_KERNELS"
DRAWN_WITH = "matplotlib"
"""The dependency that compiles nothing and is large; a first look draws nothing."""
ANY_PROCESSOR = {"x86_64": "x86-64", "amd64": "x86-64"}


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Return what has to be there to build a wheel: what its kernels are compiled with.

    Parameters
    ----------
    config_settings
        What the frontend passes on.

    Returns
    -------
    Requirements.
    """
    needed = requires_of_hatchling(config_settings)
    if _part() == "none":
        return needed
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    pinned = project["optional-dependencies"]["compiled"] if _part() == "all" else []
    # What covers all kernels runs studies too, which draw.
    known = [
        name
        for name in project["dependencies"]
        if _part() == "all" or not name.startswith(DRAWN_WITH)
    ]
    return [*needed, *known, *pinned]


class KernelHook(BuildHookInterface):  # type: ignore[type-arg]
    """Puts compiled kernels into a wheel."""

    PLUGIN_NAME = "custom"
    scratch: Path | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile, and have the wheel say for which Python and machine that is.

        Parameters
        ----------
        version
            "standard", or "editable", which gets none.
        build_data
            What hatchling builds the wheel from; written to.

        Raises
        ------
        RuntimeError
            If all kernels are asked for, and they cannot be compiled.
        """
        part = _part()
        if version != "standard" or part == "none":
            return
        self.scratch = Path(tempfile.mkdtemp(prefix="trackweave-build-"))
        done = _compile(part, self.scratch, self.metadata.version)
        if done.returncode == 0:
            build_data["pure_python"], build_data["infer_tag"] = False, True
            build_data["force_include"][str(self.scratch / "kernels")] = "trackweave/_compiled"
        elif part == "all":
            raise RuntimeError(f"kernels cannot be compiled: {done.stderr}")
        else:
            self.app.display_warning(f"without compiled kernels: {done.stderr}")

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what was compiled from where it was compiled.

        Parameters
        ----------
        version, build_data, artifact_path
            As hatchling passes them; not needed.
        """
        if self.scratch is not None:
            shutil.rmtree(self.scratch, ignore_errors=True)


def _part() -> str:
    """Return which kernels are asked for: "first", "all" or "none"."""
    return os.environ.get(PART, "first")


def _compile(part: str, scratch: Path, version: str) -> subprocess.CompletedProcess[str]:
    """Compile a part into the folder ``kernels``, for any processor of this kind."""
    # The package asks for its own version, which an environment for building does not know.
    known = scratch / f"trackweave-{version}.dist-info" / "METADATA"
    known.parent.mkdir()
    known.write_text(f"Metadata-Version: 2.1\nName: trackweave\nVersion: {version}\n")
    environment = {name: value for name, value in os.environ.items() if name[:6] != "NUMBA_"}
    paths = [str(ROOT / "src"), str(scratch), environment.get("PYTHONPATH", "")]
    environment |= {
        "NUMBA_CACHE_DIR": str(scratch / "kept"),
        "NUMBA_CPU_NAME": ANY_PROCESSOR.get(platform.machine().lower(), "generic"),
        "NUMBA_CPU_FEATURES": "",
        "PYTHONPATH": os.pathsep.join(filter(None, paths)),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    return subprocess.run(
        [sys.executable, "-m", "trackweave.warming", part, str(scratch / "kernels")],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
