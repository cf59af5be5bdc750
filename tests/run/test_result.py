"""A run's result in one's hands."""

import doctest
import json
import pickle
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import trackweave as tw
from cli.conftest import run  # noqa: F401 the fixture
from trackweave.errors import InvalidInputError, OutputError
from trackweave.io.encoding import encode_table

N = 20
MAKERS = [pd.DataFrame, pl.DataFrame, pa.table]
CONFIG = {
    "motion": {"process_noise": 0.1, "max_speed": 30.0},
    "sensors": {
        "default": {
            "sigma": 3.0,
            "detection_probability": 0.9,
            "clutter_density": 2e-6,
            "scan_period": 1.0,
        }
    },
    "lifecycle": {"new_target_density": 1e-6},
}


def columns(**more: Any) -> dict[str, Any]:
    """Two objects side by side, in an order that is nobody's."""
    rng = np.random.default_rng(2)
    time = np.repeat(np.arange(10.0), 2)
    place = np.stack([10 * time, np.tile([0.0, 300.0], 10)], axis=1)
    place += rng.normal(0, 3, place.shape)
    rows = rng.permutation(N)
    own = {"time": time, "x": place[:, 0], "y": place[:, 1], "target": np.tile(["a", "b"], 10)}
    return {name: values[rows] for name, values in own.items()} | more


def truth() -> pd.DataFrame:
    time = np.repeat(np.arange(10.0), 2)
    return pd.DataFrame(
        {"time": time, "target": ["a", "b"] * 10, "x": 10 * time, "y": [0.0, 300.0] * 10}
    )


def track(reports: Any, **options: Any) -> Any:
    return tw.track(reports, CONFIG, **options)


def rows(table: Any) -> dict[str, list[Any]]:
    """Return the columns of a table of any kind as lists with None for nothing."""
    if isinstance(table, pd.DataFrame):
        return {
            name: [None if pd.isna(value) else value for value in table[name].tolist()]
            for name in table.columns
        }
    return table.to_pydict() if isinstance(table, pa.Table) else table.to_dict(as_series=False)


def require_right(targets: Any, tracks: Any) -> None:
    """Refuse anything but one track for each target."""
    pairs = set(zip(targets, tracks, strict=True))
    assert len(pairs) == 2
    assert {target for target, _ in pairs} == {"a", "b"}
    assert len({track for _, track in pairs} - {None}) == 2


@pytest.mark.parametrize("make", MAKERS)
def test_the_table_comes_back_row_for_row_with_two_columns_more(make: Callable[..., Any]) -> None:
    given = make(columns(note=["n"] * N))
    found = track(given).reports
    assert type(found) is type(given)
    assert list(rows(found))[-2:] == ["track", "probability"]
    assert {name: rows(found)[name] for name in rows(given)} == rows(given)
    require_right(rows(found)["target"], rows(found)["track"])


@pytest.mark.parametrize("make", MAKERS)
def test_assignments_are_in_the_order_of_the_table(make: Callable[..., Any]) -> None:
    given = make(columns())
    found = rows(track(given).assignments)
    assert found["report"] == list(range(1, N + 1))
    assert found["time"] == rows(given)["time"]
    require_right(rows(given)["target"], found["track"])


@pytest.mark.parametrize(
    "index",
    [
        np.random.default_rng(3).permutation(N),
        np.zeros(N, dtype=int),
        pd.MultiIndex.from_product([["u", "v"], range(10)], names=["movie", "row"]),
        pd.date_range("2024-05-01", periods=N, freq="min", name="when"),
        pd.Index([f"cell {k // 2}" for k in range(N)], name="time"),
        pd.RangeIndex(40, 0, -2),
    ],
    ids=["shuffled", "all one", "multi", "dates", "text", "backwards"],
)
def test_the_index_of_pandas_is_kept_whatever_it_is(index: Any) -> None:
    given = pd.DataFrame(columns(), index=index)
    before = given.copy()
    result = track(given)
    pd.testing.assert_frame_equal(given, before)
    pd.testing.assert_frame_equal(result.reports[list(given.columns)], before)
    pd.testing.assert_index_equal(result.assignments.index, before.index)
    # The biologist's line, which pandas aligns by the index.
    given["particle"] = result.reports["track"]
    require_right(given["target"], given["particle"])
    given["particle"] = result.assignments["track"]
    require_right(given["target"], given["particle"])


def test_columns_of_pandas_keep_their_types_and_what_hangs_on_them() -> None:
    more = {
        "sensor": pd.Categorical(["near", "near"] * 10),
        "count": pd.array([1, None] * 10, dtype="Int64"),
        "when": pd.date_range("2024-05-01", periods=N, tz="Europe/Berlin"),
        3: [0.5] * N,
    }
    given = pd.DataFrame({**columns(), **more})
    given.attrs["microscope"] = "no. 2"
    found = tw.track(given, rng=1).reports
    pd.testing.assert_frame_equal(found.drop(columns=["track", "probability"]), given)
    assert found.attrs == given.attrs
    assert (found["track"].dtype, found["probability"].dtype) == (pd.Int64Dtype(), np.float64)


