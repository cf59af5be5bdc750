"""Which tracks come of others: mothers that go on, mothers that end, and neither."""

from itertools import combinations

import numpy as np
import pytest

from trackweave.association.problem import Status
from trackweave.domain.tracks import CONFIRMED, TENTATIVE, TrackTable
from trackweave.solvers.solving import solve
from trackweave.trackers import divisions
from trackweave.trackers.divisions import divisions_of

Path = tuple[int, int, int, float, float]


def history(*paths: Path, status: dict[int, int] | None = None, seed: int = 1) -> TrackTable:
    """Return tracks that stand still but for noise: number, first and last time, x, y."""
    rng = np.random.default_rng(seed)
    rows = [
        (time, number, x + rng.normal(0.0, 0.3), y + rng.normal(0.0, 0.3))
        for number, first, last, x, y in paths
        for time in range(first, last + 1)
    ]
    table = np.array(sorted(rows))
    n = len(table)
    track = table[:, 1].astype(np.int64)
    told = [(status or {}).get(number, CONFIRMED) for number in track.tolist()]
    mean = np.concatenate([table[:, 2:], np.zeros((n, 2))], axis=1)
    covariance = np.tile(np.eye(4), (n, 1, 1))
    return TrackTable(
        table[:, 0], track, np.array(told), mean, covariance, np.zeros(n), np.ones(n, np.int64),
        table[:, 0],
    )  # fmt: skip


# Far from each other, so that the room is wide.
FRAME = ((91, 0, 60, 0.0, 0.0), (92, 0, 60, 900.0, 900.0), (93, 0, 60, 900.0, 0.0))


def told(table: TrackTable, **how: object) -> list[tuple[int, float, tuple[int, ...]]]:
    found = divisions_of(table, **how).found
    return [(one.mother, one.time, one.daughters) for one in found]


def test_a_mother_that_goes_on_under_her_name_has_one_new_daughter():
    table = history(*FRAME, (1, 0, 60, 300.0, 300.0), (2, 20, 60, 308.0, 300.0))
    assert told(table) == [(1, 20.0, (2,))]


def test_a_mother_that_ends_has_both_daughters():
    pair = (1, 0, 19, 300.0, 300.0), (2, 20, 60, 306.0, 300.0), (3, 21, 60, 293.0, 300.0)
    assert told(history(*FRAME, *pair)) == [(1, 20.0, (2, 3))]


def test_an_end_and_one_beginning_are_no_division():
    one = (1, 0, 19, 300.0, 300.0), (2, 20, 60, 306.0, 300.0)
    assert told(history(*FRAME, *one)) == []


def test_daughters_divide_again():
    table = history(
        *FRAME, (1, 0, 60, 300.0, 300.0), (2, 20, 60, 308.0, 300.0), (3, 40, 60, 315.0, 300.0)
    )
    assert told(table) == [(1, 20.0, (2,)), (2, 40.0, (3,))]


def test_nobody_divides_twice_at_once():
    table = history(
        *FRAME, (1, 0, 60, 300.0, 300.0), (2, 20, 60, 307.0, 300.0), (3, 20, 60, 300.0, 307.0)
    )
    assert len(told(table)) == 1


@pytest.mark.parametrize("seed", range(6))
def test_births_all_over_the_room_are_no_daughters(seed):
    rng = np.random.default_rng(seed)
    paths = [
        (number, int(rng.integers(0, 50)), 60, *rng.uniform(0.0, 900.0, 2).tolist())
        for number in range(1, 25)
    ]
    assert told(history(*paths, *FRAME)) == []


def test_tentative_tracks_and_those_known_before_are_no_daughters():
    table = (*FRAME, (1, 0, 60, 300.0, 300.0), (2, 20, 60, 308.0, 300.0))
    assert told(history(*table, status={2: TENTATIVE})) == []
    assert told(history(*table), known=[2]) == []


def test_rate_and_spread_are_what_the_record_shows():
    rng = np.random.default_rng(3)
    paths: list[Path] = [*FRAME]
    for number in range(40):
        x, y = rng.uniform(50.0, 850.0, 2)
        dx, dy = rng.normal(0.0, 6.0, 2)
        paths.append((2 * number + 1, 0, 60, x, y))
        paths.append((2 * number + 2, int(rng.integers(5, 55)), 60, x + dx, y + dy))
    table = history(*paths)
    found = divisions_of(table)
    assert len(found.found) >= 36
    assert found.rate == pytest.approx(40 / len(table), rel=0.15)
    assert found.spread == pytest.approx(6.0, rel=0.15)
    assert found.certificate.status is Status.OPTIMAL


def test_a_birth_density_that_is_told_counts():
    table = history(*FRAME, (1, 0, 60, 300.0, 300.0), (2, 20, 60, 308.0, 300.0))
    assert told(table, birth_density=1.0) == []
    assert told(table, birth_density=1e-9) == [(1, 20.0, (2,))]


@pytest.mark.parametrize("seed", range(8))
def test_no_choice_of_offers_costs_less(seed):
    rng = np.random.default_rng(seed)
    offers = []
    for _ in range(9):
        mother = int(rng.integers(1, 4))
        children = rng.choice(5, int(rng.integers(1, 3)), replace=False).tolist()
        time = float(rng.integers(2)) if len(children) == 1 else None
        offers.append((((mother, time), tuple(children)), -float(rng.uniform(0.5, 9.0))))

    def is_allowed(chosen):
        slots = [slot for (slot, _), _ in chosen]
        children = [child for (_, several), _ in chosen for child in several]
        return len(set(slots)) == len(slots) and len(set(children)) == len(children)

    best = min(
        sum(cost for _, cost in chosen)
        for count in range(len(offers) + 1)
        for chosen in combinations(offers, count)
        if is_allowed(chosen)
    )
    answer = solve(divisions._problem(offers, 5))
    assert answer.cost == pytest.approx(best)
    assert answer.status is Status.OPTIMAL


def test_nothing_comes_of_nothing():
    assert told(TrackTable.empty(2)) == []
    assert told(history((1, 0, 0, 5.0, 5.0))) == []
    assert told(history((1, 0, 9, 5.0, 5.0))) == []
