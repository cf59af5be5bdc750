"""The command warm."""

import json

import pytest

from cli.conftest import Run
from trackweave.association._growth import propose
from trackweave.cli import warm
from trackweave.kernel_cache import machine
from trackweave.run import track


@pytest.fixture
def little(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the command reach little, so that it takes little."""
    import polars as pl

    reports = pl.DataFrame({"time": range(6), "x": [float(k) for k in range(6)], "y": [0.0] * 6})
    tasks = {"first": [("one", lambda: track(reports))], "all": []}
    monkeypatch.setattr(warm, "tasks_of", tasks.__getitem__)


@pytest.mark.usefixtures("little")
def test_says_where_kernels_come_from(run: Run) -> None:
    found = json.loads(run("warm", "--json").stdout)
    assert found["shipped"] == 0
    assert found["kept"] + found["compiled"] > 0
    # Tests run on sources that are edited: nothing came with them.
    assert found["shipped_folder"] is None
    assert found["why_not_shipped"] == "none came with it"
    assert found["numba"] == machine()["numba"]
    assert found["kept_folders"] == sorted(found["kept_folders"])
    assert any(folder in str(propose.stats.cache_path) for folder in found["kept_folders"])


@pytest.mark.usefixtures("little")
def test_says_so_in_words_unless_told_to_be_quiet(run: Run) -> None:
    said = run("warm").stderr
    assert "used 0 kernels that came with the package (none came with it), " in said
    assert "kept in " in said
    assert run("warm", "--quiet").output == ""
    assert run("warm", "--all", "--json").exit_code == 0
