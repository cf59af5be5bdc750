"""The live service under load: CPU of its parts, latency, drops and memory, with listeners.

    python benchmarks/service_load.py --aircraft 400 --radars 2 --seconds 60 --listeners 5

Radars that turn once in four seconds speak ASTERIX 048 over UDP in real time; listeners read the
stream and discard it, one parses it. CPU is that of the processes (user and system), the sender's
apart. Latency is from the last datagram of a sector until a listener has its tracks' message,
beyond the end of the sector.
"""

import argparse
import json
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
import urllib.request
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np
from pymap3d import geodetic2aer

from trackweave.domain.frames import LocalFrame

PERIOD, SECTORS = 4.0, 8
PLACE = (45.5, 15.5)
TICK = os.sysconf("SC_CLK_TCK")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for name, usual in (("aircraft", 400), ("radars", 2), ("seconds", 60), ("listeners", 5)):
        parser.add_argument(f"--{name}", type=int, default=usual)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--core", type=int, help="the one core that the service may use")
    parser.add_argument("--alone", action="store_true", help="no network, no clock")
    told = parser.parse_args()
    if told.alone:
        print(json.dumps(_alone(told), indent=1))
        return
    with tempfile.TemporaryDirectory() as folder:
        print(json.dumps(_measured(told, Path(folder)), indent=1))


def _measured(told: argparse.Namespace, folder: Path) -> dict[str, object]:
    page, udp = _free_port(socket.SOCK_STREAM), _free_port(socket.SOCK_DGRAM)
    config = folder / "tracker.toml"
    config.write_text(_configuration(told.radars))
    process = subprocess.Popen(
        [
            sys.executable, "-m", "trackweave", "serve", "--quiet", "--config", str(config),
            "--page", f"127.0.0.1:{page}", "--data", str(folder / "data"),
            "--listen", f"udp://127.0.0.1:{udp}?format=asterix",
        ],
        preexec_fn=None if told.core is None else partial(os.sched_setaffinity, 0, {told.core}),
    )  # fmt: skip
    try:
        _wait(page)
        listeners = [_Listener(page, parses=place == 0) for place in range(told.listeners)]
        messages = _traffic(told)
        # What is slow only once, such as loading kernels, is not of the load.
        half = len(messages) // 4
        begun, load = time.monotonic() + 0.5, os.getloadavg()[0]
        sender = time.process_time()
        _send(messages[:half], udp, begun)
        before, memory = _cpu_of(process.pid), [_memory_of(process.pid)]
        for part in np.array_split(np.arange(half, len(messages)), 4):
            _send([messages[k] for k in part], udp, begun)
            memory.append(_memory_of(process.pid))
        after, span = _cpu_of(process.pid), messages[-1][0] - messages[half - 1][0]
        time.sleep(3.0)
        health, n_reports = _get(page, "/healthz"), sum(count for _, _, count in messages)
        parts = {name: round((after[name] - before.get(name, 0.0)) / span, 3) for name in after}
        return {
            "reports": n_reports,
            "reports_per_s": round(n_reports / messages[-1][0], 1),
            "aircraft": told.aircraft,
            "tracks": len(_get(page, "/tracks")["features"]),
            "cores": {**parts, "all": round(sum(parts.values()), 3)},
            "sender_cpu_s": round(time.process_time() - sender, 2),
            "messages": [listener.count for listener in listeners],
            "latency_s": listeners[0].quantiles(begun) if listeners else None,
            "memory_mb": [round(each / 1e6) for each in memory],
            "load_average": [round(each, 1) for each in (load, os.getloadavg()[0])],
            "resynchronised": _counter(page, "trackweave_resynchronised_total"),
            **{
                name: health[name] for name in ("dropped", "late", "set_aside", "lag_s", "refused")
            },
        }
    finally:
        process.terminate()
        process.wait()


