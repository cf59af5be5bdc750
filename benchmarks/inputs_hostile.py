"""Hostile senders at the live service's inputs: no crash, no hang, bounded memory.

    python benchmarks/inputs_hostile.py --messages 350000

For each format an input runs as in the service, in a process of its own, once with datagrams and
once with connections, which are cut off after some pieces. Messages are samples with octets put
in, taken out, replaced and repeated. Afterwards an undamaged sample has to be read, by a sender
that was heard before and by a new one.
"""

import argparse
import json
import os
import select
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
from damaged_files import damaged
from text_tables import command, heading, table

from trackweave.service.inputs.outbox import FRAME, REPORTS

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from formats.samples import SAMPLES

FORMATS = {
    "asterix": "blocks", "ais": "nmea", "sbs": "sbs", "jsonl": "json lines", "csv": "csv lines",
    "readsb": "aircraft", "opensky": "states",
}  # fmt: skip
PIECES, AT_ONCE, PATIENCE_S, SETTLED_S = 200, 20, 60.0, 4.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=350_000, help="of all formats together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", choices=FORMATS, default=list(FORMATS))
    told = parser.parse_args()
    count, rows, sent = told.messages // (2 * len(told.only)), [], 0
    for name in told.only:
        for scheme in ("udp", "tcp"):
            row = _tried(name, scheme, count, told.seed)
            print(row, file=sys.stderr, flush=True)
            rows.append(row)
            sent += count
    print(heading(command("inputs_hostile.py")), end="\n\n")
    rows.append(["**all**", "", f"{sent:,}", *[""] * 5])
    head = ["format", "by", "messages", "reports", "skipped", "overflowed", "CPU s", "peak MB"]
    print(table(head, rows))


def _tried(name: str, scheme: str, count: int, seed: int) -> list[str]:
    sample = SAMPLES[FORMATS[name]][1]
    rng, port = np.random.default_rng([seed, *name.encode(), *scheme.encode()]), _free_port(scheme)
    with subprocess.Popen(
        [
            sys.executable, "-m", "trackweave.service.inputs",
            json.dumps(f"{scheme}://127.0.0.1:{port}?format={name}"),
        ],
        stdout=subprocess.PIPE,
    ) as process:  # fmt: skip
        told = _Told(process)
        told.wait_for(lambda: bool(told.state))
        sender = _Datagrams(port) if scheme == "udp" else _Pieces(port)
        for number in range(count):
            sender.send(damaged(sample, rng))
            if number % AT_ONCE == 0:
                told.wait_for(lambda: sender.is_taken())
        sender.begin_anew()
        told.settle()
        for _ in range(2):
            before = told.reports
            sender.send(sample + b"\n")
            sender.begin_anew()
            told.wait_for(lambda before=before: told.reports > before)
        found = _cost(process.pid)
        process.kill()
    state = told.state
    return [
        name, scheme, f"{count:,}", f"{told.reports:,}", f"{state['skipped']:,}",
        f"{state['dropped']:,}", f"{found[0]:.0f}", f"{found[1]:.0f}",
    ]  # fmt: skip


class _Told:
    """Reads what an input hands on, as the service does."""

    def __init__(self, process: "subprocess.Popen[bytes]") -> None:
        self.reports, self.state = 0, {}
        self._process = process
        threading.Thread(target=self._read, daemon=True).start()

    def wait_for(self, is_there) -> None:
        end = time.monotonic() + PATIENCE_S
        if self._process.poll() is not None:
            raise SystemExit(f"{self._process.args}: has ended; {self.state}")
        while not is_there():
            if time.monotonic() > end:
                raise SystemExit(f"{self._process.args}: hangs or has ended; {self.state}")
            time.sleep(0.001)

    def settle(self) -> None:
        """Wait until nothing more comes."""
        since, before = time.monotonic(), -1
        while time.monotonic() - since < SETTLED_S:
            self.wait_for(lambda: True)
            if self.reports != before:
                since, before = time.monotonic(), self.reports
            time.sleep(0.1)

    def _read(self) -> None:
        stream = self._process.stdout
        while len(head := stream.read(FRAME.size)) == FRAME.size:
            kind, n_words, n_body = FRAME.unpack(head)
            words = json.loads(stream.read(n_words))
            stream.read(n_body)
            if kind == REPORTS:
                self.reports += words["reports"]
            else:
                self.state = words


class _Datagrams:
    """Sends datagrams, of a few senders in turn."""

    def __init__(self, port: int) -> None:
        self._address, self._count = ("127.0.0.1", port), 0
        self.begin_anew()

    def begin_anew(self) -> None:
        self._out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send(self, data: bytes) -> None:
        with suppress(OSError):  # longer than any datagram
            self._out.sendto(data, self._address)
        self._count += 1
        if self._count % PIECES == 0:
            self._out.close()
            self.begin_anew()

    def is_taken(self) -> bool:
        """Tell whether the kernel's queue is empty: else it would drop what comes."""
        port = f":{self._address[1]:04X}"
        lines = Path("/proc/net/udp").read_text().splitlines()[1:]
        waiting = [line.split()[4] for line in lines if line.split()[1].endswith(port)]
        return all(int(each.partition(":")[2], 16) == 0 for each in waiting)


class _Pieces:
    """Sends over connections, of which each breaks off after some pieces."""

    def __init__(self, port: int) -> None:
        self._port, self._count = port, 0
        self._out = socket.create_connection(("127.0.0.1", port))

    def begin_anew(self) -> None:
        self._out.close()
        self._out = socket.create_connection(("127.0.0.1", self._port))

    def send(self, data: bytes) -> None:
        self._out.sendall(data)
        self._count += 1
        if self._count % PIECES == 0:
            self.begin_anew()

    def is_taken(self) -> bool:
        """Tell whether more can be sent without waiting."""
        return bool(select.select([], [self._out], [], 0)[1])


def _cost(pid: int) -> tuple[float, float]:
    """Return CPU [s] and peak memory [MB] of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    peak = next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"), peak / 1024.0


def _free_port(scheme: str) -> int:
    kind = socket.SOCK_DGRAM if scheme == "udp" else socket.SOCK_STREAM
    with socket.socket(socket.AF_INET, kind) as sock:
        sock.bind(("127.0.0.1", 0))
        return int(sock.getsockname()[1])


if __name__ == "__main__":
    main()
