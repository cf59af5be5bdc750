"""Those who watch a service under load, each kind in a process of its own: listeners, a browser.

    python benchmarks/service_watchers.py listeners PORT COUNT
    python benchmarks/service_watchers.py parser PORT
    python benchmarks/service_watchers.py browser URL

A parser prints a line of JSON for each message of tracks: when it was read whole (monotonic clock)
and up to when it tells of reports. Listeners print how many messages they got each, a browser what
its page drew, once standard input ends.
"""

import json
import os
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

CHROMIUM = "/usr/bin/chromium"
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
SLOWLY = """
const soon = globalThis.requestAnimationFrame.bind(globalThis);
globalThis.drawn = 0;
globalThis.requestAnimationFrame = (draw) => setTimeout(() => soon((ms) => {
  globalThis.drawn += 1;
  draw(ms);
}), 1000);
"""
"""One frame a second."""
TICK = os.sysconf("SC_CLK_TCK")
DAY = 86_400.0


class Watchers:
    """The processes that watch a service at a port of this machine.

    Parameters
    ----------
    port
        The service's.
    listeners
        How many read the stream, of whom the first parses what it reads.
    browser
        Whether the page is shown, drawn once a second.
    """

    def __init__(self, port: int, listeners: int, *, browser: bool) -> None:
        self._processes: dict[str, subprocess.Popen[str]] = {}
        self.seen: list[tuple[float, float]] = []
        if listeners:
            parser = self._start("parser", str(port))
            threading.Thread(target=self._note, args=(parser,), daemon=True).start()
        if listeners > 1:
            self._start("listeners", str(port), str(listeners - 1))
        if browser:
            self._start("browser", f"http://127.0.0.1:{port}/")

    def cpu(self) -> dict[str, float]:
        """Return the CPU that each kind has taken so far [s]."""
        return {name: cpu_of_all(each.pid) for name, each in self._processes.items()}

    def close(self) -> dict[str, Any]:
        """End them, and return what they said."""
        said: dict[str, Any] = {}
        for name, process in self._processes.items():
            if name == "parser":
                process.terminate()
                process.wait()
                continue
            out, _ = process.communicate(timeout=60)
            said[name] = json.loads(out or "null")
        return said

    def _start(self, *words: str) -> "subprocess.Popen[str]":
        process = subprocess.Popen(
            [sys.executable, __file__, *words],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True,
        )  # fmt: skip
        self._processes[words[0]] = process
        return process

    def _note(self, process: "subprocess.Popen[str]") -> None:
        assert process.stdout is not None
        for line in process.stdout:
            when, told = json.loads(line)
            self.seen.append((when, told))


def latencies(
    seen: list[tuple[float, float]], since: dict[float, float], morning: float
) -> dict[str, float] | None:
    """Return how long after moments [s] the last message that tells of a sector came [s].

    Parameters
    ----------
    seen
        When messages came, and up to when they tell.
    since
        The moment from which each sector's message is waited for, by the sector's end.
    morning
        The time of the day of the beginning [s].

    Returns
    -------
    The median, 99 % and the longest, of the last three quarters; None for none. A sector of which
    no message tells by itself counts with the first message of a later one.
    """
    when = np.array([each for each, _ in seen])
    # Radars tell the time of the day, and the service the date as well.
    told = np.maximum.accumulate(np.array([each for _, each in seen]) % DAY) - morning
    ends = np.array(sorted(since))
    ends = ends[len(ends) // 4 :]
    place = np.searchsorted(told, ends - 1e-6)
    after = np.searchsorted(told, ends + 1e-6)
    place = np.maximum(place, after - 1)
    ends, place = ends[place < len(told)], place[place < len(told)]
    if not len(ends):
        return None
    late = when[place] - np.array([since[end] for end in ends.tolist()])
    return {
        "median": round(float(np.median(late)), 3),
        "p99": round(float(np.quantile(late, 0.99)), 3),
        "longest": round(float(late.max()), 3),
    }


def cpu_of(pid: int) -> float:
    """Return the CPU that a process has taken so far, and those of its children that ended [s]."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, fields[11:15])) / TICK


def wait_of(pid: int) -> float:
    """Return how long the threads of a process have waited for a core so far [s]."""
    waited = 0
    for task in Path(f"/proc/{pid}/task").glob("*/schedstat"):
        with suppress(OSError):
            waited += int(task.read_text().split()[1])
    return waited / 1e9


def children_of(pid: int) -> list[int]:
    """Return a process's children."""
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):
            found += map(int, task.read_text().split())
    return found


def cpu_of_all(pid: int) -> float:
    """Return the CPU of a process and all that it started [s]."""
    return cpu_of(pid) + sum(cpu_of_all(child) for child in children_of(pid))


def memory_of(pid: int) -> int:
    """Return the memory that a process has resident [bytes]."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def _parse(port: int) -> None:
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    with (
        suppress(ConnectionClosed, BrokenPipeError),
        connect(f"ws://127.0.0.1:{port}/stream", max_size=None, compression=None) as stream,
    ):
        for message in stream:
            now = time.monotonic()
            said = json.loads(message)
            if said["type"] == "tracks" and said["time"] is not None:
                print(json.dumps([now, said["time"]]), flush=True)


def _listen(port: int, count: int) -> None:
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    got = [0] * count

    def read(number: int) -> None:
        with (
            suppress(ConnectionClosed),
            connect(f"ws://127.0.0.1:{port}/stream", max_size=None, compression=None) as stream,
        ):
            while True:
                stream.recv(decode=False)
                got[number] += 1

    for number in range(count):
        threading.Thread(target=read, args=(number,), daemon=True).start()
    sys.stdin.read()
    print(json.dumps({"fewest": min(got), "most": max(got)}), flush=True)
    os._exit(0)


def _browse(url: str) -> None:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1600, "height": 900})
        page.add_init_script(SLOWLY)
        asked: list[str] = []
        page.on("request", lambda request: asked.append(request.url))
        page.goto(url)
        waiting = threading.Thread(target=sys.stdin.read, daemon=True)
        waiting.start()
        while waiting.is_alive():
            page.wait_for_timeout(1000)
        foreign = [each for each in asked if not each.startswith(url)]
        shown = page.evaluate("() => [globalThis.drawn, globalThis.trackweave.map.instant.n]")
        browser.close()
    print(json.dumps({"frames": shown[0], "tracks": shown[1], "foreign_requests": foreign}))


if __name__ == "__main__":
    what, where, *more = sys.argv[1:]
    if what == "parser":
        _parse(int(where))
    elif what == "listeners":
        _listen(int(where), int(more[0]))
    else:
        _browse(where)
