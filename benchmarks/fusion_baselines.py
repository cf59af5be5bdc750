"""Right associations of many sensors' tracks, beside the usual practice.

    python benchmarks/fusion_baselines.py                 # some minutes
    python benchmarks/fusion_baselines.py --seeds 2

Objects are spread evenly over a square with so many standard deviations of a position between
neighbours. Each sensor sees each with a probability, tracks it with errors of its own, and gives
its tracks in an order of its own. Five updates; then a track is right when its group is exactly
the tracks of its object.
"""

import argparse
from itertools import product

import numpy as np
from text_tables import command, heading, table

from trackweave.association.chain_rule import TrackEstimates
from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.pictures import LocalPicture
from trackweave.solvers import Exact
from trackweave.studies.huo_methods import nearest_neighbour, pairwise_sequential

N_TIMES = 5
SIGMA = np.array([10.0, 10.0, 2.0, 2.0])
SPEED = 10.0


class Scene:
    """Tracks of sensors over some times, and whose they are."""

    def __init__(
        self, rng: np.random.Generator, size: tuple[int, int], *, spacing: float, seen: float
    ) -> None:
        n_sensors, n_objects = size
        side = spacing * SIGMA[0] * np.sqrt(n_objects)
        place = rng.uniform(0.0, side, (n_objects, 2))
        velocity = rng.normal(0.0, SPEED, (n_objects, 2))
        self.object = [
            rng.permutation(np.flatnonzero(rng.random(n_objects) < seen)) for _ in range(n_sensors)
        ]
        self.sensors = []
        for mine in self.object:
            scale = SIGMA * rng.uniform(0.7, 1.4, (len(mine), 1))
            times = np.arange(N_TIMES)[:, None, None]
            moved = place[mine] + times * velocity[mine]
            truth = np.concatenate([moved, np.broadcast_to(velocity[mine], moved.shape)], axis=2)
            error = rng.normal(size=truth.shape) * scale
            covariance = np.broadcast_to(np.eye(4) * (scale**2)[:, :, None], (*truth.shape, 4))
            self.sensors.append(TrackEstimates(truth + error, covariance))

    def pictures(self, time: int) -> dict[str, LocalPicture]:
        """Return what the sensors say at a time."""
        return {
            f"S{number}": LocalPicture(
                f"S{number}", float(time), np.arange(each.n_tracks),
                each.mean[time], each.covariance[time],
            )
            for number, each in enumerate(self.sensors)
        }  # fmt: skip

    def right(self, labels: list[np.ndarray]) -> float:
        """Return the share of tracks whose group is exactly the tracks of their object."""
        truth, label = np.concatenate(self.object), np.concatenate(labels)
        both = np.unique(np.stack([truth, label]), axis=1, return_counts=True)
        size = {"object": np.bincount(truth), "group": np.bincount(label)}
        exact = (both[1] == size["object"][both[0][0]]) & (both[1] == size["group"][both[0][1]])
        return float(both[1][exact].sum() / truth.shape[0])


def associated(scene: Scene, rng: np.random.Generator, **options: object) -> list[np.ndarray]:
    """Return the groups after all times."""
    associator = TrackAssociator(**options)  # type: ignore[arg-type]
    for time in range(N_TIMES):
        found = associator.step(float(time), scene.pictures(time), rng=rng)
    return [found.object[found.sensor == number] for number in range(len(scene.sensors))]


def compare(size: tuple[int, int], spacing: float, seen: float, seeds: range) -> list[float]:
    """Return the share of right associations of each method, in percent."""
    methods = {
        "nearest": lambda scene, _: nearest_neighbour(scene.sensors),
        "pairwise": lambda scene, _: pairwise_sequential(scene.sensors),
        "exact": lambda scene, rng: associated(scene, rng, search=Exact()),
        "default": lambda scene, rng: associated(scene, rng),
    }
    share = np.zeros((len(seeds), len(methods)))
    for row, seed in enumerate(seeds):
        scene = Scene(np.random.default_rng(seed), size, spacing=spacing, seen=seen)
        for column, method in enumerate(methods.values()):
            share[row, column] = scene.right(method(scene, np.random.default_rng(seed)))
    return [100.0 * value for value in share.mean(axis=0)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", type=int, default=3, help="scenes of 200 objects")
    parser.add_argument("--spacings", type=float, nargs="+", default=[3.0, 10.0])
    arguments = parser.parse_args()
    rows = []
    for sensors, objects, seen, spacing in product(
        (3, 5, 8), (10, 50, 200), (1.0, 0.8), arguments.spacings
    ):
        seeds = range(arguments.seeds * 200 // objects)
        shares = compare((sensors, objects), spacing, seen, seeds)
        rows.append([f"{sensors} × {objects}", f"{seen:g}", f"{spacing:g} σ",
                     *(f"{share:.1f}" for share in shares)])  # fmt: skip
    print(heading(command("fusion_baselines.py")), end="\n\n")
    head = ["sensors × objects", "seen", "spacing", "nearest neighbour %", "pairwise sequential %",
            "exact %", "default %"]  # fmt: skip
    print(table(head, rows))


if __name__ == "__main__":
    main()
