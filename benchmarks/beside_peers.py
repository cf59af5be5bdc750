"""Our tracker beside Stone Soup's JPDA and GNN: each scene run by all of them, one after another.

    python benchmarks/beside_peers.py --peers-python peers/bin/python

The peers, see ``peers.py``, are measured anew. CPU time is that of all steps of the trackers, from
reports in memory to tracks, compilation left out.
"""

import argparse
import json
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
from bench_data import add_arguments, bench_of, repeats
from runs import CONFIGURATION, rows_of, tracked, warm_up
from text_tables import command, heading, table

HERE = Path(__file__).resolve().parent
PEERS = {"JPDA": "JPDA-EHM2", "GNN": "GNN"}


def settings(depths: list[int]) -> dict[str, dict[str, Any]]:
    """Return what is changed of the configuration in each of our rows."""
    changes: dict[str, dict[str, Any]] = {
        f"trackweave, window {depth}": {"window": {"depth": depth}} for depth in depths
    }
    narrow = tomllib.loads((HERE / "narrow.toml").read_text(encoding="utf-8"))
    deepest = {"window": {"depth": max(depths)}}
    return {**changes, f"trackweave, window {max(depths)}, narrow growth": deepest | narrow}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add_arguments(parser)
    parser.add_argument("--targets", type=int, nargs="+", default=[20, 50, 100])
    parser.add_argument("--depths", type=int, nargs="+", default=[5, 7])
    parser.add_argument("--peers-python", default=sys.executable, help="has stonesoup and pyehm")
    arguments = parser.parse_args()
    bench = bench_of(arguments)
    warm_up(bench, CONFIGURATION)
    rows: list[list[Any]] = []
    for targets in arguments.targets:
        found: dict[str, list[dict[str, float] | None]] = {}
        for repeat in repeats(arguments):
            scene = bench.scene(targets, 1, repeat)
            for name, result in peers_on(arguments, targets, repeat).items():
                found.setdefault(name, []).append(result)
            for label, changes in settings(arguments.depths).items():
                # Twice, because a scene may be the first to need some kernel compiled.
                result, again = (
                    tracked(scene, CONFIGURATION, priors=True, changes=changes) for _ in range(2)
                )
                cpu = min(each.run["timing"]["cpu_ms"] for each in (result, again))
                cpu /= scene.n_scans
                judged = {**bench.score(scene, rows_of(result)), "cpu_ms": cpu}
                found.setdefault(label, []).append(judged)
        if not all(name in found for name in PEERS.values()):
            print("Skipped: needs stonesoup and pyehm (pip install stonesoup pyehm).")
            return
        n_scenes = len(repeats(arguments))
        if arguments.first == 1:
            rows += rows_for(f"T{targets}, the bench's own", found, slice(0, 1))
        if n_scenes > 1:
            rows += rows_for(f"T{targets}, mean of {n_scenes}", found, slice(None))
    # Where the peers live is this machine's business.
    told = command(Path(__file__).name).replace(arguments.peers_python, "peers/bin/python")
    print(heading(told), end="\n\n")
    head = ["scene", "method", "GOSPA", "switches", "CPU ms/scan", "JPDA's CPU", "GNN's CPU"]
    print(table(head, rows))


def peers_on(
    arguments: argparse.Namespace, targets: int, repeat: int
) -> dict[str, dict[str, float] | None]:
    """Return what each peer does on a scene, measured now; nothing where none is."""
    # They live in an environment of their own, with their own versions of what both need.
    subprocess.run(
        [
            arguments.peers_python, str(HERE / "peers.py"), "--again",
            "--bench", str(arguments.bench), "--cache", str(arguments.cache),
            "--targets", str(targets), "--first", str(repeat), "--seeds", "1",
        ],
        check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    kept = arguments.cache / "peers.json"
    results = json.loads(kept.read_text()) if kept.exists() else {}
    keys = {label: f"{method} T{targets} r{repeat}" for method, label in PEERS.items()}
    return {label: results[key] for label, key in keys.items() if key in results}


def rows_for(
    scenes: str, found: dict[str, list[dict[str, float] | None]], which: slice
) -> list[list[Any]]:
    """Return one row per method: its means over scenes, and how much more CPU the peers take."""
    means = {
        name: {
            key: float(np.mean([each[key] if each else np.nan for each in results[which]]))
            for key in ("gospa", "switches", "cpu_ms")
        }
        for name, results in found.items()
    }
    rows = []
    for name, mean in means.items():
        measures: list[Any] = [mean["gospa"], mean["switches"], mean["cpu_ms"]]
        ratios = [f"{means[peer]['cpu_ms'] / mean['cpu_ms']:.1f} ×" for peer in PEERS.values()]
        if np.isnan(mean["cpu_ms"]):
            measures = ["not finished", None, None]
        cells = [*measures, *ratios]
        rows.append([scenes, name, *(None if cell == "nan ×" else cell for cell in cells)])
    return rows


if __name__ == "__main__":
    main()
