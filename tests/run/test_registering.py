"""What is wrong with a sensor is found where others see the same objects, and only there."""

import numpy as np
import polars as pl
import pytest

from run.biased_sky import RADARS, off, on_plane, sky, told
from trackweave import track
from trackweave.config import load_configuration
from trackweave.metrics import assignment_quality
from trackweave.run.registering import registration_of
from trackweave.run.tracking import report_table

NONE = {"range_bias_m": 0.0, "range_scale": 1.0, "azimuth_bias_deg": 0.0, "clock_offset": 0.0}


def registered(reports, keys):
    configuration = load_configuration(keys)
    return registration_of(report_table(reports.drop("target"), configuration)[0], configuration)


def used(registration, key):
    sensors = registration.as_record()["sensors"]
    return {name: own[key]["used"] for name, own in sensors.items() if key in own}


@pytest.fixture(scope="module")
def biased():
    return registered(off(sky(), "north", 100.0, 0.3, 0.5), told())


def test_range_azimuth_and_clock_of_one_radar_are_found(biased):
    own = biased.as_record()["sensors"]["north"]
    assert own["range_bias_m"]["used"] == pytest.approx(100.0, rel=0.1)
    assert own["azimuth_bias_deg"]["used"] == pytest.approx(0.3, rel=0.1)
    assert own["clock_offset"]["used"] == pytest.approx(0.5, rel=0.1)
    assert own["range_scale"]["used"] == 1.0


def test_what_is_said_to_be_uncertain_is_about_as_uncertain_as_it_is(biased):
    own = biased.as_record()["sensors"]["north"]
    for key, true in (("range_bias_m", 100.0), ("azimuth_bias_deg", 0.3), ("clock_offset", 0.5)):
        assert abs(own[key]["learned"] - true) < 4.0 * own[key]["sigma"]
        assert own[key]["sigma"] < 0.05 * true


def test_the_others_keep_what_they_report(biased):
    assert all(used(biased, key)[name] == NONE[key] for key in NONE for name in ("east", "west"))


def test_reports_come_out_as_they_would_have_been(biased):
    configuration = load_configuration(told())
    right = report_table(sky().drop("target"), configuration)[0]
    place = np.argsort(right.row)
    mended = biased.reports
    again = np.argsort(mended.report.astype(int))
    np.testing.assert_allclose(mended.time[again], right.time[place], atol=0.05)
    np.testing.assert_allclose(
        mended.measurement[again, 0], right.measurement[place, 0], atol=15.0
    )


def test_they_stay_in_the_order_of_time_with_their_rows(biased):
    assert np.all(np.diff(biased.reports.time) >= 0.0)
    assert sorted(biased.reports.row) == [*range(1, len(biased.reports) + 1)]


def test_nothing_is_touched_where_nothing_is_wrong():
    configuration = load_configuration(told())
    table, _ = report_table(sky().drop("target"), configuration)
    registration = registration_of(table, configuration)
    assert registration.reports is table
    assert registration.configuration is configuration
    assert registration.notes() == []


def test_a_radar_alone_is_not_looked_at():
    registration = registered(off(sky(names=("west",)), "west", 100.0, 0.3, 0.5), told(("west",)))
    assert registration.found is None
    assert registration.as_record() is None


def test_of_two_radars_the_one_that_is_off_is_found_by_geometry():
    names = ("north", "west")
    registration = registered(
        off(sky(names=names, n_aircraft=40), "west", 100.0, 0.3), told(names)
    )
    assert used(registration, "azimuth_bias_deg") == {
        "north": 0.0,
        "west": pytest.approx(0.3, rel=0.1),
    }
    assert used(registration, "range_bias_m") == {
        "north": 0.0,
        "west": pytest.approx(100.0, rel=0.1),
    }


def test_if_all_clocks_are_ahead_alike_nothing_shows_it():
    reports = sky()
    for name in told()["sensors"]:
        reports = off(reports, name, clock=0.5)
    registration = registered(reports, told())
    assert set(used(registration, "clock_offset").values()) == {0.0}


