"""Whether a sensor's shift, turn and clock are recovered within what is said of their errors.

    python benchmarks/fusion_registration.py              # two or three minutes

Two sensors track the same objects; the second is 1,000 m too far east and 300 m too far south,
turned by 2° and half a second late. Then association with the bias, after registration and
without any bias; then what the tracks cannot tell, and what is said of it.
"""

import argparse
import time
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtri
from text_tables import command, heading, table

from trackweave.filters.kalman import predicted, updated
from trackweave.fusion.associator import TrackAssociator
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.bias_fit import NotObservableError
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.registration import Registration, register

BEGUN = 2
"""Updates before a track is reported."""
NUMBERS = ("east m", "north m", "turn °", "clock s")
UNITS = np.array([1.0, 1.0, 180.0 / np.pi, 1.0])
LONE = 1_000


@dataclass(frozen=True)
class Case:
    """A scene: how many objects, how many of them each sensor sees, how they move."""

    name: str
    n_objects: int = 10
    seen: float = 1.0
    extent: float = 40e3
    speed: tuple[float, float] = (100.0, 300.0)
    headings: float = 2.0 * np.pi
    noise: float = 0.5
    sigma: float = 50.0
    n_times: int = 28
    shift: tuple[float, float] = (1000.0, -300.0)
    turn: float = np.deg2rad(2.0)
    late: float = 0.5
    period: float = 4.0

    @property
    def bias(self) -> np.ndarray:
        """The numbers that are estimated by default."""
        return np.array([*self.shift, self.turn, self.late])


class Scene(NamedTuple):
    """Pictures of both sensors and the right pairs."""

    reference: list[LocalPicture]
    other: list[LocalPicture]
    pairs: np.ndarray


CASES = (
    Case("10 objects"),
    Case("50 objects", n_objects=50),
    Case("20 objects, 80 % seen by each", n_objects=20, seen=0.8),
    Case("10 ships, 5 km, σ 10 m", extent=5e3, speed=(3.0, 15.0), noise=0.01, sigma=10.0),
    Case("10 objects, no process noise", noise=0.0),
    Case("10 objects, 10 m²/s³", noise=10.0),
)


def scene(case: Case, seed: int) -> Scene:
    """Simulate both sensors' reports and track them."""
    rng = np.random.default_rng(seed)
    n = case.n_objects
    heading, speed = rng.uniform(0.0, case.headings, n), rng.uniform(*case.speed, n)
    velocity = speed[:, None] * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    state = np.concatenate([rng.uniform(-0.5, 0.5, (n, 2)) * case.extent, velocity], axis=1)
    sees = [rng.random(n) < case.seen for _ in range(2)]
    numbers = rng.permutation(n) + 1, rng.permutation(n) + LONE
    cos, sin = np.cos(case.turn), np.sin(case.turn)
    clockwise = np.array([[cos, sin], [-sin, cos]])
    first = np.diag([case.sigma**2] * 2 + [case.speed[1] ** 2] * 2)
    sigma = np.full((n, 2), case.sigma)
    pictures: tuple[list[LocalPicture], ...] = ([], [])
    tracks: list[tuple[np.ndarray, np.ndarray]] = []
    for k in range(case.n_times + BEGUN):
        late = moved(state, case.period - case.late, case.noise, rng)
        state = moved(late, case.late, case.noise, rng)
        places = state[:, :2], late[:, :2] @ clockwise.T + case.shift
        reports = [place + case.sigma * rng.normal(size=(n, 2)) for place in places]
        if tracks:
            interval = np.full(n, case.period)
            foreseen = [predicted(*track, interval, case.noise) for track in tracks]
            tracks = [updated(*f, z, sigma) for f, z in zip(foreseen, reports, strict=True)]
        else:
            still = [np.concatenate([z, np.zeros((n, 2))], axis=1) for z in reports]
            tracks = [(mean, np.tile(first, (n, 1, 1))) for mean in still]
        for side in range(2) if k >= BEGUN else ():
            mine = sees[side]
            mean, spread = tracks[side]
            pictures[side].append(
                LocalPicture(
                    "AB"[side], k * case.period, numbers[side][mine], mean[mine], spread[mine]
                )
            )
    both = sees[0] & sees[1]
    return Scene(*pictures, np.stack([numbers[0][both], numbers[1][both]], axis=1))


def moved(state: np.ndarray, interval: float, noise: float, rng: Any) -> np.ndarray:
    n = state.shape[0]
    mean, spread = predicted(state, np.zeros((n, 4, 4)), np.full(n, interval), noise)
    root = np.linalg.cholesky(spread + 1e-12 * np.eye(4))
    return np.asarray(mean + np.einsum("rij,rj->ri", root, rng.normal(size=mean.shape)))


