"""From tables of tracks to system tracks."""

from typing import Any

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from oracles.local_tracks import NOISE, sensor_table
from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import TENTATIVE
from trackweave.errors import InvalidInputError
from trackweave.io.tracks_in import read_local_tracks
from trackweave.run.fusing import FusionResult

PLACES = {1: (0.0, 0.0), 2: (0.0, 400.0), 3: (300.0, 900.0), 4: (-200.0, 1500.0)}
TURNED = {9: PLACES[4], 8: PLACES[3], 7: PLACES[2], 6: PLACES[1]}
TIMES = [float(time) for time in range(12)]


def table(seed: int, objects: dict[int, tuple[float, float]], **options: Any) -> pl.DataFrame:
    times = options.pop("times", TIMES)
    return sensor_table(np.random.default_rng(seed), objects, times, **options)


def fused(*tables: Any, config: dict[str, Any] | None = None, **options: Any) -> FusionResult:
    return tw.fuse(list(tables), config, rng=np.random.default_rng(1), **options)


@pytest.fixture(scope="module")
def both() -> FusionResult:
    return fused(table(1, PLACES), table(2, TURNED))


def test_every_object_has_its_tracks_of_both_sensors(both: FusionResult) -> None:
    assert both.associations.columns == ["object", "sensor", "track", "from", "to", "reason"]
    last = both.associations.filter(pl.col("reason").is_null())
    pairs = {
        tuple(sorted(zip(group["sensor"], group["track"], strict=True)))
        for _, group in last.group_by("object")
    }
    assert pairs == {(("A", k), ("B", 5 + k)) for k in (1, 2, 3, 4)}
    assert both.run["totals"]["common_objects"] == 4
    assert both.run["totals"]["objects"] == 4
    assert both.associations["to"].max() == 11.0


def test_writes_the_columns_of_tracks_and_reads_them_back(both: FusionResult) -> None:
    assert both.tracks.columns[:7] == ["time", "track", "status", "x", "y", "vx", "vy"]
    again = read_local_tracks(both.tracks)
    assert again.tracks.mean == pytest.approx(both.values.tracks.mean)
    assert both.tracks.height == 4 * len(TIMES)


def test_tells_the_process_noise_from_the_covariances(both: FusionResult) -> None:
    assert both.run["configuration"]["process_noise"] == pytest.approx(NOISE, rel=1e-3)
    assert both.run["sources"]["process_noise"] == "estimated"


def test_the_record_has_a_line_for_each_update_with_its_certificate(both: FusionResult) -> None:
    assert [scan["time"] for scan in both.run["scans"]] == TIMES
    assert both.run["scans"][-1]["sensors"] == ["A", "B"]
    assert all(scan["gap"] == 0.0 for scan in both.run["scans"])
    assert both.run["totals"]["proven_updates"] == len(TIMES)
    assert {change["kind"] for change in both.run["changes"]} == {"begun"}


def test_the_same_seed_gives_the_same_tables(both: FusionResult) -> None:
    again = fused(table(1, PLACES), table(2, TURNED))
    assert again.tracks.equals(both.tracks)
    assert again.associations.equals(both.associations)
    assert {**again.run, "timing": None} == {**both.run, "timing": None}


def test_sensors_report_at_rates_of_their_own() -> None:
    slow = table(2, TURNED, times=[0.3, 4.3, 8.3])
    found = fused(table(1, PLACES), slow)
    assert found.run["totals"]["common_objects"] == 4
    assert found.run["totals"]["updates"] == len(TIMES) + 3


def test_names_are_those_of_a_mapping() -> None:
    tables = {"radar": table(1, PLACES), "lidar": table(2, TURNED)}
    found = tw.fuse(tables, rng=np.random.default_rng(1))
    assert set(found.associations["sensor"]) == {"radar", "lidar"}


def test_tentative_rows_do_not_take_part_and_are_counted() -> None:
    young = table(2, TURNED).with_columns(
        status=pl.when(pl.col("time") < 3).then(pl.lit("tentative")).otherwise(pl.lit("confirmed"))
    )
    found = fused(table(1, PLACES), young)
    assert found.run["input"]["sensors"]["B"]["left_out"] == 12
    assert found.associations.filter(sensor="B")["from"].min() == 3.0
    assert np.all(found.values.tracks.status > TENTATIVE)


def test_says_why_pairings_ended() -> None:
    short = table(2, {9: PLACES[4]}, times=TIMES[:6])
    gone = table(3, TURNED).filter((pl.col("track") != 8) | (pl.col("time") < 5))
    found = fused(table(1, PLACES), short, gone)
    reasons = dict(
        found.associations.select(pl.format("{}{}", "sensor", "track"), "reason").rows()
    )
    assert reasons["B9"] == "its sensor is silent"
    assert reasons["C8"] == "its track ended"
    assert reasons["A1"] is None


