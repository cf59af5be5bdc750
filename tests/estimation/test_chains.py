"""What lines up beyond chance, and what chance lines up by itself."""

import numpy as np
import pytest

from trackweave.estimation.chains import chains_of, speed_of_few
from trackweave.estimation.frames import Frames


def unrelated(dim: int, count: int, seed: int, n_scans: int = 24) -> Frames:
    rng = np.random.default_rng(seed)
    return Frames(np.arange(n_scans) * 1.0, [rng.random((count, dim)) for _ in range(n_scans)])


@pytest.mark.parametrize(("dim", "count"), [(2, 50), (2, 200), (3, 200)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_unrelated_reports_are_no_chains(dim, count, seed) -> None:
    assert chains_of([unrelated(dim, count, seed)], 0.05, float(count)) is None


def drones(seed: int, *, n_clutter: int = 12) -> tuple[Frames, float]:
    """Five that fly straight at 5 to 18 m/s, noise 12 m, P_D 0.65, in a kilometre's half-space."""
    rng, places = np.random.default_rng(seed), []
    size = np.array([2000.0, 2000.0, 400.0])
    start, heading = rng.uniform(0.3, 0.7, (5, 3)) * size, rng.uniform(0.0, 2 * np.pi, 5)
    speed = np.linspace(5.0, 18.0, 5)
    velocity = np.column_stack([np.sin(heading), np.cos(heading), 0.0 * heading]) * speed[:, None]
    for scan in range(60):
        seen = start + scan * velocity + rng.normal(0.0, 12.0, start.shape)
        own = seen[rng.random(5) < 0.65]
        places.append(np.concatenate([own, rng.uniform(0.0, 1.0, (n_clutter, 3)) * size]))
    return Frames(np.arange(60) * 1.0, places), (n_clutter + 3.25) / np.prod(size)


@pytest.mark.parametrize("seed", range(4))
def test_chains_are_of_objects_where_most_reports_are_of_nobody(seed) -> None:
    frames, density = drones(seed)
    chains = chains_of([frames], 66.0, density)
    assert chains is not None
    assert np.quantile(chains.speed, 0.75) < 27.0
    assert 8.0 < np.sqrt(np.median(chains.residual)) < 18.0


def test_a_row_of_posts_is_no_fast_object() -> None:
    """Seen one after the other, posts 15 m apart would be an object of 150 m/s."""
    rng, places = np.random.default_rng(5), []
    posts = np.column_stack([np.full(12, 11.0), 40.0 + 15.0 * np.arange(12)])
    for scan in range(60):
        seen = posts[rng.random(12) < 0.3]
        if scan % 12 < 7:
            # By chance, or as a car passes them.
            seen = np.vstack([seen, posts[scan % 12 : scan % 12 + 1]])
        cars = np.array([[0.0, 20.0 + 25.0 * 0.1 * scan], [4.0, 190.0 - 22.0 * 0.1 * scan]])
        both = np.concatenate([seen, cars])
        places.append(both + rng.normal(0.0, 0.5, both.shape))
    frames = Frames(np.arange(60) * 0.1, places)
    few = speed_of_few([frames], 60.0, 9.0 / (20.0 * 220.0))
    assert few is None or few < 40.0


def test_a_few_among_many_slow_ones_tell_the_greatest_speed() -> None:
    """Of twenty that drift one in five is thrice as fast, in steps far beyond the noise."""
    rng, places = np.random.default_rng(3), []
    start = rng.uniform(0.1, 0.5, (20, 2))
    velocity = np.tile([0.004, 0.0], (20, 1))
    velocity[:4] *= 3.0
    for scan in range(40):
        seen = start + scan * velocity
        seen = seen[rng.random(20) < 0.9]
        both = np.concatenate([seen, rng.random((6, 2))])
        places.append(both + rng.normal(0.0, 0.0003, both.shape))
    found = speed_of_few([Frames(np.arange(40) * 1.0, places)], 0.02, 24.0)
    assert found == pytest.approx(0.012, rel=0.1)