def recovered(case: Case, seeds: int, *, is_told: bool) -> tuple[list[Any], list[list[Any]]]:
    """Return a line on all numbers together, and a line on each."""
    errors, sigmas, squared, cpu = [], [], [], []
    refused = wrong = 0
    for seed in range(seeds):
        made = scene(case, seed)
        start = time.process_time()
        try:
            found = register(
                made.reference, made.other, process_noise=case.noise,
                pairs=made.pairs if is_told else None,
            )  # fmt: skip
        except NotObservableError:
            refused += 1
            continue
        cpu.append(time.process_time() - start)
        wrong += set(map(tuple, found.pairs)) != set(map(tuple, made.pairs))
        known = found.sigma > 0.0
        error = found.bias[known] - case.bias
        spread = found.covariance[np.ix_(known, known)]
        errors.append(error)
        sigmas.append(found.sigma[known])
        squared.append(float(error @ np.linalg.solve(spread, error)))
    n = len(squared)
    low, high = (chdtri(4 * n, p) / n for p in (0.995, 0.005))
    off = np.abs(errors) / np.array(sigmas)
    ways = "told" if is_told else "found"
    line = [
        case.name, ways, n, refused, wrong, f"{np.mean(squared):.2f}", f"{low:.2f} to {high:.2f}",
        f"{100 * np.mean(off <= 3.0):.1f}", f"{100 * np.mean((off <= 3.0).all(axis=1)):.0f}",
        float(off.max()), 1e3 * float(np.median(cpu)),
    ]  # fmt: skip
    rms = np.sqrt(np.mean(np.square(errors), axis=0)) * UNITS
    middle = np.median(sigmas, axis=0) * UNITS
    mean = np.mean(errors, axis=0) * UNITS
    each = [
        [
            case.name,
            ways,
            name,
            *(f"{v[i]:.3g}" for v in (mean, rms, middle)),
            float(off[:, i].max()),
        ]
        for i, name in enumerate(NUMBERS)
    ]
    return line, each


def associated(case: Case, seeds: int) -> list[Any]:
    """Return how many pairs are right with the bias, registered, and without any bias [%]."""
    shares: dict[str, list[float]] = {"biased": [], "registered": [], "unbiased": []}
    for seed in range(seeds):
        made = scene(case, seed)
        found = register(made.reference, made.other, process_noise=case.noise)
        clean = scene(replace(case, shift=(0.0, 0.0), turn=0.0, late=0.0), seed)
        ways = {
            "biased": made,
            "registered": made._replace(other=[found.apply(p) for p in made.other]),
            "unbiased": clean,
        }
        for name, way in ways.items():
            shares[name].append(right_pairs(way, case.noise, seed))
    return [case.name, seeds, *(f"{100 * np.mean(values):.2f}" for values in shares.values())]


def right_pairs(made: Scene, noise: float, seed: int) -> float:
    """Return the share of objects whose tracks are together at the end, and with no others."""
    associator = TrackAssociator(sensors=("A", "B"), process_noise=noise)
    rng = np.random.default_rng(seed)
    for reference, other in zip(made.reference, made.other, strict=True):
        answer = associator.step(reference.time, {"A": reference, "B": other}, rng=rng)
    tuples = answer.tuples()
    return float(np.mean([(int(a), int(b)) in tuples for a, b in made.pairs]))


def refusals(seed: int = 1) -> list[list[str]]:
    """Return what registration says where tracks do not tell."""
    alike = Case("", headings=0.0, speed=(200.0, 200.0), noise=0.001, turn=0.0)
    one = Case("", n_objects=1)
    lone = replace(CASES[0], name="")
    cases = {
        "all objects at one velocity": (alike, BiasModel(), True),
        "one object": (one, BiasModel(), True),
        "another scene's tracks": (lone, BiasModel(), False),
    }
    rows = []
    for name, (case, model, is_told) in cases.items():
        made = scene(case, seed)
        other = made.other if is_told else scene(case, seed + 100).other
        pairs = made.pairs if is_told else None
        rows.append([name, outcome(made.reference, other, case.noise, model, pairs)])
    made = scene(alike, seed)
    known = BiasModel(prior={"clock": 0.5})
    answer = outcome(made.reference, made.other, alike.noise, known, made.pairs)
    return [*rows, ["all objects at one velocity, clock known to 0.5 s", answer]]


def outcome(reference: Any, other: Any, noise: float, model: BiasModel, pairs: Any) -> str:
    try:
        found: Registration = register(
            reference, other, process_noise=noise, model=model, pairs=pairs
        )
    except NotObservableError as error:
        return str(error)
    values = zip(found.names, found.bias, found.sigma, strict=True)
    return ", ".join(f"{name} {value:.3g} ± {sigma:.2g}" for name, value, sigma in values if sigma)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seeds", type=int, default=100)
    arguments = parser.parse_args()
    print(heading(command("fusion_registration.py")), end="\n\n")
    lines, numbers = [], []
    for case in CASES:
        for is_told in (True, False) if case is CASES[0] else (False,):
            line, each = recovered(case, arguments.seeds, is_told=is_told)
            lines.append(line)
            numbers += each if case in CASES[:2] and not is_told else []
    head = ["scene", "pairs", "seeds", "refused", "wrong pairs", "NEES, should be 4",
            "99 % bounds", "numbers within 3σ %", "seeds with all four %", "worst, σ",
            "CPU ms"]  # fmt: skip
    print(table(head, lines), end="\n\n")
    head = ["scene", "pairs", "number", "mean error", "RMS error", "its σ", "worst, σ"]
    print(table(head, numbers), end="\n\n")
    rows = [associated(case, max(1, arguments.seeds // 4)) for case in CASES[:3]]
    print(table(["scene", "seeds", "right with the bias %", "registered %", "no bias %"], rows))
    print()
    print(table(["tracks", "what registration says"], refusals()))


if __name__ == "__main__":
    main()
