"""Memory of a live tracker over runs ten and a hundred times as long.

Targets wander in a square; who leaves it is replaced by another.
"""

import argparse
import gc
import subprocess
import sys
import tracemalloc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from text_tables import heading, table

from trackweave import ConstantVelocity, Lifecycle, MultiHypothesisTracker, Scan, Sensor, Window

SIDE, MARGIN, SIGMA, DETECTION, PROCESS_NOISE = 1000.0, 100.0, 10.0, 0.9, 0.05


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--targets", type=int, default=20)
    parser.add_argument("--scans", type=int, default=500)
    parser.add_argument("--depth", type=int, default=7)
    parser.add_argument("--resident", type=int, metavar="SCANS", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.resident is not None:
        _run(arguments.targets, arguments.resident, arguments.depth)
        print(_resident_mb("VmHWM"))
        return
    lengths = [arguments.scans // 10, arguments.scans, 10 * arguments.scans]
    _apart(arguments, 50)  # compiles and fills the cache
    held = _traced(arguments, lengths)
    rows = [[number, *held[number], _apart(arguments, number)] for number in lengths]
    print(heading("python benchmarks/memory.py"), end="\n\n")
    print(f"T{arguments.targets}, window {arguments.depth}; a live tracker, outputs dropped.\n")
    print(
        table(
            ["after scans", "held, MB", "peak since the row above, MB", "process's peak, MB"], rows
        )
    )


def _traced(arguments: argparse.Namespace, lengths: list[int]) -> dict[int, tuple[float, float]]:
    """Return what Python and NumPy hold, and their peak since the last look, by scans done."""
    # Once without the tracer: compiling is not what is measured.
    _run(arguments.targets, 20, arguments.depth)
    found: dict[int, tuple[float, float]] = {}
    tracemalloc.start()

    def look(number: int) -> None:
        if number in lengths:
            gc.collect()
            held, peak = tracemalloc.get_traced_memory()
            found[number] = held / 1e6, peak / 1e6
            tracemalloc.reset_peak()

    _run(arguments.targets, max(lengths), arguments.depth, look)
    tracemalloc.stop()
    return found


def _apart(arguments: argparse.Namespace, n_scans: int) -> float:
    """Return the peak of a process of its own [MB]."""
    done = subprocess.run(
        [sys.executable, str(Path(__file__)), "--resident", str(n_scans),
         "--targets", str(arguments.targets), "--depth", str(arguments.depth)],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    return float(done.stdout)


def _resident_mb(name: str) -> float:
    for line in Path("/proc/self/status").read_text(encoding="utf-8").splitlines():
        if line.startswith(name):
            return float(line.split()[1]) / 1e3
    raise SystemExit("needs /proc/self/status")


def _run(
    targets: int, n_scans: int, depth: int, look: Callable[[int], None] | None = None
) -> None:
    clutter = targets / (SIDE + 2 * MARGIN) ** 2
    tracker = MultiHypothesisTracker(
        motion=ConstantVelocity(PROCESS_NOISE, 20.0),
        sensors=[Sensor("radar", SIGMA, DETECTION, clutter, scan_period=1.0)],
        window=Window(depth),
        lifecycle=Lifecycle(initial_target_density=1e-4, new_target_density=1e-7),
    )
    rng = np.random.default_rng(1)
    for number, scan in enumerate(_scans(targets, n_scans), start=1):
        tracker.step(scan, rng=rng)
        if look is not None:
            look(number)


def _scans(targets: int, n_scans: int) -> Iterator[Scan]:
    """Yield scans of targets that wander; who leaves is replaced by another, anywhere."""
    rng = np.random.default_rng(2)
    position, velocity = _fresh(targets, rng)
    for second in range(n_scans):
        seen = position[rng.random(targets) < DETECTION]
        own = seen + SIGMA * rng.standard_normal(seen.shape)
        false = rng.uniform(-MARGIN, SIDE + MARGIN, (rng.poisson(targets), 2))
        yield Scan(float(second), "radar", np.concatenate([own, false]))
        velocity = velocity + np.sqrt(PROCESS_NOISE) * rng.standard_normal(velocity.shape)
        position = position + velocity
        gone = np.any((position < 0) | (position > SIDE), axis=1)
        position[gone], velocity[gone] = _fresh(int(gone.sum()), rng)


def _fresh(count: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    position = rng.uniform(0, SIDE, (count, 2))
    speed, course = rng.uniform(5, 20, count), rng.uniform(0, 2 * np.pi, count)
    return position, speed[:, np.newaxis] * np.column_stack([np.cos(course), np.sin(course)])


if __name__ == "__main__":
    main()
