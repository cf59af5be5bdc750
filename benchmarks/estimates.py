"""What to report of a track: the average over its sequences, or the best hypothesis alone."""

import argparse
from pathlib import Path

from bench_data import add_arguments, bench_of, repeats
from runs import CONFIGURATION, KEYS, mean_of, measured, warm_up
from text_tables import command, heading, table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser)
    parser.add_argument("--config", type=Path, default=CONFIGURATION)
    arguments = parser.parse_args()
    bench = bench_of(arguments)
    warm_up(bench, arguments.config)
    rows = []
    for priors in (True, False):
        for targets in (20, 50, 100):
            for estimate in ("average", "best"):
                runs = [
                    measured(
                        bench, bench.scene(targets, 1, repeat), arguments.config, priors=priors,
                        changes={"output": {"estimate": estimate}},
                    )
                    for repeat in repeats(arguments)
                ]  # fmt: skip
                cpu = sum(float(run["cpu"].mean()) for run in runs) / len(runs)
                start = "priors" if priors else "none"
                rows.append(
                    [f"T{targets}, {start}", estimate, *(mean_of(runs, key) for key in KEYS), cpu]
                )
    print(heading(command("estimates.py")), end="\n\n")
    print(
        table(
            ["scenes, start", "estimate", "GOSPA", "switches", "missed", "false", "RMSE m",
             "CPU ms/scan, mean"],
            rows,
        )
    )  # fmt: skip


if __name__ == "__main__":
    main()