def test_most_clocks_are_believed():
    registration = registered(off(sky(), "east", clock=-0.8), told())
    found = used(registration, "clock_offset")
    assert found == {"east": pytest.approx(-0.8, rel=0.1), "north": 0.0, "west": 0.0}


def test_a_large_bias_is_found_too():
    registration = registered(off(sky(), "west", 400.0, 1.5, 3.0), told())
    assert used(registration, "azimuth_bias_deg")["west"] == pytest.approx(1.5, rel=0.05)
    assert used(registration, "clock_offset")["west"] == pytest.approx(3.0, rel=0.05)


@pytest.mark.parametrize("names", [("north", "west"), tuple(RADARS)])
@pytest.mark.parametrize("angle", [4.0, -15.0, 100.0])
def test_a_north_that_is_far_off_is_found(names, angle):
    # A magnetic north, a mark that was not set: no track is near those of others.
    registration = registered(off(sky(names=names), "west", 100.0, angle, 0.5), told(names))
    found = used(registration, "azimuth_bias_deg")
    assert (found["west"] - angle + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=0.02)
    assert found["north"] == pytest.approx(0.0, abs=0.02)
    assert used(registration, "clock_offset")["west"] == pytest.approx(0.5, rel=0.2)


def test_a_radar_without_any_track_is_passed_over():
    names = ("north", "west")
    frame = off(sky(names=names), "west", 0.0, 4.0).drop("report")
    few = {"time": [1.0, 60.0, 120.0], "range_m": [5e4] * 3, "azimuth_deg": [10.0, 90.0, 200.0]}
    alone = pl.DataFrame(few).with_columns(sensor=pl.lit("east"))
    registration = registered(pl.concat([frame, alone], how="diagonal").sort("time"), told())
    assert used(registration, "azimuth_bias_deg")["west"] == pytest.approx(4.0, abs=0.02)


def test_a_north_that_is_trusted_stays():
    keys = told(("north", "west"))
    for each in keys["sensors"].values():
        each |= {"azimuth_bias_deg": 0.0, "trust": ["azimuth_bias_deg"]}
    registration = registered(off(sky(names=("north", "west")), "west", 0.0, 4.0), keys)
    assert registration.found is None or not registration.found.bias.any()


def elsewhere(name, east, north, names=tuple(RADARS), **more):
    """What is told where one radar is told to stand elsewhere than it does."""
    keys = told(names)
    own = keys["sensors"][name]
    x, y = own["position"]
    keys["sensors"][name] = {**own, "position": [x + east, y + north], **more}
    return keys


@pytest.mark.parametrize("shift", [(1500.0, 1000.0), (-300.0, 0.0), (4000.0, -3000.0)])
def test_a_radar_that_stands_elsewhere_is_found(shift):
    registration = registered(sky(), elsewhere("north", *shift))
    at = used(registration, "position")
    true = told()["sensors"]
    assert at.pop("north") == pytest.approx(true["north"]["position"], abs=25.0)
    assert at == {name: true[name]["position"] for name in at}
    (said,) = registration.notes()
    assert said.startswith("sensor north: it stands ")
    assert f" m {'west' if shift[0] > 0 else 'east'}" in said
    (record,) = registration.told_record()
    assert record["key"] == "sensors.north.position"
    assert record["sigma"][0] < 15.0


def test_of_two_radars_one_stands_elsewhere_and_none_points_elsewhere():
    names = ("north", "west")
    found = registered(sky(names=names), elsewhere("west", 1300.0, 0.0, names))
    (shifted,) = found.found_out()
    assert shifted[2] == "position"
    before, after = (np.array(used(one, "position")[shifted[0]])
                     for one in (registered(sky(names=names), told(names)), found))  # fmt: skip
    assert abs(after - before)[0] == pytest.approx(0.0 if shifted[0] == "west" else 1300.0, abs=25)


