"""A large recording in regions on workers, beside one process: quality, borders, CPU, traffic.

    python benchmarks/regions.py --aircraft 16000 --blocks 2 --turns 15

A sky as in ``capacity.py``, with ten turning radars over each of ``blocks`` × ``blocks`` squares;
everything that an engineer knows is told. It is tracked by one process and in regions, by workers
that take one region after the other, so that each region's CPU is its own. The largest worker's
share for W workers is that of regions given to whoever is free first, in the order in which the
engine gives them. An aircraft is tracked while a confirmed track lies within 2 km, and doubled
while there are two; GOSPA is of order 2, cut at 2 km, at each turn's end after a warm-up.
"""

import argparse
import resource
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
import polars as pl
from capacity_scene import TURN, Radars, Sky, Truth, lifecycle, recorded
from names_kept import names_of
from scipy.optimize import linear_sum_assignment
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from ten_radars import told_of
from text_tables import command, heading, table

from trackweave import TrackingResult, track
from trackweave.engine import pool
from trackweave.engine.serving import packed_call, unpacked_reply

NEAR = 2_000.0
WARM_UP = 5
"""Turns before anything counts: tracks begin."""
WORKERS = (2, 4, 8)


class Quality(NamedTuple):
    """What tracks are worth, sums over all turns that count."""

    gospa: float
    """Root of the mean square over turns [m]."""
    missed: int
    doubled: int
    false: int
    idf1: float
    switches: int


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--aircraft", type=int, default=16_000)
    parser.add_argument("--blocks", type=int, default=2)
    parser.add_argument("--turns", type=int, default=15)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    sky = Sky(arguments.aircraft, arguments.seed)
    radars = Radars(sky, arguments.blocks)
    told = configuration(radars)
    reports, truth = recorded(radars, arguments.turns)
    few = reports.filter(pl.col("time") < TURN)
    track(few, told)  # compiles
    print(heading(command("regions.py")), end="\n\n")
    shown = reports.drop("target")
    alone, cpu = timed(shown, told, None)
    with traffic() as bytes_sent:
        apart, driver = timed(shown, told, "local")
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    record = apart.run
    timing = record["timing"]["regions"]
    regions = np.array(timing["regions_cpu_ms"]) / 1e3
    smoothing = np.array(timing.get("smoothing_cpu_ms", [])) / 1e3
    rows = [
        [name, *judged(result, reports, truth[WARM_UP:])]
        for name, result in (("one process", alone), ("regions", apart))
    ]
    count = len(regions)
    print(f"{len(reports):,} reports, {count} regions, {record['regions']['joined']} tracks of "
          f"several regions, margin {record['regions']['margin'] / 1e3:.1f} km\n")  # fmt: skip
    print(table(
        ["", "GOSPA m", "missed", "doubled", "false", "IDF1", "switches"], rows
    ), end="\n\n")  # fmt: skip
    lines = []
    for workers in WORKERS:
        largest = greatest_share(regions, workers) + greatest_share(smoothing, workers)
        lines.append([workers, largest, driver, cpu / (largest + driver)])
    print(f"One process: {cpu:.1f} s of CPU. All regions: {regions.sum():.1f} s, smoothing on "
          f"workers {smoothing.sum():.1f} s.\n")  # fmt: skip
    print(table(["workers", "largest worker s", "driver s", "gain"], lines), end="\n\n")
    others = children.ru_utime + children.ru_stime - regions.sum() - smoothing.sum()
    scans = record["scans"]
    last = scans[-1]
    print(f"Cutting {timing['cutting_cpu_ms'] / 1e3:.2f} s, joining "
          f"{timing['joining_cpu_ms'] / 1e3:.2f} s; workers beside their regions (starting, "
          f"reading tasks, packing replies) {others:.1f} s.")  # fmt: skip
    sent, returned = (each / len(reports) for each in bytes_sent)
    print(f"Bytes per report: {sent:.0f} to the workers, {returned:.0f} back.")
    print(f"Gap at the end: alone {alone.run['scans'][-1]['gap']}, regions {last['gap']}, "
          f"status {last['status']}, reports of clusters that a border cuts: "
          f"{sum(each['cut_reports'] for each in scans)} over {len(scans)} scans.")  # fmt: skip


