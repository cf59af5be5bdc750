"""Live regions say what a recording's regions say, whoever has them and whoever dies."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace as Namespace
from typing import Any

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from service.recordings import ALL, positions
from service.serving import PATIENCE_S, Service
from service.test_engine import records, rows_of
from service.test_serve import replayed, toml_of, wait_until_still
from trackweave.config import load_configuration
from trackweave.domain.facts import Facts
from trackweave.domain.tracks import TrackTable
from trackweave.engine import EngineError, Pool, serving
from trackweave.engine.protocol import Death
from trackweave.engine.serving import Served
from trackweave.errors import InvalidInputError
from trackweave.io.frames_out import tracks_frame
from trackweave.run.regions import cutting, running
from trackweave.run.regions.cutting import Region
from trackweave.service import seats
from trackweave.service.engine import Engine
from trackweave.service.journal import Journal
from trackweave.service.learning import learned
from trackweave.service.records import Arrived
from trackweave.service.seats import Seats
from trackweave.service.shared_tracks import Given, SharedTracks
from trackweave.service.spec import Spec

MARGIN = 1_280.0
"""Two windows' flight of the boats and ten deviations of their reports [m]."""


def halves(at: float) -> tuple[Region, Region]:
    """Return the plane, cut along a line that runs north."""
    low, high = np.full(2, -np.inf), np.full(2, np.inf)
    return Region(low, np.array([at, np.inf])), Region(np.array([at, -np.inf]), high)


def boats(*, is_cut: bool = True) -> tuple[pl.DataFrame, Spec]:
    """Return what radars see of boats, and a configuration that cuts the plane among them."""
    frame, configuration = positions()
    regions = halves(float(np.median(frame["x"]))) if is_cut else None
    return frame, Spec(configuration, regions=regions, margin=MARGIN)


@pytest.mark.slow
@pytest.mark.parametrize("what", ["positions", "turning radar"])
def test_rows_are_those_of_track_on_an_engine(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cutting, "LEAST", 60)
    monkeypatch.setattr(cutting, "NARROWEST", 0.05)
    made: list[Any] = []

    def cut(position: Any, margin: float, _: Any = None) -> list[Region]:
        made[:] = [cutting.cut(position, margin), margin]
        return made[0]

    monkeypatch.setattr(running, "cut", cut)
    frame, configuration = ALL[what]()
    run = tw.track(frame, configuration, rng=1, engine="local", workers=2)
    assert run.run["regions"]["joined"] > 1
    spec = Spec(configuration, regions=tuple(made[0]), margin=made[1])
    rows = rows_of(records(frame, spec))
    keys = ["time", "x", "y"]
    one, two = run.tracks.sort(keys), rows.sort(keys)
    assert one.height > 100
    assert two.drop("track").equals(one.drop("track"))
    # Names are others, but each object has one of its own.
    pairs = set(zip(one["track"].to_list(), two["track"].to_list(), strict=True))
    assert len(pairs) == one["track"].n_unique() == two["track"].n_unique()


def test_what_runs_is_the_journals_business() -> None:
    _, spec = boats()
    again = Spec.of(spec.payload())
    assert again.regions is not None
    for one, two in zip(spec.regions or (), again.regions, strict=True):
        assert np.array_equal([one.low, one.high], [two.low, two.high])
    assert again.margin == MARGIN
    # What was written before there were regions reads as ever, and is written as ever.
    assert b"regions" not in boats(is_cut=False)[1].payload()


@pytest.mark.slow
def test_goes_on_from_a_snapshot_as_if_nothing_had_happened() -> None:
    given = records(*boats())
    engine, tables = Engine(), []
    for number, (kind, payload) in enumerate(given):
        tables += engine.take(engine.sequence + 1, kind, payload).rows
        if number % 5 == 0:
            content = engine.pack()
            engine = Engine.unpack(content)
            assert engine.pack() == content
    tables += engine.finish().rows
    assert tracks_frame(TrackTable.concatenate(tables, 2)).equals(rows_of(given))