def test_a_radar_is_told_beside_its_biases_to_stand_elsewhere():
    found = registered(off(sky(), "west", 100.0, 0.3, 0.5), elsewhere("west", 800.0, 0.0))
    own = found.as_record()["sensors"]["west"]
    assert own["position"]["used"] == pytest.approx([0.0, 0.0], abs=25.0)
    assert own["range_bias_m"]["used"] == pytest.approx(100.0, rel=0.1)
    assert own["azimuth_bias_deg"]["used"] == pytest.approx(0.3, rel=0.1)


@pytest.mark.parametrize("word", ["position", "place"])
def test_a_place_that_is_trusted_stays(word):
    told_so = elsewhere("west", 1500.0, 1000.0, trust=[word])
    assert used(registered(sky(), told_so), "position")["west"] == [1500.0, 1000.0]


def test_positions_are_shifted_back():
    shift = pl.col("x") + 250.0 * (pl.col("sensor") == "east").cast(pl.Float64)
    reports = on_plane(sky()).with_columns(x=shift, target=None)
    own = registered(reports, told()).as_record()["sensors"]["east"]
    assert own["translation"]["used"][0] == pytest.approx(250.0, rel=0.1)
    assert own["translation"]["sigma"][0] < 25.0


def test_who_flies_and_tells_no_height_is_not_looked_at_and_that_is_said():
    found = registered(off(sky(), "north", 100.0, 0.3, 0.5).drop("height_m"), told())
    assert found.found is None
    assert "height_m" in found.as_record()["doubt"]
    assert ["height_m" in note for note in found.notes()] == [True]


@pytest.mark.slow
def test_a_sensor_that_moves_is_refused_by_name():
    reports = on_plane(sky()).with_columns(target=None)
    where = pl.when(pl.col("sensor") == "east").then(6e4)
    registration = registered(reports.with_columns(sensor_x=where, sensor_y=where), told())
    assert "moves" in registration.refused["east"]
    assert "east" not in registration.as_record()["sensors"]


def test_what_is_told_is_taken_out_and_only_the_rest_is_found():
    keys = told()
    keys["sensors"]["north"]["range_bias_m"] = 60.0
    own = registered(off(sky(), "north", 100.0), keys)
    found = own.as_record()["sensors"]["north"]["range_bias_m"]
    assert found["told"] == 60.0
    assert found["used"] == pytest.approx(100.0, rel=0.1)
    assert [each["key"] for each in own.told_record()] == ["sensors.north.range_bias_m"]


def test_what_is_trusted_stays_as_told():
    keys = told()
    keys["sensors"]["north"] |= {"range_bias_m": 0.0, "trust": ["range_bias_m"]}
    registration = registered(off(sky(), "north", 60.0), keys)
    assert used(registration, "range_bias_m")["north"] == 0.0


@pytest.mark.slow
def test_aircraft_keep_their_names_under_a_biased_radar():
    right, wrong = sky(minutes=2.0), off(sky(minutes=2.0), "north", 100.0, 0.3, 0.5)
    quality = []
    for reports in (right, wrong):
        result = track(reports.drop("target"), told())
        found = result.assignments["track"].fill_null(-1).to_numpy()
        order = reports.sort("report")["target"].cast(pl.String).fill_null("").to_list()
        by_report = result.assignments.sort("report")["track"].fill_null(-1).to_numpy()
        assert found.size == len(order)
        quality.append(assignment_quality(order, by_report).idf1)
    assert quality[1] == pytest.approx(quality[0], abs=0.01)
    assert result.run["sources"]["sensors.north.clock_offset"] == "estimated"
    used_now = result.run["configuration"]["sensors"]["north"]["azimuth_bias_deg"]
    assert used_now == result.run["registration"]["sensors"]["north"]["azimuth_bias_deg"]["used"]
    assert any(note.startswith("sensor north: range_bias_m") for note in result.run["notes"])
    # What a run used makes the same run when it is told.
    own = result.run["configuration"]["sensors"]["north"]
    biases = {key: own[key] for key in ("range_bias_m", "azimuth_bias_deg", "clock_offset")}
    keys = told()
    keys["sensors"]["north"] |= {**biases, "trust": [*biases]}
    again = track(wrong.drop("target"), keys)
    assert again.assignments.equals(result.assignments)


