"""How long a scan takes: window of five scans, one thread, after warm-up."""

import argparse
from pathlib import Path

import numpy as np
from bench_data import add_arguments, bench_of, repeats
from runs import CONFIGURATION, cpu_by_instant, tracked, warm_up
from text_tables import command, heading, table

WARM_UP_SCANS = 8


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser, seeds=3)
    parser.add_argument("--config", type=Path, default=CONFIGURATION)
    parser.add_argument("--targets", type=int, nargs="+", default=[20, 100])
    parser.add_argument("--depths", type=int, nargs="+", default=[5, 7])
    arguments = parser.parse_args()
    bench = bench_of(arguments)
    warm_up(bench, arguments.config)
    rows = []
    for targets in arguments.targets:
        for depth in arguments.depths:
            cpu, reports = [], []
            for repeat in repeats(arguments):
                scene = bench.scene(targets, 1, repeat)
                changes = {"window": {"depth": depth}}
                result = tracked(scene, arguments.config, priors=True, changes=changes)
                cpu.append(cpu_by_instant(result, 1)[WARM_UP_SCANS:])
                reports.append(len(scene.detections) / scene.n_scans)
            each = np.concatenate(cpu)
            per_second = np.mean(reports) / (each.mean() / 1e3)
            rows.append(
                [f"T{targets}", depth, *np.percentile(each, [50, 95, 100]).tolist(),
                 float(each.mean()), f"{per_second:,.0f}"]
            )  # fmt: skip
    print(heading(command("latency.py")), end="\n\n")
    print(
        table(
            ["scene", "window", "CPU ms/scan, median", "95 %", "worst", "mean", "reports/s"], rows
        )
    )


if __name__ == "__main__":
    main()
