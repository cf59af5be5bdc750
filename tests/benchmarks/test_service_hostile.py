"""Hostile messages to a service of its own process, as the benchmark sends a million of them."""

import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow


@pytest.fixture
def benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parents[2] / "benchmarks"), *sys.path])


@pytest.mark.usefixtures("benchmarks")
def test_nothing_gets_in_and_the_service_still_answers() -> None:
    from service_hostile import measure

    found = measure(1500, 100)
    assert found["entries"] == 0
    assert found["without an answer in 60 s"] == 0
    assert found["messages"] >= 1500
    assert found["reports taken with the right token"] > 0
    before, _, after = found["memory_mb"]
    assert after < before + 100
    statuses = {kind.rpartition(" ")[2] for kind in found["answers"] if ":" in kind}
    assert {"200", "400", "401"} <= statuses
    assert "500" not in statuses
