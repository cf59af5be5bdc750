"""The clerk: what comes in and what the clock decides is written down, then it counts."""

import asyncio
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Coroutine, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from trackweave.config import Configuration, load_configuration
from trackweave.errors import InvalidInputError, OutputError, TrackweaveError
from trackweave.service.board import Board
from trackweave.service.delays import Standstill
from trackweave.service.desk import (
    Json,
    OverloadedError,
    Picture,
    Receipt,
    Rows,
    Subscription,
)
from trackweave.service.fanout import Fanout
from trackweave.service.inputs.outbox import told_times
from trackweave.service.inputs.process import Input
from trackweave.service.inputs.source import Source
from trackweave.service.log import say
from trackweave.service.office import Office, Order, Outcome
from trackweave.service.records import Kind, as_json, packed_reports
from trackweave.service.rehearsing import Rehearsal, warm_solvers
from trackweave.service.saying import Saying
from trackweave.service.sorting_in import usable_rows

__all__ = ["Clerk"]

MOST_WAITING = 20_000
"""So many reports wait for the tracker; beyond, no more are taken."""
TICK, BEAT = 0.1, 1.0
"""Seconds between two looks at the clock, and two reports on how it is."""
AGAIN = 1.0
"""Seconds until a disk that refused is tried again."""

_log = logging.getLogger("trackweave.service")


@dataclass(slots=True)
class _Promise:
    """Who waits until a record is on the disk."""

    sequence: int
    done: "asyncio.Future[int]"


@dataclass(slots=True)
class _Waiting:
    """Records on their way: to the disk, then to the tracker."""

    unsynced: deque[Order] = field(default_factory=deque)
    ready: deque[Order] = field(default_factory=deque)
    promises: list[_Promise] = field(default_factory=list)
    reports: int = 0


