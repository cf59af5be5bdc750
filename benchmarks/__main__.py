"""Runs every benchmark and enters its tables into the pages of measurements.

    python -m benchmarks                      # all of them, about half an hour without the peers
    python -m benchmarks --only tracking latency
    python -m benchmarks --only association   # the solvers on assignment problems
    python -m benchmarks --only plots         # plots of one instant, some fifteen minutes
    python -m benchmarks --only fusion        # tracks of many sensors, some twenty minutes
    python -m benchmarks --only presets       # what the documents' usable presets are worth
    python -m benchmarks --only performance   # capacity, deadlines, and what each part gains
    python -m benchmarks --peers-python peers/bin/python

Text between ``<!-- begin NAME -->`` and ``<!-- end NAME -->`` is replaced; the rest is written by
hand and stays.
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGES = HERE.parent / "docs"
_PLACES = ("--aircraft", "60", "--radars", "3", "--first", "61", "--seeds", "3")
# The peers come first: tracking.py sets its own figures beside theirs.
SCRIPTS = {
    "peers": ["peers.py"],
    "tracking": ["tracking.py"],
    "unseen": ["tracking.py", "--first", "6"],
    "estimates": ["estimates.py"],
    "biases": ["biases.py", "--seeds", "3"],
    "biases-found": ["biases.py", "--only", "--first", "31", "--seeds", "12"],
    "places-found": ["biases.py", "--places", *_PLACES],
    "optimality": ["optimality.py"],
    "opensky": ["opensky.py"],
    "manoeuvres": ["manoeuvres.py"],
    "simulated": ["simulated.py"],
    "bearings": ["bearings_only.py"],
    "recordings": ["recordings.py"],
    "boxes": ["boxes.py"],
    "dividing": ["dividing.py"],
    "merges": ["dividing_merges.py"],
    "damaged": ["damaged_files.py"],
    "inputs": ["inputs_hostile.py"],
    "scenes": ["eight_scenes.py"],
    "told": ["told_wrongly.py"],
    "joins": ["joins.py"],
    "existence": ["existence.py"],
    "never-worse": ["never_worse.py", "--anew"],
    "contradictions": ["contradictions.py", "--seeds", "101", "111"],
    "memory": ["memory.py"],
    "latency": ["latency.py"],
    # Whoever finds a better answer enters it in best_known.json, for those after it.
    "association-axial": ["solvers_axial.py"],
    "association-windows": ["solvers_windows.py"],
    "association-positions": ["solvers_positions.py"],
    "association-alone": ["solvers_alone.py"],
    "association-bearings": ["solvers_bearings.py"],
    "association-truth": ["solvers_truth.py"],
    "plots-few": ["plots_truth.py", "--objects", "5", "10"],
    "plots-twenty": ["plots_truth.py", "--objects", "20"],
    "plots-fifty": ["plots_truth.py", "--objects", "50"],
    "plots-hundred": ["plots_truth.py", "--objects", "100"],
    "plots-three": [
        "plots_truth.py",
        "--objects",
        "5",
        "20",
        "50",
        "--times",
        "5",
        "--only",
        "position",
        "3",
    ],
    "plots-solvers": ["plots_solvers.py"],
    "fusion-baselines": ["fusion_baselines.py"],
    "fusion-rates": ["fusion_rates.py"],
    "fusion-consistency": ["fusion_consistency.py"],
    "fusion-registration": ["fusion_registration.py"],
    "fusion-autoferry": ["fusion_autoferry.py"],
    "fusion-capacity": ["fusion_capacity.py"],
    "performance-open": ["open_models.py"],
    "performance-capacity": ["capacity.py"],
    "performance-bench": ["beside_peers.py"],
    "performance-deadlines": ["deadlines.py"],
    "performance-islands": ["islands.py"],
    "performance-regions": ["regions.py"],
    "performance-gains": ["gains.py"],
    "performance-cold": ["cold_start.py"],
    "performance-hostile": ["hostile.py"],
    "asterix": ["asterix_speed.py"],
    "asterix-damaged": ["asterix_speed.py", "--mutants", "100000"],
    "presets-hillis": ["presets_hillis.py"],
    "presets-huo": ["presets_huo.py"],
    "presets-wiranto": ["presets_wiranto.py", "--first", "11", "--seeds", "4"],
}
PAGE = "explanation/measurements.md"
# Names that begin so are run together, and stand on a page of their own.
GROUPS = {
    "association": "explanation/association.md",
    "asterix": "reference/asterix.md",
    "fusion": "explanation/fusion.md",
    "performance": "performance.md",
    "plots": "explanation/plots.md",
    "presets": PAGE,
}
OWN_PAGES = {
    "biases": "explanation/registration.md",
    "biases-found": "explanation/registration.md",
    "places-found": "explanation/registration.md",
    "boxes": "how-to/my-video-detections.md",
    "contradictions": "explanation/diagnostics.md",
    "damaged": "reference/formats.md",
    "dividing": "how-to/my-particles.md",
    "inputs": "explanation/service-security.md",
    "merges": "how-to/my-particles.md",
    "recordings": "explanation/recordings.md",
    "scenes": "explanation/scenes.md",
    "told": "explanation/scenes.md",
    "never-worse": "explanation/scenes.md",
    "presets-hillis": "explanation/hillis-1997.md",
    "presets-huo": "explanation/huo-2008.md",
    "presets-wiranto": "explanation/wiranto-2018.md",
}
BESIDE_PEERS = {"peers", "boxes", "dividing"}
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "POLARS_MAX_THREADS": "1",
}


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Run benchmarks.")
    known = [*GROUPS, "presets"]
    parser.add_argument("--only", nargs="+", choices=[*SCRIPTS, *known], default=list(SCRIPTS))
    parser.add_argument("--pages", type=Path, default=PAGES, help="folder of the documents")
    parser.add_argument(
        "--peers-python", default=sys.executable, help="interpreter that has the peers"
    )
    arguments = parser.parse_args()
    failed = []
    for name, (script, *options) in SCRIPTS.items():
        group = name.partition("-")[0]
        if name not in arguments.only and not (group in known and group in arguments.only):
            continue
        print(f"==> {name}", flush=True)
        python = (
            arguments.peers_python if name in {"peers", "boxes", "dividing"} else sys.executable
        )
        if name == "performance-bench":
            options += ["--peers-python", arguments.peers_python]
        done = subprocess.run(
            [python, str(HERE / script), *options],
            check=False, stdout=subprocess.PIPE, text=True, env={**os.environ, **ONE_THREAD},
        )  # fmt: skip
        print(done.stdout)
        if done.returncode:
            failed.append(name)
        elif not done.stdout.startswith("Skipped"):
            page = OWN_PAGES.get(name) or GROUPS.get(group, PAGE)
            enter(arguments.pages / page, name, done.stdout.strip())
    if failed:
        print(f"Failed: {', '.join(failed)}", file=sys.stderr)
    return bool(failed)


def enter(page: Path, name: str, text: str) -> None:
    """Replace what stands between a script's marks on the page."""
    old = page.read_text(encoding="utf-8")
    pattern = re.compile(rf"(<!-- begin {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
    if not pattern.search(old):
        raise SystemExit(f"{page}: no marks for {name}")
    page.write_text(pattern.sub(lambda m: f"{m[1]}{text}\n{m[2]}", old), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
