"""Files that are not what they should be: status 2 and one line, or a run as any other."""

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from cli.conftest import Run, write_reports
from cli.run_directory import write_run
from trackweave.io.tracks_in import covariance_names, state_names

SCENE = """
duration = 20.0
[area]
low = [0, 0]
high = [1000, 1000]
[[sensors]]
name = "a"
sigma = 5.0
scan_period = 2.0
"""
CROSSING = "[[crossings]]\npoint = [1, 1]\ntime = 1\nspeed = 1\ncount = 2\n"
DEEP = f"x = {'[' * 2000}{']' * 2000}\n"
DIGITS = f"[window]\ndepth = {'9' * 5000}\n"


def refused(run: Run, *arguments: object) -> str:
    """Return the one line with which a command refuses its input."""
    done = run(*arguments)
    assert done.exit_code == 2, done.stderr
    assert len(done.stderr.splitlines()) == 1
    return done.stderr


class TestTables:
    """Columns of other types than text and numbers."""

    def frame(self, **columns: pl.Series) -> pl.DataFrame:
        rows = [(float(scan), 10.0 * scan, 0.0) for scan in range(8)]
        frame = pl.DataFrame(rows, schema=["time", "x", "y"], orient="row")
        return frame.with_columns(**columns)

    def test_a_duration_is_passed_on(self, run: Run, tmp_path: Path, config: Path) -> None:
        ages = pl.Series([90_000, None, *range(6)], dtype=pl.Int64).cast(pl.Duration("ms"))
        self.frame(age=ages).write_parquet(tmp_path / "r.parquet")
        out = tmp_path / "out"
        done = run("track", tmp_path / "r.parquet", "--config", config, "--out", out)
        assert done.exit_code == 0, done.stderr
        passed = pl.read_csv(out / "assignments.csv")["age"]
        assert passed.to_list()[:2] == ["PT1M30S", None]

    @pytest.mark.parametrize("kind", [pl.Date, pl.Datetime("ms"), pl.Duration("ms")])
    @pytest.mark.parametrize("name", ["age", "sensor", "time"])
    def test_a_day_that_no_calendar_has_is_named(
        self, run: Run, tmp_path: Path, kind: pl.DataType, name: str
    ) -> None:
        days = pl.Series([0] * 5 + [2**30] * 3)
        days = days.cast(pl.Int32) if kind == pl.Date else days * 86_400_000
        self.frame(**{name: days.cast(kind)}).write_parquet(tmp_path / "r.parquet")
        said = refused(run, "track", tmp_path / "r.parquet", "--out", tmp_path / "out")
        found = f"row 6, column {name}: 1073741824 days; expected"
        if (kind, name) == (pl.Duration("ms"), "time"):
            found = "row 1, column time: 0:00:00; expected"  # a duration is no time
        assert f"r.parquet, {found}" in said
        assert "--on-bad-row skip" in said

    def test_a_row_with_such_a_day_can_be_skipped(
        self, run: Run, tmp_path: Path, config: Path
    ) -> None:
        days = pl.Series([0] * 7 + [2**30]).cast(pl.Int32).cast(pl.Date)
        self.frame(day=days).write_parquet(tmp_path / "r.parquet")
        done = run(
            "track", tmp_path / "r.parquet", "--config", config, "--out", tmp_path / "out",
            "--on-bad-row", "skip",
        )  # fmt: skip
        assert done.exit_code == 0, done.stderr
        assert pl.read_csv(tmp_path / "out" / "assignments.csv")["report"].to_list() == [
            *range(1, 8)
        ]

    def test_a_day_inside_a_list_is_found_too(self, run: Run, tmp_path: Path) -> None:
        days = pl.Series([[2**30]] * 8, dtype=pl.List(pl.Int32)).cast(pl.List(pl.Date))
        self.frame(days=days).write_parquet(tmp_path / "r.parquet")
        said = refused(run, "init", tmp_path / "r.parquet", "-o", tmp_path / "t.toml")
        assert "column days" in said

    def test_a_name_of_a_hundred_thousand_letters_is_refused(
        self, run: Run, tmp_path: Path
    ) -> None:
        self.frame(sensor=pl.Series(["s" * 100_000] * 8)).write_csv(tmp_path / "r.csv")
        said = refused(run, "track", tmp_path / "r.csv", "--out", tmp_path / "out")
        assert "r.csv, row 1, column sensor: sss" in said
        assert "expected at most 256 bytes" in said
        assert len(said) < 400


