"""A restart behind a long journal, which is made faster than real time.

    python benchmarks/service_restart.py --aircraft 4000 --minutes 60 --starts 3

The traffic of turning radars is decoded, written down, tracked and drawn as by the service, with
its rule for snapshots, and left off where the next is nearly due: nothing but what the clock
decides is missing. Then the service is begun on copies of the folder and killed again. Told are
seconds and CPU until its page answers, until it shows nine of ten aircraft, and until it is "ok".
``--folder`` keeps what was made, and is begun on again where it is there.
"""

import argparse
import json
import os
import shutil
import signal
import tempfile
import time
import tomllib
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

import polars as pl
from service_load import Service
from service_traffic import MORNING, PERIOD, PLACE, SECTORS, configuration, traffic

from trackweave.domain.frames import LocalFrame
from trackweave.formats.asterix.decoding import AsterixDecoder
from trackweave.service.board import Board
from trackweave.service.inputs.outbox import completed
from trackweave.service.office import SPENT_S, Office, Order
from trackweave.service.records import Kind, as_json, packed_reports
from trackweave.service.spec import Spec

NEARLY = 0.9
"""The journal ends when so much of what a snapshot is due for has been spent since the last."""
MORE_S = 20.0
"""So much more traffic there is to come to that [s]."""
RADARS = 2
RECORDS_S = 2 * RADARS * SECTORS / PERIOD
"""Records a second: each sector's reports, and that it is over."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--aircraft", type=int, default=4000)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--starts", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path)
    told = parser.parse_args()
    with tempfile.TemporaryDirectory() as passing:
        folder = told.folder or Path(passing) / "made"
        found: dict[str, Any] = {"aircraft": told.aircraft, "minutes": told.minutes}
        if not folder.exists():
            found |= _made(folder, told)
        sizes = {path.name: path.stat().st_size for path in (folder / "journal").iterdir()}
        found["segments"] = sum(name.endswith(".journal") for name in sizes)
        for kind in ("journal", "snapshot"):
            size = sum(n for name, n in sizes.items() if name.endswith(kind))
            found[f"{kind}_mb"] = round(size / 1e6, 1)
        starts = []
        for number in range(told.starts):
            place = Path(passing) / str(number)
            place.mkdir()
            shutil.copytree(folder, place / "data")
            starts.append(_begun(place, told.aircraft))
            shutil.rmtree(place)
        print(json.dumps({**found, "starts": starts}, indent=1))


def _made(folder: Path, told: argparse.Namespace) -> dict[str, Any]:
    """Make the folder of a service that has run for a while, and return what that took."""
    office, board = Office.open(folder), Board()
    begun, n_snapshots, n_bytes = time.process_time(), 0, 0
    enough = told.minutes * 60.0 * RECORDS_S
    for kind, payload in _records(told):
        if office.journal.last >= enough and office.spent >= NEARLY * SPENT_S:
            break
        sequence = office.journal.append(kind, payload)
        if kind == Kind.CLOSE:
            office.journal.sync()
        drawn = office.take([Order(sequence, kind, payload)], board).drawn
        if drawn is not None and office.is_snapshot_due(is_idle=True):
            office.journal.sync()
            content = office.packed()
            office.keep(*content)
            n_snapshots, n_bytes = n_snapshots + 1, n_bytes + len(content[1])
    office.close()
    return {
        "made_cpu_s": round(time.process_time() - begun, 1),
        "records": office.journal.last,
        "snapshots": n_snapshots,
        "mb_a_snapshot_before_deflating": round(n_bytes / max(1, n_snapshots) / 1e6, 1),
        "cpu_to_repeat_s": round(office.spent, 2),
    }


def _records(told: argparse.Namespace) -> Iterator[tuple[Kind, bytes]]:
    """Yield what a service would write down of the traffic."""
    spec = Spec(tomllib.loads(configuration(RADARS)), frame=LocalFrame(*PLACE))
    yield Kind.CONFIGURE, spec.payload()
    span = told.minutes * 60.0 + MORE_S
    datagrams = traffic(told.aircraft, RADARS, span, seed=told.seed, marks=False)
    decoder = AsterixDecoder()
    for end, group in groupby(datagrams, key=lambda each: each.when):
        table = pl.concat([decoder.feed(each.content) for each in group], how="diagonal_relaxed")
        for (sensor,), part in sorted(table.group_by("sensor", maintain_order=True)):
            yield Kind.REPORTS, packed_reports(completed(part), "udp", decoder.facts)
            yield Kind.CLOSE, as_json({"until": {str(sensor): MORNING + end}})


def _begun(place: Path, aircraft: int) -> dict[str, Any]:
    """Begin the service in a folder, kill it, and return how long it took to be there."""
    (place / "tracker.toml").write_text(configuration(RADARS))
    load, begun = os.getloadavg()[0], time.monotonic()
    service = Service(place, None)

    def reached(what: str, is_so: Any) -> dict[str, float]:
        service.wait(what, is_so)
        cpu = sum(service.cpu().values())
        return {"s": round(time.monotonic() - begun, 2), "cpu_s": round(cpu, 2)}

    try:
        return {
            "load_average": round(load, 1),
            "page": reached("a page", lambda: service.get("/healthz")),
            "picture": reached(
                "a picture", lambda: len(service.get("/tracks")["features"]) >= 0.9 * aircraft
            ),
            "ok": reached("ok", lambda: service.get("/healthz")["status"] == "ok"),
        }
    finally:
        service.process.send_signal(signal.SIGKILL)
        service.process.wait()


if __name__ == "__main__":
    main()
