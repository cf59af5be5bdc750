"""Heights that nobody told are found from the ranges of several sensors."""

import numpy as np
import polars as pl
import pytest

from run.biased_sky import off, sky, told
from trackweave import read_reports, track
from trackweave.config import load_configuration
from trackweave.estimation.sightings import CLOCK
from trackweave.metrics import assignment_quality
from trackweave.run.heights import found_heights, registered
from trackweave.run.registering import registration_of


@pytest.fixture(scope="module")
def reports() -> pl.DataFrame:
    return sky(seed=8)


def found(frame: pl.DataFrame, configuration=None):
    """Return what is found of a frame without its targets, and the true heights by row."""
    table = read_reports(frame.drop("target", "report", "true", strict=False))
    return found_heights(table, load_configuration(configuration or told()))


def heights_beside_truth(frame: pl.DataFrame, finding) -> np.ndarray:
    true = frame["true"].to_numpy()[
        finding.reports.row - 1 if finding.reports.row is not None else slice(None)
    ]
    return finding.reports.height - true


def without(frame: pl.DataFrame) -> pl.DataFrame:
    """Return reports that tell no heights, which are kept as the truth."""
    return frame.rename({"height_m": "true"})


def test_heights_are_those_at_which_radars_see_their_objects_at_one_place(reports) -> None:
    frame = without(reports)
    finding = found(frame)
    off_by = heights_beside_truth(frame, finding)
    known = np.isfinite(off_by)
    of_objects = frame["true"].is_not_null().sum()
    assert known.sum() > 0.85 * of_objects
    assert np.median(np.abs(off_by[known])) < 200.0
    # Next to no false alarm is given any.
    given = np.isfinite(finding.reports.height) & np.isnan(off_by)
    assert given.sum() < 0.01 * of_objects
    (note,) = finding.notes()
    assert note.startswith(f"height_m: {finding.n_filled} of {len(frame)} reports are given")
    assert finding.as_record()["reports"] == finding.n_filled


@pytest.mark.slow
def test_tracks_are_those_of_heights_that_are_told() -> None:
    names, by_way = ("east", "west"), {}
    reports = sky(seed=9, minutes=2.0, n_aircraft=10, names=names)
    for way, frame in (("told", reports), ("found", without(reports).drop("true"))):
        result = track(frame.drop("target", "report"), told(names), rng=1)
        number = result.assignments["track"].fill_null(-1).to_numpy()
        quality = assignment_quality(frame["target"].to_list(), number)
        by_way[way] = quality.idf1, np.unique(number[number >= 0]).size
    assert by_way["found"][0] >= by_way["told"][0] - 0.02
    assert by_way["found"][1] <= by_way["told"][1] + 1
    assert result.run["heights"]["reports"] > 0


def test_heights_of_0_m_for_all_are_those_of_a_radar_that_knows_of_none(reports) -> None:
    frame = reports.with_columns(true="height_m")
    zero = pl.when(pl.col("sensor") == "east").then(0.0).otherwise(pl.col("height_m"))
    finding = found(frame.with_columns(height_m=zero))
    east = frame["sensor"].to_numpy() == "east"
    off_by = np.abs(heights_beside_truth(frame, finding))[east]
    assert np.nanmedian(off_by) < 200.0
    assert f"reports, {finding.n_zero} of them told as 0 m, are given" in finding.notes()[0]
    # Those of the others are as told.
    others = finding.reports.height[~east], frame["true"].to_numpy()[~east]
    np.testing.assert_array_equal(*others)


@pytest.mark.slow
def test_heights_of_0_m_of_what_is_on_the_ground_are_left_alone(reports) -> None:
    ground = (pl.col("range_m") ** 2 - pl.col("height_m").fill_null(0.0) ** 2).clip(1.0).sqrt()
    finding = found(reports.with_columns(range_m=ground, height_m=pl.lit(0.0)))
    assert finding.n_filled == finding.n_zero == 0
    assert np.all(finding.reports.height == 0.0)


def test_ranges_on_the_ground_are_left_alone(reports) -> None:
    ground = (pl.col("range_m") ** 2 - pl.col("true").fill_null(0.0) ** 2).clip(1.0).sqrt()
    finding = found(without(reports).with_columns(range_m=ground))
    assert finding.n_filled == 0
    assert finding.reports.height is None
    assert finding.found is not None
    assert finding.notes() == []


