"""Kills the workers of a live service's regions again and again, and times what comes of it.

Run ``python benchmarks/service_regions.py --kills 100 --seed 1``. The real command, with
``--engine local`` (or another), takes the scans of two radars by ``POST /reports`` in real time:
150 aircraft on circles that cross the border of two regions. A listener on its stream notes when
each scan is in the picture. Whenever both workers of each region are there, one is killed by
``SIGKILL`` or, one time in ten, stopped (``SIGSTOP``, a worker that hangs); with ``--both``, both
workers of a region are killed. ``--seconds`` ends the killing earlier.

At the end it is asked what ``service_serve_kills.py`` asks: is every acknowledged report in the
journal, are tracker and tracks files to the byte those of a run of the journal that nobody
disturbed (in one process, without workers), does ``trackweave replay`` write the same bytes? And:
how long after its last report was each scan in the picture, next to a kill and else? Ends with
status 1 if something is wrong.
"""

import argparse
import bisect
import json
import os
import signal
import sys
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from service_serve_kills import wrong_of
from websockets.sync.client import connect

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from service.serving import Service
from service.test_serve import toml_of

AIRCRAFT, SIDE, SPEED, PERIOD = 150, 60_000.0, 150.0, 1.0
"""Aircraft, half the side of where they are [m], their speed [m/s], and the scan period [s]."""
RADARS = ("north", "south")
NEXT_TO = 4.0
"""A scan is next to a kill that comes so long after it at most [s]: a turn of a radar."""
QUIET = 20.0
"""So long nobody is killed before the first and after the last kill [s]."""
SETTLED = 1.0
"""From when all workers are there until the next kill, at most twice so long [s]."""
CONFIGURATION = {
    "seed": 1,
    "motion": {"process_noise": 20.0, "max_speed": 300.0},
    "lifecycle": {"new_target_density": 1e-9},
    "sensors": {
        name: {
            "measurement": "position", "sigma": 30.0, "detection_probability": 0.9,
            "clutter_density": 1e-9, "scan_period": PERIOD,
        }
        for name in RADARS
    },
}  # fmt: skip


class Traffic:
    """Scans in real time until it is over; when each was acknowledged, and drawn."""

    def __init__(self, service: Service, seed: int) -> None:
        self._service, self._rng = service, np.random.default_rng(seed)
        rng = self._rng
        self._centre = rng.uniform(-SIDE, SIDE, (AIRCRAFT, 2))
        self._radius = rng.uniform(3e3, 15e3, AIRCRAFT)
        self._phase = rng.uniform(0, 2 * np.pi, AIRCRAFT)
        self.acknowledged: set[tuple[float, str, float]] = set()
        self.sent: dict[float, float] = {}
        self.drawn: list[tuple[float, float]] = []
        self.over = threading.Event()
        self._threads = [threading.Thread(target=each) for each in (self._send, self._listen)]
        for each in self._threads:
            each.start()

    def _send(self) -> None:
        begun, number = time.monotonic(), 0
        while not self.over.is_set():
            moment = number * PERIOD / len(RADARS)
            self.over.wait(max(0.0, begun + moment - time.monotonic()))
            rows = self._scan(moment, RADARS[number % len(RADARS)])
            receipt = self._service.post(rows)
            self.sent[moment] = time.monotonic()
            assert receipt["accepted"] == len(rows), receipt
            self.acknowledged |= {(row["time"], row["sensor"], row["x"]) for row in rows}
            number += 1

    def _scan(self, moment: float, radar: str) -> list[dict[str, Any]]:
        angle = self._phase + SPEED / self._radius * moment
        place = self._centre + self._radius[:, None] * np.column_stack(
            [np.cos(angle), np.sin(angle)]
        )
        place += self._rng.normal(0.0, 30.0, place.shape)
        seen = place[self._rng.random(AIRCRAFT) < 0.9]
        return [{"time": moment, "sensor": radar, "x": x, "y": y} for x, y in seen.tolist()]

    def _listen(self) -> None:
        with connect(f"ws://127.0.0.1:{self._service.port}/stream", max_size=None) as stream:
            while not self.over.is_set():
                try:
                    message = json.loads(stream.recv(timeout=1.0))
                except TimeoutError:
                    continue
                if message["type"] == "tracks" and message["time"] is not None:
                    self.drawn.append((message["time"], time.monotonic()))

    def end(self) -> None:
        """Send no more."""
        self.over.set()
        for each in self._threads:
            each.join()

    def waits(self) -> list[tuple[float, float]]:
        """Return when each scan was acknowledged, and how long after that it was drawn [s]."""
        times = np.maximum.accumulate([moment for moment, _ in self.drawn])
        found = []
        for moment, sent in self.sent.items():
            place = bisect.bisect_left(times, moment)
            if place < len(times):
                found.append((sent, max(0.0, self.drawn[place][1] - sent)))
        return found