class Clerk:
    """The desk's other side: one event loop, which owns journal and engine.

    Parameters
    ----------
    office
        Journal, engine and files, already brought to where they were.
    configuration
        Returns what the user told; asked again where it is to be read anew.
    sources
        Where to listen.
    """

    def __init__(
        self,
        office: Office,
        configuration: Callable[[], Configuration],
        sources: Sequence[Source] = (),
    ) -> None:
        self._office, self._read = office, configuration
        self._configuration = configuration()
        self.board = Board()
        self.fanout = Fanout(lambda: self.board.picture)
        self.saying = Saying(office)
        self.publishers: list[Callable[[Any], None]] = []
        self._wait = _Waiting()
        self._rehearsal, self._is_ready = Rehearsal(), asyncio.Event()
        self._inputs = [
            Input(source, self._handed, self._marked, self._is_ready) for source in sources
        ]
        self._tracking = ThreadPoolExecutor(1, thread_name_prefix="tracker")
        self._writing = ThreadPoolExecutor(1, thread_name_prefix="journal")
        self._keeping = ThreadPoolExecutor(1, thread_name_prefix="snapshot")
        self._kept: asyncio.Future[None] | None = None
        self._appended, self._work = asyncio.Event(), asyncio.Event()
        self._refused, self._standstill = "", Standstill()
        self._is_reconfiguring = False
        self._configured_by = 0
        self._tasks: list[asyncio.Task[None]] = []

    # What is asked over the desk.

    async def accept(self, rows: Rows) -> Receipt:
        """Check reports, write them to the journal and return once they are on the disk."""
        self._require_room()
        if rows.table.is_empty():
            return Receipt(0, (), self._office.journal.synced)
        spec = self._office.engine.spec
        loop = asyncio.get_running_loop()
        table, rejected = await loop.run_in_executor(None, usable_rows, rows, spec)
        if table.is_empty():
            return Receipt(0, rejected, self._office.journal.synced)
        self._require_room()
        told = told_times(table)
        if too_many := self._office.delays.too_many(told):
            raise InvalidInputError(too_many)
        payload = packed_reports(table, rows.source, rows.facts)
        sequence = self._append(Kind.REPORTS, payload, table.height)
        self._hear(told)
        promise = _Promise(sequence, loop.create_future())
        self._wait.promises.append(promise)
        return Receipt(table.height, rejected, await promise.done)

    def picture(self) -> Picture:
        """Return all live tracks as they are now."""
        return self.board.picture

    def track(self, identifier: str) -> Json | None:
        """Return one track with its trail; None for none."""
        return self.board.track(identifier)

    def sensors(self) -> list[Json]:
        """Return the sensors."""
        return self.saying.sensors()

    def health(self) -> Json:
        """Return how the service is."""
        told = self._configuration if self._is_ready.is_set() else None
        return self.saying.health(self._refused, self._lag(), self._inputs, told)

    def counters(self) -> Mapping[str, float]:
        """Return numbers for ``/metrics``."""
        found = self.saying.counters(self._inputs)
        return {
            **found,
            "lag_seconds": self._lag(),
            "waiting_reports": float(self._wait.reports),
            "listeners": float(len(self.fanout)),
            "resynchronised_total": float(self.fanout.resynchronised),
        }

    def subscribe(self, *, reports: bool = False) -> Subscription:
        """Return messages from now on."""
        return self.fanout.subscribe(reports=reports)

    # What it does.

    async def run(self) -> None:
        """Work until it is cancelled or something fails for good."""
        self._draw_first()
        parts: list[Coroutine[Any, Any, None]] = [
            self._keep_synced(), self._keep_tracking(), self._watch_clock(), self._keep_saying(),
            *(each.run() for each in self._inputs),
        ]  # fmt: skip
        async with asyncio.TaskGroup() as group:
            self._tasks = [group.create_task(part) for part in parts]

    async def inputs_told(self) -> None:
        """Return once each input listens, or has said why it does not."""
        for each in self._inputs:
            await each.has_told.wait()

    async def close(self) -> None:
        """End inputs, bring to the disk what waits, and let the tracker take it in."""
        for each in self._inputs:
            await each.close()
        for task in self._tasks:
            task.cancel()
        self.fanout.close()
        loop = asyncio.get_running_loop()
        with suppress(OutputError):
            await loop.run_in_executor(self._writing, self._office.journal.sync)
        self._tracking.shutdown(cancel_futures=True)
        self._writing.shutdown()
        self._keeping.shutdown()
        self._office.close()

    def reload(self) -> str:
        """Read the configuration again, and begin to run with it; return what came of it."""
        try:
            self._configuration = self._read()
        except TrackweaveError as err:
            say(_log, logging.ERROR, "configuration refused", message=str(err))
            return str(err)
        self._is_reconfiguring = True
        self._work.set()
        return ""

    async def _handed(self, payload: bytes, count: int, told: Mapping[str, list[float]]) -> None:
        """Take what an input hands on; it is not read on while too much waits."""
        while self._wait.reports > MOST_WAITING or self._refused:
            self._standstill.begin(time.monotonic())
            await asyncio.sleep(TICK / 2)
        self._standstill.end(time.monotonic())
        with suppress(OutputError):
            if too_many := self._office.delays.too_many(told):
                self._drop(count, too_many)
            else:
                self._append(Kind.REPORTS, payload, count)
                self._hear(told)

    def _marked(self, marks: Mapping[str, float]) -> None:
        """Take in that sensors' beams came by somewhere: their sectors before are perhaps over."""
        self._office.delays.mark(marks)
        with suppress(OutputError):
            self._close(tuple(marks))

    def _close(self, names: Sequence[str] = ()) -> None:
        """Write down up to when nothing is waited for any more, of some sensors or of all."""
        until = self._office.closing(self._standstill.clock(time.monotonic()))
        if names:
            until = {name: until[name] for name in names if name in until}
        if until and not self._refused:
            self._append(Kind.CLOSE, as_json({"until": until}))

    def _hear(self, told: Mapping[str, Sequence[float]]) -> None:
        self._office.delays.note(told, self._standstill.clock(time.monotonic()))
        self.saying.heard(told)

    def _require_room(self) -> None:
        if self._refused:
            raise OutputError(self._refused)
        if self._wait.reports > MOST_WAITING:
            raise OverloadedError(
                f"{self._wait.reports:,} reports wait for the tracker; expected at most "
                f"{MOST_WAITING:,}: send them again later"
            )

    def _append(self, kind: Kind, payload: bytes, count: int = 0) -> int:
        sequence = self._office.journal.append(kind, payload)
        self._wait.unsynced.append(Order(sequence, kind, payload, count, time.monotonic()))
        self._wait.reports += count
        self._appended.set()
        return sequence

    async def _keep_synced(self) -> None:
        """Bring to the disk what was written, in groups, and keep the promises."""
        loop = asyncio.get_running_loop()
        while True:
            await self._appended.wait()
            self._appended.clear()
            try:
                synced = await loop.run_in_executor(self._writing, self._office.journal.sync)
                self._refused = ""
            except OutputError as err:
                if not self._refused:
                    say(_log, logging.ERROR, "disk refused", message=str(err))
                self._refused = str(err)
                self._break_promises(err)
                await asyncio.sleep(AGAIN)
                self._appended.set()
                continue
            wait = self._wait
            while wait.unsynced and wait.unsynced[0].sequence <= synced:
                wait.ready.append(wait.unsynced.popleft())
            self._work.set()
            kept = [each for each in wait.promises if each.sequence <= synced]
            wait.promises = [each for each in wait.promises if each.sequence > synced]
            for promise in kept:
                if not promise.done.done():
                    promise.done.set_result(synced)

    def _break_promises(self, err: OutputError) -> None:
        broken, self._wait.promises = self._wait.promises, []
        for promise in broken:
            if not promise.done.done():
                promise.done.set_exception(OutputError(str(err)))

    async def _keep_tracking(self) -> None:
        """Let the tracker take in what is on the disk."""
        loop, office = asyncio.get_running_loop(), self._office
        spec = office.engine.spec
        await self._rehearse(
            self._configuration if spec is None else load_configuration(spec.configuration),
            2 if spec is None else spec.dim,
        )
        # The first scans do not need these yet: they are loaded beside them. Nobody waits for that
        # at the end, as for what an executor does.
        threading.Thread(target=warm_solvers, name="warming", daemon=True).start()
        while True:
            await self._work.wait()
            self._work.clear()
            while self._wait.ready or self._is_reconfiguring:
                batch = office.batch(self._wait.ready)
                wants = self.fanout.wants_reports
                take = partial(office.take, wants_reports=wants, more=self._has_more)
                outcome = await loop.run_in_executor(self._tracking, take, batch, self.board)
                self._wait.reports -= sum(order.reports for order in batch)
                self._tell(outcome)
                # What was found out last is waited for before more is.
                is_settled = office.engine.configured_by >= self._configured_by
                if is_settled and (self._is_reconfiguring or office.wants_to_learn()):
                    await self._learn(self._configuration)
                # Right after a picture there is time before the next scans, if ever.
                is_idle = outcome.drawn is not None and not self._has_more()
                is_free = self._kept is None or self._kept.done()
                if is_free and office.is_snapshot_due(is_idle=is_idle):
                    content = await loop.run_in_executor(self._tracking, office.packed)
                    # Neither the tracker nor an acknowledgement waits for it.
                    self._kept = loop.run_in_executor(self._keeping, office.keep, *content)

    def _has_more(self) -> bool:
        """Tell whether records wait for the disk or the tracker; from any thread."""
        return bool(self._wait.ready or self._wait.unsynced)

    async def _learn(self, configuration: Configuration) -> None:
        """Find out with what to run, and write it to the journal."""
        loop = asyncio.get_running_loop()
        anew, self._is_reconfiguring = self._is_reconfiguring, False
        found = await loop.run_in_executor(self._tracking, self._office.learn, configuration, anew)
        if found is None:
            return
        if self._office.most_regions is not None:
            self._is_ready.clear()
            await loop.run_in_executor(self._tracking, self._office.prepare, found.spec)
        await self._rehearse(load_configuration(found.spec.configuration), found.spec.dim)
        with suppress(OutputError):
            self._configured_by = self._append(Kind.CONFIGURE, found.spec.payload())
            self.saying.learned(found)

    async def _rehearse(self, configuration: Configuration, dim: int) -> None:
        """Make ready what compiles, so that no scan waits for it; reports are written down."""
        if self._rehearsal.needs(configuration, dim):
            self._is_ready.clear()
            run, loop = self._rehearsal.run, asyncio.get_running_loop()
            await loop.run_in_executor(self._tracking, run, configuration, dim)
        self._is_ready.set()

    def _tell(self, outcome: Outcome) -> None:
        self.saying.took(outcome)
        drawn = outcome.drawn
        if drawn is not None:
            time_, frame = drawn.picture.time, drawn.picture.frame
            assert time_ is not None
            self.fanout.tracks(time_, drawn.changed, drawn.ended, frame)
            for publisher in self.publishers:
                publisher(drawn)
        if outcome.seen and outcome.time is not None:
            self.fanout.reports(outcome.time, outcome.seen)

    def _draw_first(self) -> None:
        if self._office.engine.is_configured:
            self.board.draw(self._office.engine)

    async def _watch_clock(self) -> None:
        """Write down what only the clock can decide."""
        while True:
            due = time.monotonic() + TICK
            await asyncio.sleep(TICK)
            late = time.monotonic() - due
            if late > TICK:  # whoever gets no core has heard nothing meanwhile
                self._standstill.miss(late)
            if self._refused:
                continue
            with suppress(OutputError):
                self._close()
                # Whoever is not ready has to catch up, which is no lag yet.
                lag = self._lag() if self._is_ready.is_set() else 0.0
                bound = self._office.pace.bound(lag, time.monotonic())
                if bound is not None:
                    self._append(Kind.BOUND, as_json(bound))
                    say(_log, logging.WARNING, "work bound", **bound)
                for each in self._inputs:
                    if dropped := each.newly_dropped():
                        self._drop(dropped, each.source.url)

    def _drop(self, reports: int, why: str) -> None:
        self._append(Kind.DROP, as_json({"reports": reports, "source": why}))
        say(_log, logging.WARNING, "reports dropped", reports=reports, source=why)

    async def _keep_saying(self) -> None:
        while True:
            await asyncio.sleep(BEAT)
            self.fanout.send(self.saying.status(self._lag(), BEAT))
            self.fanout.send({"type": "sensors", "sensors": self.sensors()})

    def _lag(self) -> float:
        """Return for how long the oldest record has waited for the tracker [s]."""
        ready = self._wait.ready
        try:
            return max(0.0, time.monotonic() - ready[0].arrived) if ready else 0.0
        except IndexError:
            return 0.0