@pytest.mark.slow
def test_an_azimuth_that_is_off_is_no_height(reports) -> None:
    """Biases alone explain ranges on the ground: 0.5° are 400 m at 50 km, as heights may be."""
    ground = (pl.col("range_m") ** 2 - pl.col("true").fill_null(0.0) ** 2).clip(1.0).sqrt()
    frame = off(without(reports).with_columns(range_m=ground), "east", azimuth_deg=0.5)
    finding = found(frame)
    assert finding.found is not None
    assert finding.n_filled == 0
    assert finding.found.n_clear < 0.1 * finding.found.n_pairs


def test_heights_of_one_radar_serve_the_others(reports) -> None:
    is_told = pl.col("sensor") == "west"
    frame = reports.with_columns(
        true="height_m", height_m=pl.when(is_told).then(pl.col("height_m"))
    )
    finding = found(frame)
    off_by = heights_beside_truth(frame, finding)
    known = np.isfinite(off_by)
    assert known.sum() > 0.85 * frame["true"].is_not_null().sum()
    assert np.median(np.abs(off_by[known])) < 60.0


@pytest.mark.slow
def test_biases_are_told_apart_from_heights(reports) -> None:
    frame = off(without(reports), "east", azimuth_deg=0.3)
    finding = found(frame)
    off_by = heights_beside_truth(frame, finding)
    assert np.nanmedian(np.abs(off_by)) < 250.0
    registration = registration_of(finding.reports, load_configuration(told()))
    assert registration.found is not None
    east = finding.reports.sensors.index("east")
    assert np.degrees(registration.found.likely[east, 2]) == pytest.approx(0.3, abs=0.05)


def test_what_taxies_is_on_the_ground(reports) -> None:
    rng, parts = np.random.default_rng(4), []
    for name, at, period in (("west", (0.0, 0.0), 5.0), ("north", (20e3, 70e3), 4.0)):
        for number in range(3):
            time = (np.arange(int(180 / period)) + 0.5) * period
            away = (
                np.array([4e3 + 500.0 * number, 3e3]) + np.outer(time, [8.0, 4.0]) - np.array(at)
            )
            azimuth = np.degrees(np.arctan2(*away.T)) % 360
            near = np.hypot(*away.T) + rng.normal(0.0, 20.0, time.size)
            parts.append(
                pl.DataFrame({"time": time + azimuth / 360 * period, "range_m": near})
                .with_columns(azimuth_deg=pl.Series(azimuth), sensor=pl.lit(name))
                .with_columns(target=pl.lit(1000 + number), true=pl.lit(0.0))
            )
    frame = pl.concat([without(reports).drop("report"), *parts], how="diagonal_relaxed").sort(
        "time"
    )
    finding = found(frame)
    assert finding.n_filled > 0
    taxies = (frame["target"] >= 1000).fill_null(value=False).to_numpy()
    row = finding.reports.row
    taxies = taxies if row is None else taxies[row - 1]
    assert np.isnan(finding.reports.height[taxies]).all()


@pytest.mark.parametrize(
    "ways",
    [
        {"sensors": {n: {**keys, "trust": True} for n, keys in told()["sensors"].items()}},
        {"sensors": told()["sensors"], "motion": {"max_speed": 300.0}},
    ],
    ids=["trusted", "one radar"],
)
def test_nothing_is_looked_for_where_nothing_can_be(reports, ways) -> None:
    frame = without(reports)
    if "motion" in ways:
        frame = frame.filter(pl.col("sensor") == "west")
        ways = {"sensors": {"west": ways["sensors"]["west"]}}
    finding = found(frame, ways)
    assert finding.found is None
    assert finding.as_record() is None
    assert finding.notes() == []


@pytest.mark.slow
def test_a_clock_that_is_ahead_is_no_height(reports) -> None:
    """On the ground it explains all; the ranges are those on the ground, and it is found."""
    ground = (pl.col("range_m") ** 2 - pl.col("true").fill_null(0.0) ** 2).clip(1.0).sqrt()
    frame = off(without(reports).with_columns(range_m=ground), "east", clock=2.5)
    table = read_reports(frame.drop("target", "report", "true"))
    finding, registration = registered(table, load_configuration(told()))
    assert finding.n_filled == 0
    assert finding.found is not None
    assert finding.found.is_on_ground
    assert registration.found is not None
    clock = registration.found.likely[:, CLOCK]
    names = table.sensors
    assert clock[names.index("east")] - clock[names.index("west")] == pytest.approx(2.5, abs=0.25)


