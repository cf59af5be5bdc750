"""What sensors' reports show, and the settings that follow."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from trackweave.config import load_configuration
from trackweave.domain.facts import Facts, Place
from trackweave.domain.frames import LocalFrame
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError
from trackweave.formats.reading import read_reports
from trackweave.run.observing import observe, settle
from trackweave.run.told_places import with_facts

SENSOR = {"detection_probability": 0.9, "clutter_density": 1e-6, "scan_period": 4.0}
GIVEN = {
    "motion": {"process_noise": 1.0, "max_speed": 100.0},
    "lifecycle": {"new_target_density": 1e-9},
}


def radar(n_turns: int = 40, direction: int = 1, **columns) -> pl.DataFrame:
    """Five standing objects, seen as a beam of four seconds a turn passes them."""
    azimuth = np.tile(np.linspace(20.0, 250.0, 5), n_turns)
    turn = np.repeat(np.arange(n_turns), 5)
    time = 4.0 * (turn + (direction * azimuth / 360.0) % 1.0)
    order = np.argsort(time)
    return pl.DataFrame(
        {
            "time": time[order],
            "range_m": np.tile([5e3, 9e3, 2e4, 3e4, 4e4], n_turns)[order],
            "azimuth_deg": azimuth[order],
            **columns,
        }
    )


def table(frame: pl.DataFrame) -> ReportTable:
    return read_reports(frame)


@pytest.mark.parametrize("direction", [1, -1])
def test_sees_that_a_beam_turns(direction: int) -> None:
    seen = observe(table(radar(direction=direction)), load_configuration(None))["default"]
    assert seen.rotation is not None
    assert seen.rotation.direction == direction
    assert seen.rotation.period == pytest.approx(4.0, rel=1e-3)
    assert seen.reports_per_scan == pytest.approx(5.0, rel=0.05)
    assert seen.measurement is Kind.RANGE_AZIMUTH
    assert not seen.needs_place


def test_who_reports_every_third_turn_is_under_no_beam() -> None:
    """Senders in slots of a second are as regular as a beam of a third of a second."""
    azimuth = np.tile(np.linspace(20.0, 250.0, 5), 60)
    second = np.repeat(np.arange(60), 5)
    slot = np.tile([0, 2, 1, 0, 2], 60)
    told = pl.DataFrame(
        {
            "time": second + (slot + azimuth / 360.0) / 3.0,
            "range_m": np.tile([5e3, 9e3, 2e4, 3e4, 4e4], 60),
            "azimuth_deg": azimuth,
            "identity": np.tile(list("abcde"), 60),
        }
    ).sort("time")
    assert observe(table(told), load_configuration(None))["default"].rotation is None
    told = told.drop("identity")
    turns = observe(table(told), load_configuration(None))["default"].rotation
    assert turns is not None
    assert turns.period == pytest.approx(1.0 / 3.0, rel=1e-3)


def test_is_told_that_a_beam_does_not_turn() -> None:
    configuration = load_configuration({"sensors": {"default": {"rotation": "none"}}})
    assert observe(table(radar()), configuration)["default"].rotation is None


@pytest.mark.parametrize(
    "told",
    [
        {"rotation": "counter-clockwise", "scan_period": 4.0},
        {"rotation": "counter-clockwise"},
        {"rotation": "clockwise", "scan_period": 6.5},
        {"scan_period": 6.5},
    ],
)
def test_a_turn_that_reports_show_otherwise_is_theirs_and_said(told: dict) -> None:
    settings, _ = settle(table(radar()), load_configuration({"sensors": {"default": told}}))
    turn = settings.sensors[0].rotation
    assert turn is not None
    assert turn.direction == 1
    assert settings.sensors[0].scan_period == pytest.approx(turn.period)
    assert turn.period == pytest.approx(4.0, rel=1e-3)
    said = [note for note in settings.notes if "its reports show" in note]
    wrong = {"rotation": "counter-clockwise", "scan_period": 6.5}
    for key in told.items() & wrong.items():
        assert sum(f'trust = ["{key[0]}"] in [sensors.default]' in note for note in said) == 1


@pytest.mark.parametrize("trust", [True, ["scan_period"]])
def test_a_period_that_is_trusted_is_kept(trust: object) -> None:
    told = {"scan_period": 6.5, "rotation": "clockwise", "trust": trust}
    settings, _ = settle(table(radar()), load_configuration({"sensors": {"default": told}}))
    assert settings.sensors[0].scan_period == 6.5
    assert settings.sensors[0].rotation.period == 6.5


@pytest.mark.parametrize("trust", [True, ["rotation"]])
def test_a_sense_that_is_trusted_is_kept(trust: object) -> None:
    told = {"rotation": "counter-clockwise", "scan_period": 4.0, "trust": trust}
    settings, _ = settle(table(radar()), load_configuration({"sensors": {"default": told}}))
    assert settings.sensors[0].rotation.direction == -1


def test_a_turn_that_is_given_needs_few_reports() -> None:
    section = {"rotation": "counter-clockwise", "scan_period": 5.0}
    configuration = load_configuration({"sensors": {"default": section}})
    seen = observe(table(radar(1)), configuration)["default"]
    assert seen.rotation is not None
    assert (seen.rotation.period, seen.rotation.direction) == (5.0, -1)


def test_scan_numbers_leave_no_turn_to_be_guessed() -> None:
    reports = table(radar(scan=np.arange(200) // 5))
    assert observe(reports, load_configuration(None))["default"].rotation is None


def test_a_missing_place_is_refused_before_anything_is_estimated(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("trackweave.run.refining.estimates_for", lambda *_: pytest.fail("late"))
    two = pl.DataFrame(
        {
            "time": np.repeat(np.arange(40.0), 2),
            "sensor": ["a", "b"] * 40,
            "range_m": np.full(80, 9e3),
            "azimuth_deg": np.arange(80.0),
        }
    )
    with pytest.raises(InvalidInputError, match=r"sensors\.a\.position, sensors\.b\.position"):
        settle(read_reports(two), load_configuration({}))


def test_measures_what_reports_fill() -> None:
    seen = observe(table(radar()), load_configuration(None))["default"]
    # The sector from 250 to 20 degrees is not watched.
    assert seen.extent == pytest.approx(1.05 * 4e4 * np.radians(230.0), rel=0.01)
    assert seen.usual_range == 2e4


def test_a_sensor_without_a_position_is_refused_where_one_is_needed() -> None:
    two = pl.DataFrame(
        {
            "time": [0.0, 0.0, 1.0],
            "sensor": ["lidar", "camera", "lidar"],
            "x": [1.0, None, 2.0],
            "y": [1.0, None, 2.0],
            "bearing_deg": [None, 3.0, None],
        }
    )
    with pytest.raises(InvalidInputError, match=r"sensors\.camera\.position: left out"):
        settle(table(two), load_configuration(GIVEN))
    edited, _ = settle(table(two), load_configuration(None), to_be_edited=True)
    assert "sensors.camera.position: give where it stands" in edited.notes
    placed = {**GIVEN, "sensors": {"camera": {"position": [0.0, 5.0]}}}
    settings, _ = settle(table(two), load_configuration(placed))
    assert [sensor.position for sensor in settings.sensors] == [(0.0, 5.0), None]


def test_nothing_is_estimated_where_everything_is_given() -> None:
    section = {**SENSOR, "sigma": {"range_m": 50.0, "azimuth_deg": 0.1}}
    configuration = load_configuration({**GIVEN, "sensors": {"default": section}})
    settings, estimates = settle(table(radar()), configuration)
    assert estimates is None
    assert settings.sensors[0].rotation is not None
    assert settings.sensors[0].scan_period == 4.0


def test_bearings_alone_take_usual_values() -> None:
    bearings = pl.DataFrame({"time": np.arange(30.0), "bearing_deg": np.linspace(10, 50, 30)})
    settings, estimates = settle(table(bearings), load_configuration(None))
    assert estimates is None
    assert settings.sensors[0].sigma == (pytest.approx(np.radians(1.0)),)
    assert settings.sensors[0].scan_period == 1.0
    assert settings.sources["motion.max_speed"] == "default"
    assert any("usual values stand in" in note for note in settings.notes)
    assert any("one sensor's bearings do not tell where" in note for note in settings.notes)


def test_says_nothing_of_bearings_whose_sensor_is_known() -> None:
    bearings = pl.DataFrame(
        {"time": np.repeat(np.arange(30.0), 2), "sensor": ["A", "B"] * 30, "bearing_deg": 10.0}
    )
    known = {
        "sigma": {"bearing_deg": 0.5}, "detection_probability": 0.9, "clutter_density": 0.1,
        "position": [0.0, 0.0],
    }  # fmt: skip
    elsewhere = {"default": known, "B": {"position": [1000.0, 0.0]}}
    settings, _ = settle(table(bearings), load_configuration({"sensors": elsewhere}))
    assert not any("do not tell" in note for note in settings.notes)
    # What is told does not tell ghosts apart.
    assert any("may be taken for such ghosts" in note for note in settings.notes)
    settings, _ = settle(table(bearings), load_configuration({"sensors": {"default": known}}))
    assert any("cross nowhere" in note for note in settings.notes)


def two_radars(reach: float) -> ReportTable:
    """Return reports of two radars 3 km apart, the first with a reach."""
    rng = np.random.default_rng(1)
    n, places = 1200, np.array([[0.0, 0.0], [3000.0, 0.0]])
    place, sensor = rng.uniform([-1000, -1000], [4000, 1000], (n, 2)), np.arange(n) % 2
    offset = place - places[sensor]
    away = np.linalg.norm(offset, axis=1)
    frame = pl.DataFrame({
        "time": np.repeat(np.arange(n // 10), 10).astype(float),
        "sensor": np.array(["a", "b"])[sensor],
        "range_m": away,
        "azimuth_deg": np.degrees(np.arctan2(*offset.T)) % 360,
    })  # fmt: skip
    return read_reports(frame.filter((away < reach) | (sensor == 1)))


def test_a_reach_that_nobody_told_is_estimated_and_said() -> None:
    told = {
        **GIVEN,
        "sensors": {
            "default": {**SENSOR, "sigma": {"range_m": 5.0, "azimuth_deg": 0.1}},
            "a": {"position": [0.0, 0.0]},
            "b": {"position": [3000.0, 0.0]},
        },
    }
    settings, _ = settle(two_radars(1500.0), load_configuration(told))
    first, second = settings.sensors
    assert first.field_of_view is not None
    assert 1500.0 <= first.field_of_view.max_range < 1550.0
    assert second.field_of_view is None
    assert settings.sources["sensors.a.field_of_view"] == "estimated"
    assert settings.values["sensors"]["a"]["field_of_view"].keys() == {"max_range_m"}
    (note,) = [note for note in settings.notes if "no field_of_view is given" in note]
    assert note.startswith("sensor a: ")
    told["sensors"]["a"]["field_of_view"] = {"max_range_m": 9e8}
    settings, _ = settle(two_radars(1500.0), load_configuration(told))
    assert settings.sensors[0].field_of_view.max_range == 9e8
    assert not any("no field_of_view is given" in note for note in settings.notes)


def test_a_speed_too_small_for_a_few_objects_is_said() -> None:
    rng = np.random.default_rng(6)
    heading = rng.uniform(0, 2 * np.pi, 22)
    speed = np.where(np.arange(22) < 19, 8.0, 160.0)
    velocity = speed[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=1)
    start = rng.uniform(-5000, 5000, (22, 2))
    time = np.repeat(np.arange(0.0, 80.0, 2.0), 22)
    place = (start + velocity * time.reshape(-1, 22, 1)).reshape(-1, 2)
    seen = place + rng.normal(0, 12.0, place.shape)
    reports = table(pl.DataFrame({"time": time, "x": seen[:, 0], "y": seen[:, 1]}))
    for told, is_said in ((20.0, True), (180.0, False)):
        settings, _ = settle(reports, load_configuration({"motion": {"max_speed": told}}))
        assert any("a few objects seem to move at" in note for note in settings.notes) == is_said


def test_who_is_asked_where_radars_stand_learns_from_which_point_and_what_is_known() -> None:
    table = pl.DataFrame(
        {
            "time": np.arange(6.0),
            "sensor": ["025/012", "025/013"] * 3,
            "range_m": np.full(6, 9e3),
            "azimuth_deg": np.arange(6.0),
        }
    )
    alone = read_reports(table)
    with pytest.raises(InvalidInputError, match="north of one point for all, any that you"):
        settle(alone, load_configuration({}))
    known = replace(
        alone,
        facts=Facts(places={"025/012": Place(43.57103, 16.40606)}),
        frame=LocalFrame(43.571, 16.4061),
    )
    with pytest.raises(InvalidInputError) as caught:
        settle(known, with_facts(load_configuration({}), known))
    told = str(caught.value)
    assert told.startswith("sensors.025/013.position: left out")
    assert "north of latitude 43.571, longitude 16.4061, where the plane touches" in told
    assert "[frame] origin = [latitude, longitude] puts that elsewhere" in told
    assert told.endswith("The recording tells that of 025/012 at 43.57103, 16.40606")
