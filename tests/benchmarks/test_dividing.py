"""Cells that divide, judged by an independent program."""

import sys
from pathlib import Path

import polars as pl
import pytest


@pytest.fixture
def benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parents[2] / "benchmarks"), *sys.path])
    monkeypatch.setenv("TQDM_DISABLE", "1")


@pytest.mark.usefixtures("benchmarks")
def test_simulated_cells_divide_in_two_where_their_mother_was() -> None:
    from dividing_cells import APART, simulated

    truth, detections = simulated(1)
    daughters = truth.filter(truth["parent"].is_not_null())
    assert daughters.group_by("parent").agg(pl.col("track").n_unique())["track"].max() == 2
    first = daughters.sort("time").group_by("track").first()
    last = truth.sort("time").group_by("track").last()
    both = first.join(last, left_on="parent", right_on="track")
    assert (both["time"] == both["time_right"] + 1).all()
    apart = ((both["x"] - both["x_right"]) ** 2 + (both["y"] - both["y_right"]) ** 2).sqrt()
    assert apart.median() == pytest.approx(APART, abs=3.0)
    assert detections["target"].null_count() > 0


@pytest.mark.slow
@pytest.mark.usefixtures("benchmarks")
@pytest.mark.filterwarnings("ignore")
def test_lineages_stand_before_an_independent_judge() -> None:
    pytest.importorskip("traccuracy")
    pytest.importorskip("tifffile")
    from dividing import measures, ours
    from dividing_cells import simulated

    truth, detections = simulated(1)
    exact = measures(truth, truth)
    assert exact[:4] == ["1.0000", "1.0000", "1.0000", "1.00"]
    det, tra, _, complete, found, wrong = measures(
        truth, ours(detections.select("time", "x", "y"), {})
    )
    assert float(det) > 0.99
    assert float(tra) > 0.99
    assert float(complete) > 0.8
    right, _, total = found.partition(" of ")
    assert int(right) > 0.75 * int(total)
    assert wrong <= 4


@pytest.mark.usefixtures("benchmarks")
def test_merged_spots_are_shared_by_the_tracks_of_both_cells() -> None:
    from dividing_merges import judged, simulated

    detections = simulated(1)
    assert detections["second"].is_not_null().sum() > 20
    found = judged(detections)
    assert found["wrong"] <= 2
    assert found["both"] > 0.7 * found["spots"]
