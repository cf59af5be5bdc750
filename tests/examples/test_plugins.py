"""The example package of plug-ins, by its entry points, and plug-ins that are not right."""

import json
import subprocess
import sys

import polars as pl
import pytest

import trackweave as tw
from oracles import plugins
from oracles.plugin_site import EXAMPLES, example_entry_points, installed
from trackweave.cli.app import app
from trackweave.errors import InvalidInputError
from trackweave.io.frames_out import reports_frame

LONGEST = 150


@pytest.fixture
def example(tmp_path):
    with installed(tmp_path / "site", example_entry_points(), EXAMPLES):
        yield tmp_path


def run(script, *arguments):
    path = EXAMPLES / script
    subprocess.run([sys.executable, path, *map(str, arguments)], check=True, cwd=path.parent)


def told(name):
    return EXAMPLES / f"{name}.toml"


def command(*arguments):
    """Run a command of ours in this process, which knows the entry points."""
    from typer.testing import CliRunner

    done = CliRunner().invoke(app, [*map(str, arguments), "--json"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_each_plugin_fits_on_a_few_pages():
    for name in ("reentry", "time_differences"):
        lines = (EXAMPLES / "trackweave_plugins" / f"{name}.py").read_text().splitlines()
        assert len(lines) <= LONGEST


@pytest.mark.slow
def test_bodies_are_followed_down_by_the_model_of_their_drag(example):
    run("make_reentry.py", example)
    out = example / "out"
    arguments = ("--config", told("reentry"), "--out", out)
    found = command("track", example / "reports.csv", *arguments)
    assert found["tracks"] == 4
    judged = command(
        "evaluate", "--truth", example / "truth.csv", "--tracks", out / "tracks.csv",
        "--assignments", out / "assignments.csv", "--cutoff", "500",
    )  # fmt: skip
    assert judged["report_idf1"] > 0.98
    assert judged["idf1"] > 0.95
    record = json.loads((out / "run.json").read_text())
    assert record["configuration"]["motion"]["ballistic_coefficient"] == 600.0


@pytest.mark.shared
def test_aircraft_are_found_by_the_times_their_messages_arrive(example, shared):
    data = shared / "data" / "locards"
    run("read_locards.py", data / "set_5.csv", data / "sensors.csv", example)
    found = command(
        "track", example / "reports.csv", "--config", told("locards"), "--out", example / "out"
    )
    assert found["assigned_reports"] > 0.9 * found["reports"]
    judged = command(
        "evaluate", "--truth", example / "truth.csv", "--tracks", example / "out" / "tracks.csv",
        "--assignments", example / "out" / "assignments.csv", "--cutoff", "1000",
    )  # fmt: skip
    assert judged["report_purity"] > 0.85
    assert judged["rmse"] < 250.0


def table(steps=12):
    rows = [
        (4.0 * step, x + 40.0 * step, y, str(number))
        for step in range(steps)
        for number, (x, y) in enumerate([(0.0, 0.0), (500.0, 900.0)])
    ]
    return pl.DataFrame(rows, schema=["time", "x", "y", "target"], orient="row")


SENSOR = {"sigma": 5.0, "detection_probability": 0.9, "clutter_density": 1e-8, "scan_period": 4.0}
MOTION = {"process_noise": 0.1, "max_speed": 60.0}
LIFECYCLE = {"new_target_density": 1e-8}


def configuration(motion="constant-velocity", **sensor):
    return {
        "motion": {"model": motion, **MOTION},
        "sensors": {"default": {**SENSOR, **sensor}},
        "lifecycle": LIFECYCLE,
    }


POINTS = {
    "trackweave.motions": {
        "cruising": "oracles.plugins:Cruising",
        "straight": "oracles.plugins:Straight",
        "gone": "oracles.plugins:Nobody",
    },
    "trackweave.measurements": {
        "place": "oracles.plugins:Place",
        "no-class": "oracles.plugins:np",
    },
    "trackweave.solvers": {"patient": "oracles.plugins:Patient", "mute": "oracles.plugins:Place"},
}


@pytest.fixture
def points(tmp_path):
    with installed(tmp_path / "site", POINTS):
        yield


@pytest.mark.usefixtures("points")
@pytest.mark.parametrize(
    "other",
    [
        configuration("straight"),
        configuration(measurement="place"),
        configuration("straight", measurement="place"),
        {**configuration(), "search": {"method": "patient", "patience": 3}},
    ],
)
def test_what_a_file_names_by_entry_point_tracks_as_ours_do(other):
    ours, theirs = tw.track(table(), configuration()), tw.track(table(), other)
    for name in ("tracks", "history", "assignments"):
        own, found = getattr(ours, name), getattr(theirs, name)
        assert found.columns == own.columns
        for column in own.columns:
            if own[column].dtype.is_float():
                assert (own[column].fill_null(0) - found[column].fill_null(0)).abs().max() < 1e-5
            else:
                assert own[column].to_list() == found[column].to_list()


@pytest.mark.usefixtures("points")
def test_a_history_of_several_modes_is_that_of_ours():
    both = []
    for sensor in ({}, {"measurement": "place"}):
        told = configuration("imm", **sensor)
        told["motion"] |= {"imm": {"models": ["constant-velocity", "coordinated-turn"]}}
        both.append(tw.track(table(), told).history)
    for name in ("x", "vx", "p_x_x", "p_vx_vx"):
        assert (both[0][name] - both[1][name]).abs().max() < 1e-5


@pytest.mark.usefixtures("points")
def test_a_history_shows_velocities_that_a_model_tells_in_its_own_way():
    told = {**configuration(), "motion": {"model": "cruising", "course": 1.5}}
    history = tw.track(table(), told).history
    assert (history["vx"] - 10.0).abs().max() < 2.0
    assert history["vy"].abs().max() < 2.0


@pytest.mark.usefixtures("points")
def test_the_record_holds_every_key_of_a_plugin_and_whence_it_came():
    record = tw.track(table(), configuration("straight", measurement="place")).run
    assert record["configuration"]["motion"]["model"] == "straight"
    assert record["configuration"]["motion"]["max_speed"] == 60.0
    assert record["configuration"]["sensors"]["default"]["measurement"] == "place"


@pytest.mark.usefixtures("points")
@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"motion": {"model": "straight", "process_noise": 1.0}},
            "configuration, motion.max_speed: left out; expected a value",
        ),
        (
            {"motion": {"model": "straight", "process_noise": "much", "max_speed": 1.0}},
            'configuration, motion.process_noise: "much"; expected a number',
        ),
        (
            {"motion": {"model": "straight", "proces_noise": 1.0}},
            "configuration, motion.proces_noise: unknown key; did you mean process_noise?",
        ),
        (
            {"motion": {"model": "strait"}},
            'configuration, motion.model: "strait"; expected one of',
        ),
        (
            {"motion": {"model": "gone"}},
            'configuration, motion.model: "gone" is oracles.plugins:Nobody, which cannot be load',
        ),
        (
            {"sensors": {"default": {"measurement": "no-class"}}},
            'configuration, sensors.default.measurement: "no-class" is oracles.plugins:np; '
            "expected a dataclass",
        ),
        (
            {"search": {"method": "mute"}},
            'configuration, search.method: "mute": Place(columns=',
        ),
        (
            {"search": {"method": "patient", "patience": "x"}},
            'configuration, search.patience: "x"; expected a whole number',
        ),
        (
            {"sensors": {"default": {"measurement": "place"}}},
            "configuration: sensors.default.sigma, sensors.default.detection_probability, "
            "sensors.default.clutter_density, sensors.default.scan_period (or scans = false), "
            "motion.process_noise, motion.max_speed, lifecycle.new_target_density left out; "
            "expected to be told, because nothing can be estimated from reports of measurement "
            "place, which is a plug-in",
        ),
    ],
)
def test_what_is_wrong_is_told_once_with_the_key(values, message):
    with pytest.raises(InvalidInputError) as refused:
        tw.track(table(), values)
    assert str(refused.value).startswith(message)


