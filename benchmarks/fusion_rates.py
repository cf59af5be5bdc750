"""How often the test of one object rejects tracks of one object, against the rate asked for.

    python benchmarks/fusion_rates.py                     # a minute or two

First with independent errors, for every statistic and number of sensors; then with tracks that
Kalman filters keep of objects with process noise, whose errors are correlated from time to time
and from sensor to sensor, for every memory and remedy.
"""

import argparse
from collections.abc import Iterator
from itertools import product

import numpy as np
from scipy.special import chdtri
from text_tables import command, heading, table

from trackweave.filters.kalman import predicted, transition, updated
from trackweave.fusion._statistic import evaluate_all
from trackweave.fusion.histories import Histories
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.statistic import Statistic, tuple_values

KINDS = ("fused-mean", "chain", "all-pairs")
RATES = (0.05, 0.01)
NOISE = 1.0
SIGMAS = (10.0, 14.0, 20.0)


def independent(kind: str, n_sensors: int, n_times: int, n_draws: int) -> list[float]:
    """Return the rates of rejection [%], and of the plain χ² threshold for sums of distances."""
    rng = np.random.default_rng(n_sensors)
    root = np.linalg.cholesky(np.eye(4) + 0.4) * rng.uniform(0.5, 2.0, (n_sensors, 1, 1))
    covariance = root @ root.swapaxes(1, 2)
    shape = (n_draws, n_times, n_sensors, 4)
    mean = 1e5 + np.einsum("sij,ktsj->ktsi", root, rng.normal(size=shape))
    spread = np.broadcast_to(covariance, (*shape, 4))
    found = []
    for rate in RATES:
        values = tuple_values(mean, spread, Statistic(kind, "full", false_rejection=rate))
        found.append(100.0 * float(np.mean(values.value > values.threshold)))
        n_terms = n_sensors * (n_sensors - 1) // 2 if kind == "all-pairs" else n_sensors - 1
        plain = chdtri(4 * n_times * n_terms, rate)
        found.append(100.0 * float(np.mean(values.value > plain)))
    return found


def pictures(n_objects: int, n_times: int, seed: int) -> Iterator[dict[str, LocalPicture]]:
    """Yield what sensors' Kalman filters know of objects driven by process noise, every second."""
    rng = np.random.default_rng(seed)
    n_sensors = len(SIGMAS)
    one = np.ones(1)
    moving, noise = (each[0] for each in transition(one, NOISE, 2))
    root = np.linalg.cholesky(noise)
    truth = np.zeros((n_objects, 4))
    # From the tracks' own first errors on, which are independent.
    start = np.diag([25.0**2, 25.0**2, 5.0**2, 5.0**2])
    means = [truth + rng.normal(size=truth.shape) * np.sqrt(np.diag(start)) for _ in SIGMAS]
    spreads = [np.tile(start, (n_objects, 1, 1)) for _ in SIGMAS]
    for time in range(n_times):
        truth = truth @ moving.T + rng.normal(size=truth.shape) @ root.T
        now = {}
        for sensor in range(n_sensors):
            mean, spread = predicted(means[sensor], spreads[sensor], np.ones(n_objects), NOISE)
            sigma = np.full((n_objects, 2), SIGMAS[sensor])
            report = truth[:, :2] + sigma * rng.normal(size=(n_objects, 2))
            means[sensor], spreads[sensor] = updated(mean, spread, report, sigma)
            now[f"S{sensor}"] = LocalPicture(
                f"S{sensor}", float(time), np.arange(n_objects), means[sensor], spreads[sensor]
            )
        yield now


def correlated(statistic: Statistic, n_objects: int = 2_000, n_times: int = 40) -> list[float]:
    """Return how often the test rejects after some updates and after all [%]."""
    histories = Histories(statistic, NOISE, 3.0, [f"S{i}" for i in range(len(SIGMAS))])
    found = []
    for time, now in enumerate(pictures(n_objects, n_times, 1)):
        live = histories.take(float(time), now)
        if time in {4, n_times - 1}:
            assert histories.rings is not None
            rows = np.ascontiguousarray(live.row.reshape(len(SIGMAS), n_objects).T)
            value, limit = np.empty((2, n_objects))
            form = statistic.form(histories.slots, 4 * n_times * len(SIGMAS) ** 2)
            evaluate_all(histories.rings, form, rows, value, limit)
            found.append(100.0 * float(np.mean(value > limit)))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--draws", type=int, default=40_000)
    parser.add_argument("--objects", type=int, default=4_000)
    arguments = parser.parse_args()
    print(heading(command("fusion_rates.py")), end="\n\n")
    rows = [
        [kind, sensors, times, *independent(kind, sensors, times, arguments.draws // times)]
        for kind, sensors, times in product(KINDS, (2, 3, 8), (1, 5))
    ]
    head = ["statistic", "sensors", "times"]
    head += [
        f"{name} at {100 * rate:g} %" for rate in RATES for name in ("rejected %", "plain χ² %")
    ]
    print(table(head, rows), end="\n\n")
    memories = {
        "the last": {"length": 1},
        "the last 5": {"length": 5},
        "fading, 0.7": {"memory": "fading", "factor": 0.7},
        "full": {"memory": "full"},
    }
    remedies = ("none", "inflated", "effective", "cross-covariance", "both")
    rows = []
    for (name, memory), remedy in product(memories.items(), remedies):
        statistic = Statistic(correlation=remedy, false_rejection=0.05, **memory)
        rows.append([name, remedy, *correlated(statistic, arguments.objects)])
    print(table(["memory", "remedy", "rejected % after 5", "after 40 updates"], rows))


if __name__ == "__main__":
    main()
