"""The fuzzing of formats finds what it looks for."""

import importlib
import sys
from pathlib import Path
from typing import Any

import pytest

from trackweave.domain.facts import Facts, Skips
from trackweave.formats.sbs import SbsDecoder

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"


@pytest.fixture
def damaging(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return the benchmark as a module."""
    monkeypatch.setattr(sys, "path", [str(BENCHMARKS), *sys.path])
    return importlib.import_module("damaged_files")


@pytest.mark.parametrize("name", ["sbs", "mot", "trackmate", "csv", "parquet"])
def test_nothing_is_wrong_with_a_few(damaging: Any, name: str) -> None:
    found, _ = damaging.fuzzed(name, 30, 5)
    assert found.files >= 30
    assert found.wrong == []


@pytest.mark.parametrize(("kind", "method"), [(Skips, "add"), (Facts, "leave_out")])
def test_a_decoder_that_forgets_to_count_is_found_out(
    damaging: Any, monkeypatch: pytest.MonkeyPatch, kind: type, method: str
) -> None:
    monkeypatch.setattr(kind, method, lambda *_: None)
    assert any(
        "records" in line and "told" in line for line in damaging.fuzzed("sbs", 30, 5)[0].wrong
    )


def test_what_is_raised_and_what_depends_on_pieces_is_found_out(
    damaging: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    honest = SbsDecoder.feed

    def raises(self: SbsDecoder, data: bytes) -> Any:
        return 1 / 0 if b"4CA2D6" not in data else honest(self, data)

    monkeypatch.setattr(SbsDecoder, "feed", raises)
    assert any("ZeroDivisionError" in line for line in damaging.fuzzed("sbs", 30, 5)[0].wrong)

    def forgets(self: SbsDecoder, data: bytes) -> Any:
        self._rest = b""
        return honest(self, data)

    monkeypatch.setattr(SbsDecoder, "feed", forgets)
    assert any("pieces" in line for line in damaging.fuzzed("sbs", 30, 5)[0].wrong)