def test_a_shift_is_found_of_a_sensor_that_is_turned_a_little_too():
    # No bias that is looked for tells that: it differs from object to object.
    east = (pl.col("sensor") == "east").cast(pl.Float64)
    x, y = pl.col("x"), pl.col("y")
    reports = on_plane(sky()).with_columns(
        x=x + east * (250.0 + 0.001 * y), y=y - east * 0.001 * x, target=None
    )
    found = registered(reports, told())
    assert found.found.scale > 3.0
    own = found.as_record()["sensors"]["east"]["translation"]
    assert own["used"][0] == pytest.approx(250.0, abs=40.0)
    assert own["sigma"][0] < 10.0


@pytest.mark.parametrize("names", [("north", "west"), tuple(RADARS)])
def test_a_radar_that_stands_far_off_is_found_by_the_ways_of_objects(names):
    # Thirty kilometres, where no track of it is near one of another's.
    found = registered(sky(names=names), elsewhere("west", 25e3, -18e3, names))
    at = used(found, "position")
    true = {name: told()["sensors"][name]["position"] for name in names}
    apart = {name: np.subtract(at[name], true[name]) for name in names}
    np.testing.assert_allclose(apart["west"] - apart["north"], [0.0, 0.0], atol=30.0)
    if len(names) == 2:
        assert "which nothing tells apart" in found.notes()[0]


def test_where_nobody_flies_alike_nothing_is_moved():
    # Two radars of which each sees aircraft of its own.
    one, other = sky(seed=5, names=("north",)), sky(seed=6, names=("west",))
    reports = pl.concat([one.drop("report"), other.drop("report")]).sort("time")
    found = registered(reports, told(("north", "west")))
    assert found.found is None or not found.is_elsewhere


def beside_receiver(*, named, clock=0.0):
    """The aircraft of a sky as one radar sees them, and as they report each second themselves."""
    rng, rows = np.random.default_rng(2), []
    seen = sky(names=("north",)).drop("report")
    told = seen.filter(pl.col("height_m").is_not_null())
    for (who,), own in (
        on_plane(told).with_columns(told["target"]).group_by("target", maintain_order=True)
    ):
        # They fly straight; through their plots they are known to some ten metres.
        time = own["time"].to_numpy()
        ways = [np.polynomial.Polynomial.fit(time, own[axis].to_numpy(), 1) for axis in "xy"]
        for moment in np.arange(time.min() + rng.uniform(), time.max(), 1.0):
            x, y = (way(moment) + rng.normal(0.0, 15.0) for way in ways)
            name = f"A{who}" if named else None
            rows.append((moment, x, y, name, "adsb", who, None))
    names = ["time", "x", "y", "identity", "sensor", "target", "height_m"]
    heard = pl.DataFrame(rows, names, orient="row", infer_schema_length=None)
    heard = heard.with_columns(pl.col("height_m").cast(pl.Float64))
    seen = off(seen, "north", 120.0, 0.3, clock)
    return pl.concat([seen, heard], how="diagonal").sort("time")


@pytest.mark.parametrize("named", [True, False])
def test_a_radar_is_registered_beside_what_objects_report_of_themselves(named):
    found = registered(beside_receiver(named=named, clock=0.6), told(("north",)))
    assert used(found, "range_bias_m")["north"] == pytest.approx(120.0, abs=15.0)
    assert used(found, "azimuth_bias_deg")["north"] == pytest.approx(0.3, abs=0.02)
    clocks = used(found, "clock_offset")
    assert clocks["north"] - clocks["adsb"] == pytest.approx(0.6, abs=0.1)
    # Who says where it is stands nowhere else, whatever a radar sees.
    assert found.as_record()["sensors"]["adsb"]["translation"]["used"] == [0.0, 0.0]