def kill_one(service: Service, rng: np.random.Generator, *, both: bool) -> str:
    """Kill or stop a worker of a region drawn; return which it was."""
    region = int(rng.integers(len(regions := service.get("/healthz")["regions"])))
    workers = regions[region]
    if both:
        for pid in workers:
            os.kill(pid, signal.SIGKILL)
        return "both workers of a region killed"
    which, is_stopped = int(rng.integers(len(workers))), bool(rng.random() < 0.1)
    os.kill(workers[which], signal.SIGSTOP if is_stopped else signal.SIGKILL)
    return f"{('first', 'standby')[which]} {'stopped' if is_stopped else 'killed'}"


def settled(service: Service, workers: set[int], seconds: float) -> bool:
    """Wait until each region has two workers, not those of before; tell whether they came."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        regions = service.get("/healthz").get("regions", [])
        there = {pid for each in regions for pid in each}
        if len(there) == 2 * len(regions) > 0 and there != workers:
            return True
        time.sleep(0.1)
    return False


def told(waits: list[tuple[float, float]], kills: list[float], begun: float) -> None:
    """Print how long scans waited for the picture, next to kills and else."""
    near, far = [], []
    for sent, wait in waits:
        if sent < begun:
            continue
        is_near = any(kill - NEXT_TO <= sent <= kill + NEXT_TO for kill in kills)
        (near if is_near else far).append(wait)
    for name, each in (("next to a kill", near), ("else", far)):
        if each:
            shares = np.quantile(each, [0.5, 0.99, 1.0])
            print(f"scans {name}: {len(each)}; in the picture after, median, 99 %, longest [s]: "
                  + ", ".join(f"{share:.2f}" for share in shares))  # fmt: skip
    longest = [max((wait for sent, wait in waits if kill - NEXT_TO <= sent <= kill + NEXT_TO),
                   default=np.nan) for kill in kills]  # fmt: skip
    if longest:
        over = sum(each > NEXT_TO for each in longest)
        print(f"longest wait by kill, median, longest [s]: {np.median(longest):.2f}, "
              f"{max(longest):.2f}; after {over} one waited for more than 4 s")  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--engine", default="local")
    parser.add_argument("--both", action="store_true", help="kill both workers of a region")
    parser.add_argument("--folder", type=Path, help="where to work; a disk's, not a memory's")
    options = parser.parse_args()
    rng, seen, kills = np.random.default_rng(options.seed), Counter[str](), list[float]()
    end = time.monotonic() + options.seconds
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        place = Path(name)
        folder, config = place / "data", toml_of(CONFIGURATION, place / "told.toml")
        service = Service(
            folder, "--config", str(config), "--engine", options.engine, "--workers", "2"
        )
        traffic, workers, wrong = Traffic(service, options.seed), set[int](), list[str]()
        begun = None
        while len(kills) < options.kills and time.monotonic() < end:
            if not settled(service, workers, 120.0):
                wrong.append("no new worker came within two minutes")
                break
            # What was heard before there were regions is taken in first.
            begun = begun or time.monotonic() + 5.0
            time.sleep(float(rng.uniform(SETTLED, 2 * SETTLED)) if kills else QUIET)
            workers = {pid for each in service.get("/healthz")["regions"] for pid in each}
            kills.append(time.monotonic())
            seen[kill_one(service, rng, both=options.both)] += 1
        time.sleep(NEXT_TO + QUIET)
        health = service.get("/healthz")
        traffic.end()
        status = service.terminate()
        wrong += [f"SIGTERM: status {status}"] if status else []
        wrong += wrong_of(folder, place, traffic)
        print(f"kills: {len(kills)} ({', '.join(f'{n} {k}' for k, n in seen.items())})")
        print(f"regions: {len(health['regions'])}; late reports: {health['late']}; work bound "
              f"{service.log.read_text().count('work bound')} times")  # fmt: skip
        told(traffic.waits(), kills, begun or 0.0)
    print(f"wrong: {len(wrong)}")
    for each in wrong:
        print(each)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
