"""What a command takes from its start to its end: small files, first runs, long thin recordings.

Each command is a process of its own, on one core; beside it, in turn, one that imports what
any program with tables would, and does nothing.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from text_tables import command, heading, table

BESIDE = [sys.executable, "-c", "import numpy, polars"]
TRACKWEAVE = [sys.executable, "-m", "trackweave"]
SIGMA, DETECTION, CLUTTER, SIDE = 5.0, 0.9, 5, 1000.0
FEW = f"""
[motion]
max_speed = 30.0

[sensors.default]
sigma = {SIGMA}
detection_probability = {DETECTION}
clutter_per_scan = {CLUTTER}
scan_period = 1.0
"""
# What is left out above is estimated from the reports; nothing is left out below.
ALL = (
    FEW.replace("[motion]", "[motion]\nprocess_noise = 0.1")
    + """
[lifecycle]
new_target_density = 1e-8
initial_target_density = 1e-5
delete_after_misses = 5
"""
)


@dataclass(frozen=True)
class Taken:
    """CPU and wall clock [s] and peak memory [MB] of a process."""

    cpu: float
    wall: float
    peak: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=int, default=86_400, help="of one report a second")
    parser.add_argument("--runs", type=int, default=5, help="of each warm command")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        _write_files(place, arguments.seconds)
        rows = _rows(place, arguments.runs, arguments.seconds)
    print(heading(command("cold_start.py")), end="\n\n")
    print(
        "Small file: 20 scans of 10 objects and 5 false alarms. First run: no kernel compiled "
        'yet. Beside: `python -c "import numpy, polars"`, run in turn; medians.\n'
    )
    print(table(["command", "CPU, s", "wall, s", "peak, MB", "CPU beside that"], rows))


def _rows(place: Path, runs: int, seconds: int) -> list[list[object]]:
    """Return a row for each command."""
    few, every = ["--config", place / "few.toml"], ["--config", place / "all.toml"]
    small = ["track", place / "small.csv", "--out", place / "out"]
    cold = [
        ("first `track` of a small file", small),
        ("first `demo`", ["demo", "--out", place / "demo"]),
    ]
    warm = [
        ("`--help`", ["--help"]),
        ("`track` of a small file, all configured", [*small, *every]),
        ("`track` of a small file, sensor configured", [*small, *few]),
        ("`track` of a small file, nothing configured", small),
        ("`demo`", ["demo", "--out", place / "demo"]),
    ]
    long = [
        (f"`track`, one report a second for {seconds:,} s, {what}",
         ["track", place / f"{what}.csv", "--out", place / what])
        for what in ("object", "noise")
    ]  # fmt: skip
    rows = []
    for number, (name, words) in enumerate(cold):
        rows.append(_row(name, words, place / f"first-{number}", 1))
    # What the first runs compiled, and what the others need besides.
    cache = place / "first-1"
    for _, words in warm:
        _taken([*TRACKWEAVE, *map(str, words)], cache)
    rows += [_row(name, words, cache, runs) for name, words in warm]
    return rows + [_row(name, words, cache, 1) for name, words in long]


def _row(name: str, words: list[object], cache: Path, runs: int) -> list[object]:
    """Return what a command takes, and how often as much as what is run beside it."""
    pairs = [
        (_taken(BESIDE, cache), _taken([*TRACKWEAVE, *map(str, words)], cache))
        for _ in range(runs)
    ]
    cpu, wall, peak = (
        float(np.median([getattr(one, key) for _, one in pairs]))
        for key in ("cpu", "wall", "peak")
    )
    ratio = float(np.median([one.cpu / beside.cpu for beside, one in pairs]))
    return [name, f"{cpu:.2f}", f"{wall:.2f}", f"{peak:.0f}", f"{ratio:.1f}"]


def _taken(words: list[str], cache: Path) -> Taken:
    """Run a process to its end on one core and return what it took."""
    begin = perf_counter()
    process = subprocess.Popen(
        words,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
    )
    os.sched_setaffinity(process.pid, {min(os.sched_getaffinity(0))})
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"{' '.join(words)}: failed")
    cpu = usage.ru_utime + usage.ru_stime
    return Taken(cpu, perf_counter() - begin, usage.ru_maxrss / 1e3)


def _write_files(place: Path, seconds: int) -> None:
    rng = np.random.default_rng(1)
    start, velocity = rng.uniform(0, SIDE, (10, 2)), rng.normal(0, 8, (10, 2))
    rows = []
    for scan in range(20):
        seen = (start + scan * velocity)[rng.random(10) < DETECTION]
        false = rng.uniform(0, SIDE, (rng.poisson(CLUTTER), 2))
        found = np.concatenate([seen + SIGMA * rng.standard_normal(seen.shape), false])
        rows += [(scan, *report) for report in found]
    _write(place / "small.csv", rows)
    (place / "few.toml").write_text(FEW, encoding="utf-8")
    (place / "all.toml").write_text(ALL, encoding="utf-8")
    course = np.cumsum(rng.normal(0, 0.002, seconds))
    path = np.cumsum(10.0 * np.column_stack([np.cos(course), np.sin(course)]), axis=0)
    noisy = path + 10.0 * rng.standard_normal(path.shape)
    _write(place / "object.csv", [(k, *report) for k, report in enumerate(noisy)])
    nowhere = rng.uniform(0, 10_000, (seconds, 2))
    _write(place / "noise.csv", [(k, *report) for k, report in enumerate(nowhere)])


def _write(path: Path, rows: list[tuple[float, ...]]) -> None:
    lines = ["time,x,y", *(f"{time},{x:.2f},{y:.2f}" for time, x, y in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
