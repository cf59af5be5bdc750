"""The shared bench, several seeds, one configuration: our tracker beside its peers."""

import argparse
import json
import resource
from pathlib import Path
from typing import Any

import numpy as np
from bench_data import Bench, add_arguments, bench_of, repeats
from runs import CONFIGURATION, KEYS, mean_of, measured, told, warm_up
from text_tables import command, heading, table

WARM_UP_SCANS = 8
SIZES = ((20, 1), (50, 1), (100, 1), (20, 3))
# GOSPA of the best peer known that starts without priors, on the first scene of each size alone.
WITHOUT_PRIORS = {(20, 1): 70.9, (50, 1): 165.0, (100, 1): 413.0}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    add_arguments(parser)
    parser.add_argument("--config", type=Path, default=CONFIGURATION)
    arguments = parser.parse_args()
    bench = bench_of(arguments)
    warm_up(bench, arguments.config)
    peers_file = arguments.cache / "peers.json"
    peers = json.loads(peers_file.read_text()) if peers_file.exists() else {}
    print(heading(command("tracking.py")), end="\n\n")
    means, each = [], []
    for priors in (True, False):
        for size in SIZES:
            runs = {
                repeat: measured(
                    bench, bench.scene(*size, repeat), arguments.config, priors=priors
                )
                for repeat in repeats(arguments)
            }
            each += _seed_rows(size, priors, runs)
            means.append(_mean_row(bench, size, priors, runs, peers))
    print(
        table(
            ["scenes, start", "GOSPA", "best peer", "told the truth", "switches",
             "best peer's", "missed", "false", "RMSE m", "CPU ms/scan, median", "mean",
             "bound met", "with all that counts", "peak MB"],
            means,
        )
    )  # fmt: skip
    print("\nSeed by seed:\n")
    print(
        table(
            ["scene, start", "GOSPA", "switches", "missed", "false", "RMSE m", "CPU ms/scan"],
            each,
        )
    )


def _mean_row(
    bench: Bench, size: tuple[int, int], priors: bool, runs: dict[int, dict[str, Any]],
    peers: dict[str, Any],
) -> list[Any]:  # fmt: skip
    found = list(runs.values())
    cpu = np.concatenate([run["cpu"][WARM_UP_SCANS:] for run in found])
    floor = [bench.score(s, told(s))["gospa"] for s in (bench.scene(*size, k) for k in runs)]
    return [
        _name(size, priors),
        f"**{mean_of(found, 'gospa'):.1f}**",
        _best_peer(size, priors, peers, list(runs), "gospa"),
        float(np.mean(floor)) if priors else None,
        mean_of(found, "switches"),
        _best_peer(size, priors, peers, list(runs), "switches") if priors else None,
        *(mean_of(found, key) for key in KEYS[2:]),
        float(np.median(cpu)),
        float(np.mean(cpu)),
        f"{100 * (mean_of(found, 'proven') + mean_of(found, 'among_kept')):.0f} %",
        f"{100 * mean_of(found, 'proven'):.0f} %",
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024,
    ]


def _best_peer(
    size: tuple[int, int], priors: bool, peers: dict[str, Any], scenes: list[int], key: str
) -> str | float | None:
    """Return a measure of the best peer: JPDA where it was run on all these scenes."""
    if not priors:
        known = WITHOUT_PRIORS.get(size)
        return None if known is None or 1 not in scenes else f"{known} (one scene)"
    names = [f"JPDA T{size[0]} r{k}" for k in scenes]
    if size[1] > 1 or any(peers.get(name) is None for name in names):
        return None
    return float(np.mean([peers[name][key] for name in names]))


def _seed_rows(
    size: tuple[int, int], priors: bool, runs: dict[int, dict[str, Any]]
) -> list[list[Any]]:
    return [
        [
            f"{_name(size, priors)}, r{number}",
            *(run[key] for key in KEYS),
            float(np.mean(run["cpu"][WARM_UP_SCANS:])),
        ]
        for number, run in runs.items()
    ]


def _name(size: tuple[int, int], priors: bool) -> str:
    sensors = f" × {size[1]} sensors" if size[1] > 1 else ""
    return f"T{size[0]}{sensors}, {'priors' if priors else 'none'}"


if __name__ == "__main__":
    main()
