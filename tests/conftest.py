"""What all tests share: a cache of compiled kernels that follows the sources, and fixtures."""

import hashlib
import os
import re
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "trackweave"
IMPORTED = re.compile(r"^from (trackweave[\w.]*) import (?:\(([^)]*)\)|(.*))$", re.MULTILINE)


def kernel_sources() -> list[Path]:
    """Return the files on which compiled kernels may depend: theirs, and what those import."""
    waiting = [file for file in SOURCE.rglob("*.py") if "@jit" in file.read_text()]
    found: set[Path] = set()
    while waiting:
        file = waiting.pop()
        if file in found:
            continue
        found.add(file)
        for module, many, few in IMPORTED.findall(file.read_text()):
            names = [name.split(" as ")[0].strip() for name in (many or few).split(",")]
            paths = [SOURCE.parent.joinpath(*module.split("."), name) for name in ("", *names)]
            waiting += [path for path in (p.with_suffix(".py") for p in paths) if path.is_file()]
    return sorted(found)


def _cache_folder() -> Path:
    """Return a folder named for the sources: numba does not see edits of a callee elsewhere."""
    # Nor does it tell kernels with bounds checked from others.
    digest = hashlib.sha256(os.environ.get("NUMBA_BOUNDSCHECK", "").encode())
    for file in kernel_sources():
        digest.update(str(file.relative_to(SOURCE)).encode() + b"\0" + file.read_bytes())
    user = os.getuid() if hasattr(os, "getuid") else "user"
    folder = Path(tempfile.gettempdir()) / f"trackweave-kernels-{user}" / digest.hexdigest()[:16]
    folder.mkdir(parents=True, exist_ok=True)
    return folder


# Before anything imports numba, which reads these once.
os.environ["NUMBA_CACHE_DIR"] = str(_cache_folder())
os.environ.setdefault("MPLBACKEND", "agg")

# The same examples at each run; HYPOTHESIS_PROFILE=explore looks for new ones.
settings.register_profile(
    "steady",
    derandomize=True,
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("explore", parent=settings.get_profile("steady"), derandomize=False)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))


@pytest.fixture(scope="session")
def shared() -> Path:
    """Return the folder of recordings beside the checkout, or skip the test."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip("the recordings are not beside the checkout")
    return folder