def heard_by_two(*, named, off=0.0):
    """What aircraft report of themselves, by one receiver and again by another, 0.7 s later."""
    heard = beside_receiver(named=named).filter(pl.col("sensor") == "adsb")
    again = {"sensor": pl.lit("other"), "x": pl.col("x") + off, "time": pl.col("time") + 0.7}
    both = pl.concat([heard, heard.with_columns(**again)]).sort("time")
    return both.drop("range_m", "azimuth_deg")


@pytest.mark.parametrize("named", [True, False])
def test_of_two_that_only_hear_the_clocks_are_found(named):
    clocks = used(registered(heard_by_two(named=named), {}), "clock_offset")
    assert clocks["other"] - clocks["adsb"] == pytest.approx(0.7, abs=0.02)


def test_of_two_that_only_hear_no_place_is_found():
    found = registered(heard_by_two(named=True, off=50.0), {})
    assert used(found, "translation") == {"adsb": [0.0, 0.0], "other": [0.0, 0.0]}
    assert found.as_record()["doubt"] == "no biases make what the sensors see agree"


def road(*, off, apart, seed=1):
    """Return cars on four lanes under two roadside radars at 5 Hz, one of which is ``off``."""
    rng, rows = np.random.default_rng(seed), []
    lanes = np.array([0.0, 3.6, 8.5, 12.1])
    speed = np.array([24.0, 32.0, -30.0, -22.0])
    start = [rng.uniform(0.0, 600.0, round(600.0 / apart)) for _ in lanes]
    for scan in range(125):
        for k, (name, at) in enumerate((("near", 150.0), ("far", 350.0))):
            time = 0.2 * scan + 0.1 * k
            for lane, first in enumerate(start):
                x = (first + speed[lane] * time) % 600.0
                x = x[(np.abs(x - at) < 200.0) & (rng.random(x.size) < 0.95)]
                x, y = x + rng.normal(0.0, 0.6, x.size), rng.normal(lanes[lane], 0.5, x.size)
                clock = round(time + off * k, 3)
                rows += [(clock, name, *place) for place in zip(x, y, strict=True)]
    return pl.DataFrame(rows, ["time", "sensor", "x", "y"], orient="row").sort("time")


def clocks_on(roads):
    table = report_table(roads, load_configuration({}))[0]
    sensors = registration_of(table, load_configuration({})).as_record()["sensors"]
    return [own["clock_offset"]["used"] for _, own in sorted(sensors.items())]


def test_in_a_crowd_whose_tracks_stand_out_clocks_are_found():
    # Where a car's next report may be lie five others; where it leads, hardly any.
    far, near = clocks_on(road(off=0.32, apart=40.0))
    assert abs(far - near) == pytest.approx(0.32, abs=0.02)
    assert clocks_on(road(off=0.0, apart=40.0)) == [0.0, 0.0]


@pytest.mark.parametrize(("off", "apart", "seed"), [(0.32, 35.0, 3), (0.7, 30.0, 2)])
def test_clocks_so_far_off_that_other_cars_are_nearer_are_found(off, apart, seed):
    far, near = clocks_on(road(off=off, apart=apart, seed=seed))
    assert abs(far - near) == pytest.approx(off, abs=0.02)


def test_in_a_crowd_of_which_no_track_stands_out_nothing_is_looked_for():
    rng = np.random.default_rng(2)
    place = rng.uniform(0.0, 40.0, (300, 2))
    rows = []
    for scan in range(60):
        place = place + rng.normal(0.0, 0.4, place.shape)
        for k, name in enumerate(("one", "other")):
            seen = place + rng.normal(0.0, 1.0, place.shape)
            rows += [(scan + 0.5 * k, name, *at) for at in seen]
    table = pl.DataFrame(rows, ["time", "sensor", "x", "y"], orient="row")
    found = registration_of(report_table(table, load_configuration({}))[0], load_configuration({}))
    assert found.found is None
    assert "crowd" in found.doubt