def _alone(told: argparse.Namespace) -> dict[str, object]:  # noqa: PLR0915 one loop, each part timed
    """Return the CPU of decoding, tracking and drawing for each second of traffic [s]."""
    from trackweave.formats.asterix.decoding import AsterixDecoder
    from trackweave.service.board import Board
    from trackweave.service.engine import Engine
    from trackweave.service.inputs.outbox import completed
    from trackweave.service.messages import as_text, track_messages
    from trackweave.service.records import Kind, as_json, packed_reports
    from trackweave.service.spec import Spec

    messages = _traffic(told)
    decoder, engine, board = AsterixDecoder(), Engine(), Board()
    spec = Spec(tomllib.loads(_configuration(told.radars)), frame=LocalFrame(*PLACE))
    engine.take(1, Kind.CONFIGURE, spec.payload())
    cpu = dict.fromkeys(("decode", "journal", "track", "draw", "message"), 0.0)
    drawn, n_reports, longest, since = 0.0, 0, 0.0, messages[-1][0] / 4
    closed = messages[0][0]
    for when, message, count in messages:
        marks = [time.process_time()]
        table = decoder.feed(message)
        marks.append(time.process_time())
        payload = packed_reports(completed(table), "udp", decoder.facts)
        marks.append(time.process_time())
        if when > closed:
            # All radars' datagrams of the moment before are in.
            close = as_json({"until": {"": MORNING + closed}})
            engine.take(engine.sequence + 1, Kind.CLOSE, close)
            closed = when
        engine.take(engine.sequence + 1, Kind.REPORTS, payload)
        marks.append(time.process_time())
        change = None
        if when - drawn >= 0.15:
            change, drawn = board.draw(engine), when
        marks.append(time.process_time())
        if change is not None:
            as_text({"changed": track_messages(change.changed, change.picture.frame)})
        marks.append(time.process_time())
        if when < since:
            continue
        n_reports += count
        longest = max(longest, marks[3] - marks[2])
        for name, took in zip(cpu, np.diff(marks), strict=True):
            cpu[name] += float(took)
    span = messages[-1][0] - since
    begun = time.process_time()
    content = engine.pack()
    return {
        "aircraft": told.aircraft,
        "reports_per_s": round(n_reports / span, 1),
        "tracks": int(np.sum(engine.tracks().status == 1)),
        "cores": {name: round(took / span, 4) for name, took in cpu.items()},
        "all": round(sum(cpu.values()) / span, 3),
        "longest_step_cpu_s": round(longest, 3),
        "snapshot": {
            "mb": round(len(content) / 1e6, 2),
            "cpu_s": round(time.process_time() - begun, 3),
        },
    }


