"""The live service under load: CPU of its parts, latency, drops and memory, with listeners.

    python benchmarks/service_load.py --aircraft 400 --radars 2 --seconds 60 --listeners 5

Radars that turn once in four seconds speak ASTERIX 048 over UDP in real time, and tell in 034
when a sector is over (``--no-marks``: they do not); listeners read the stream and discard it, one
parses it, and a browser shows the page (``--browser``). CPU is that of the processes (user and
system), shown apart. Latency is until the parsing listener has the message of a sector: from the
last datagram of the sector, and beyond what the sector waits for, which without marks is the next
datagram of each radar. ``--crowd`` shows the service more than it can take in the second third of
the time, ``--restart`` kills and begins it anew at the end; ``--starve 0.35`` lets its processes
run for that share of each fifth of a second after the first quarter; ``--alone`` takes the same
traffic through the parts without network and clock.
"""

import argparse
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
import urllib.request
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from service_traffic import (
    MORNING,
    PERIOD,
    PLACE,
    Datagram,
    Sent,
    configuration,
    send,
    traffic,
)
from service_watchers import Watchers, children_of, cpu_of, latencies, memory_of, wait_of

from trackweave.domain.frames import LocalFrame
from trackweave.run.scans import N_SECTORS

Process = subprocess.Popen[bytes]
TAIL_S = 60.0
"""So much traffic is kept for the restart [s]."""
NOTHING_S = 0.01
STARVED_S = 0.2
"""A service that is starved is stopped once in so many seconds."""
LOOKS = 30
"""So often memory and CPU are looked at."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for name, usual in (
        ("aircraft", 400), ("radars", 2), ("seconds", 60), ("listeners", 5), ("seed", 1),
        ("crowd", 0),
    ):  # fmt: skip
        parser.add_argument(f"--{name}", type=int, default=usual)
    parser.add_argument("--core", type=int, help="the one core that the service may use")
    parser.add_argument("--starve", type=float, help="share of the time that it may run")
    parser.add_argument("--no-marks", action="store_true", help="no sector messages")
    parser.add_argument("--browser", action="store_true", help="with the page shown")
    parser.add_argument("--restart", action="store_true", help="kill and begin anew at the end")
    parser.add_argument("--alone", action="store_true", help="no network, no clock")
    told = parser.parse_args()
    if told.alone:
        print(json.dumps(_alone(told), indent=1))
        return
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps(_measured(told, Path(folder)), indent=1))


class Service:
    """The service's process, and how it is asked how it is."""

    def __init__(self, folder: Path, core: int | None) -> None:
        self.folder, self._core = folder, core
        self.page, self.udp = _free_port(socket.SOCK_STREAM), _free_port(socket.SOCK_DGRAM)
        self.process = self.begun()

    def begun(self) -> "Process":
        """Return the service's process, begun now."""
        core = self._core
        self.process = subprocess.Popen(
            [
                sys.executable, "-m", "trackweave", "serve", "--quiet",
                "--config", str(self.folder / "tracker.toml"),
                "--page", f"127.0.0.1:{self.page}", "--data", str(self.folder / "data"),
                "--listen", f"udp://127.0.0.1:{self.udp}?format=asterix",
            ],
            start_new_session=True,
            preexec_fn=None if core is None else partial(os.sched_setaffinity, 0, {core}),
        )  # fmt: skip
        return self.process

    def get(self, path: str) -> Any:
        """Return what is answered in JSON."""
        with urllib.request.urlopen(f"http://127.0.0.1:{self.page}{path}", timeout=120) as answer:
            return json.load(answer)

    def counter(self, name: str) -> float:
        """Return a number of the service's metrics."""
        where = f"http://127.0.0.1:{self.page}/metrics"
        with urllib.request.urlopen(where, timeout=120) as answer:
            lines = answer.read().decode().splitlines()
        return sum(float(line.split()[-1]) for line in lines if line.split()[0].startswith(name))

    def wait(self, what: str, is_so: Any, within: float = 120.0) -> float:
        """Return how long it takes until something is so [s]."""
        begun = time.monotonic()
        while time.monotonic() - begun < within:
            try:
                if is_so():
                    return time.monotonic() - begun
            except OSError:
                pass
            time.sleep(0.05)
        raise SystemExit(f"not so within {within:.0f} s: {what}")

    def cpu(self) -> dict[str, float]:
        """Return the CPU that the service and each kind of its children have taken so far [s]."""
        found = {"service": cpu_of(self.process.pid)}
        for child in children_of(self.process.pid):
            words = Path(f"/proc/{child}/cmdline").read_bytes()
            name = "input" if b"service.inputs" in words else "decoding"
            found[name] = found.get(name, 0.0) + cpu_of(child)
        return found