@pytest.mark.slow
def test_a_clock_that_is_told_is_no_height(reports) -> None:
    ground = (pl.col("range_m") ** 2 - pl.col("true").fill_null(0.0) ** 2).clip(1.0).sqrt()
    frame = off(without(reports).with_columns(range_m=ground), "east", clock=6.0)
    configuration = told()
    configuration["sensors"]["east"]["clock_offset"] = 6.0
    finding = found(frame, configuration)
    assert finding.n_filled == 0
    assert finding.found is not None
    assert finding.found.is_on_ground


def test_a_radar_that_stands_far_off_tells_heights_all_the_same():
    configuration = told(("north", "west"))
    configuration["sensors"]["west"]["position"] = [2100.0, -2900.0]
    bare = sky(seed=8, names=("north", "west"), n_aircraft=30).drop("height_m", "target")
    keys = load_configuration(configuration)
    finding, registration = registered(read_reports(bare), keys)
    places = {
        name: registration.configuration.sensor(name)["position"] for name in ("north", "west")
    }
    apart = np.subtract(places["north"], places["west"])
    np.testing.assert_allclose(apart, [20e3, 70e3], atol=150.0)
    assert finding.n_filled > 0.5 * len(bare)


def test_where_no_track_is_long_enough_no_heights_are_found():
    seen = sky(minutes=0.3, n_aircraft=60, names=("east", "north"))
    table = read_reports(seen.drop("height_m", "target", "report"))
    where = load_configuration(told(("east", "north")))
    heights = found_heights(table, where, elsewhere=True)
    assert (heights.found, heights.n_filled) == (None, 0)


def turned_at(frame: pl.DataFrame, when: float, angle: float, ranges: float = 0.0) -> pl.DataFrame:
    """Return a sky on the ground in which a radar points, and measures, otherwise later on."""
    flat = (pl.col("range_m") ** 2 - pl.col("height_m").fill_null(0.0) ** 2).clip(1.0).sqrt()
    late = ((pl.col("sensor") == "west") & (pl.col("time") >= when)).cast(pl.Float64)
    return frame.with_columns(
        range_m=flat + ranges * late, azimuth_deg=(pl.col("azimuth_deg") + angle * late) % 360.0
    ).drop("height_m")


@pytest.mark.parametrize("names", [("east", "west"), ("east", "north", "west")])
def test_biases_that_change_are_no_heights(names) -> None:
    frame = turned_at(sky(seed=8, names=names), 75.0, 0.9)
    finding = found(frame, told(names))
    assert finding.n_filled == 0
    change = finding.as_record()["change"]
    assert change["time"] == pytest.approx(75.0, abs=6.0)
    assert change["sensors"] == {"west": {"azimuth_bias_deg": pytest.approx(0.9, rel=0.05)}}
    (note,) = finding.notes()
    assert note.startswith(f"sensor west: from {change['time']:.6g} s on its biases are others")
    # What remains is as if nothing had changed.
    own = read_reports(turned_at(sky(seed=8, names=names), 75.0, 0.0).drop("target", "report"))
    west = own.sensor == own.sensors.index("west")
    late = west & (own.time > change["time"] + 6.0)
    azimuth = np.angle(np.exp(1j * (finding.reports.measurement - own.measurement)[:, 1]))
    assert np.degrees(np.abs(azimuth[late])).max() < 0.05
    assert np.abs(azimuth[~west]).max() == 0.0


def test_a_bias_that_is_trusted_is_not_taken_out_when_it_changes() -> None:
    names = "east", "west"
    keys = told(names)
    keys["sensors"]["west"] |= {"azimuth_bias_deg": 0.0, "trust": ["azimuth_bias_deg"]}
    frame = turned_at(sky(seed=8, names=names), 75.0, 0.9)
    came = read_reports(frame.drop("target", "report"))
    finding = found(frame, keys)
    np.testing.assert_array_equal(finding.reports.measurement, came.measurement)
    assert finding.n_filled == 0
    # Nor is it said to have been.
    assert finding.notes() == []
    assert finding.as_record()["change"] is None