def test_pictures_and_reports_have_the_names_of_rows() -> None:
    engine, seen = Engine(), set[int]()
    for kind, payload in records(*boats()):
        for table in engine.take(engine.sequence + 1, kind, payload).rows:
            seen |= set(table.track.tolist())
    seen |= {name for table in engine.finish().rows for name in table.track.tolist()}
    shown = engine.tracks().track.tolist()
    assert len(shown) > 4
    assert len(set(shown)) == len(shown)
    assert set(shown) <= seen
    assert set(engine.track_of().values()) - {-1} <= seen


def test_another_configuration_keeps_names() -> None:
    frame, spec = boats()
    given = records(frame, spec)
    half = len(given) // 2
    engine, before = Engine(), dict[int, Any]()
    for kind, payload in given[:half]:
        engine.take(engine.sequence + 1, kind, payload)
    sure = engine.tracks().at(engine.tracks().status != 0)
    before = dict(zip(sure.track.tolist(), sure.mean[:, :2], strict=True))
    engine.take(engine.sequence + 1, *given[0])
    for kind, payload in given[half : half + 3]:
        engine.take(engine.sequence + 1, kind, payload)
    after = dict(zip(engine.tracks().track.tolist(), engine.tracks().mean[:, :2], strict=True))
    kept = [name for name in before if name in after]
    assert len(kept) >= len(before) - 1 > 3
    assert max(np.hypot(*(after[name] - before[name])) for name in kept) < 500.0


def test_an_object_has_the_name_of_the_track_that_was_there_first() -> None:
    shared = SharedTracks(2)
    times = dict.fromkeys(range(20), 0.0) | {report: float(report) for report in range(20)}
    shared.born = {(0, 3): 1, (1, 5): 7}
    none = Given(np.empty(0, np.int64), np.empty(0, np.int64))
    shared.settle([Given(np.arange(4), np.full(4, 3)), none], times)
    assert (shared.name((0, 3)), shared.name((1, 5))) == (5, 10)
    both = np.arange(4, 7)
    shared.join([Given(both, np.full(3, 3)), Given(both, np.full(3, 5))], times)
    assert shared.name((1, 5)) == 5
    # What may still change may, and what is final stays.
    shared.join([none, none], times)
    assert shared.name((1, 5)) == 10
    shared.settle([Given(both, np.full(3, 3)), Given(both, np.full(3, 5))], times)
    shared.join([none, none], times)
    shared.forget([(1, 5)])
    assert shared.name((1, 5)) == 5
    shared.forget([])
    assert not (shared.shared)
    assert not (shared.looked)
    assert not (shared.spans)
    assert not (shared.born)
    assert not (shared.objects)


class Bench:
    """Workers in this process, which die and hang when they are told to: see ``Host``."""

    def __init__(self) -> None:
        self.hired: list[OnBench] = []

    def hire(self) -> "OnBench":
        self.hired.append(OnBench(1_000 + len(self.hired)))
        return self.hired[-1]

    def wait(self, workers: Any, seconds: float | None) -> list[tuple[Any, bytes | Death]]:
        found: list[tuple[Any, bytes | Death]] = []
        for each in workers:
            if each.is_dead:
                found.append((each, Death("was killed by signal 9")))
            elif each.calls and not each.is_stopped:
                found.append((each, each.served.reply(each.calls.pop(0))))
        if not found:
            time.sleep(min(seconds or 0.0, 0.01))
        return found

    def close(self) -> None:
        pass


class OnBench:
    """One of them; its region's calls end up in it as in a process."""

    def __init__(self, number: int) -> None:
        self.served, self.number = Served(), number
        self.calls: list[bytes] = []
        self.is_dead = self.is_stopped = False

    def send(self, call: bytes) -> None:
        self.calls.append(call)

    def kill(self) -> None:
        self.is_dead = True


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Bench, Seats]]:
    monkeypatch.setattr(seats, "PATIENCE_S", 0.2)
    monkeypatch.setattr(seats, "Rehearsal", lambda: Namespace(run=lambda *_: None))
    monkeypatch.setattr(seats, "warm_solvers", lambda: None)
    monkeypatch.setattr(serving, "_SERVING", threading.Event())
    own = Bench()
    house = Seats(Pool(own, 6), 2)
    yield own, house
    house.close()


