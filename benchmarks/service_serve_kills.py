"""Kills a whole ``trackweave serve`` under load again and again, and looks what is left.

Run ``python benchmarks/service_serve_kills.py --kills 100 --seed 1``. The real command takes
reports of two radars by ``POST /reports`` on several connections at once, and of a third one by
UDP, as fast as it acknowledges them. It ends by ``SIGKILL`` at a moment drawn beforehand: while it
starts and recovers, soon after, or once snapshots have been written. Then it is started anew in
the same folder. ``--seconds`` ends the killing earlier.

At the end it is asked: is every report that was acknowledged with 200 in the journal? Is what
the last start recovered, tracker and tracks files, to the byte what one run of the journal from
its first record gives that nobody disturbed? Does ``trackweave replay`` write the same bytes? Ends
with status 1 if not.
"""

import argparse
import itertools
import json
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from trackweave.service.office import Office
from trackweave.service.records import Kind, arrived
from trackweave.service.recovery import stored_records
from trackweave.service.repeating import repeated

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from service.recordings import positions
from service.serving import Service, free_port
from service.test_serve import replayed, toml_of

LOT, SENDERS, PAUSE = 6, 3, 0.03
"""Reports of a request, connections that send at once, and seconds between their requests."""
BY_UDP = "pier"
STARTING, SOON, LATER = (0.05, 8.0), (0.0, 3.0), (11.0, 14.0)
"""When it is killed [s]: after the start of its process; after its first answer; and so long
after it that a snapshot has been written."""
SHARES = (0.2, 0.65, 0.15)

Key = tuple[float, str, float]


class Traffic:
    """Reports without end, in order of time; what was acknowledged of them."""

    def __init__(self) -> None:
        frame, self.configuration = positions()
        self._lots = self._endless(frame.to_dicts())
        self._lock = threading.Lock()
        self.acknowledged: set[Key] = set()
        self.udp_port = free_port()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def _endless(self, rows: list[dict[str, Any]]) -> Iterator[list[dict[str, Any]]]:
        """Yield the next reports, at least one of which is posted."""
        lap = rows[-1]["time"] + 6.0
        later = ({**row, "time": row["time"] + k * lap} for k in itertools.count() for row in rows)
        while True:
            lot = list(itertools.islice(later, LOT))
            while all(row["sensor"] == BY_UDP for row in lot):
                lot.append(next(later))
            yield lot

    def send(self, port: int) -> None:
        """Hand one lot to the service; raises where nobody answers."""
        with self._lock:
            lot = next(self._lots)
            heard = [each for each in lot if each["sensor"] == BY_UDP]
            if heard:
                self._socket.sendto(_lines(heard), ("127.0.0.1", self.udp_port))
        lot = [each for each in lot if each["sensor"] != BY_UDP]
        request = urllib.request.Request(
            f"http://127.0.0.1:{port}/reports",
            data=_lines(lot),
            headers={"Content-Type": "application/x-ndjson"},
        )
        with urllib.request.urlopen(request, timeout=30) as answer:
            receipt = json.load(answer)
        assert (receipt["accepted"], receipt["rejected"]) == (len(lot), []), receipt
        with self._lock:
            self.acknowledged |= {_key(each) for each in lot}