def test_positions_with_latitudes_are_fused_on_one_plane_and_keep_dates() -> None:
    frame = LocalFrame(60.0, 5.0)
    found = fused(*(table(k, PLACES, frame=frame, iso_time=True) for k in (1, 2)))
    assert found.values.frame is not None
    assert found.tracks["lat"].mean() == pytest.approx(60.0, abs=0.02)
    assert found.tracks.schema["time"] == found.associations.schema["from"]
    assert str(found.tracks.schema["time"]).startswith("Datetime")


def test_a_shifted_sensor_is_registered() -> None:
    objects = {
        k: tuple(place)
        for k, place in enumerate(np.random.default_rng(5).uniform(0, 5e3, (12, 2)))
    }
    shift = (400.0, -150.0)
    shifted = table(2, objects, shift=shift)
    apart = fused(table(1, objects), shifted)
    assert apart.run["totals"]["common_objects"] == 0
    found = fused(table(1, objects), shifted, config={"register": True, "bias": ["translation"]})
    assert found.run["totals"]["common_objects"] == 12
    told = found.run["registrations"]["B"]
    for axis, true in zip("xy", shift, strict=True):
        off = told["bias"][f"translation_{axis}"] - true
        assert abs(off) < 4.0 * told["sigma"][f"translation_{axis}"] < 40.0
    assert found.values.registrations["B"].reference == "A"


def test_the_preset_needs_every_sensor_to_see_every_object() -> None:
    found = fused(table(1, PLACES), table(2, TURNED), preset="huo-2008")
    assert found.run["configuration"]["statistic"]["kind"] == "chain"
    last = found.associations.filter(pl.col("reason").is_null())
    assert last["object"].n_unique() == 4
    fewer = table(2, {9: PLACES[4]})
    with pytest.raises(InvalidInputError, match="expected equally many of each"):
        fused(table(1, PLACES), fewer, preset="huo-2008")


def test_a_sensor_that_sees_nothing_or_only_false_tracks_loses_nothing() -> None:
    found = fused(table(1, PLACES), table(2, TURNED).clear())
    assert found.run["totals"]["objects"] == 4
    assert "sensor B sees nothing" in found.run["notes"][0]
    false = table(2, {5: (3e3, 3e3), 6: (4e3, 1e3)})
    found = fused(table(1, PLACES), false)
    assert found.run["totals"]["common_objects"] == 0
    assert found.run["totals"]["objects"] == 6


def test_objects_are_counted_that_did_not_turn_out_to_be_others() -> None:
    # In its first row the other sensor is off, so that its tracks begin objects of their own.
    late = table(2, TURNED).with_columns(
        x=pl.when(pl.col("time") == 0.0).then(pl.col("x") + 90.0).otherwise(pl.col("x"))
    )
    found = fused(table(1, PLACES), late)
    totals = found.run["totals"]
    assert (totals["names"], totals["merged"]) == (found.tracks["track"].n_unique(), 4)
    assert (totals["objects"], totals["names"]) == (4, 8)


@pytest.mark.parametrize("tracks", ["a.csv", 3])
def test_refuses_what_are_not_several_tables(tracks: Any) -> None:
    with pytest.raises(InvalidInputError, match="tracks"):
        tw.fuse(tracks, rng=np.random.default_rng(1))


def test_refuses_one_sensor() -> None:
    with pytest.raises(InvalidInputError, match="two sensors at least"):
        fused(table(1, PLACES))


def test_pandas_comes_back_as_pandas() -> None:
    pandas = pytest.importorskip("pandas")
    tables = [pandas.DataFrame(table(k, PLACES).to_dict(as_series=False)) for k in (1, 2)]
    assert isinstance(fused(*tables).associations, pandas.DataFrame)


def test_names_registration_where_sensors_have_nothing_in_common(both: FusionResult) -> None:
    far = {track: (x + 9000.0, y) for track, (x, y) in PLACES.items()}
    apart = fused(table(1, PLACES), table(2, far))
    assert any("--register tells by how much" in note for note in apart.run["notes"])
    assert not any("--register" in note for note in both.run["notes"])


def test_names_the_sensor_that_has_hardly_anything_in_common_with_two_that_agree() -> None:
    rng = np.random.default_rng(5)
    objects = {k: tuple(place) for k, place in enumerate(rng.uniform(0, 5e3, (12, 2)))}
    right = table(1, objects), table(2, objects)
    notes = fused(*right, table(3, objects, shift=(250.0, -150.0))).run["notes"]
    (note,) = (each for each in notes if "--register" in each)
    assert note.startswith("hardly any object of C ")
    # Far away it sees objects of its own.
    apart = fused(*right, table(3, {k: (x + 9e3, y) for k, (x, y) in objects.items()}))
    assert not any("--register" in each for each in apart.run["notes"])
