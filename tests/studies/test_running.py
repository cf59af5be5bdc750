"""Studies part by part: written as they come, gone on with after an interruption."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.io.output import OutputDirectory
from trackweave.studies import Claim, Part, Study, Tick, WriteUp
from trackweave.studies.judging import Verdict
from trackweave.studies.running import Order, run_study
from trackweave.studies.writing import Table, frame, text_table

ORDER = Order("huo-2008", seed=3, quick=True)


class _Drawn:
    """A study of random numbers whose parts count how often they are measured."""

    def __init__(self, stops_at: str | None = None) -> None:
        self.stops_at = stops_at
        self.measured: list[str] = []

    def study(self) -> Study:
        return Study(tuple(Part(name, self._part(name)) for name in "abc"), self._write_up)

    def _part(self, name: str):  # type: ignore[no-untyped-def]
        def measure(rng: np.random.Generator, quick: bool, tick: Tick) -> Mapping[str, Table]:
            if name == self.stops_at:
                raise KeyboardInterrupt
            self.measured.append(name)
            tick(1, 2)
            rows = ((name, 1, float(rng.normal()), None), ('x, "y"', 2, 1.0, float(quick)))
            return {f"table-{name}": frame(("what", "number", "drawn", "known"), rows)}

        return measure

    def _write_up(self, tables: Mapping[str, Table], quick: bool) -> WriteUp:
        text = "\n\n".join(text_table(table.columns, table.rows()) for table in tables.values())
        claims = (Claim("“It holds”", Verdict.HOLDS, "1 of 1."),)
        return WriteUp(f"# Report\n\n{text}\n", claims, {"figure.png": b"png"})


def contents(folder: Path) -> dict[str, bytes]:
    """Return a run's files but for how long it took."""
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    record = json.loads(files["run.json"])
    del record["timing"]
    return {**files, "run.json": json.dumps(record).encode()}


@pytest.mark.parametrize("stops_at", ["a", "b", "c"])
def test_an_interrupted_study_goes_on_and_ends_with_the_same_bytes(
    stops_at: str, tmp_path: Path
) -> None:
    whole = OutputDirectory(tmp_path / "whole", "reproduce")
    run_study(_Drawn().study(), ORDER, whole)
    parted = OutputDirectory(tmp_path / "parted", "reproduce")
    with pytest.raises(KeyboardInterrupt):
        run_study(_Drawn(stops_at).study(), ORDER, parted)
    again = _Drawn()
    run_study(again.study(), ORDER, parted)
    assert again.measured == list("abc"["abc".index(stops_at) :])
    assert contents(tmp_path / "parted") == contents(tmp_path / "whole")


def test_each_part_is_on_the_disk_once_it_is_measured(tmp_path: Path) -> None:
    place = OutputDirectory(tmp_path / "out", "reproduce")
    with pytest.raises(KeyboardInterrupt):
        run_study(_Drawn("c").study(), ORDER, place)
    names = sorted(path.name for path in place.path.iterdir())
    assert names == ["run.json", "table-a.csv", "table-b.csv"]
    assert json.loads((place.path / "run.json").read_text())["complete"] is False


@pytest.mark.parametrize("other", [Order("huo-2008", 4, True), Order("huo-2008", 3, False)])
def test_a_run_of_another_order_starts_anew(other: Order, tmp_path: Path) -> None:
    place = OutputDirectory(tmp_path / "out", "reproduce")
    with pytest.raises(KeyboardInterrupt):
        run_study(_Drawn("c").study(), ORDER, place)
    again = _Drawn()
    run_study(again.study(), other, place)
    assert again.measured == ["a", "b", "c"]


def test_a_complete_run_is_measured_anew(tmp_path: Path) -> None:
    place = OutputDirectory(tmp_path / "out", "reproduce")
    run_study(_Drawn().study(), ORDER, place)
    again = _Drawn()
    run_study(again.study(), ORDER, place)
    assert again.measured == ["a", "b", "c"]


@pytest.mark.parametrize("harm", ["remove", "mangle", "record"])
def test_refuses_to_go_on_with_files_that_have_changed(harm: str, tmp_path: Path) -> None:
    place = OutputDirectory(tmp_path / "out", "reproduce")
    with pytest.raises(KeyboardInterrupt):
        run_study(_Drawn("c").study(), ORDER, place)
    if harm == "remove":
        (place.path / "table-a.csv").unlink()
    elif harm == "mangle":
        (place.path / "table-a.csv").write_bytes(b"")
    else:
        record = json.loads((place.path / "run.json").read_text())
        record["parts"] = ["a"]
        (place.path / "run.json").write_text(json.dumps(record))
    with pytest.raises(InvalidInputError, match="interrupted run have changed"):
        run_study(_Drawn().study(), ORDER, place)


def test_progress_never_falls_back(tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    place = OutputDirectory(tmp_path / "out", "reproduce")
    run_study(_Drawn().study(), ORDER, place, lambda done, of: seen.append((done, of)))
    assert len(seen) == 3
    assert seen == sorted(seen)


def test_a_quick_run_is_marked_so(tmp_path: Path) -> None:
    run_study(_Drawn().study(), ORDER, OutputDirectory(tmp_path / "quick", "reproduce"))
    assert "**Quick run" in (tmp_path / "quick" / "report.md").read_text()
    full = Order("huo-2008", 3, False)
    run_study(_Drawn().study(), full, OutputDirectory(tmp_path / "full", "reproduce"))
    assert "Quick run" not in (tmp_path / "full" / "report.md").read_text()
