"""Of several reports that one object gives in a look one stands for all, where objects do."""

import itertools

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from trackweave.config import load_configuration
from trackweave.domain.measurements import MeasurementKind
from trackweave.formats.reading import read_reports
from trackweave.metrics import assignment_quality
from trackweave.run.pieces import first_pieces, mean_of, pieces_of

RADAR = MeasurementKind.RANGE_AZIMUTH_RATE


def people(seed: int = 10, looks: int = 60) -> pl.DataFrame:
    """Three people before a lidar, each of so many points as chance has it, and false alarms."""
    rng = np.random.default_rng(seed)
    place, velocity, rows = rng.uniform(-8, 8, (3, 2)), rng.normal(0, 0.8, (3, 2)), []
    for look in range(looks):
        velocity += rng.normal(0, 0.1, (3, 2))
        place = place + 0.1 * velocity
        for person, count in enumerate(rng.poisson(5, 3)):
            rows += [
                (0.1 * look, *at, str(person)) for at in rng.normal(place[person], 0.2, (count, 2))
            ]
        rows += [(0.1 * look, *at, None) for at in rng.uniform(-12, 12, (rng.poisson(1), 2))]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


def rows_of_eight(seed: int = 10) -> pl.DataFrame:
    """Eight that keep together, five metres from each other, seen with a metre of noise."""
    rng = np.random.default_rng(seed)
    aside = 5.0 * np.stack([np.arange(8) % 4, np.arange(8) // 4], axis=1)
    rows = []
    for look in range(60):
        for each in np.flatnonzero(rng.random(8) < 0.9):
            at = rng.normal(aside[each] + look * np.array([3.0, 1.0]), 1.0)
            rows.append((float(look), *at, str(each)))
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


def fleet(seed: int) -> pl.DataFrame:
    """Four ships 250 m long that give up to five plots, among three small ones."""
    rng, rows = np.random.default_rng(seed), []
    place, heading = rng.uniform(-4000, 4000, (7, 2)), rng.uniform(0, 2 * np.pi, 7)
    ahead = np.stack([np.sin(heading), np.cos(heading)], axis=1)
    speed = rng.uniform(3, 8, 7)
    for time in np.arange(2.5, 250.0, 2.5):
        place = place + 2.5 * speed[:, None] * ahead
        for ship in range(7):
            is_long = ship < 4
            count = 1 + rng.binomial(4, 0.4) if is_long else int(rng.random() < 0.85)
            for along in rng.uniform(-125, 125, count) * is_long:
                at = rng.normal(place[ship] + along * ahead[ship], 10.0)
                rows.append((time, *at, str(ship)))
        rows += [(time, *at, None) for at in rng.uniform(-4500, 4500, (rng.poisson(4), 2))]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


def side_by_side(seed: int) -> pl.DataFrame:
    """Two that go side by side, six sigma apart, among some false alarms."""
    rng, rows = np.random.default_rng(seed), []
    for time in np.arange(0.0, 100.0, 2.0):
        for number in np.flatnonzero(rng.random(2) < 0.95):
            at = rng.normal([10.0 * time - 600.0, 25.0 * number], 4.0)
            rows.append((time, *at, str(number)))
        rows += [(time, *at, None) for at in rng.uniform(-1000, 1000, (rng.poisson(2), 2))]
    return pl.DataFrame(rows, ["time", "x", "y", "target"], orient="row")


def idf1(frame: pl.DataFrame, result: tw.TrackingResult[pl.DataFrame]) -> float:
    track = result.reports["track"].fill_null(-1).to_numpy()
    found = assignment_quality(frame["target"].to_list(), track).idf1
    assert found is not None
    return found


def linked(place: np.ndarray, look: np.ndarray, extent: float) -> list[set[int]]:
    """Return groups of what is linked, by hand."""
    groups = [{row} for row in range(len(place))]
    for a, b in itertools.combinations(range(len(place)), 2):
        if look[a] == look[b] and np.linalg.norm(place[a] - place[b]) <= extent:
            one = next(group for group in groups if a in group)
            other = next(group for group in groups if b in group)
            if one is not other:
                groups.remove(other)
                one |= other
    return groups


@pytest.mark.parametrize("seed", range(5))
def test_what_is_linked_is_as_by_hand(seed: int) -> None:
    rng = np.random.default_rng(seed)
    place, look = rng.uniform(0, 10, (60, 2)), rng.integers(0, 4, 60)
    first = first_pieces(MeasurementKind.POSITION, place, look, 1.5)
    found = [set(np.flatnonzero(first == head).tolist()) for head in np.unique(first)]
    assert sorted(map(sorted, found)) == sorted(map(sorted, linked(place, look, 1.5)))
    assert all(head == min(group) for head, group in zip(np.unique(first), found, strict=True))


def test_the_strongest_stands_for_all() -> None:
    place, look = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]), np.zeros(3, dtype=np.int64)
    for strength, head in (([1.0, 5.0, 3.0], 1), ([np.nan, np.nan, 3.0], 2), ([4.0, 4.0, 3.0], 0)):
        first = first_pieces(MeasurementKind.POSITION, place, look, 1.5, np.array(strength))
        assert first.tolist() == [head] * 3