class _Listener:
    """Reads the stream; one that parses notes when messages came, and of what time."""

    def __init__(self, port: int, *, parses: bool) -> None:
        self.count = 0
        self._parses, self._seen = parses, list[tuple[float, float]]()
        threading.Thread(target=self._read, args=(port,), daemon=True).start()

    def quantiles(self, begun: float) -> dict[str, float] | None:
        """Return median and 99 % of the time from the end of a sector to its message [s]."""
        late = [when - begun - (told - MORNING) for when, told in self._seen]
        late = late[len(late) // 4 :]
        if not late:
            return None
        return {
            "median": round(float(np.median(late)), 3),
            "p99": round(float(np.quantile(late, 0.99)), 3),
        }

    def _read(self, port: int) -> None:
        from websockets.exceptions import ConnectionClosed
        from websockets.sync.client import connect

        with (
            suppress(ConnectionClosed),
            connect(f"ws://127.0.0.1:{port}/stream", max_size=None) as stream,
        ):
            for message in stream:
                self.count += 1
                if self._parses:
                    said = json.loads(message)
                    if said["type"] == "tracks" and said["time"] is not None:
                        self._seen.append((time.monotonic(), said["time"]))


MORNING = 36_000.0
"""The time of the day at which the traffic begins [s]."""


def _traffic(told: argparse.Namespace) -> list[tuple[float, bytes, int]]:
    """Return when each datagram is sent, what it holds, and how many plots."""
    rng = np.random.default_rng(told.seed)
    place = rng.uniform(-1.5e5, 1.5e5, (told.aircraft, 2))
    velocity = rng.normal(0.0, 150.0, (told.aircraft, 2))
    found = []
    for radar in range(told.radars):
        centre, start = _centre(radar), radar / told.radars * PERIOD
        for turn in range(int(told.seconds / PERIOD)):
            when = np.full(told.aircraft, start + turn * PERIOD)
            for _ in range(3):
                azimuth, true = _seen_from(centre, place + velocity * when[:, None])
                when = start + (turn + azimuth / (2 * np.pi)) * PERIOD
            distance = true + rng.normal(0, 60, told.aircraft)
            measured = azimuth + np.radians(rng.normal(0, 0.07, told.aircraft))
            seen = (rng.random(told.aircraft) < 0.95) & (distance < 4.6e5)
            for sector in range(SECTORS):
                rows = np.flatnonzero(seen & (azimuth * SECTORS // (2 * np.pi) == sector))
                end = start + (turn + (sector + 1) / SECTORS) * PERIOD
                for begin in range(0, max(len(rows), 1), 100):
                    some = rows[begin : begin + 100]
                    plots = b"".join(
                        _plot(radar, MORNING + when[k], distance[k], measured[k]) for k in some
                    )
                    if plots:
                        found.append((end, _block(48, plots), len(some)))
    return sorted(found)


def _seen_from(centre: np.ndarray, place: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return azimuth from the radar's own north [rad] and distance [m] of places on the plane."""
    frame = LocalFrame(*PLACE)
    latitude, longitude, _ = frame.to_geodetic(place)
    here, there, _ = frame.to_geodetic(centre[None])
    azimuth, _, distance = geodetic2aer(latitude, longitude, 0.0, here[0], there[0], 0.0)
    return np.radians(azimuth) % (2 * np.pi), distance


def _plot(radar: int, time_: float, distance: float, azimuth: float) -> bytes:
    rho = int(distance / 1852.0 * 256.0 + 0.5) & 0xFFFF
    theta = int(azimuth / (2 * np.pi) * 65536.0 + 0.5) % 65536
    return (
        b"\xf0\x19"
        + bytes([radar])
        + int(time_ * 128.0).to_bytes(3, "big")
        + b"\x40"
        + (rho.to_bytes(2, "big") + theta.to_bytes(2, "big"))
    )


def _block(category: int, records: bytes) -> bytes:
    return bytes([category]) + (3 + len(records)).to_bytes(2, "big") + records


def _centre(radar: int) -> np.ndarray:
    return np.array([radar * 4e4, 0.0])


def _configuration(radars: int) -> str:
    lines = [
        "[frame]", f"origin = [{PLACE[0]}, {PLACE[1]}]",
        "[motion]", "process_noise = 1.0", "max_speed = 600.0",
        "[lifecycle]", "new_target_density = 1e-12",
        "[output]", "period = 4.0",
    ]  # fmt: skip
    for radar in range(radars):
        x, y = _centre(radar)
        phase = (-radar / radars * 360.0 - MORNING / PERIOD * 360.0) % 360.0
        lines += [
            f'[sensors."025/{radar:03d}"]', 'measurement = "range-azimuth"',
            f"position = [{x}, {y}]", "sigma = {range_m = 60.0, azimuth_deg = 0.07}",
            "detection_probability = 0.95", "clutter_density = 1e-9",
            f"scan_period = {PERIOD}", 'rotation = "clockwise"', f"phase_deg = {phase}",
        ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _send(messages: list[tuple[float, bytes, int]], port: int, begun: float) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        for when, message, _ in messages:
            time.sleep(max(0.0, begun + when - time.monotonic()))
            out.sendto(message, ("127.0.0.1", port))


def _cpu_of(pid: int) -> dict[str, float]:
    """Return the CPU that the service and each of its children have taken so far [s]."""
    listed = subprocess.run(
        ["ps", "-o", "pid=,args=", "--ppid", str(pid), "-p", str(pid)],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    found: dict[str, float] = {}
    for line in listed.splitlines():
        number, _, words = line.strip().partition(" ")
        name = (
            "input" if "service.inputs" in words else "service" if "serve" in words else "decoding"
        )
        fields = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
        found[name] = found.get(name, 0.0) + (int(fields[11]) + int(fields[12])) / TICK
    return found


def _memory_of(pid: int) -> int:
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def _get(port: int, path: str) -> dict:
    with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=120) as answer:
        return json.load(answer)


def _counter(port: int, name: str) -> float:
    """Return a number of the service's metrics."""
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/metrics", timeout=120) as answer:
        lines = answer.read().decode().splitlines()
    return sum(float(line.split()[-1]) for line in lines if line.split()[0].startswith(name))


def _wait(port: int) -> None:
    for _ in range(600):
        try:
            is_ready = _get(port, "/healthz")["status"] != "starting"
        except OSError:
            is_ready = False
        if is_ready:
            time.sleep(5.0)  # its inputs begin after its page
            return
        time.sleep(0.5)
    raise SystemExit("the service does not begin")


def _free_port(kind: socket.SocketKind) -> int:
    with socket.socket(socket.AF_INET, kind) as sock:
        sock.bind(("127.0.0.1", 0))
        return int(sock.getsockname()[1])


if __name__ == "__main__":
    main()