class TestConfigurations:
    """Keys that are no keys, numbers that are no numbers."""

    @pytest.mark.parametrize(
        ("text", "said"),
        [
            (DEEP, "line 1, x: nested too deeply"),
            (f"x = {'[' * 30}{']' * 30}\n", "nested too deeply"),
            (DIGITS, "line 2, depth: a whole number too large"),
            (f"[window]\ndepth = {2**63}\n", "window.depth: 9223372036854775808; expected"),
            (
                "[sensors.default]\nsigma = {range_m = 1e-12, azimuth_deg = 0.2}\n",
                "sensors.default.sigma.range_m: 1e-12; expected a number > 0 in metres, at least",
            ),
        ],
    )
    def test_are_refused_by_their_key(
        self, text: str, said: str, run: Run, reports: Path, tmp_path: Path
    ) -> None:
        (tmp_path / "c.toml").write_text(text)
        arguments = ("track", reports, "--config", tmp_path / "c.toml")
        assert said in refused(run, *arguments, "--out", tmp_path / "out")

    @pytest.mark.parametrize(
        ("text", "said"),
        [
            (DEEP, "line 1, x: nested too deeply"),
            (SCENE.replace("5.0", "9" * 400), "sensors[0].sigma: 99999999999999999999…; expected"),
            (
                SCENE + CROSSING.replace("count = 2", "count = 1000000000"),
                "crossings[0].count: 1000000000; expected a whole number from 2 to 100000",
            ),
            (SCENE + 900 * CROSSING.replace("2", "1000"), "targets: 900000 with crossings"),
            (SCENE.replace('"a"', '" a"'), "sensors[0].name: ' a'; expected a text"),
            (SCENE.replace('"a"', f'"{"a" * 300}"'), "that is not empty, of at most 256 bytes"),
        ],
    )
    def test_of_scenes_are_refused_before_anything_is_made(
        self, text: str, said: str, run: Run, tmp_path: Path
    ) -> None:
        (tmp_path / "s.toml").write_text(text)
        assert said in refused(run, "simulate", tmp_path / "s.toml", "--out", tmp_path / "out")
        assert not (tmp_path / "out").exists()


def covariances(path: Path) -> np.ndarray[Any, Any]:
    """Return the covariances of a file of tracks."""
    table = pl.read_csv(path)
    names = state_names(2)
    found = np.empty((len(table), 4, 4))
    for name in covariance_names(2):
        row, column = (names.index(axis) for axis in name.split("_")[1:])
        found[:, row, column] = found[:, column, row] = table[name].to_numpy()
    return found


class TestNegativeVariances:
    """What was written once with variances below zero, and then refused by ourselves."""

    def test_near_times_and_fast_objects(self, run: Run, tmp_path: Path) -> None:
        rng = np.random.default_rng(3)
        rows = ["time,range_m,azimuth_deg,sigma_range_m,sigma_azimuth_deg"]
        for scan in range(12):
            for place in (800.0, 1700.0, 2500.0):
                time = 2.0 * scan + rng.choice([0.0, 1e-9, 0.3]) * rng.random()
                turn = place / 10.0 + rng.normal(0, 0.2)
                rows.append(f"{float(time)!r},{place + rng.normal(0, 10)},{turn},0.1,0.01")
        (tmp_path / "r.csv").write_text("\n".join(rows))
        (tmp_path / "c.toml").write_text(
            "[motion]\nprocess_noise = 0.0006\nmax_speed = 5e4\n[sensors.default]\n"
            "clutter_density = 1e-5\ndetection_probability = 0.9\n"
        )
        self.check(run, tmp_path)

    def test_turns_a_thousand_times_too_fast(self, run: Run, tmp_path: Path) -> None:
        write_reports(tmp_path / "r.csv")
        (tmp_path / "c.toml").write_text(
            '[motion]\nmodel = "coordinated-turn"\nmax_turn_rate = 1000.0\n'
        )
        self.check(run, tmp_path)

    def check(self, run: Run, folder: Path) -> None:
        arguments = ("track", folder / "r.csv", "--config", folder / "c.toml")
        done = run(*arguments, "--out", folder / "out")
        assert done.exit_code == 0, done.stderr
        for name in ("tracks.csv", "history.csv"):
            found = covariances(folder / "out" / name)
            assert len(found)
            scale = 1.0 / np.sqrt(np.diagonal(found, axis1=1, axis2=2))
            correlations = found * scale[:, :, None] * scale[:, None, :]
            assert np.linalg.eigvalsh(correlations).min() > 0.0
        tracks = folder / "out" / "tracks.csv"
        again = run(*arguments, "--priors", tracks, "--out", folder / "again")
        assert again.exit_code == 0, again.stderr