def _measured(told: argparse.Namespace, folder: Path) -> dict[str, Any]:
    (folder / "tracker.toml").write_text(configuration(told.radars))
    datagrams = traffic(
        told.aircraft, told.radars, told.seconds, seed=told.seed, marks=not told.no_marks,
        crowd=told.crowd,
    )  # fmt: skip
    service = Service(folder, told.core)
    try:
        service.wait("ready", lambda: service.get("/healthz")["status"] != "starting")
        watchers = Watchers(service.page, told.listeners, browser=told.browser)
        time.sleep(8.0 if told.browser else 2.0)
        found = _loaded(told, service, watchers, datagrams)
        if told.restart:
            found["restart"] = _restarted(told.aircraft, service)
        return found
    finally:
        service.process.terminate()
        service.process.wait()


def _loaded(
    told: argparse.Namespace, service: Service, watchers: Watchers, datagrams: list[Datagram]
) -> dict[str, Any]:
    """Send all there is, and return what came of it."""
    begun, load, sent = time.monotonic() + 0.5, os.getloadavg()[0], Sent()
    # What is slow only once, such as loading kernels, is not of the load.
    n_tail = np.searchsorted([each.when for each in datagrams], datagrams[-1].when - TAIL_S)
    datagrams, tail = (datagrams[:n_tail], datagrams[n_tail:]) if told.restart else (datagrams, [])
    first = len(datagrams) // 4
    out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    out.connect(("127.0.0.1", service.udp))
    send(datagrams[:first], out, begun, sent)
    over = threading.Event()
    if told.starve is not None:
        threading.Thread(target=_starve, args=(service, told.starve, over), daemon=True).start()
    own, others, sender = service.cpu(), watchers.cpu(), time.process_time()
    looks, waited = [_look(service, begun)], wait_of(service.process.pid)
    for part in np.array_split(np.arange(first, len(datagrams)), LOOKS):
        send([datagrams[k] for k in part], out, begun, sent)
        looks.append(_look(service, begun))
    over.set()
    span = looks[-1]["at_s"] - looks[0]["at_s"]
    sender = time.process_time() - sender
    waited = wait_of(service.process.pid) - waited
    cores = {n: round((t - own.get(n, 0.0)) / span, 3) for n, t in service.cpu().items()}
    apart = {n: round((t - others[n]) / span, 3) for n, t in watchers.cpu().items()}
    if told.restart:
        # Traffic goes on while the service is away.
        threading.Thread(target=send, args=(tail, out, begun, Sent()), daemon=True).start()
    behind = service.wait("up to date", lambda: service.get("/healthz")["lag_s"] < 0.1)
    time.sleep(1.0)
    health, n_reports = service.get("/healthz"), sum(each.plots for each in datagrams)
    mb = [look["mb"] for look in looks]
    return {
        "reports": n_reports,
        "reports_per_s": round(n_reports / datagrams[-1].when, 1),
        "aircraft": told.aircraft,
        "tracks": len(service.get("/tracks")["features"]),
        "cores": {**cores, "all": round(sum(cores.values()), 3)},
        "service_waited_for_a_core_s_per_s": round(waited / span, 3),
        "cores_apart": {**apart, "generator": round(sender / span, 3)},
        "latency_s": latencies(watchers.seen, _of_scans(sent.last), MORNING),
        "latency_beyond_wait_s": latencies(watchers.seen, _waits(told, sent), MORNING),
        "memory_mb": {"quarter": mb[0], "half": mb[LOOKS // 3], "end": mb[-1], "most": max(mb)},
        "load_average": [round(each, 1) for each in (load, os.getloadavg()[0])],
        "up_to_date_after_s": round(behind, 2),
        "bounds": [look["bound"] for look in looks] if told.crowd else max(_bounds(looks)),
        "lags_s": [look["lag_s"] for look in looks] if told.crowd else max(_lags(looks)),
        "resynchronised": service.counter("trackweave_resynchronised_total"),
        **{name: health[name] for name in ("dropped", "late", "set_aside", "refused")},
        "watchers": watchers.close(),
    }


def _starve(service: Service, share: float, over: threading.Event) -> None:
    """Stop the service's processes and let them go on, again and again."""
    pids = [service.process.pid, *children_of(service.process.pid)]
    while not over.is_set():
        for number, part in ((signal.SIGSTOP, 1.0 - share), (signal.SIGCONT, share)):
            for pid in pids:
                os.kill(pid, number)
            time.sleep(part * STARVED_S)


def _waits(told: argparse.Namespace, sent: Sent) -> dict[float, float]:
    """Return until when each sector is waited for, by its end."""
    if not told.no_marks:
        return _of_scans(sent.last)
    ends = sorted(sent.first)
    return _of_scans({end: sent.first[later] for end, later in pairwise(ends)})


def _of_scans(moments: dict[float, float]) -> dict[float, float]:
    """Return those at which the tracker's own sectors end, of which a turn has fewer."""
    return {end: when for end, when in moments.items() if end / PERIOD * N_SECTORS % 1.0 == 0.0}


def _look(service: Service, begun: float) -> dict[str, float]:
    pids = [service.process.pid, *children_of(service.process.pid)]
    return {
        "at_s": time.monotonic() - begun,
        "mb": round(sum(map(memory_of, pids)) / 1e6),
        "bound": service.counter("trackweave_work_bound_level"),
        "lag_s": service.get("/healthz")["lag_s"],
    }


def _bounds(looks: list[dict[str, float]]) -> list[float]:
    return [look["bound"] for look in looks]


def _lags(looks: list[dict[str, float]]) -> list[float]:
    return [look["lag_s"] for look in looks]


def _restarted(aircraft: int, service: Service) -> dict[str, Any]:
    """Kill the service and begin it anew; return how long that takes."""
    service.process.send_signal(signal.SIGKILL)
    service.process.wait()
    size = sum(f.stat().st_size for f in (service.folder / "data" / "journal").iterdir())
    service.begun()
    count = 0.9 * aircraft
    full = service.wait("a picture", lambda: len(service.get("/tracks")["features"]) >= count)
    cpu = sum(service.cpu().values())
    ready = full + service.wait("ok", lambda: service.get("/healthz")["status"] == "ok")
    return {
        "journal_and_snapshots_mb": round(size / 1e6, 1),
        "tracks": len(service.get("/tracks")["features"]),
        "full_picture_after_s": round(full, 2),
        "cpu_s": round(cpu, 2),
        "ok_after_s": round(ready, 2),
    }


def _alone(told: argparse.Namespace) -> dict[str, object]:  # noqa: PLR0915 one loop, each part timed
    """Return the CPU of decoding, tracking and drawing for each second of traffic [s]."""
    from trackweave.formats.asterix.decoding import AsterixDecoder
    from trackweave.service.board import Board
    from trackweave.service.engine import Engine
    from trackweave.service.inputs.outbox import completed
    from trackweave.service.messages import as_text, track_messages
    from trackweave.service.records import Kind, as_json, packed_reports
    from trackweave.service.spec import Spec

    datagrams = traffic(told.aircraft, told.radars, told.seconds, seed=told.seed, marks=False)
    decoder, engine, board = AsterixDecoder(), Engine(), Board()
    spec = Spec(tomllib.loads(configuration(told.radars)), frame=LocalFrame(*PLACE))
    engine.take(1, Kind.CONFIGURE, spec.payload())
    cpu = dict.fromkeys(("decode", "journal", "track", "draw", "message"), 0.0)
    drawn, n_reports, longest, since = 0.0, 0, 0.0, datagrams[-1].when / 4
    closed, paths = datagrams[0].when, list[float]()
    for datagram in datagrams:
        when, marks = datagram.when, [time.process_time()]
        table = decoder.feed(datagram.content)
        marks.append(time.process_time())
        payload = packed_reports(completed(table), "udp", decoder.facts)
        marks.append(time.process_time())
        closing = 0.0
        if when > closed:
            # All radars' datagrams of the moment before are in.
            begun = time.process_time()
            close = as_json({"until": {"": MORNING + closed}})
            engine.take(engine.sequence + 1, Kind.CLOSE, close)
            closed, closing = when, time.process_time() - begun
        engine.take(engine.sequence + 1, Kind.REPORTS, payload)
        marks.append(time.process_time())
        change = None
        # A mark that closes no scan takes no time.
        if when - drawn >= 0.15 or closing > NOTHING_S:
            change, drawn = board.draw(engine), when
        marks.append(time.process_time())
        if change is not None:
            as_text({"changed": track_messages(change.changed, change.picture.frame)})
        marks.append(time.process_time())
        if when < since:
            continue
        n_reports += datagram.plots
        longest = max(longest, marks[3] - marks[2])
        if change is not None and closing > NOTHING_S:
            # From the last datagram of a sector to its message.
            paths.append(closing + marks[2] - marks[0] + marks[5] - marks[3])
        for name, took in zip(cpu, np.diff(marks), strict=True):
            cpu[name] += float(took)
    span = datagrams[-1].when - since
    begun = time.process_time()
    content = engine.pack()
    return {
        "aircraft": told.aircraft,
        "reports_per_s": round(n_reports / span, 1),
        "tracks": int(np.sum(engine.tracks().status == 1)),
        "cores": {name: round(took / span, 4) for name, took in cpu.items()},
        "all": round(sum(cpu.values()) / span, 3),
        "longest_step_cpu_s": round(longest, 3),
        "sector_to_message_cpu_s": {
            "median": round(float(np.median(paths)), 3),
            "p99": round(float(np.quantile(paths, 0.99)), 3),
        },
        "snapshot": {
            "mb": round(len(content) / 1e6, 2),
            "cpu_s": round(time.process_time() - begun, 3),
        },
    }


def _free_port(kind: socket.SocketKind) -> int:
    with socket.socket(socket.AF_INET, kind) as sock:
        sock.bind(("127.0.0.1", 0))
        return int(sock.getsockname()[1])


if __name__ == "__main__":
    main()