def configuration(radars: Radars) -> dict[str, Any]:
    """Return a configuration that tells everything."""
    sky, known = radars.sky, told_of(radars, with_range=True)
    begins = lifecycle(sky)
    for sensor, phase in zip(known["sensors"].values(), radars.phase.tolist(), strict=True):
        sensor |= {
            "rotation": "clockwise", "phase_deg": float(np.degrees(phase)), "trust": True,
            "clutter_density": radars.n_false / (2.0 * np.pi * radars.reach),
        }  # fmt: skip
    return {
        **known,
        "motion": {
            "model": "constant-velocity", "process_noise": 15.0, "max_speed": 300.0,
            "trust": True,
        },
        # Beyond what the window holds of scans, regions hear of fewer sensors than the whole.
        "window": {"depth": 5, "max_scans": min(200, 5 * len(radars.place))},
        "lifecycle": {
            "new_target_density": begins.new_target_density,
            "initial_target_density": begins.initial_target_density,
            "survival": begins.survival,
        },
        "output": {"period": TURN},
    }  # fmt: skip


def timed(
    reports: pl.DataFrame, told: dict[str, Any], engine: str | None
) -> tuple[TrackingResult[pl.DataFrame], float]:
    """Return what came of a run and the CPU of this process [s]."""
    begun = time.process_time()
    workers = None if engine is None else 1
    result = track(reports, told, rng=0, engine=engine, workers=workers)
    return result, time.process_time() - begun


@contextmanager
def traffic() -> Iterator[list[int]]:
    """Count the bytes that go to workers and come back."""
    counted = [0, 0]

    def packed(*call: Any) -> bytes:
        content = packed_call(*call)
        counted[0] += len(content)
        return content

    def unpacked(content: bytes) -> Any:
        counted[1] += len(content)
        return unpacked_reply(content)

    with patch.multiple(pool, packed_call=packed, unpacked_reply=unpacked):
        yield counted


def greatest_share(regions: np.ndarray, workers: int) -> float:
    """Return the CPU of the worker that had most of it, each taking the next region when free."""
    busy = np.zeros(workers)
    for each in regions:
        busy[np.argmin(busy)] += each
    return float(busy.max())


def judged(
    result: TrackingResult[pl.DataFrame], reports: pl.DataFrame, truth: Sequence[Truth]
) -> Quality:
    """Compare tracks with the truth."""
    idf1, switches, _ = names_of(result, reports)
    tracks = result.tracks.filter(pl.col("status") != "tentative")
    square, missed, doubled, false = 0.0, 0, 0, 0
    for then in truth:
        # Rows are told when a step ends, whose last beam may be some moments on.
        last = tracks.filter((pl.col("time") - then.time).abs() < TURN / 4)
        past = then.time - last["time"].to_numpy()
        where = last.select("x", "y").to_numpy()
        where = where + past[:, None] * last.select("vx", "vy").to_numpy()
        paired, cost = pairs(then.position, where)
        alone = len(then.position) - paired
        surplus = len(where) - paired
        near = cKDTree(where).query_ball_point(then.position, NEAR, return_length=True)
        square += cost + NEAR**2 / 2 * (alone + surplus)
        missed += alone
        false += surplus
        doubled += int((near > 1).sum())
    return Quality(float(np.sqrt(square / len(truth))), missed, doubled, false, idf1, switches)


def pairs(true: np.ndarray, found: np.ndarray) -> tuple[int, float]:
    """Return how many pairs the best assignment has, and the sum of their squares [m²]."""
    apart = cKDTree(true).sparse_distance_matrix(cKDTree(found), NEAR, output_type="coo_matrix")
    n = len(true)
    size = n + len(found)
    joined = apart.copy()
    joined.resize((size, size))
    joined.col = joined.col + n
    _, of = connected_components(joined, directed=False)
    order = np.argsort(of[apart.row], kind="stable")
    count, total = 0, 0.0
    for edges in np.split(order, np.flatnonzero(np.diff(of[apart.row][order])) + 1):
        rows, row = np.unique(apart.row[edges], return_inverse=True)
        columns, column = np.unique(apart.col[edges], return_inverse=True)
        cost = np.full((rows.size, columns.size), NEAR**2)
        cost[row, column] = np.minimum(apart.data[edges] ** 2, NEAR**2)
        best = linear_sum_assignment(cost)
        kept = cost[best] < NEAR**2
        count += int(kept.sum())
        total += float(cost[best][kept].sum())
    return count, total


if __name__ == "__main__":
    main()