KILL, STOP = "is_dead", "is_stopped"
BLOWS = {
    "a worker killed": {5: [(0, KILL)]},
    "its standby killed": {5: [(1, KILL)]},
    "one after the other": {5: [(0, KILL)], 7: [(1, KILL)], 9: [(0, KILL)], 20: [(2, KILL)]},
    "both and the spare killed": {5: [(0, KILL), (1, KILL), (-1, KILL)]},
    "all killed": {15: [(n, KILL) for n in range(5)]},
    "one hangs": {5: [(0, STOP)]},
    "both hang": {5: [(0, STOP), (1, STOP)]},
    "one hangs and one is killed": {12: [(0, STOP), (1, KILL)]},
}
"""By record: the workers that are there, by age, and what becomes of them."""


@pytest.mark.slow
@pytest.mark.parametrize("blows", BLOWS.values(), ids=BLOWS)
def test_the_same_bytes_whoever_dies(bench: tuple[Bench, Seats], blows: dict[int, Any]) -> None:
    given, (host, house) = records(*boats()), bench
    engine, tables = Engine(house), []
    for number, (kind, payload) in enumerate(given):
        tables += engine.take(number + 1, kind, payload).rows
        alive = [each for each in host.hired if not each.is_dead]
        for which, what in blows.get(number, []):
            setattr(alive[which], what, True)
        if number == 10:
            engine.pack()  # from which whoever comes later begins
    tables += engine.finish().rows
    alone = Engine()
    assert tracks_frame(TrackTable.concatenate(tables, 2)).equals(rows_of(given, alone))
    assert engine.pack() == alone.pack()
    time.sleep(2 * seats.PATIENCE_S)  # whoever hangs is found out
    for _ in range(9):
        house.look()
    # All have two that answer, and there is one to spare.
    assert [len(each) for each in house.workers()] == [2, 2]
    alive = [each for each in host.hired if not each.is_dead]
    assert len(alive) == 5
    assert not any(each.is_stopped for each in alive)
    assert len(host.hired) >= 5 + sum(map(len, blows.values()))


def test_workers_that_never_begin_end_the_service_by_a_message(
    bench: tuple[Bench, Seats], monkeypatch: pytest.MonkeyPatch
) -> None:
    host, house = bench
    monkeypatch.setattr(seats, "monotonic", iter(range(0, 10**9, 40)).__next__)
    hire = host.hire

    def dead() -> OnBench:
        made = hire()
        made.is_dead = True
        return made

    monkeypatch.setattr(host, "hire", dead)
    with pytest.raises(EngineError, match=r"region 0 has no worker: 5 in a row .* by signal 9"):
        rows_of(records(*boats()), Engine(house))


