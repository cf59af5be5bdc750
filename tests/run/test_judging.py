"""Tracks against the truth, whatever they come as."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import trackweave as tw
from trackweave.errors import InvalidInputError

TIME = np.repeat(np.arange(8.0), 2)
TRUTH = {
    "time": TIME,
    "target": ["a", "b"] * 8,
    "x": 5.0 * TIME,
    "y": np.tile([0.0, 200.0], 8),
}


@pytest.fixture(scope="module")
def result() -> Any:
    noise = np.random.default_rng(4).normal(0, 1, (2, TIME.size))
    reports = pl.DataFrame({**TRUTH, "x": TRUTH["x"] + noise[0], "y": TRUTH["y"] + noise[1]})
    return tw.track(reports)


def test_takes_whatever_holds_tracks_and_says_the_same(result: Any, tmp_path: Path) -> None:
    path, truth = tmp_path / "tracks.csv", tmp_path / "truth.csv"
    path.write_bytes(result.files()["tracks.csv"])
    pl.DataFrame(TRUTH).write_csv(truth)
    expected = tw.evaluate(tw.read_truth(truth), result.values.tracks)
    assert expected.n_found == 2
    tables = [result.tracks, result.tracks.to_pandas(use_pyarrow_extension_array=False)]
    for tracks in (*tables, result.tracks.to_arrow(), path, str(path), tw.read_tracks(path)):
        assert tw.evaluate(truth, tracks) == expected
    for true in (pd.DataFrame(TRUTH), pa.table(TRUTH), pl.DataFrame(TRUTH), str(truth)):
        assert tw.evaluate(true, result.values.tracks) == expected
    assert tw.evaluate(truth, result.history).rmse != expected.rmse


def test_a_result_brings_its_own_reports(result: Any, tmp_path: Path) -> None:
    path = tmp_path / "assignments.csv"
    path.write_bytes(result.files()["assignments.csv"])
    truth = pl.DataFrame(TRUTH)
    own = result.evaluate(truth, cutoff=20.0, order=1.0, max_gap=3.0, window=5)
    assert (own.report_idf1, own.cutoff, own.order, own.window) == (1.0, 20.0, 1.0, 5)
    assert tw.evaluate(truth, result) == tw.evaluate(truth, result.tracks, path)
    assert tw.evaluate(truth, result.tracks).report_idf1 is None


def test_reports_alone_are_judged_where_nobody_knows_where_targets_were(result: Any) -> None:
    assignments = result.assignments
    found = tw.evaluate(assignments=assignments)
    assert found == result.evaluate()
    whole = tw.evaluate(pl.DataFrame(TRUTH), result.tracks, assignments)
    names = ("right_share", "report_idf1", "report_purity", "report_mota", "report_switches")
    told = found.as_dict()
    assert {name: told.pop(name) for name in names} == {n: getattr(whole, n) for n in names}
    assert told.pop("targets") == []
    assert set(told.values()) == {None}


def test_reports_that_tell_no_targets_are_not_judged_alone(result: Any) -> None:
    with pytest.raises(InvalidInputError, match="no column target"):
        tw.evaluate(assignments=result.assignments.drop("target"))
    with pytest.raises(InvalidInputError, match="truth: None; expected where targets were, or as"):
        tw.evaluate(tracks=result.tracks, assignments=result.assignments)
    with pytest.raises(InvalidInputError, match="truth: None"):
        tw.track(pl.DataFrame(TRUTH).drop("target")).evaluate()


def test_switches_of_reports_do_not_depend_on_the_order_of_rows(result: Any) -> None:
    time = np.arange(6.0)
    table = pl.DataFrame(
        {
            "report": range(6), "time": time, "sensor": ["s"] * 6, "target": ["a"] * 6,
            "track": [1, 1, 1, 2, 2, 2],
        }
    )  # fmt: skip
    for rows in ([0, 1, 2, 3, 4, 5], [0, 3, 1, 4, 2, 5], [5, 0, 4, 1, 3, 2]):
        found = tw.evaluate(pl.DataFrame(TRUTH), result.tracks, table[rows])
        assert found.report_switches == 1


def test_fused_tracks_are_tracks(result: Any) -> None:
    fused = tw.fuse([result.tracks, result.tracks])
    assert tw.evaluate(pl.DataFrame(TRUTH), fused).n_found == 2
    assert len(repr(fused).splitlines()) <= 5
    assert fused.run["seed"] == 0


@pytest.mark.parametrize("wrong", [3, None, [1, 2], object(), {"time": [0.0]}, np.zeros((3, 2))])
def test_refuses_what_holds_no_tracks(wrong: Any) -> None:
    with pytest.raises(InvalidInputError, match="not a table"):
        tw.evaluate(pl.DataFrame(TRUTH), wrong)
    with pytest.raises(InvalidInputError, match="truth: None" if wrong is None else "not a table"):
        tw.evaluate(wrong, pl.DataFrame(TRUTH))


def test_compares_on_the_earth_where_both_are(result: Any) -> None:
    place = {"lat": 47.0 + 1e-5 * TRUTH["x"], "lon": 8.0 + 1e-5 * TRUTH["y"]}
    truth = pl.DataFrame({"time": TIME, "target": TRUTH["target"], **place})
    found = tw.track(truth)
    assert found.evaluate(truth) == tw.evaluate(truth, found.tracks, found.assignments)
    assert found.evaluate(truth).n_found == 2
    assert len(found.plot(truth).axes) > 1
    with pytest.raises(InvalidInputError, match="latitudes and longitudes, which a TrackTable"):
        tw.evaluate(truth, found.values.tracks)
    with pytest.raises(InvalidInputError, match="latitudes"):
        tw.evaluate(truth, result)
    with pytest.raises(InvalidInputError, match="latitudes and longitudes, which the run is not"):
        result.plot(truth)


def test_times_may_be_called_frames() -> None:
    frames = {("frame" if name == "time" else name): value for name, value in TRUTH.items()}
    found = tw.track(pd.DataFrame(frames))
    assert found.evaluate(pd.DataFrame(frames)).n_found == 2


def test_refuses_tracks_of_another_time(result: Any) -> None:
    later = pl.DataFrame({**TRUTH, "time": TIME + 1e6})
    with pytest.raises(InvalidInputError, match="expected tracks and truth of the same time"):
        result.evaluate(later)


def ways(**changed: Any) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return a truth that means something else than it says, and tracks that are right."""
    time = np.repeat(np.arange(0.0, 300.0, 4.0), 3)
    start = np.tile([[0.0, 900.0], [2000.0, -400.0], [-1500.0, 2500.0]], (75, 1))
    step = np.tile([[12.0, 3.0], [-8.0, 10.0], [5.0, -14.0]], (75, 1))
    place = start + step * time[:, None]
    table = pl.DataFrame(
        {"time": time, "target": ["a", "b", "c"] * 75, "x": place[:, 0], "y": place[:, 1]}
    )
    tracks = table.rename({"target": "track"}).with_columns(
        track=pl.col("track").replace_strict({"a": 1, "b": 2, "c": 3}), status=pl.lit("confirmed")
    )
    return table.with_columns(**changed), tracks


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"x": pl.col("x") / 1e3, "y": pl.col("y") / 1e3}, "it is in kilometres"),
        ({"x": pl.col("y"), "y": pl.col("x")}, "its x and y are exchanged"),
        ({"time": pl.col("time") + 60.0}, "its clock is some 60 s ahead"),
        ({"x": pl.col("x") + 400.0}, "a larger cutoff judges them"),
    ],
)
def test_a_truth_that_means_something_else_is_told(changed: dict, words: str) -> None:
    truth, tracks = ways(**changed)
    with pytest.warns(UserWarning, match=words):
        tw.evaluate(truth, tracks)
