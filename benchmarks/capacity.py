"""Thousands of aircraft and ten turning radars: simulated time against CPU time on one core.

Aircraft fly straight legs and turn now and then; who leaves the sky is replaced. Each is seen by
about two radars of 4 s a turn (70 m, 0.08°, P_D 0.97), one report in ten is false. The tracker
gets each eighth of a turn at its end, holds five turns, and tracks are written every 4 s. An
aircraft is tracked while a confirmed track lies within 2 km; it switches when that track has
another name. Fewer aircraft fly over a smaller sky, as crowded and seen by as many radars.
"""

import argparse
import gc
import resource
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import polars as pl
from capacity_scene import TURN, Radars, Sky, Truth, lifecycle
from scipy.spatial import cKDTree
from text_tables import command, heading, table

from trackweave import ConstantVelocity, MultiHypothesisTracker, Window
from trackweave.domain.tracks import TENTATIVE, TrackTable

NEAR = 2_000.0
WARM_UP = 8
"""Turns before anything counts: the window fills, tracks begin."""


class Figures(NamedTuple):
    """What a run took and what it was worth."""

    reports: float
    cpu: float
    worst: float
    tracked: float
    switches: float
    false: float
    rmse: float
    resident: list[float]


class Judge:
    """Compares tracks with the truth, turn by turn."""

    def __init__(self) -> None:
        self.last: dict[int, int] = {}
        self.seen = self.found = self.false = self.switches = 0
        self.square = 0.0

    def look(self, truth: Truth, tracks: TrackTable) -> None:
        """Take in a turn."""
        own = tracks.status != TENTATIVE
        name, place = tracks.track[own], tracks.mean[own, :2]
        apart, nearest = cKDTree(place).query(truth.position, distance_upper_bound=NEAR)
        hit = np.isfinite(apart)
        now = dict(zip(truth.name[hit].tolist(), name[nearest[hit]].tolist(), strict=True))
        # A track that is still near keeps its aircraft, even if another has come nearer.
        row_of = {track: row for row, track in enumerate(name.tolist())}
        for row, aircraft in enumerate(truth.name.tolist()):
            before = row_of.get(self.last.get(aircraft, -1))
            if before is not None and np.hypot(*(place[before] - truth.position[row])) < NEAR:
                now[aircraft] = int(name[before])
        last = self.last
        self.switches += sum(last.get(aircraft, track) != track for aircraft, track in now.items())
        alive = set(truth.name.tolist())
        self.last = {**{key: self.last[key] for key in self.last.keys() & alive}, **now}
        self.seen += truth.name.size
        self.found += int(hit.sum())
        self.square += float(np.sum(apart[hit] ** 2))
        far, _ = cKDTree(truth.position).query(place, distance_upper_bound=NEAR)
        self.false += int(np.sum(~np.isfinite(far)))


def run(aircraft: int, turns: int, depth: int, seed: int = 1) -> Figures:
    """Return the figures of a run, its tracks written to a file that grows."""
    sky = Sky(aircraft, seed)
    radars, judge = Radars(sky), Judge()
    tracker = MultiHypothesisTracker(
        motion=ConstantVelocity(process_noise=15.0, max_speed=300.0),
        sensors=radars.sensors(),
        window=Window(depth, 10 * depth),
        lifecycle=lifecycle(sky),
    )
    rng, spent, reports, resident = np.random.default_rng(seed), [], 0, []
    with tempfile.TemporaryDirectory() as folder, (Path(folder) / "tracks.csv").open("wb") as file:
        for turn in range(turns + WARM_UP):
            scans = radars.scans()
            begin = time.process_time()
            for scan in scans:
                tracker.step(scan, rng=rng, tracks=False)
            rows = tracker.tracks()
            file.write(_text(rows))
            cpu = time.process_time() - begin
            sky.advance(TURN)
            if turn >= WARM_UP:
                spent.append(cpu)
                reports += sum(map(len, scans))
                judge.look(sky.truth(), rows)
            if turn % 15 == 0:
                gc.collect()
                resident.append(_resident_mb())
    hours = judge.seen * TURN / 3600
    return Figures(
        reports / (turns * TURN), float(np.sum(spent)) / turns, max(spent),
        judge.found / judge.seen, judge.switches / hours, judge.false / turns,
        float(np.sqrt(judge.square / judge.found)), resident,
    )  # fmt: skip


def _text(rows: TrackTable) -> bytes:
    """Return rows as they are written."""
    columns: dict[str, Any] = {"time": rows.time, "track": rows.track, "status": rows.status}
    for place, name in enumerate(("x", "y", "vx", "vy")):
        columns[name] = rows.mean[:, place]
    for place, name in enumerate(("p_x_x", "p_y_y")):
        columns[name] = rows.covariance[:, place, place]
    return pl.DataFrame(columns).write_csv(include_header=False).encode()


def _resident_mb() -> float:
    for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
        if line.startswith("VmRSS"):
            return float(line.split()[1]) / 1e3
    return float("nan")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--aircraft", type=int, nargs="+", default=[500, 1000, 2000, 4000])
    parser.add_argument("--turns", type=int, default=30, help="of 4 s, after a warm-up")
    parser.add_argument("--depth", type=int, default=5)
    parser.add_argument("--hour", type=int, default=4000, help="aircraft of the hour, 0 for none")
    arguments = parser.parse_args()
    run(100, 2, arguments.depth)  # compiles
    print(heading(command("capacity.py")), end="\n\n")
    rows, first = [], None
    for aircraft in arguments.aircraft:
        found = run(aircraft, arguments.turns, arguments.depth)
        first = first or found
        rows.append(
            [f"{aircraft:,}", f"{found.reports:,.0f}", TURN / found.cpu, TURN / found.worst,
             found.cpu / first.cpu, f"{found.tracked:.2%}", found.switches, found.false,
             found.rmse]
        )  # fmt: skip
    names = [
        "aircraft", "reports/s", "simulated s per CPU s", "in the worst turn",
        "CPU against the first row",
        "tracked", "switches per aircraft-hour", "false tracks at a time", "RMSE m",
    ]  # fmt: skip
    print(table(names, rows))
    if arguments.hour:
        found = run(arguments.hour, 900, arguments.depth)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
        tenth = len(found.resident) // 10
        print(f"\nAn hour of {arguments.hour:,} aircraft, window {arguments.depth}:\n")
        print(
            table(
                ["simulated s per CPU s", "tracked", "switches per aircraft-hour",
                 "resident MB after a tenth", "at the end", "peak of the process"],
                [[TURN / found.cpu, f"{found.tracked:.2%}", found.switches,
                  found.resident[tenth], found.resident[-1], peak]],
            )
        )  # fmt: skip


if __name__ == "__main__":
    main()
