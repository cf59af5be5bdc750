"""Tests of the evaluation of a run."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from trackweave.domain.tracks import TrackTable
from trackweave.domain.truth import TruthTable
from trackweave.errors import InvalidInputError
from trackweave.metrics.assignments import assignment_quality
from trackweave.metrics.evaluate import evaluate

Row = tuple[int, str, float, float]


def noisy_tracks(truth: TruthTable, rng: np.random.Generator) -> list[Row]:
    """Return tracks that miss, wander, swap names, and a ghost."""
    names = sorted(set(truth.target))
    alias = dict(zip(names, names, strict=True))
    rows: dict[tuple[int, str], Row] = {}
    for time, target, place in zip(truth.time, truth.target, truth.position, strict=True):
        if rng.random() < 0.03:
            other = names[rng.integers(len(names))]
            alias[target], alias[other] = alias[other], alias[target]
        if rng.random() < 0.9:
            x, y = place + 25 * rng.standard_normal(2)
            key = int(time), f"t{alias[target]}"
            rows.setdefault(key, (*key, float(x), float(y)))
    ghosts = [(k, "ghost", *rng.uniform(0, 1000, 2).tolist()) for k in range(40)]
    return [*rows.values(), *ghosts]


def as_table(rows: list[Row]) -> TruthTable:
    return TruthTable.from_columns(
        [float(row[0]) for row in rows], [row[1] for row in rows], [row[2:] for row in rows]
    )


def simple_truth() -> TruthTable:
    times = [0.0, 1.0, 2.0, 3.0]
    return TruthTable.from_columns(
        np.repeat(times, 2), ["a", "b"] * 4, [[t, y] for t in times for y in (0.0, 500.0)]
    )


def judged(judge: Path, name: str, tracks: list[Row], file: Path) -> dict[str, float]:
    """Return what the judge says; as a program of its own, for it leaves files open."""
    with file.open("w", newline="") as lines:
        csv.writer(lines).writerows([("scan", "track", "x", "y"), *tracks])
    done = subprocess.run(
        [sys.executable, str(judge), name, str(file)], capture_output=True, text=True, check=True
    )
    said: dict[str, float] = json.loads(done.stdout)
    return said


@pytest.mark.shared
def test_agrees_with_the_benchmarks_judge(shared: Path, tmp_path: Path) -> None:
    for name in ("T5_S1_r1", "T50_S1_r1"):
        with (shared / "bench" / "data" / name / "truth.csv").open() as file:
            rows = list(csv.DictReader(file))
        truth = TruthTable.from_columns(
            [float(row["time"]) for row in rows],
            [row["target"] for row in rows],
            [[float(row["x"]), float(row["y"])] for row in rows],
        )
        tracks = noisy_tracks(truth, np.random.default_rng(5))
        expected = judged(shared / "bench" / "score.py", name, tracks, tmp_path / "tracks.csv")
        found = evaluate(truth, as_table(tracks), cutoff=50, order=2, max_gap=0.0)
        assert found.gospa == pytest.approx(expected["gospa"], abs=0.0051)
        assert found.ospa == pytest.approx(expected["ospa"], abs=0.0051)
        assert found.rmse == pytest.approx(expected["rmse"], abs=0.0051)
        assert found.covered == pytest.approx(expected["covered"], abs=0.0001)
        assert found.missed_per_time == pytest.approx(expected["missed_per_scan"], abs=0.0051)
        assert found.false_per_time == pytest.approx(expected["false_per_scan"], abs=0.0051)
        assert found.switches == expected["switches"]
        assert found.n_tracks == expected["track_ids"]


def test_values_computed_by_hand() -> None:
    truth = simple_truth()
    # One track 3 m beside target a all the time, one on b for the first two times.
    rows = [(k, "7", float(k), 3.0) for k in range(4)]
    rows += [(k, "9", float(k), 500.0) for k in range(2)]
    found = evaluate(truth, as_table(rows), cutoff=50, order=2)
    assert found.gospa == pytest.approx((3 + 3 + 2 * np.sqrt(9 + 1250)) / 4)
    assert found.gospa_localisation == pytest.approx(3.0)
    assert found.gospa_missed == pytest.approx(np.sqrt(1250) / 2)
    assert (found.gospa_false, found.false_per_time) == (0.0, 0.0)
    assert found.missed_per_time == pytest.approx(0.5)
    assert found.mota == pytest.approx(1 - 2 / 8)
    assert found.motp == pytest.approx(3 * 4 / 6)
    assert found.rmse == pytest.approx(np.sqrt(9 * 4 / 6))
    assert found.idf1 == pytest.approx(2 * 6 / (8 + 6))
    assert (found.idp, found.idr) == (1.0, 0.75)
    assert (found.n_truth, found.n_found, found.n_tracks, found.n_times) == (2, 2, 2, 4)


def test_without_tracks_everything_is_missed() -> None:
    found = evaluate(simple_truth(), TrackTable.empty(2), cutoff=50)
    assert found.gospa == pytest.approx(np.sqrt(2 * 1250))
    assert found.gospa == pytest.approx(found.gospa_missed)
    assert (found.ospa, found.mota, found.hota, found.idf1) == (50.0, 0.0, 0.0, 0.0)
    assert (found.motp, found.rmse, found.idp, found.right_share) == (None, None, None, None)


def test_is_ready_for_json_with_the_promised_keys() -> None:
    found = evaluate(simple_truth(), simple_truth()).as_dict()
    promised = (
        "gospa gospa_localisation gospa_missed gospa_false ospa mota motp idf1 idp idr hota "
        "switches fragmentations rmse n_truth n_tracks right_share ospa2 loca mostly_tracked "
        "partly_tracked mostly_lost report_mota report_switches targets window"
    )
    assert set(promised.split()) <= set(found)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["right_share"] is None


def test_tells_of_each_target() -> None:
    rows = [(k, "7", float(k), 3.0) for k in range(4)]
    rows += [(k, "9", float(k), 500.0) for k in range(2)]
    found = evaluate(simple_truth(), as_table(rows))
    assert (found.mostly_tracked, found.partly_tracked, found.mostly_lost) == (1, 1, 0)
    assert [record.tracks for record in found.targets] == [("7",), ("9",)]
    first, second = found.as_dict()["targets"]
    assert (first["target"], first["rmse"], first["covered"]) == ("a", 3.0, 1.0)
    assert (second["target"], second["rmse"], second["covered"]) == ("b", 0.0, 0.5)


def test_ospa2_sees_what_ospa_does_not() -> None:
    truth = TruthTable.from_columns(np.arange(6.0), ["a"] * 6, np.zeros((6, 2)))
    broken = as_table([(k, "xy"[k // 3], 0.0, 0.0) for k in range(6)])
    found = evaluate(truth, broken, window=6)
    assert found.ospa == 0.0
    assert found.ospa2 is not None
    assert found.ospa2 > 5.0
    assert found.window == 6


def test_takes_in_the_measures_of_reports() -> None:
    quality = assignment_quality(["a", "a", ""], [1, 1, 2])
    found = evaluate(simple_truth(), simple_truth()).with_assignments(quality)
    assert found.right_share == pytest.approx(2 / 3)
    assert found.report_idf1 == quality.idf1
    assert found.report_purity == quality.purity
    assert (found.report_mota, found.report_switches) == (quality.mota, quality.switches)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"cutoff": -1.0}, "cutoff: -1.0"),
        ({"order": 0.0}, "order: 0.0"),
        ({"max_gap": -2.0}, "max_gap: -2.0"),
        ({"window": 0}, "window: 0"),
    ],
)
def test_refuses_parameters_out_of_range(change: dict[str, float], words: str) -> None:
    with pytest.raises(InvalidInputError, match=words):
        evaluate(simple_truth(), simple_truth(), **change)


def test_refuses_an_empty_truth() -> None:
    empty = TruthTable.from_columns([], [], np.empty((0, 2)))
    with pytest.raises(InvalidInputError, match="truth: no rows"):
        evaluate(empty, simple_truth())