@pytest.mark.slow
def test_serves_on_while_workers_are_killed(tmp_path: Path) -> None:
    frame, configuration = positions()
    groups = [frame.with_columns(pl.col("x") + east) for east in (0.0, 2e4, 4e4, 6e4)]
    lines = pl.concat(groups).sort("time", "sensor").to_dicts()
    third = len(lines) // 3
    config, folder = toml_of(configuration, tmp_path / "told.toml"), tmp_path / "data"
    options = ("--config", str(config), "--engine", "local", "--workers", "2")
    service = Service(folder, *options)
    for begin in range(0, third, 60):
        assert service.post(lines[begin : min(begin + 60, third)])["sequence"]
    service.wait_for("configured_by", 1)
    end, regions = time.monotonic() + PATIENCE_S, list[list[int]]()
    while [len(each) for each in regions] != [2, 2]:
        assert time.monotonic() < end, service.log.read_text()
        service.post(lines[third : third + 1])
        regions = service.get("/healthz")["regions"]
        time.sleep(0.2)
    for pid in (regions[0][0], regions[1][1]):
        os.kill(pid, signal.SIGKILL)
    for begin in range(third + 1, 2 * third, 60):
        service.post(lines[begin : begin + 60])
    wait_until_still(folder / "tracks")
    service.kill()
    # Without an engine regions are tracked in the one process.
    service = Service(folder, "--config", str(config))
    assert "regions" not in service.get("/healthz")
    for begin in range(2 * third, len(lines), 60):
        service.post(lines[begin : begin + 60])
    wait_until_still(folder / "tracks")
    assert service.terminate() == 0
    own = {path.name: path.read_bytes() for path in sorted((folder / "tracks").iterdir())}
    again = replayed(folder, tmp_path / "again")
    assert all(again[name].startswith(content) for name, content in own.items())
    assert sum(map(len, own.values())) > 0.5 * sum(map(len, again.values()))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--engine", "cloud"), "engine: 'cloud'; expected local, ray"),
        (("--engine", "local", "--workers", "0"), "workers: 0; expected a whole number"),
        (("--workers", "2"), "--workers 2; expected --engine as well"),
        (("--engine", "local"), "goes on with one tracker, as it was begun"),
    ],
)
def test_bad_arguments_end_with_a_message(
    options: tuple[str, ...], message: str, tmp_path: Path
) -> None:
    journal = Journal.open(tmp_path / "journal")
    journal.append(*records(*boats(is_cut=False))[0])
    journal.sync()
    journal.close()
    done = subprocess.run(
        [sys.executable, "-m", "trackweave", "serve", "--data", str(tmp_path), "--page",
         "127.0.0.1:0", *options],
        capture_output=True, text=True, check=False, timeout=PATIENCE_S,
    )  # fmt: skip
    assert done.returncode == 2
    assert message in done.stderr


def test_more_regions_than_workers_may_have_are_refused(bench: tuple[Bench, Seats]) -> None:
    bench[1].most = 1
    with pytest.raises(InvalidInputError, match="expected --workers 2"):
        Engine(bench[1]).take(1, *records(*boats())[0])


def heard(frame: pl.DataFrame) -> list[Arrived]:
    return [Arrived(frame, "test", Facts())]


def test_the_plane_is_cut_where_half_of_what_was_heard_is() -> None:
    frame, configuration = positions()
    wide = frame.with_columns(pl.col("x") * 10.0, pl.col("y") * 10.0)
    found = learned(load_configuration(configuration), heard(wide), Facts(), most_regions=2)
    assert found is not None
    assert found.spec.regions is not None
    first, second = (each.holds(np.array(wide.select("x", "y"))) for each in found.spec.regions)
    assert np.all(first ^ second)
    assert abs(int(first.sum()) - int(second.sum())) < 0.1 * wide.height
    assert found.spec.margin > 500.0
    # Where both halves were narrow, there is one region.
    found = learned(load_configuration(configuration), heard(frame), Facts(), most_regions=2)
    assert found is not None
    assert len(found.spec.regions or ()) == 1
    assert learned(load_configuration(configuration), heard(frame), Facts()).spec.regions is None  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tracker": {"kind": "nearest-neighbour"}}, "tracker.kind is nearest-neighbour"),
        ({"sensors": {"scans": False}}, "pier.* does not scan"),
    ],
)
def test_what_cannot_be_cut_is_refused(change: dict[str, Any], message: str) -> None:
    frame, configuration = positions()
    sensors = {
        name: {**own, **change.get("sensors", {})}
        for name, own in configuration["sensors"].items()
    }
    if "sensors" in change:
        for own in sensors.values():
            own.pop("scan_period")
    told = load_configuration({**configuration, **change, "sensors": sensors})
    with pytest.raises(InvalidInputError, match=message):
        learned(told, heard(frame), Facts(), most_regions=2)


def test_one_region_is_tracked_as_ever() -> None:
    frame, spec = boats(is_cut=False)
    everywhere = Region(np.full(2, -np.inf), np.full(2, np.inf))
    alone = Spec(spec.configuration, regions=(everywhere,), margin=MARGIN)
    one, two = rows_of(records(frame, spec)), rows_of(records(frame, alone))
    assert two.equals(one)