def places(document: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the way to every entry of a document, of lists only the first."""
    if isinstance(document, dict):
        for key, value in document.items():
            yield (*path, key)
            yield from places(value, (*path, key))
    elif isinstance(document, list) and document:
        yield (*path, 0)
        yield from places(document[0], (*path, 0))


class TestRecords:
    """A run.json that somebody or something changed."""

    @pytest.mark.parametrize("change", ["gone", None, "zap", -1, 1e400, [], {}, [{}], True])
    def test_each_entry_is_missed_by_name_or_not_needed(
        self, change: Any, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        directory = write_run(tmp_path / "run")
        monkeypatch.setattr("trackweave.cli.plot.picture_of_run", lambda *_: b"picture")
        record = json.loads((directory / "run.json").read_text())
        for way in list(places(record)):
            changed = copy.deepcopy(record)
            inside = changed
            for key in way[:-1]:
                inside = inside[key]
            if change == "gone":
                del inside[way[-1]]
            else:
                inside[way[-1]] = change
            (directory / "run.json").write_text(json.dumps(changed))
            done = run("plot", directory)
            assert done.exit_code in {0, 2}, (way, done.stderr)
            assert done.exit_code == 0 or str(directory) in done.stderr, way


class TestSizes:
    """More than anybody means."""

    def test_thousands_of_sensors_are_not_estimated(self, run: Run, tmp_path: Path) -> None:
        rows = [f"{scan},{name},{name},{scan}" for scan in range(2) for name in range(2001)]
        (tmp_path / "r.csv").write_text("\n".join(["time,sensor,x,y", *rows]))
        said = refused(run, "init", tmp_path / "r.csv", "-o", tmp_path / "t.toml")
        assert "column sensor: 2001 sensors; expected at most 2000 where" in said

    @pytest.mark.parametrize(
        ("text", "said"),
        [
            (SCENE, "no report comes of it"),
            (SCENE + CROSSING.replace("speed = 1", "speed = 1e12"), "targets: a place of"),
            (SCENE.replace("20.0", "1e12"), "duration: 1000000000000.0; expected a number above"),
            (SCENE.replace("5.0", "1e-12"), "sensors[0].sigma: 1e-12; expected a number above 0"),
        ],
    )
    def test_scenes_that_no_reader_takes_are_refused(
        self, text: str, said: str, run: Run, tmp_path: Path
    ) -> None:
        (tmp_path / "s.toml").write_text(text)
        assert said in refused(run, "simulate", tmp_path / "s.toml", "--out", tmp_path / "out")


def test_tracks_without_acceleration_begin_a_run_that_knows_it(run: Run, tmp_path: Path) -> None:
    reports = write_reports(tmp_path / "r.csv", n_scans=6)
    (tmp_path / "c.toml").write_text('[motion]\nmodel = "constant-acceleration"\n')
    arguments = ("track", reports, "--config", tmp_path / "c.toml")
    assert run(*arguments, "--out", tmp_path / "out").exit_code == 0
    tracks = tmp_path / "out" / "tracks.csv"
    again = run(*arguments, "--priors", tracks, "--out", tmp_path / "again")
    assert again.exit_code == 0, again.stderr