@pytest.mark.parametrize("make", MAKERS)
def test_columns_called_like_ours_are_kept_and_said(make: Callable[..., Any]) -> None:
    given = make(columns(track=["old"] * N, reports_track=[7] * N, probability=[0.5] * N))
    result = track(given)
    found = rows(result.reports)
    assert found["reports_reports_track"] == ["old"] * N
    assert found["reports_track"] == [7] * N
    assert found["reports_probability"] == [0.5] * N
    require_right(found["target"], found["track"])
    assert rows(result.assignments)["reports_reports_track"] == ["old"] * N
    notes = " ".join(result.run["notes"])
    assert "column track: is called reports_reports_track" in notes
    assert "column probability: is called reports_probability" in notes


@pytest.mark.parametrize("make", MAKERS)
def test_rows_that_are_skipped_stay_and_have_no_track(make: Callable[..., Any]) -> None:
    given = columns()
    given["x"][[0, 7, N - 1]] = np.nan
    table = make(given)
    with pytest.raises(InvalidInputError, match="row 1, column x"):
        track(table)
    result = track(table, on_bad_row="skip")
    found = rows(result.reports)
    assert [k for k in range(N) if found["track"][k] is None] == [0, 7, N - 1]
    assert found["probability"][7] is None
    assert found["time"] == given["time"].tolist()
    assert rows(result.assignments)["report"] == [
        k + 1 for k in range(N) if k not in (0, 7, N - 1)
    ]
    if make is pd.DataFrame:
        assert result.assignments.index.tolist() == [k for k in range(N) if k not in (0, 7, N - 1)]


def test_records_of_a_file_stay_in_their_places(tmp_path: Path) -> None:
    path = tmp_path / "reports.csv"
    good = pl.DataFrame(columns(code=["007"] * N)).write_csv().splitlines()
    path.write_text("\n".join([*good[:3], "1.0,2.0", *good[3:], "9,no,0,a,007"]) + "\n")
    result = track(path, on_bad_row="skip")
    assert isinstance(result.reports, pl.DataFrame)
    assert result.reports.schema == {
        "time": pl.Float64, "x": pl.String, "y": pl.Float64, "target": pl.String,
        "code": pl.String, "track": pl.Int64, "probability": pl.Float64,
    }  # fmt: skip
    assert len(result.reports) == N + 2
    assert result.reports.row(2) == (None,) * 7
    assert result.reports.row(N + 1)[-2:] == (None, None)
    right = result.reports.filter(pl.col("track").is_not_null())
    require_right(right["target"], right["track"])


@pytest.mark.parametrize("ending", [".csv.gz", ".parquet"])
def test_files_of_every_kind_come_back_as_they_are(ending: str, tmp_path: Path) -> None:
    given = pl.DataFrame(columns(code=[f"{k}" for k in range(N)]))
    path = tmp_path / f"reports{ending}"
    path.write_bytes(encode_table(given, path.name))
    found = track(str(path)).reports
    code = pl.String if ending == ".parquet" else pl.Int64  # text knows no types
    assert found.drop("track", "probability").equals(given.cast({"code": code}))


def test_reports_read_beforehand_come_back_as_they_are_written() -> None:
    given = columns()
    result = track(tw.read_reports(pl.DataFrame(given)))
    assert result.reports["time"].to_list() == given["time"].tolist()
    require_right(result.reports["target"], result.reports["track"])


@pytest.mark.parametrize(
    ("identifiers", "dtype"),
    [
        (np.arange(N) * 3 + 5, pl.Int64),
        (np.arange(N, dtype=np.uint64) + np.uint64(2**63), pl.UInt64),
        (np.arange(N) * 2.0, pl.Int64),
        (np.arange(N) + 0.5, pl.String),
        ([str(k) for k in range(N)], pl.String),
        ([2**70 + k for k in range(N)], pl.String),
    ],
)
def test_identifiers_keep_their_type(identifiers: Any, dtype: Any) -> None:
    given = pd.DataFrame(columns(report=identifiers))
    found = track(given).assignments["report"].tolist()
    as_type = str if dtype == pl.String else int
    assert found == [as_type(k) for k in identifiers]
    assert {type(value) for value in found} == {as_type}


