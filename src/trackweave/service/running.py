"""The whole service in one process: folder, clerk, page, and an end within two seconds."""

import asyncio
import logging
import os
import shutil
import signal
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from trackweave.config import Configuration, load_configuration, with_learned
from trackweave.engine.choice import processors
from trackweave.errors import InvalidInputError, OutputError
from trackweave.service.clerk import Clerk
from trackweave.service.inputs.source import Source
from trackweave.service.journal import Retention
from trackweave.service.log import say
from trackweave.service.office import Office
from trackweave.service.publish import Publisher, Target
from trackweave.service.web.application import Application
from trackweave.service.web.server import WebServer
from trackweave.service.web.settings import Tls, WebSettings

__all__ = ["Plan", "run_service"]

MOST_S = 1.0
"""After so long the service ends whatever still hangs: what was acknowledged is on the disk."""
GRACE_S = 0.5

_log = logging.getLogger("trackweave.service")


@dataclass(frozen=True, slots=True)
class Plan:
    """All that a user told.

    Parameters
    ----------
    folder
        Where journal, snapshots and tracks are.
    config
        A file or the tables of one; None for nothing told.
    learned
        What ``trackweave init --learn`` wrote; it counts where ``config`` is silent.
    sources, targets
        Where reports come from, and where tracks go.
    host, port
        Where the page is.
    web, tls
        Who is let in, and what with.
    retention
        How much of the journal is kept.
    passing
        A folder that goes with the service, as that of a demonstration; None for none.
    engine, workers
        On whose workers regions are tracked, and how many regions at most; None for one tracker,
        in this process.
    """

    folder: Path
    config: Path | Mapping[str, Any] | None = None
    learned: Path | None = None
    sources: Sequence[Source] = ()
    targets: Sequence[Target] = ()
    host: str = "127.0.0.1"
    port: int = 8700
    web: WebSettings = field(default_factory=WebSettings)
    tls: Tls | None = None
    retention: Retention = field(default_factory=Retention)
    passing: Path | None = None
    engine: str | None = None
    workers: int | None = None

    def configuration(self) -> Configuration:
        """Return what the user told of the tracker, read anew."""
        told = load_configuration(self.config)
        return (
            told if self.learned is None else with_learned(told, load_configuration(self.learned))
        )


def run_service(plan: Plan, told: Callable[[str], None]) -> None:
    """Serve until SIGTERM or an interrupt.

    Parameters
    ----------
    plan
        What the user told.
    told
        Takes lines for the user, such as the page's address.

    Raises
    ------
    TrackweaveError
        If the folder, an address or the configuration cannot be used.
    """
    asyncio.run(_serve(plan, told))


async def _serve(plan: Plan, told: Callable[[str], None]) -> None:
    plan.configuration()
    _require_own(plan.folder)
    loop = asyncio.get_running_loop()
    office = await loop.run_in_executor(None, _office, plan)
    if office.journal.cut is not None:
        cut = office.journal.cut
        say(_log, logging.WARNING, "torn tail cut off", path=cut.path, offset=cut.offset)
    for why in office.snapshots.unreadable:
        say(_log, logging.WARNING, "snapshot left out", message=why)
    clerk = Clerk(office, plan.configuration, plan.sources)
    publishers = [Publisher(target) for target in plan.targets]
    clerk.publishers += publishers
    server = WebServer(Application(clerk, plan.web), plan.host, plan.port, plan.tls)
    try:
        await server.start()
    except OutputError:
        office.close()
        raise
    last = office.journal.last
    over = asyncio.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, over.set)
    with suppress(AttributeError):
        loop.add_signal_handler(signal.SIGHUP, clerk.reload)
    work = [asyncio.create_task(clerk.run())]
    work += [asyncio.create_task(each.run()) for each in publishers]
    waiting = asyncio.create_task(over.wait())

    async def announce() -> None:
        await clerk.inputs_told()
        told(f"page: {server.url}")
        told(f"journal: {plan.folder / 'journal'}, record {last}")

    announcing = asyncio.create_task(announce())
    await asyncio.wait([*work, waiting], return_when=asyncio.FIRST_COMPLETED)
    _end_at_last(plan.passing)
    failed = [task for task in work if task.done()]
    for task in (*work, waiting, announcing):
        task.cancel()
    await server.stop(GRACE_S)
    await clerk.close()
    for task in failed:
        task.result()


def _require_own(folder: Path) -> None:
    """Refuse a folder that holds something else than a service."""
    try:
        there = {path.name for path in folder.iterdir()} if folder.is_dir() else set()
    except OSError as err:
        raise OutputError(f"{folder}: cannot be read ({err.strerror or err})") from err
    # Disks of their own come with a folder for what was lost.
    others = sorted(there - {"lost+found"})
    if others and "journal" not in others:
        raise OutputError(
            f"{folder}: it holds {', '.join(others[:3])} and no journal; expected a new or empty "
            "folder for --data, or that of an earlier service"
        )


def _office(plan: Plan) -> Office:
    """Return the office of a service, with its regions on workers if it has any."""
    if plan.engine is None:
        return Office.open(plan.folder, plan.retention)
    from trackweave.service.seats import seats_of

    house = seats_of(plan.engine, plan.workers or processors())
    try:
        office = Office.open(plan.folder, plan.retention, house)
    except BaseException:
        house.close()
        raise
    spec, office.most_regions = office.engine.spec, house.most
    if spec is not None and spec.regions is None:
        office.close()
        raise InvalidInputError(
            f"engine: {plan.folder} goes on with one tracker, as it was begun; expected another "
            "--data, or no --engine"
        )
    return office


def _end_at_last(passing: Path | None) -> None:
    """End the process after a time, whatever a step of the tracker still takes."""

    def end() -> None:
        if passing is not None:
            shutil.rmtree(passing, ignore_errors=True)
        os._exit(0)

    timer = threading.Timer(MOST_S, end)
    timer.daemon = True
    timer.start()
