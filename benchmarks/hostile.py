"""Ten thousand reports at one place: what a scan costs in time and memory."""

import argparse
import resource
import subprocess
import sys
import time
from typing import Any

import numpy as np
from text_tables import command, heading, table

import trackweave as tw

KINDS = {
    "equal": "all equal",
    "sigma": "within one sigma",
    "area": "uniform over 1 km²",
    "objects": "of as many objects within 30 m",
}
SCANS = 10


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--reports", type=int, nargs="+", default=[2_000, 10_000])
    parser.add_argument("--scans", type=int, default=SCANS)
    parser.add_argument("--kind", choices=KINDS, help="one kind alone, in this process")
    arguments = parser.parse_args()
    if arguments.kind is not None:
        print(*_measured(arguments.kind, arguments.reports[0], arguments.scans))
        return
    rows = []
    for count in arguments.reports:
        for kind, words in KINDS.items():
            # Peak memory is a process's own.
            done = subprocess.run(
                [sys.executable, __file__, "--kind", kind, "--reports", str(count), "--scans",
                 str(arguments.scans)],
                check=True, stdout=subprocess.PIPE, text=True,
            )  # fmt: skip
            mean, worst, sequences, megabytes = done.stdout.split()
            rows.append(
                [f"{count:,} reports", words, mean, worst, f"{int(sequences):,}", megabytes]
            )
    print(heading(command("hostile.py")), end="\n\n")
    head = ["scan", "places", "CPU s/scan, mean", "worst", "sequences at most", "peak MB"]
    print(table(head, rows))


def _measured(kind: str, count: int, n_scans: int) -> tuple[Any, ...]:
    """Return CPU seconds per scan, mean and worst, most sequences, and peak memory [MB]."""
    rng, tracker = np.random.default_rng(1), _tracker()
    _follow(_tracker(), "sigma", 200, 8, rng)
    seconds, sequences = _follow(tracker, kind, count, n_scans, rng)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    return f"{np.mean(seconds):.1f}", f"{max(seconds):.1f}", max(sequences), peak


def _tracker() -> tw.MultiHypothesisTracker:
    sensor = tw.Sensor(
        "radar", sigma=10.0, detection_probability=0.9, clutter_density=1e-6, scan_period=1.0
    )
    motion = tw.ConstantVelocity(process_noise=0.05, max_speed=30.0)
    return tw.MultiHypothesisTracker(motion=motion, sensors=[sensor])


def _follow(
    tracker: tw.MultiHypothesisTracker,
    kind: str,
    count: int,
    n_scans: int,
    rng: np.random.Generator,
) -> tuple[list[float], list[int]]:
    """Return the CPU time of each scan [s] and how many sequences were held."""
    start, speed = rng.uniform(0.0, 30.0, (count, 2)), rng.normal(0.0, 5.0, (count, 2))
    seconds, sequences = [], []
    for number in range(n_scans):
        place = {
            "equal": lambda: np.full((count, 2), 100.0),
            "sigma": lambda: 100.0 + rng.normal(0.0, 10.0, (count, 2)),
            "area": lambda: rng.uniform(0.0, 1000.0, (count, 2)),
            "objects": lambda n=number: start + n * speed + rng.normal(0.0, 10.0, (count, 2)),
        }[kind]()
        begin = time.process_time()
        hypothesis = tracker.step(tw.Scan(float(number), "radar", place), rng=rng)
        seconds.append(time.process_time() - begin)
        sequences.append(hypothesis.n_sequences)
    return seconds, sequences


if __name__ == "__main__":
    main()