def test_identifiers_of_a_file_stay_as_they_are_written(tmp_path: Path) -> None:
    for names in (["1.50", "2e1"], ["007", "8"], ["7", "8"]):
        path = tmp_path / "reports.csv"
        given = columns(report=[f"{name}{k:02}" for k in range(N // 2) for name in names])
        path.write_bytes(encode_table(pl.DataFrame(given), path.name))
        kept = track(path).files()["assignments.csv"].decode().splitlines()
        assert [line.split(",")[0] for line in kept[1:]] == given["report"]


def test_what_comes_back_can_be_written_to() -> None:
    result = track(pd.DataFrame(columns()))
    for table in (result.reports, result.assignments, result.tracks):
        for name in table.columns:
            table.loc[table.index[0], name] = table.loc[table.index[1], name]
        assert table.iloc[0].tolist() == table.iloc[1].tolist()


def test_a_table_without_rows_is_refused_in_words() -> None:
    for make in MAKERS:
        with pytest.raises(InvalidInputError, match="no data rows"):
            track(make({"time": [], "x": [], "y": []}))


@pytest.mark.parametrize("name", ["t", "frame"])
@pytest.mark.parametrize("make", MAKERS)
def test_t_and_frame_are_taken_for_time_and_said(name: str, make: Callable[..., Any]) -> None:
    given = columns()
    expected = track(make(given))
    result = track(make({name if key == "time" else key: v for key, v in given.items()}))
    assert rows(result.reports)["track"] == rows(expected.reports)["track"]
    assert next(iter(rows(result.reports))) == name
    assert f"column {name}: taken for time" in " ".join(result.run["notes"])


def test_time_comes_before_t_and_t_before_frame() -> None:
    given = columns(t=["x"] * N, frame=[0] * N)
    result = track(pl.DataFrame(given))
    assert result.run["notes"] == track(pl.DataFrame(columns())).run["notes"]
    assert result.assignments["frame"].to_list() == [0] * N
    del given["time"]
    with pytest.raises(InvalidInputError, match="row 1, column t: x"):
        track(pl.DataFrame(given))


def test_a_seed_is_a_generator_and_zero_where_nothing_is_said() -> None:
    given = pl.DataFrame(columns())
    bare, seeded = track(given), track(given, rng=np.random.default_rng(0))
    assert bare.tracks.equals(seeded.tracks)
    assert (bare.run["seed"], seeded.run["seed"], track(given, rng=7).run["seed"]) == (0, None, 7)
    with pytest.raises(InvalidInputError, match="rng"):
        track(given, rng=None)


def test_a_result_prints_as_a_few_lines() -> None:
    result = track(pl.DataFrame(columns()))
    assert len(repr(result).splitlines()) <= 5
    assert "2 from 20 reports, 100.0 % of them assigned" in repr(result)
    assert len(repr(result.values)) < 1000


def test_a_result_shows_itself_in_a_notebook_by_few_bytes() -> None:
    page = track(pl.DataFrame(columns()))._repr_html_()
    assert page.startswith("<table>")
    assert "data:image/png;base64," in page
    assert len(page) < 100_000


def test_a_result_draws_itself() -> None:
    from matplotlib.figure import Figure

    result = track(pl.DataFrame(columns()))
    figure = result.plot()
    assert isinstance(figure, Figure)
    assert len(figure.axes) > 1
    assert figure.axes[0].get_title(loc="left") == "2 tracks from 20 reports in 9 s"
    assert figure._repr_png_().startswith(b"\x89PNG")
    for given in (truth(), pl.DataFrame(columns()), tw.read_truth(truth())):
        seen = result.plot(given, history=True)
        assert len(seen.axes[0].get_children()) > len(figure.axes[0].get_children())


def test_a_result_is_saved_as_the_command_saves_it(
    run: Callable[..., Any],  # noqa: F811
    tmp_path: Path,
) -> None:
    path, out = tmp_path / "reports.csv", tmp_path / "out"
    path.write_bytes(encode_table(pl.DataFrame(columns()), "reports.csv"))
    assert run("track", path, "--out", tmp_path / "command", "-q").exit_code == 0
    tw.track(path).save(out)
    names = ["assignments.csv", "history.csv", "run.json", "tracks.csv"]
    assert sorted(file.name for file in out.iterdir()) == names
    for name in names:
        mine, theirs = ((folder / name).read_bytes() for folder in (out, tmp_path / "command"))
        if name == "run.json":
            mine, theirs = ({**json.loads(each), "timing": 0} for each in (mine, theirs))
        assert mine == theirs
    tw.track(pd.read_csv(path)).save(out)
    for name in names[:2]:
        assert (out / name).read_bytes() == (tmp_path / "command" / name).read_bytes()
    with pytest.raises(OutputError, match="not empty"):
        tw.track(path).save(tmp_path)


@pytest.mark.parametrize(
    "name",
    ["randomness", "domain.tracks", "formats.reading"]
    + [f"run.{part}" for part in ("fusing", "judging", "result", "tracking")],
)
def test_examples_of_docstrings_run(name: str) -> None:
    done = doctest.testmod(import_module(f"trackweave.{name}"))
    assert done.attempted > 0
    assert done.failed == 0


def test_refuses_another_way_with_bad_rows() -> None:
    with pytest.raises(InvalidInputError, match="on_bad_row: 'ignore'; expected one of"):
        track(pl.DataFrame(columns()), on_bad_row="ignore")


def test_a_result_can_be_kept() -> None:
    result = track(pd.DataFrame(columns()))
    again = pickle.loads(pickle.dumps(result))
    pd.testing.assert_frame_equal(again.reports, result.reports)
