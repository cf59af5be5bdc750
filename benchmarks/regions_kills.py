"""A recording in regions whose workers and driver are killed at random: the same bytes.

    python benchmarks/regions_kills.py --kills 200 --seed 1

The command is run again and again on 15,951 reports of 1,400 objects, with two local workers. In
each run two workers are killed (SIGKILL) at moments drawn from the time for which a run has some,
in every fifth the driver at any moment, after which the command is run once more. Whatever
dies, tracks, assignments and history have to be those of an undisturbed run, nothing may be
written by a driver that was killed, and no worker may be left.

Ends with status 1 where bytes differ or something is left behind.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from cluster import BARE, differing, write_input
from service_watchers import children_of
from text_tables import command, heading

EVERY = 5
"""Of so many runs one loses its driver."""
PATIENCE = 10.0
"""Within so long the workers of a killed driver are gone [s]."""
AT_ONCE = 2
"""Kills in a run: a task is given to a third worker, and to no fourth."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    n_workers = n_drivers = n_runs = 0
    wrong: list[str] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_input(folder)
        started(folder, "whole").wait()  # compiles
        begun = time.monotonic()
        started(folder, "again").wait()
        lasts = time.monotonic() - begun
        while n_workers + n_drivers < arguments.kills and not wrong:
            out = f"run{n_runs}"
            n_runs += 1
            if n_runs % EVERY == 0:
                n_drivers += driver_killed(folder, out, rng.uniform(0.1, lasts), wrong)
                started(folder, out).wait()
            else:
                run = started(folder, out)
                n_workers += workers_killed(
                    run, np.sort(rng.uniform(0.3, 1.0, AT_ONCE)) * lasts, rng
                )
                run.wait()
            odd = differing(folder / "whole", folder / out, BARE)
            wrong += [f"{out}: {each}" for each in odd]
            print(f"\r{n_workers + n_drivers} kills", end="", file=sys.stderr, flush=True)
    print("\n" + heading(command("regions_kills.py")), end="\n\n")
    print(f"{n_runs} runs, {n_workers} workers and {n_drivers} drivers killed:",
          "; ".join(wrong) or "the same bytes, and nothing left behind")  # fmt: skip
    sys.exit(bool(wrong))


def started(folder: Path, out: str) -> "subprocess.Popen[bytes]":
    """Begin a run."""
    given = f"track reports.csv --config tracker.toml --engine local --workers 2 --out {out}"
    run = [sys.executable, "-m", "trackweave", *given.split(), "--quiet"]
    return subprocess.Popen(run, cwd=folder, stdin=subprocess.DEVNULL)


def workers_killed(
    run: "subprocess.Popen[bytes]", moments: np.ndarray, rng: np.random.Generator
) -> int:
    """Kill a worker at each moment [s] at which there is one; return how many."""
    begun, count = time.monotonic(), 0
    for moment in moments.tolist():
        time.sleep(max(0.0, begun + moment - time.monotonic()))
        workers = [] if run.poll() is not None else children_of(run.pid)
        if workers:
            count += kill(int(rng.choice(workers)))
    return count


def driver_killed(folder: Path, out: str, moment: float, wrong: list[str]) -> int:
    """Kill a driver at a moment [s] and see what it leaves; return whether it still ran."""
    run = started(folder, out)
    time.sleep(moment)
    workers = [] if run.poll() is not None else children_of(run.pid)
    is_killed = run.poll() is None and kill(run.pid)
    run.wait()
    if not is_killed:
        return 0
    if (folder / out).exists():
        wrong.append(f"{out}: there, though its driver was killed")
    until = time.monotonic() + PATIENCE
    while any(map(is_there, workers)) and time.monotonic() < until:
        time.sleep(0.1)
    wrong += [f"{out}: worker {each} goes on" for each in workers if is_there(each)]
    return 1


def kill(pid: int) -> int:
    """Kill a process; return whether it was there."""
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return 0
    return 1


def is_there(pid: int) -> bool:
    """Tell whether a process runs."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


if __name__ == "__main__":
    main()