class Life:
    """One start of the service, sent to by several until it is killed."""

    def __init__(self, folder: Path, config: Path, traffic: Traffic) -> None:
        self.port, self._traffic = free_port(), traffic
        self._over, self.answered = threading.Event(), threading.Event()
        url = f"udp://127.0.0.1:{traffic.udp_port}?format=jsonl"
        with folder.with_suffix(".log").open("ab") as said:
            self._process = subprocess.Popen(
                [
                    sys.executable, "-m", "trackweave", "serve", "--data", str(folder),
                    "--page", f"127.0.0.1:{self.port}", "--config", str(config), "--listen", url,
                ],
                stderr=said, stdout=said, stdin=subprocess.DEVNULL, env=dict(os.environ),
            )  # fmt: skip
        self._senders = [threading.Thread(target=self._send) for _ in range(SENDERS)]
        for each in self._senders:
            each.start()

    def _send(self) -> None:
        while not self._over.is_set():
            try:
                # What nobody is there to take is not drawn: the traffic waits.
                socket.create_connection(("127.0.0.1", self.port), 30.0).close()
                self._traffic.send(self.port)
            except (OSError, ValueError):  # not there yet, killed while it answered, or too much
                self._over.wait(0.1)
            else:
                self.answered.set()
                self._over.wait(PAUSE)

    def kill(self) -> bool:
        """End it; tell whether it was still alive."""
        was_alive = self._process.poll() is None
        self._process.kill()
        self._process.wait()
        self._over.set()
        for each in self._senders:
            each.join()
        return was_alive


def kill_once(life: Life, rng: np.random.Generator) -> str:
    """Kill a life at a moment drawn; return which it was."""
    which = int(rng.choice(3, p=SHARES))
    name, (low, high) = (
        ("while it started", STARTING), ("soon after", SOON), ("after a snapshot", LATER)
    )[which]  # fmt: skip
    if which:
        life.answered.wait(120.0)
    time.sleep(float(rng.uniform(low, high)))
    return name if life.kill() else "it had ended by itself"


def wrong_of(folder: Path, out: Path, traffic: Traffic) -> Iterator[str]:
    """Yield what is wrong with what is left, after the service was ended by nobody's kill."""
    office = Office.open(folder)  # the last recovery, to the last record
    try:
        own = _files(folder / "tracks")
        engine, last = office.engine.pack(), office.journal.last
    finally:
        office.close()
    records = list(stored_records(folder / "journal"))
    tables = [arrived(each.payload).table for each in records if each.kind == Kind.REPORTS]
    stored = {_key(row) for table in tables for row in table.to_dicts()}
    lost = traffic.acknowledged - stored
    if lost:
        yield f"{len(lost)} acknowledged reports are not in the journal, as {min(lost)}"
    undisturbed = repeated(folder, out / "undisturbed")
    if undisturbed.engine.pack() != engine:
        yield "the recovered tracker is not that of an undisturbed run"
    expected = _files(out / "undisturbed")
    if own != expected:
        yield "the service's tracks files are not those of an undisturbed run"
    if replayed(folder, out / "replay") != expected:
        yield "replay writes other bytes than an undisturbed run"
    print(
        f"records: {last}; reports stored: {len(stored)}, acknowledged: "
        f"{len(traffic.acknowledged)}; bytes of tracks: {sum(map(len, own.values()))}"
    )


def _lines(rows: list[dict[str, Any]]) -> bytes:
    return "".join(json.dumps(row) + "\n" for row in rows).encode()


def _key(row: dict[str, Any]) -> Key:
    return row["time"], row["sensor"], row["x"]


def _files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--folder", type=Path, help="where to work; a disk's, not a memory's")
    options = parser.parse_args()
    rng, seen, traffic = np.random.default_rng(options.seed), Counter[str](), Traffic()
    begun = time.monotonic()
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        place = Path(name)
        folder, config = place / "data", toml_of(traffic.configuration, place / "told.toml")
        while seen.total() < options.kills and time.monotonic() - begun < options.seconds:
            seen[kill_once(Life(folder, config, traffic), rng)] += 1
        service = Service(folder, "--config", str(config))
        status = service.terminate()
        wrong = [f"SIGTERM: status {status}"] if status else []
        wrong += wrong_of(folder, place, traffic)
        if seen["it had ended by itself"]:
            wrong.append(f"ended by itself; its log: {folder.with_suffix('.log').read_text()}")
    print(f"kills: {seen.total()} ({', '.join(f'{n} {k}' for k, n in seen.items())})")
    print(f"wrong: {len(wrong)}")
    for each in wrong:
        print(each)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
