"""What is heard twice counts once, and every copy has the track of the first."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import polars as pl
import pytest

import trackweave as tw
from cli.conftest import Run, run  # noqa: F401 the fixture
from service.recordings import turning_radar
from trackweave.config import load_configuration
from trackweave.config.fill import fill
from trackweave.domain.reports import ReportTable
from trackweave.formats.reading import read_reports
from trackweave.run.doubles import Settled, Settling, doubles_of
from trackweave.run.observing import observe

SENSOR = {"sigma": 3.0, "detection_probability": 0.9, "clutter_density": 2e-6}
REST = {
    "motion": {"process_noise": 0.1, "max_speed": 30.0},
    "lifecycle": {"new_target_density": 1e-6},
}
SCANNING = {**REST, "sensors": {"default": {**SENSOR, "scan_period": 1.0}}}
ANYHOW = {**REST, "sensors": {"default": {**SENSOR, "scans": False}}}


def scans() -> pl.DataFrame:
    """Two objects side by side, scan by scan."""
    rng = np.random.default_rng(2)
    time = np.repeat(np.arange(10.0), 2)
    place = np.stack([10 * time, np.tile([0.0, 300.0], 10)], axis=1) + rng.normal(0, 3, (20, 2))
    target = ["a", "b"] * 10
    return pl.DataFrame({"time": time, "x": place[:, 0], "y": place[:, 1], "target": target})


def lone() -> pl.DataFrame:
    """Six ships far apart, each heard at its own pace."""
    rng = np.random.default_rng(3)
    time = np.concatenate(
        [np.cumsum(rng.uniform(0.95, 1.05, 15) * pace) for pace in rng.uniform(20, 40, 6)]
    )
    ship = np.repeat(np.arange(6), 15)
    x, y = 5.0 * time + rng.normal(0, 3, 90), 3000.0 * ship + rng.normal(0, 3, 90)
    target = [f"ship {number}" for number in ship]
    return pl.DataFrame({"time": time, "x": x, "y": y, "target": target}).sort("time")


def heard_again(frame: pl.DataFrame, every: int, later: float) -> pl.DataFrame:
    """Append copies of some rows, which other receivers stamp a little later."""
    copies = frame.gather_every(every).with_columns(pl.col("time") + later)
    return pl.concat([frame, copies]).sample(fraction=1, shuffle=True, seed=1)


def settled_by(config: Any) -> Settling:
    configuration = load_configuration(config)

    def settle(once: ReportTable) -> Settled:
        observed = observe(once, configuration)
        return fill(configuration, None, once.sensors, observed=observed), None

    return settle


def firsts(frame: pl.DataFrame, config: Any = ANYHOW) -> list[tuple[str, str]]:
    doubles, _ = doubles_of(read_reports(frame), settled_by(config))
    names = doubles.reports.report
    return [(names[copy], names[doubles.first[copy]]) for copy in doubles.copies]


def standing(times: list[float], **columns: Any) -> pl.DataFrame:
    """One place, reported again and again beside others that make clear how the sensor looks."""
    return pl.DataFrame({"time": times, "x": 5.0, "y": 7.0, **columns})


def irregular(frame: pl.DataFrame) -> pl.DataFrame:
    times = np.cumsum(np.random.default_rng(1).uniform(0.3, 9.0, 40)) + 50.0
    other = pl.DataFrame({"time": times, "x": np.arange(40.0), "y": 900.0})
    return pl.concat([frame, other], how="diagonal")


def test_what_stands_still_in_every_scan_is_no_copy() -> None:
    assert firsts(standing([float(k) for k in range(30)]), SCANNING) == []
    assert firsts(irregular(standing([0.0, 1.0])), SCANNING) == []
    assert firsts(standing([0.0, 0.5, 1.1, 1.3], scan=[1, 2, 3, 4])) == []


def test_equal_numbers_at_one_time_are_one_report() -> None:
    assert firsts(standing([0.0, 1.0, 1.0, 1.0, 2.0]), SCANNING) == [("3", "2"), ("4", "2")]
    assert firsts(standing([0.0, 0.1, 0.3, 0.9], scan=[1, 1, 2, 2])) == [("2", "1"), ("4", "3")]


def test_without_scans_copies_come_within_two_seconds_of_the_first() -> None:
    table = irregular(standing([0.0, 1.5, 2.0, 3.0, 4.5, 7.5]))
    assert firsts(table) == [("2", "1"), ("3", "1"), ("5", "4")]
    since_1970 = table.with_columns(pl.col("time") + 1.7e9 + 0.1)
    assert firsts(since_1970) == [("2", "1"), ("3", "1"), ("5", "4")]


def test_under_a_turning_beam_copies_come_within_a_part_of_its_turn() -> None:
    """A network brings them later; what stands still comes again with the next turn."""
    rows = [
        (turn * 4.0 + azimuth / 90.0, 5e3 + 10.0 * turn * azimuth, azimuth)
        for turn in range(40)
        for azimuth in (0.0, 45.0, 120.0, 200.0)
    ]
    frame = pl.DataFrame(rows, ["time", "range_m", "azimuth_deg"], orient="row")
    again = frame[[9, 10, 11]].with_columns(pl.col("time") + pl.Series([0.004, 1.9, 2.3]))
    beam = {"measurement": "range-azimuth", "position": [0.0, 0.0], "rotation": "clockwise"}
    own = {**SENSOR, "sigma": {"range_m": 10.0, "azimuth_deg": 0.06}, "scan_period": 4.0, **beam}
    assert firsts(pl.concat([frame, again]), {**REST, "sensors": {"default": own}}) == [
        ("161", "10"), ("162", "11")
    ]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("told", [None, {}], ids=["told", "nothing told"])
def test_what_two_networks_bring_of_a_radar_changes_no_track(told: dict[str, Any] | None) -> None:
    """Nor are copies pieces, of objects that would be kilometres long."""
    frame, configuration = turning_radar(n_aircraft=12)
    config = configuration if told is None else told
    later = np.random.default_rng(5).uniform(0.001, 0.4, frame.height)
    again = frame.with_columns(pl.col("time") + later).gather_every(5)
    plain, found = tw.track(frame, config), tw.track(pl.concat([frame, again]), config)
    assert found.run["totals"]["doubles"] == len(again)
    assert found.run["totals"]["pieces"] == 0
    assert found.tracks.equals(plain.tracks)


@pytest.mark.parametrize(
    "columns",
    [
        {"sensor": ["a", "b"]},
        {"identity": ["211", "212"]},
        {"sigma_x": [1.0, 2.0], "sigma_y": [1.0, 1.0]},
        {"strength": [1.0, 2.0]},
    ],
    ids=["sensor", "identity", "sigma", "strength"],
)
def test_whatever_is_measured_differently_is_no_copy(columns: dict[str, Any]) -> None:
    assert firsts(standing([1.0, 1.0], **columns)) == []
    same = {name: [values[0]] * 2 for name, values in columns.items()}
    assert firsts(standing([1.0, 1.0], **same, note=["x", "y"])) == [("2", "1")]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("frame", "config", "later"),
    [(scans(), SCANNING, 0.0), (scans(), None, 0.0), (lone(), ANYHOW, 1.0), (lone(), None, 1.0)],
    ids=["scans", "scans, nothing told", "lone", "lone, nothing told"],
)
def test_copies_change_no_track(frame: pl.DataFrame, config: Any, later: float) -> None:
    plain, found = tw.track(frame, config), tw.track(heard_again(frame, 3, later), config)
    assert found.tracks.equals(plain.tracks)
    assert found.history.equals(plain.history)
    assert found.run["configuration"] == plain.run["configuration"]
    totals, copies = found.run["totals"], -(-len(frame) // 3)
    assert (totals["reports"], totals["doubles"]) == (len(frame) + copies, copies)
    assert plain.run["totals"]["doubles"] == 0
    assert plain.run["doubles"] == []
    assert not any("heard twice" in note for note in plain.run["notes"])
    (note,) = [note for note in found.run["notes"] if "heard twice" in note]
    # Heard later it may also be what rests.
    assert ("What rests" in note) == (later > 0)
    assert note.startswith(f"{copies} of {len(frame) + copies} reports are heard twice")


@pytest.mark.parametrize("make", [pl.DataFrame, pl.DataFrame.to_pandas, "csv"])
def test_every_copy_has_the_track_of_the_first(make: Any, tmp_path: Path) -> None:
    given = heard_again(scans(), 2, 0.0)
    if make == "csv":
        given.write_csv(tmp_path / "r.csv")
        result = tw.track(tmp_path / "r.csv", SCANNING)
    else:
        result = tw.track(make(given), SCANNING)
    reports: Any = result.reports
    if isinstance(reports, pd.DataFrame):
        reports = pl.from_pandas(reports)
    assert reports.select(given.columns).equals(given)
    same = reports.group_by("time", "target").agg(pl.col("track", "probability").n_unique())
    assert same["track"].max() == same["probability"].max() == 1
    assert reports["track"].null_count() == 0
    assert reports["probability"].null_count() == 0
    by_row = pl.from_pandas(result.assignments) if make == pl.DataFrame.to_pandas else None
    assigned: Any = result.assignments if by_row is None else by_row
    assert assigned["track"].to_list() == reports["track"].to_list()
    assert result.run["totals"]["assigned_reports"] == len(given)
    for double in result.run["doubles"]:
        copy, first = (reports.row(int(double[key]) - 1, named=True) for key in ("report", "of"))
        assert copy == first


def test_a_copy_of_a_false_alarm_is_one() -> None:
    alarm = pl.DataFrame({"time": [4.0], "x": [-500.0], "y": [900.0], "target": ["x"]})
    result = tw.track(pl.concat([scans(), alarm, alarm]), SCANNING)
    assert result.reports["track"].to_list()[-2:] == [None, None]
    assert result.run["totals"]["doubles"] == 1


def test_the_nearest_neighbour_tracker_hears_them_once_too() -> None:
    config = {**SCANNING, "tracker": {"kind": "nearest-neighbour"}}
    plain, found = tw.track(scans(), config), tw.track(heard_again(scans(), 2, 0.0), config)
    assert found.tracks.equals(plain.tracks)
    assert found.run["totals"]["assigned_reports"] == 30


class TestCommand:
    """Files in, files out."""

    def test_unavailable_positions_and_copies_have_their_rows(
        self,
        run: Run,  # noqa: F811
        tmp_path: Path,
    ) -> None:
        frame = lone().rename({"x": "lon", "y": "lat"})
        frame = frame.with_columns(pl.col("lon") / 70_000 - 1.3, pl.col("lat") / 111_000 + 50.7)
        codes = pl.DataFrame(
            {"time": [5.5, 80.5], "lon": [181.0] * 2, "lat": [91.0] * 2, "target": ["a", "b"]}
        ).select(frame.columns)
        given = pl.concat([heard_again(frame, 3, 1.0), codes]).sample(
            fraction=1, shuffle=True, seed=2
        )
        given.write_csv(tmp_path / "r.csv")
        out = tmp_path / "out"
        done = run("track", tmp_path / "r.csv", "--out", out)
        assert done.exit_code == 0, done.stderr
        assert "2 of 122 rows hold the codes" in done.stderr
        assert "30 of 120 reports are heard twice" in done.stderr
        found = pl.read_csv(out / "assignments.csv")
        assert found["report"].to_list() == list(range(1, 123))
        assert found["target"].to_list() == given["target"].to_list()
        assert found["track"].is_null().to_numpy()[(given["lat"] == 91).to_numpy()].all()
        record = json.loads((out / "run.json").read_text())
        totals = record["totals"]
        kinds = ("reports", "doubles", "unavailable_reports")
        assert [totals[kind] for kind in kinds] == [122, 30, 2]
        assert totals["assigned_reports"] == found["track"].count()
        assert run("plot", out).exit_code == 0
        record["doubles"] = [3]
        (out / "run.json").write_text(json.dumps(record))
        assert "key doubles: not as expected" in run("plot", out).stderr

    def test_init_estimates_from_what_was_heard_once(
        self,
        run: Run,  # noqa: F811
        tmp_path: Path,
    ) -> None:
        texts = []
        for name, frame in (("a", lone()), ("b", heard_again(lone(), 3, 1.0))):
            (tmp_path / name).mkdir()
            frame.write_csv(tmp_path / name / "r.csv")
            target = tmp_path / name / "t.toml"
            assert run("init", tmp_path / name / "r.csv", "-o", target).exit_code == 0
            texts.append([row for row in target.read_text().splitlines() if row[:1] != "#"])
        assert texts[0] == texts[1]


def test_measures_of_reports_are_those_of_the_files(tmp_path: Path) -> None:
    codes = pl.DataFrame({"time": [3.5], "lat": [91.0], "lon": [181.0], "target": ["a"]})
    frame = heard_again(scans(), 2, 0.0).select(
        "time", pl.col("y") / 111_000 + 50.7, pl.col("x") / 70_000, "target"
    )
    given = pl.concat([frame.rename({"y": "lat", "x": "lon"}), codes])
    result = tw.track(given, SCANNING)
    truth = pl.DataFrame(
        {"time": [0.0, 9.0], "target": ["a", "a"], "lat": [50.7, 50.7], "lon": [0.0, 90 / 70_000]}
    )
    result.save(tmp_path / "out")
    own = result.evaluate(truth)
    files = tw.evaluate(truth, result, tmp_path / "out" / "assignments.csv")
    assert own == files


@pytest.mark.parametrize("make", [pd.DataFrame, pl.DataFrame, tw.read_reports])
def test_unavailable_positions_keep_their_place_in_memory(make: Any) -> None:
    columns = {"time": range(5), "lat": [50, 91, 50, 50, 47], "lon": [1, 1, 1, 181, 1]}
    given = make(pl.DataFrame(columns) if make is tw.read_reports else columns)
    if make is pd.DataFrame:
        given.index = [7, 5, 3, 1, 9]
    result = tw.track(given)
    tracks = [None if pd.isna(track) else track for track in result.reports["track"]]
    assert len(tracks) == 5
    assert tracks[1] is tracks[3] is None
    assert list(result.reports["time"]) == list(range(5))
    assert list(result.assignments["time"]) == list(range(5))
    if make is pd.DataFrame:
        assert result.assignments.index.tolist() == [7, 5, 3, 1, 9]


def test_an_identity_that_one_copy_lacks_is_that_of_the_other():
    named = lone().rename({"target": "identity"})
    copies = named.with_columns(pl.col("time") + 1.0, identity=pl.lit(None, pl.String))
    either = pl.concat([copies.with_columns(pl.col("time") - 2.0), named])
    for frame in (pl.concat([named, copies]), either):
        doubles, _ = doubles_of(read_reports(frame), settled_by(ANYHOW))
        assert len(doubles.copies) == len(named)
        once = doubles.once
        assert once.identity is not None
        assert np.all(once.identity >= 0)


def test_equal_numbers_of_two_identities_are_two_reports():
    named = lone().rename({"target": "identity"})
    other = named.with_columns(identity=pl.lit("another"))
    unnamed = named.with_columns(identity=pl.lit(None, pl.String))
    doubles, _ = doubles_of(read_reports(pl.concat([named, other, unnamed])), settled_by(ANYHOW))
    assert len(doubles.copies) == 0


@pytest.mark.parametrize("lacking", [0, 1])
def test_a_noise_that_one_copy_lacks_is_that_of_the_other(lacking: int) -> None:
    once = lone().sort("time")
    told = once.with_columns(sigma_x=pl.lit(7.0), sigma_y=pl.lit(8.0))
    bare = told.with_columns(sigma_x=pl.lit(None, pl.Float64), sigma_y=pl.lit(None, pl.Float64))
    parts = [told, bare] if lacking else [bare, told]
    table = pl.concat(parts).sort("time", maintain_order=True).drop("target")
    reports = read_reports(table)
    found, _ = doubles_of(reports, settled_by(ANYHOW))
    assert found.copies.size == len(once)
    np.testing.assert_array_equal(found.once.sigma[:, :2], np.tile([7.0, 8.0], (len(once), 1)))