def test_two_whose_range_rates_differ_are_two() -> None:
    measurement = np.array([[50.0, 0.1, -8.0], [51.0, 0.1, -8.2], [50.5, 0.1, 20.0]])
    first = first_pieces(RADAR, measurement, np.zeros(3, dtype=np.int64), 3.0)
    assert first.tolist() == [0, 0, 2]


def test_the_middle_of_azimuths_is_on_the_shorter_way() -> None:
    measurement = np.array([[50.0, 0.02, 1.0], [52.0, 2 * np.pi - 0.01, 3.0], [9.0, 3.0, 0.0]])
    mean = mean_of(RADAR, measurement, np.array([0, 0, 1]))
    np.testing.assert_allclose(mean, [[51.0, 0.005, 2.0], [9.0, 3.0, 0.0]], atol=1e-12)


def test_reports_of_other_names_other_looks_and_other_sensors_are_no_pieces() -> None:
    frame = pl.DataFrame(
        {
            "time": [0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
            "sensor": ["a", "a", "a", "a", "b", "b"],
            "x": [0.0, 0.5, 1.0, 0.2, 0.3, 0.4],
            "y": [0.0] * 6,
            "identity": ["A", "A", "B", "A", "A", "A"],
        }
    )
    told = load_configuration({"sensors": {"a": {"extent": 2.0}, "b": {"extent": 0.0}}})
    reports = read_reports(frame)
    found = pieces_of(reports, reports.look, told)
    assert found.first.tolist() == [0, 0, 2, 3, 4, 5]
    assert found.joined.measurement[:, 0].tolist() == [0.25, 1.0, 0.2, 0.3, 0.4]
    again = found.restored(found.joined)
    np.testing.assert_allclose(again.measurement, found.reports.measurement)


@pytest.mark.slow
def test_an_object_of_many_points_is_one_track() -> None:
    frame = people()
    found = tw.track(frame)
    assert idf1(frame, found) > 0.95
    sensor = found.run["configuration"]["sensors"]["default"]
    assert 0.5 < sensor["extent"] < 2.0
    assert found.run["sources"]["sensors.default.extent"] == "estimated"
    assert found.run["totals"]["pieces"] > 500
    assert found.run["totals"]["reports"] == len(frame) == len(found.assignments)
    assert any("give several reports a scan" in note for note in found.run["notes"])
    for_itself = tw.track(frame, {"sensors": {"default": {"extent": 0}}})
    assert idf1(frame, for_itself) < 0.5
    assert for_itself.run["totals"]["pieces"] == 0


@pytest.mark.slow
def test_what_one_sensor_sees_as_several_reports_another_may_too() -> None:
    rng, many = np.random.default_rng(5), people()
    known = many.filter(pl.col("target").is_not_null())
    middle = known.group_by("time", "target").agg(pl.col("x", "y").mean()).sort("time", "target")
    again = middle.filter(pl.Series(rng.random(middle.height) < 0.12))
    few = pl.concat([middle, again]).select("time", "x", "y", "target")
    noise = rng.normal(0, 0.1, (2, few.height))
    few = few.with_columns(x=pl.col("x") + noise[0], y=pl.col("y") + noise[1])
    both = pl.concat([many.with_columns(sensor=pl.lit("a")), few.with_columns(sensor=pl.lit("b"))])
    found = tw.track(both.drop("target").sort("time")).run
    extents = {name: each["extent"] for name, each in found["configuration"]["sensors"].items()}
    assert extents["b"] == extents["a"] > 0.2
    assert found["sources"]["sensors.b.extent"] == "estimated"


@pytest.mark.slow
def test_the_configuration_as_used_finds_the_same_again() -> None:
    frame = people()
    first = tw.track(frame)
    again = tw.track(frame, first.run["configuration"])
    assert first.assignments.equals(again.assignments)
    assert first.tracks.equals(again.tracks)


@pytest.mark.slow
def test_who_keeps_together_is_not_one_object() -> None:
    frame = rows_of_eight()
    found = tw.track(frame)
    assert found.run["totals"]["pieces"] == 0
    assert idf1(frame, found) > 0.85


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_two_side_by_side_are_two(seed: int) -> None:
    frame = side_by_side(seed)
    result = tw.track(frame.drop("target"))
    assert result.run["configuration"]["sensors"]["default"]["extent"] == 0.0
    assert idf1(frame, result) > 0.99


@pytest.mark.slow
def test_who_is_named_once_a_look_gives_one_report_when_nameless_too() -> None:
    rng, rows = np.random.default_rng(1), []
    centre, own = np.zeros(2), rng.normal(0, 150, (12, 2))
    for look in range(60):
        centre = centre + rng.normal(0, 120, 2)
        own = 0.8 * own + rng.normal(0, 90, (12, 2))
        for each in np.flatnonzero(rng.random(12) < 0.95):
            name = f"c{each}" if rng.random() < 0.5 else None
            at = rng.normal(centre + own[each], 15.0)
            rows.append((3600.0 * look + rng.uniform(0, 60), *at, name))
    herd = pl.DataFrame(rows, ["time", "x", "y", "identity"], orient="row").sort("time")
    found = tw.track(herd)
    assert found.run["totals"]["pieces"] == 0
    assert not any("several reports a scan" in note for note in found.run["notes"])


@pytest.mark.parametrize(
    "told",
    [
        {"extent": -1.0},
        {"extent": "wide"},
        {"extent": 2e9},
        {"extent": 5.0, "scans": False},
    ],
)
def test_an_extent_that_cannot_be_is_refused(told: dict[str, object]) -> None:
    with pytest.raises(tw.InvalidInputError, match="extent"):
        tw.track(people(looks=5), {"sensors": {"default": told}})


def test_a_sensor_of_bearings_has_no_extents() -> None:
    with pytest.raises(tw.InvalidInputError, match="extent: 3; expected 0"):
        tw.Sensor("camera", measurement=MeasurementKind.BEARING, extent=3.0)


def before_a_beam(seed: int, *, lengths: list[float], apart: float, decimals: int) -> pl.DataFrame:
    """Ships that keep together before a turning radar, each a row of plots as long as it is."""
    rng, rows = np.random.default_rng(seed), []
    for turn in range(60):
        plots = []
        for ship, length in enumerate(lengths):
            at = np.array([-3e3 + 24.0 * turn, 4e3 + apart * ship])
            count = 1 + rng.poisson(length / 30.0)
            along = np.outer(length * rng.uniform(-0.5, 0.5, count), (1.0, 0.0))
            plots += [(place, ship) for place in at + along]
        away = 8e3 * np.sqrt(rng.random(4))[:, np.newaxis]
        course = rng.uniform(0, 2 * np.pi, 4)
        false = away * np.stack([np.sin(course), np.cos(course)], axis=1)
        for place, ship in [*plots, *((at, None) for at in false)]:
            azimuth = float(np.degrees(np.arctan2(*place)) + rng.normal(0, 0.1)) % 360
            distance = float(np.hypot(*place)) + rng.normal(0, 8)
            whose = None if ship is None else str(ship)
            rows.append((round(3.0 * (turn + azimuth / 360), decimals), distance, azimuth, whose))
    columns = ["time", "range_m", "azimuth_deg", "target"]
    return pl.DataFrame(rows, columns, orient="row").sort("time")


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_those_that_keep_together_before_a_turning_beam_are_no_pieces(seed: int) -> None:
    frame = before_a_beam(seed, lengths=[0.0] * 12, apart=50.0, decimals=1)
    result = tw.track(frame.drop("target"))
    assert result.run["totals"]["pieces"] == 0
    assert idf1(frame, result) > 0.97


@pytest.mark.slow
def test_plots_of_one_ship_have_times_of_their_own_under_a_turning_beam() -> None:
    frame = before_a_beam(1, lengths=[150.0, 100.0], apart=3e3, decimals=3)
    result = tw.track(frame.drop("target"))
    assert result.run["configuration"]["sensors"]["default"]["extent"] > 20.0
    assert idf1(frame, result) > 0.95
    told = {"sensors": {"default": {"extent": 0.0}}}
    assert idf1(frame, tw.track(frame.drop("target"), told)) < 0.6


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3])
def test_long_ships_among_small_ones_are_one_track_each(seed: int) -> None:
    frame = fleet(seed)
    result = tw.track(frame.drop("target"))
    assert result.run["configuration"]["sensors"]["default"]["extent"] > 50.0
    assert idf1(frame, result) > 0.95
