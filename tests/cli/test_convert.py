"""The commands convert and formats, and what track takes and writes besides tables."""

import json
import re
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from cli.conftest import Run
from formats.samples import BLOCKS, NMEA, SBS


@pytest.fixture
def flight(tmp_path: Path) -> Path:
    """Return messages of an aircraft that flies east, and of another to the north of it."""
    rng = np.random.default_rng(3)
    lines = [
        f"MSG,3,1,1,{name},1,2024/05/01,12:00:{k:02d}.000,2024/05/01,12:00:{k:02d}.000,,10000,,,"
        f"{north + rng.normal(0, 2e-4):.5f},{10.0 + 0.003 * k + rng.normal(0, 3e-4):.5f},,,0,0,0,0"
        for k in range(0, 60, 2)
        for name, north in (("4CA2D6", 50.0), ("4CA2D7", 50.2))
    ]
    path = tmp_path / "flight.txt"
    path.write_text("\n".join(lines))
    return path


def test_tracks_any_format_and_writes_further_ones(run: Run, flight: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run("track", flight, "--out", out, "--also", "geojson,kml,czml,cot")
    assert done.exit_code == 0, done.stderr
    names = sorted(path.name for path in out.iterdir())
    assert [name for name in names if name.startswith("tracks.")] == [
        "tracks.cot", "tracks.csv", "tracks.czml", "tracks.geojson", "tracks.kml",
    ]  # fmt: skip
    found = json.loads((out / "tracks.geojson").read_text())
    assert len(found["features"]) == 2
    assert found["features"][0]["properties"]["begin"].startswith("2024-05-01T12:00:0")
    # Run again with fewer of them, the others are gone.
    assert run("track", flight, "--out", out, "--also", "kml").exit_code == 0
    assert sorted(p.name for p in out.glob("tracks.*")) == ["tracks.csv", "tracks.kml"]


def test_standard_input_is_tracked(run: Run, flight: Path, tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from trackweave.cli.app import app

    done = CliRunner().invoke(
        app, ["track", "-", "--out", str(tmp_path / "out")], input=flight.read_bytes()
    )
    assert done.exit_code == 0, done.stderr
    assert len(pl.read_csv(tmp_path / "out" / "assignments.csv")) == 60


def test_an_unknown_further_format_is_refused_before_any_work(
    run: Run, flight: Path, tmp_path: Path
) -> None:
    done = run("track", flight, "--out", tmp_path / "out", "--also", "shapefile")
    assert done.exit_code == 2
    assert "'shapefile': expected one that can be written" in done.stderr
    assert not (tmp_path / "out").exists()


def test_reports_become_a_table_that_is_tracked_alike(
    run: Run, flight: Path, tmp_path: Path
) -> None:
    table = tmp_path / "reports.csv"
    done = run("convert", flight, "-o", table)
    assert done.exit_code == 0, done.stderr
    assert pl.read_csv(table).columns[:4] == ["time", "lat", "lon", "identity"]
    for source, name in ((flight, "a"), (table, "b")):
        assert run("track", source, "--out", tmp_path / name, "--quiet").exit_code == 0
    one, two = ((tmp_path / name / "tracks.csv").read_bytes() for name in "ab")
    assert one == two


def test_identities_can_be_hidden_from_the_tracker(run: Run, flight: Path, tmp_path: Path) -> None:
    table = tmp_path / "reports.parquet"
    assert run("convert", flight, "-o", table, "--hide-identities").exit_code == 0
    assert set(pl.read_parquet(table)["target"]) == {"4ca2d6", "4ca2d7"}


def test_a_run_and_a_truth_become_any_format_of_tracks(
    run: Run, flight: Path, tmp_path: Path
) -> None:
    out, truth = tmp_path / "out", tmp_path / "truth.csv"
    assert run("track", flight, "--out", out, "--quiet").exit_code == 0
    assert run("convert", out, "-o", tmp_path / "a.geojson").exit_code == 0
    assert run("convert", flight, "-o", truth, "--hide-identities").exit_code == 0
    assert run("convert", truth, "-o", tmp_path / "b.geojson").exit_code == 0
    ours, true = (json.loads((tmp_path / f"{n}.geojson").read_text())["features"] for n in "ab")
    assert len(ours) == len(true) == 2
    assert {feature["properties"]["name"] for feature in true} == {"4ca2d6", "4ca2d7"}


@pytest.mark.parametrize("ending", ["csv", "parquet", "jsonl"])
def test_the_table_of_a_run_is_what_was_known_then(
    ending: str, run: Run, flight: Path, tmp_path: Path
) -> None:
    out, table = tmp_path / "out", tmp_path / f"a.{ending}"
    assert run("track", flight, "--out", out, "--quiet").exit_code == 0
    assert run("convert", out, "-o", table).exit_code == 0
    read = {"csv": pl.read_csv, "parquet": pl.read_parquet, "jsonl": pl.read_ndjson}[ending]
    found, known = read(table), pl.read_csv(out / "tracks.csv")
    smoothed = pl.read_csv(out / "history.csv")
    np.testing.assert_array_equal(found["lat"], known["lat"])
    assert not np.array_equal(found["lat"], smoothed["lat"])


def test_a_runs_table_of_tracks_knows_what_its_reports_told(
    run: Run, flight: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert run("track", flight, "--out", out, "--quiet").exit_code == 0
    kinds = {}
    for name in ("tracks.csv", "history.csv", ""):
        assert run("convert", out / name, "-o", tmp_path / "a.cot").exit_code == 0
        kinds[name] = set(re.findall(r' type="(\S+)"', (tmp_path / "a.cot").read_text()))
    assert set(map(tuple, kinds.values())) == {("a-u-A",)}
    (tmp_path / "tracks.csv").write_bytes((out / "tracks.csv").read_bytes())
    assert run("convert", tmp_path / "tracks.csv", "-o", tmp_path / "a.cot").exit_code == 0
    assert ' type="a-u-G"' in (tmp_path / "a.cot").read_text()


def test_reports_are_no_tracks(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "x.nmea"
    path.write_bytes(NMEA)
    done = run("convert", path, "-o", tmp_path / "x.kml")
    assert done.exit_code == 2
    assert "do not say whose they are" in done.stderr
    done = run("convert", path, "-o", tmp_path / "x.shp")
    assert done.exit_code == 2
    assert "expected a name that ends in" in done.stderr


def test_the_longest_ending_tells_what_to_write_and_what_fits_two_is_asked_back(
    run: Run, tmp_path: Path
) -> None:
    path = tmp_path / "gt.txt"
    path.write_text("1,1,10,20,4,8,1,1,1\n2,1,11,20,4,8,1,1,1\n")
    done = run("convert", path, "-o", tmp_path / "again.mot.txt", "--json")
    assert json.loads(done.stdout)["to"] == "mot"
    assert (tmp_path / "again.mot.txt").read_text().startswith("1,1,10.0,20.0,4.0,8.0,1.0")
    done = run("convert", path, "-o", tmp_path / "again.txt")
    assert "or --to" in done.stderr
    done = run("convert", path, "-o", tmp_path / "again.txt", "--to", "mot")
    assert done.exit_code == 0, done.stderr


def test_ranges_become_a_table_that_tells_where_their_radar_stands(
    run: Run, tmp_path: Path
) -> None:
    (tmp_path / "radar.ast").write_bytes(BLOCKS)
    assert run("convert", tmp_path / "radar.ast", "-o", tmp_path / "a.csv").exit_code == 0
    table = pl.read_csv(tmp_path / "a.csv")
    assert table["sensor_lat"].to_list() == [45.0] * 3
    assert set(table.columns) >= {"sensor_lon", "sensor_alt_m"}


def test_records_that_are_skipped_are_counted(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.write_bytes(SBS)
    done = run("convert", path, "-o", tmp_path / "x.csv", "--json")
    assert json.loads(done.stdout)["undecoded_records"] == 1


def test_formats_are_listed_with_what_they_carry_and_lose(run: Run) -> None:
    done = run("formats")
    assert done.exit_code == 0
    assert "ais (reads): AIS, NMEA sentences of ships" in done.stdout
    assert "--from 'mot?frame_rate=25.0'" in done.stdout
    listed = json.loads(run("formats", "--json").stdout)["formats"]
    assert {"name", "reads", "writes", "carries", "loses"} <= set(listed[0])


def test_a_truth_of_any_format_is_what_tracks_are_compared_with(run: Run, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    boxes = [(k, 10.0 * k + rng.normal(), 200.0 * n) for k in range(1, 31) for n in range(2)]
    found = [f"{k},-1,{x:.2f},{y},20,40,0.9,-1,-1,-1" for k, x, y in boxes]
    true = [f"{k},{n},{10.0 * k},{200.0 * n},20,40,1,1,1" for k in range(1, 31) for n in range(2)]
    (tmp_path / "det.txt").write_text("\n".join(found))
    (tmp_path / "gt.txt").write_text("\n".join(true))
    out = tmp_path / "out"
    assert run("track", tmp_path / "det.txt", "--out", out, "--quiet").exit_code == 0
    done = run(
        "evaluate", "--truth", tmp_path / "gt.txt", "--tracks", out / "tracks.csv", "--json"
    )
    assert done.exit_code == 0, done.stderr
    assert json.loads(done.stdout)["n_truth"] == 2


def test_bad_rows_end_a_conversion_unless_they_may_be_left_out(run: Run, tmp_path: Path) -> None:
    source, out = tmp_path / "bad.csv", tmp_path / "out.parquet"
    source.write_text("time,x,y\n0,1,2\n1,abc,3\n2,3,4\n3,5\n4,,6\n")
    done = run("convert", source, "-o", out)
    assert done.exit_code == 2
    assert "row 2, column x: abc; expected a finite number; 3 rows are bad" in done.stderr
    assert not out.exists()
    done = run("convert", source, "-o", out, "--on-bad-row", "skip", "--json")
    assert done.exit_code == 0
    assert json.loads(done.stdout)["skipped_rows"] == 3
    assert pl.read_parquet(out).rows() == [(0, 1, 2), (2, 3, 4)]
    source.write_text("time,track,x,y\n0,1,1,2\n1,1,1\n")
    assert "row 2" in run("convert", source, "-o", out).stderr


def test_what_is_converted_may_be_anywhere_on_the_earth(run: Run, tmp_path: Path) -> None:
    source, out = tmp_path / "wide.csv", tmp_path / "out.csv"
    source.write_text("time,lat,lon\n0,54.0,10.0\n0,91.0,181.0\n1,-54.5,-170.0\n1,0.5,100.0\n")
    assert run("convert", source, "-o", out).exit_code == 0
    assert len(pl.read_csv(out)) == 4


def test_assignments_become_points_where_reports_were(run: Run, tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    reports = pl.DataFrame(
        {
            "time": np.arange(20.0),
            "lat": 54.0 + 1e-4 * np.arange(20.0) + rng.normal(0, 1e-5, 20),
            "lon": np.full(20, 10.0),
        }
    )
    reports[7, "lat"], reports[7, "lon"] = 91.0, 181.0
    reports.write_csv(tmp_path / "reports.csv")
    assert run("track", tmp_path / "reports.csv", "--out", tmp_path / "out").exit_code == 0
    out = tmp_path / "points.geojson"
    assert run("convert", tmp_path / "out" / "assignments.csv", "-o", out).exit_code == 0
    points = json.loads(out.read_text())["features"]
    assert len(points) == 20
    assert points[3]["properties"]["track"] == 1
    assert points[3]["properties"]["time"] == "1970-01-01T00:00:03Z"
    assert points[3]["geometry"]["coordinates"] == pytest.approx([10.0, reports[3, "lat"]])
    assert points[7]["geometry"] is None
    (tmp_path / "reports.csv").unlink()
    done = run("convert", tmp_path / "out" / "assignments.csv", "-o", out)
    assert done.exit_code == 2
    assert "no columns lat and lon, and the reports of a run are not where they w" in done.stderr
    reports.drop("lat", "lon").with_columns(x=pl.lit(0.0), y=pl.lit(0.0)).write_csv(
        tmp_path / "reports.csv"
    )
    done = run("convert", tmp_path / "out" / "assignments.csv", "-o", out)
    assert done.exit_code == 2
    assert "and the reports of its run have none either; expected assignments of" in done.stderr
