"""Whether fused estimates are as good as they say, and better than the best sensor's.

    python benchmarks/fusion_consistency.py               # some seconds

First estimates of one object whose errors are independent: NEES of the convex combination, which
should be the state's length. Then errors that are correlated from sensor to sensor: nothing may
ever be over-confident that does not know of it. Then tracks that Kalman filters keep of objects
with process noise, beside one filter that has all reports.
"""

import argparse
from typing import Any

import numpy as np
from scipy.special import chdtri
from text_tables import command, heading, table

from trackweave.filters.kalman import predicted, transition, updated
from trackweave.fusion.combine import COMBINATIONS, Combination, SharedPrior

Estimates = tuple[np.ndarray, np.ndarray]

SIGMAS = (10.0, 14.0, 20.0)
CORRELATIONS = (0.0, 0.3, 0.6, 0.9)
UNINFORMED = COMBINATIONS[:3]
BURN_IN = 10


def covariances(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return covariances of all shapes and sizes, (count, 4, 4)."""
    root = rng.normal(size=(count, 4, 6)) * np.exp(0.5 * rng.normal(size=(count, 4, 1)))
    return np.asarray(root @ root.swapaxes(1, 2))


def nees(error: np.ndarray, spread: np.ndarray) -> float:
    """Return the mean normalised squared error, in parts of what it should be."""
    weighted = np.linalg.solve(spread, error[:, :, None])[:, :, 0]
    return float(np.einsum("ri,ri->r", error, weighted).mean() / error.shape[1])


def bounds(n_draws: int, size: int = 4) -> tuple[float, float]:
    """Return between which values a consistent NEES lies 99 times of 100, in the same parts."""
    number = n_draws * size
    return float(chdtri(number, 0.995) / number), float(chdtri(number, 0.005) / number)


def drawn(n_sensors: int, correlation: float, method: str, n_draws: int) -> tuple[float, float]:
    """Return the NEES, and the greatest true variance in parts of the reported one."""
    rng = np.random.default_rng(n_sensors)
    covariance = covariances(rng, n_draws * n_sensors)
    root = np.linalg.cholesky(covariance).reshape(n_draws, n_sensors, 4, 4)
    shared = correlation * np.ones((n_sensors, n_sensors))
    shared += (1.0 - correlation) * np.eye(n_sensors)
    noise = np.einsum("st,rti->rsi", np.linalg.cholesky(shared), rng.normal(size=root.shape[:3]))
    error = np.einsum("rsij,rsj->rsi", root, noise).reshape(-1, 4)
    start = np.arange(0, n_draws * n_sensors + 1, n_sensors)
    how = Combination(method)
    mean, spread = how(error, covariance, start)
    information = np.linalg.inv(covariance)
    weight = how.weights(information, start)
    gain = (weight[:, None, None] * information).reshape(n_draws, n_sensors, 4, 4) @ root
    gain = spread[:, None] @ gain
    true = np.einsum("st,rsij,rtkj->rik", shared, gain, gain)
    narrow = np.linalg.inv(np.linalg.cholesky(spread))
    worst = np.linalg.eigvalsh(narrow @ true @ narrow.swapaxes(1, 2))[:, -1].max()
    return nees(mean, spread), float(worst)


def followed(n_objects: int, n_times: int, noise: float) -> dict[str, list[float]]:
    """Return RMSE of the position [m], its reported size [m] and NEES, of each way to know."""
    rng = np.random.default_rng(1)
    moving, turbulence = (each[0] for each in transition(np.ones(1), noise, 2))
    root = np.linalg.cholesky(turbulence + 1e-12 * np.eye(4))
    first = np.tile(np.diag([50.0**2, 50.0**2, 10.0**2, 10.0**2]), (n_objects, 1, 1))
    truth = rng.normal(size=(n_objects, 4)) * [50.0, 50.0, 10.0, 10.0]
    tracks: list[Estimates] = [(np.zeros((n_objects, 4)), first) for _ in SIGMAS]
    central = fused = tracks[0]
    found: dict[str, list[list[float]]] = {}
    for time in range(n_times):
        truth = truth @ moving.T + rng.normal(size=truth.shape) @ root.T
        reports = [truth[:, :2] + s * rng.normal(size=(n_objects, 2)) for s in SIGMAS]
        before = [ahead(track, noise) for track in tracks]
        central, foreseen = ahead(central, noise), ahead(fused, noise)
        sigmas = [np.full((n_objects, 2), s) for s in SIGMAS]
        tracks = [updated(*t, z, s) for t, z, s in zip(before, reports, sigmas, strict=True)]
        for report, sigma in zip(reports, sigmas, strict=True):
            central = updated(*central, report, sigma)
        prior = SharedPrior(*foreseen, *together(before))
        start = np.arange(0, len(SIGMAS) * n_objects + 1, len(SIGMAS))
        ways = {method: Combination(method)(*together(tracks), start) for method in UNINFORMED}
        fused = Combination("information-matrix")(*together(tracks), start, prior)
        ways |= {"information-matrix": fused, "one filter with all reports": central}
        ways = {"best sensor alone": tracks[0], **ways}
        for name, (mean, spread) in ways.items():
            if time >= BURN_IN:
                error = mean - truth
                squares = [np.square(error[:, :2]).sum(1).mean()]
                squares.append(np.trace(spread[:, :2, :2], axis1=1, axis2=2).mean())
                found.setdefault(name, []).append([*squares, nees(error, spread)])
    means = {name: np.mean(rows, axis=0) for name, rows in found.items()}
    return {name: [*np.sqrt(row[:2]), row[2]] for name, row in means.items()}


def ahead(track: Estimates, noise: float) -> Estimates:
    return predicted(*track, np.ones(track[0].shape[0]), noise)


def together(tracks: list[Estimates]) -> Estimates:
    """Return the estimates of all sensors, those of an object one after the other."""
    means, spreads = (np.stack(each, axis=1) for each in zip(*tracks, strict=True))
    return means.reshape(-1, 4), spreads.reshape(-1, 4, 4)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--draws", type=int, default=4_000)
    parser.add_argument("--objects", type=int, default=400)
    arguments = parser.parse_args()
    print(heading(command("fusion_consistency.py")), end="\n\n")
    low, high = bounds(arguments.draws)
    rows: list[list[Any]] = []
    for n_sensors in (2, 3, 5, 8):
        value = drawn(n_sensors, 0.0, "convex", arguments.draws)[0]
        rows.append(
            [n_sensors, f"{value:.3f}", f"{low:.3f} to {high:.3f}",
             "yes" if low < value < high else "NO"]
        )  # fmt: skip
    print(table(["sensors", "NEES ÷ n, convex, independent", "99 % bounds", "within"], rows))
    print()
    rows = []
    for n_sensors in (2, 3, 5):
        for correlation in CORRELATIONS:
            pairs = [drawn(n_sensors, correlation, m, arguments.draws) for m in UNINFORMED]
            rows.append([n_sensors, correlation, *(f"{v:.2f}" for pair in pairs for v in pair)])
    head = [f"{m}: {what}" for m in UNINFORMED for what in ("NEES ÷ n", "worst variance ratio")]
    print(table(["sensors", "correlation", *head], rows), end="\n\n")
    rows = []
    for noise in (0.0, 0.1, 1.0, 10.0):
        for name, values in followed(arguments.objects, 50, noise).items():
            rows.append([noise, name, *values])
    print(table(["process noise m²/s³", "estimate", "RMSE m", "reported m", "NEES ÷ n"], rows))


if __name__ == "__main__":
    main()
