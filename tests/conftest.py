"""What all tests share: a cache of compiled kernels that follows the sources, and fixtures."""

import hashlib
import os
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Imports no compiler, which reads its settings once.
from trackweave.kernel_sources import digest_of, kernel_files, sources_of

ROOT = Path(__file__).resolve().parent.parent


def _cache_folder() -> Path:
    """Return a folder named for the sources, so that checkouts beside this one keep theirs."""
    # Numba does not tell kernels with bounds checked from others.
    digest = hashlib.sha256(os.environ.get("NUMBA_BOUNDSCHECK", "").encode())
    sources = {source for file in kernel_files() for source in sources_of(file)}
    digest.update(digest_of(sources).encode())
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


def _is_of_all(config: pytest.Config) -> bool:
    """Tell whether all tests are asked for, and none by its file or its marks."""
    if hasattr(config, "workerinput"):
        return bool(config.workerinput["is_of_all"])
    is_all = config.args_source is pytest.Config.ArgsSource.TESTPATHS
    return is_all and config.option.markexpr == "not tutorial" and not config.option.keyword


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node) -> None:
    """Let workers know what was asked for."""
    node.workerinput["is_of_all"] = _is_of_all(node.config)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave the slow tests out where all are asked for."""
    if _is_of_all(config):
        slow = [item for item in items if "slow" in item.keywords]
        config.hook.pytest_deselected(items=slow)
        items[:] = [item for item in items if "slow" not in item.keywords]


@pytest.fixture(scope="session")
def shared() -> Path:
    """Return the folder of recordings beside the checkout, or skip the test."""
    folder = ROOT.parent / "shared"
    if not folder.is_dir():
        pytest.skip("the recordings are not beside the checkout")
    return folder