@pytest.mark.usefixtures("points")
def test_a_column_that_a_kind_names_and_is_not_there_is_told():
    reports = table().rename({"y": "north"})
    with pytest.raises(tw.DataFormatError, match="column y: missing; expected numbers of"):
        tw.track(reports, configuration(measurement="place"))


def test_reports_of_a_kind_are_read_with_their_own_noise_and_context():
    class Kind(plugins.Place):
        context = ("height",)

    reports = table(2).with_columns(
        pl.lit(3.0).alias("sigma_x"), pl.Series("height", [1.0, None, 2.0, 3.0])
    )
    read = tw.read_reports(reports, kinds={"default": Kind()})
    scan = next(read.scans())
    assert scan.sigma[:, 0].tolist() == [3.0, 3.0]
    assert scan.context is not None
    assert scan.context[0].tolist() == [1.0]
    written = reports_frame(read)
    assert written["height"].to_list() == [1.0, None, 2.0, 3.0]
    again = tw.read_reports(written, kinds={"default": Kind()})
    assert again.measurement.tolist() == read.measurement.tolist()


@pytest.mark.usefixtures("points")
def test_a_sensor_may_say_that_it_measures_what_ours_do():
    both = [table().with_columns(pl.lit(name).alias("sensor")) for name in ("a", "b")]
    told = configuration(measurement="place")
    told["sensors"]["b"] = {"measurement": "position"}
    record = tw.track(pl.concat(both), told).run
    kinds = {
        name: keys["measurement"] for name, keys in record["configuration"]["sensors"].items()
    }
    assert kinds == {"a": "place", "b": "position"}


@pytest.mark.usefixtures("points")
def test_a_live_tracker_is_made_of_a_file_that_names_plugins():
    tracker = tw.MultiHypothesisTracker.from_config(configuration("straight", measurement="place"))
    for step in range(4):
        found = tracker.step(tw.Scan(4.0 * step, "default", [[40.0 * step, 0.0]]))
    assert found.n_tracks == 1


def test_a_kind_beside_sensors_of_ours():
    reports = pl.concat(
        [
            table().with_columns(pl.lit("ours").alias("sensor")),
            table().with_columns(pl.lit("theirs").alias("sensor")),
        ]
    )
    read = tw.read_reports(reports, kinds={"theirs": plugins.Place()})
    assert [kind.word for kind in read.kinds] == ["position", "Place"]
