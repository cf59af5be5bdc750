"""How long it takes to associate the tracks of 8 sensors, 1,000 each, every second.

    python benchmarks/fusion_capacity.py

Objects at 150 m/s are spread over a square; each sensor tracks 95 % of them with errors of its
own, 50 m and 8 m/s. Times are those of one step, checks of the pictures included.
"""

import argparse
from time import process_time

import numpy as np
from text_tables import command, heading, table

from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.pictures import LocalPicture
from trackweave.solvers.auto import Auto
from trackweave.solvers.warming import warm_up

SIGMA = np.array([50.0, 50.0, 8.0, 8.0])


def measure(n_sensors: int, n_objects: int, side: float, n_steps: int) -> list[object]:
    """Return a row of the table."""
    rng = np.random.default_rng(1)
    place, velocity = (
        rng.uniform(0.0, side, (n_objects, 2)),
        rng.normal(0.0, 150.0, (n_objects, 2)),
    )
    mine = [rng.permutation(n_objects)[: int(0.95 * n_objects)] for _ in range(n_sensors)]
    truth = np.concatenate(mine)
    associator = TrackAssociator()
    taken, right = [], []
    for step in range(n_steps + 2):
        state = np.concatenate([place + step * velocity, velocity], axis=1)
        means = [state[which] + SIGMA * rng.normal(size=(len(which), 4)) for which in mine]
        begin = process_time()
        pictures = {
            f"S{number}": LocalPicture(
                f"S{number}", float(step), which, means[number],
                np.tile(np.diag(SIGMA**2), (len(which), 1, 1)),
            )
            for number, which in enumerate(mine)
        }  # fmt: skip
        found = associator.step(float(step), pictures, rng=rng)
        # The first two compile kernels, or load them.
        if step >= 2:
            taken.append(1e3 * (process_time() - begin))
            whole = np.array([len(set(found.object[truth == k])) == 1 for k in range(n_objects)])
            right.append(100.0 * whole.mean())
    return [n_sensors, n_objects, f"{side / 1e3:g} km", float(np.median(taken)), max(taken),
            f"{np.mean(right):.1f}"]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--steps", type=int, default=10)
    arguments = parser.parse_args()
    warm_up(Auto(), np.random.default_rng(0))
    sizes = [(3, 1_000, 300e3), (8, 1_000, 300e3), (8, 1_000, 60e3), (8, 2_000, 300e3)]
    rows = [measure(*size, arguments.steps) for size in sizes]
    print(heading(command("fusion_capacity.py")), end="\n\n")
    head = ["sensors", "objects", "square", "CPU ms a step, median", "greatest", "objects whole %"]
    print(table(head, rows))


if __name__ == "__main__":
    main()
