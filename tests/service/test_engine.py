"""The engine gives the tracks that ``track`` gives, whatever pieces the reports come in."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from service.recordings import ALL, held_places, positions
from trackweave.domain.facts import Facts
from trackweave.domain.frames import LocalFrame
from trackweave.domain.tracks import TrackTable
from trackweave.io.frames_out import tracks_frame
from trackweave.service.engine import Engine
from trackweave.service.records import Kind, as_json, packed_reports
from trackweave.service.spec import Spec

Records = list[tuple[int, bytes]]


def records(frame: pl.DataFrame, spec: Spec, seed: int = 0) -> Records:
    """Return what a journal holds of a recording that came in pieces."""
    found: Records = [(Kind.CONFIGURE, spec.payload())]
    rng, begin = np.random.default_rng(seed), 0
    while begin < frame.height:
        end = begin + int(rng.integers(1, 40))
        found.append((Kind.REPORTS, packed_reports(frame[begin:end], "test", Facts())))
        begin = end
    return found


def rows_of(given: Records, engine: Engine | None = None) -> pl.DataFrame:
    """Return the rows of all tracks after the end of everything."""
    engine = engine or Engine()
    tables = list(_rows(engine, given))
    return tracks_frame(TrackTable.concatenate(tables, 2))


def _rows(engine: Engine, given: Records) -> Iterator[TrackTable]:
    for kind, payload in given:
        yield from engine.take(engine.sequence + 1, kind, payload).rows
    yield from engine.finish().rows


@pytest.mark.slow
@pytest.mark.parametrize("what", sorted(ALL))
def test_tracks_are_those_of_track_row_for_row(what: str) -> None:
    frame, configuration = ALL[what]()
    expected = tw.track(frame, configuration, rng=configuration["seed"]).tracks
    assert expected.height > 100
    for seed in (0, 1):
        assert rows_of(records(frame, Spec(configuration), seed)).equals(expected)


def test_places_that_are_said_on_of_what_has_flown_on_are_old_news_here_too() -> None:
    frame, configuration = held_places()
    found = tw.track(frame, configuration, rng=configuration["seed"])
    assert 40 < found.run["totals"]["doubles"] < 80
    spec = Spec(configuration, frame=LocalFrame(51.0, 0.0))
    rows = rows_of(records(frame, spec))
    assert rows.equals(found.tracks.select(rows.columns))


@pytest.mark.slow
@pytest.mark.parametrize("what", sorted(ALL))
def test_goes_on_from_a_snapshot_as_if_nothing_had_happened(what: str) -> None:
    frame, configuration = ALL[what]()
    given = records(frame, Spec(configuration))
    assert gone_on(given).equals(rows_of(given))


def test_goes_on_from_a_snapshot_while_places_are_said_on() -> None:
    frame, configuration = held_places()
    given = records(frame, Spec(configuration, frame=LocalFrame(51.0, 0.0)))
    assert gone_on(given).equals(rows_of(given))


def gone_on(given: Records) -> pl.DataFrame:
    """Return the rows of all tracks, going on from a snapshot at every fifth record."""
    engine, tables = Engine(), []
    for number, (kind, payload) in enumerate(given):
        tables += engine.take(engine.sequence + 1, kind, payload).rows
        if number % 5 == 0:
            content = engine.pack()
            engine = Engine.unpack(content)
            assert engine.pack() == content
    tables += engine.finish().rows
    return tracks_frame(TrackTable.concatenate(tables, 2))


@pytest.mark.slow
def test_reports_before_the_configuration_count_from_the_first() -> None:
    frame, configuration = positions()
    first, *others = records(frame, Spec(configuration))
    assert rows_of([*others[:5], first, *others[5:]]).equals(rows_of([first, *others]))


def test_closing_what_is_over_changes_no_row() -> None:
    frame, configuration = positions()
    given = records(frame, Spec(configuration))
    closed, last = given[:1], frame["time"].max()
    for moment in frame["time"].unique().sort().to_list():
        part = frame.filter(pl.col("time") == moment)
        closed.append((Kind.REPORTS, packed_reports(part, "test", Facts())))
        # Nothing of this moment comes any more.
        closed.append((Kind.CLOSE, as_json({"until": {"": moment}})))
    assert last is not None
    assert rows_of(closed).equals(rows_of(given))


def test_a_silent_sensor_does_not_keep_others_waiting_once_it_is_closed() -> None:
    frame, configuration = positions()
    engine = Engine()
    # Of few reports in a scan, so that more without any are scans all the same.
    few = pl.int_range(pl.len()).over("sensor", "time") < 6
    silent = frame.filter(few & ((pl.col("sensor") != "pier") | (pl.col("time") < 30.0)))
    for kind, payload in records(silent, Spec(configuration)):
        engine.take(engine.sequence + 1, kind, payload)
    waited = engine.time
    engine.take(engine.sequence + 1, Kind.CLOSE, as_json({"until": {"": 117.0}}))
    assert waited is not None
    assert engine.time is not None
    assert waited < 40.0 < 110.0 < engine.time
    assert engine.counts.empty_scans > 10


def test_one_stamp_a_day_ahead_blinds_nobody() -> None:
    frame, configuration = positions()
    stray = pl.DataFrame({"time": [86_460.0], "sensor": ["pier"], "x": [1.0], "y": [2.0]})
    part = pl.concat([frame[:300], stray, frame[300:]])
    engine = Engine()
    rows = rows_of(records(part, Spec(configuration)), engine)
    assert rows["time"].max() == frame["time"].max()
    assert engine.counts.set_aside + engine.counts.held == 1
    assert (rows["status"] == "confirmed").sum() > 200


def test_a_clock_that_jumps_for_good_is_followed() -> None:
    frame, configuration = positions()
    later = frame[450:].with_columns(pl.col("time") + 3_600.0)
    rows = rows_of(records(pl.concat([frame[:450], later]), Spec(configuration)))
    assert rows["time"].max() == later["time"].max()
    assert (rows.filter(pl.col("time") > 3_600.0)["status"] == "confirmed").sum() > 50


def test_what_cannot_be_tracked_is_counted_and_changes_nothing() -> None:
    frame, configuration = positions()
    spec = Spec(configuration)
    given = records(frame, spec)
    bad = pl.DataFrame(
        {"time": [50.0], "sensor": ["pier"], "range_m": [9.0], "azimuth_deg": [1.0]}
    )
    strange = pl.DataFrame({"time": [50.0], "sensor": ["buoy"], "x": [9.0], "y": [1.0]})
    broken = pl.DataFrame({"time": [50.0], "sensor": ["pier"], "x": [None], "y": [1.0]})
    wild = [packed_reports(each, "test", Facts()) for each in (bad, strange, broken)]
    engine = Engine()
    more = [*given[:9], *((Kind.REPORTS, payload) for payload in wild), *given[9:]]
    assert rows_of(more, engine).equals(rows_of(given))
    assert (engine.counts.unfit, engine.counts.strange, engine.counts.refused) == (1, 1, 1)


@pytest.mark.slow
def test_a_bound_of_work_is_part_of_the_answer() -> None:
    frame, configuration = positions()
    given = records(frame, Spec(configuration))
    bound = {"nodes": 200, "keep": [2, 1], "evaluations": 0, "branches": 0}
    bounded = [*given[:5], (int(Kind.BOUND), as_json(bound)), *given[5:]]
    assert rows_of(bounded).equals(rows_of(bounded))
    assert not rows_of(bounded).equals(rows_of(given))


@pytest.mark.slow
def test_the_same_configuration_again_loses_no_report_and_no_row() -> None:
    frame, configuration = positions()
    spec = Spec(configuration)
    given = records(frame, spec)
    for at in range(len(given) // 2, len(given) // 2 + 4):
        again = [*given[:at], (Kind.CONFIGURE, spec.payload()), *given[at:]]
        one, two = rows_of(given), rows_of(again)
        assert two["time"].unique().sort().to_list() == one["time"].unique().sort().to_list()
        assert two.select("time", "track").is_unique().all()
        # What a report said before counts, but not how likely other sequences were.
        sure = pl.col("status") == "confirmed"
        assert abs(two.filter(sure).height - one.filter(sure).height) < 0.02 * one.height
        last = pl.col("time") == one["time"].max()
        assert two.filter(last)["hits"].sum() >= 0.98 * one.filter(last)["hits"].sum()


def test_another_configuration_keeps_the_tracks() -> None:
    frame, configuration = positions()
    spec = Spec(configuration)
    given = records(frame, spec)
    changed: dict[str, Any] = {**configuration, "window": {"depth": 3}}
    other = replace(spec, configuration=changed).payload()
    engine, half = Engine(), len(given) // 2
    for kind, payload in given[:half]:
        engine.take(engine.sequence + 1, kind, payload)
    known = engine.tracks()
    confirmed = set(known.track[known.status > 0].tolist())
    # Twice before the next scan.
    for kind, payload in [(Kind.CONFIGURE, other)] * 2 + given[half : half + 3]:
        engine.take(engine.sequence + 1, kind, payload)
    now = engine.tracks()
    assert len(confirmed) > 4
    assert len(confirmed & set(now.track.tolist())) >= len(confirmed) - 1
