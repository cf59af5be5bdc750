"""What ranks best of each family, what a report is worth, and what is negligible."""

from itertools import combinations

import numpy as np
import pytest

from trackweave.association._nodes import new_families
from trackweave.association._pruning import best_of, forget_least, second_gains, sum_below
from trackweave.association.growth_limits import GrowthLimits
from trackweave.association.pruning import Offer, bounds_of, silence_beside


@pytest.mark.parametrize("seed", range(5))
def test_the_best_of_each_family_is_the_first_of_its_least(seed):
    rng = np.random.default_rng(seed)
    family = rng.integers(0, 6, size=30)
    rank = rng.integers(0, 8, size=30).astype(float)
    rank[rng.random(30) < 0.3] = np.inf
    best = best_of(family, rank, 8)
    for number in range(8):
        own = np.flatnonzero((family == number) & np.isfinite(rank))
        wanted = own[np.argmin(rank[own])] if own.size else -1
        assert best[number] == wanted


@pytest.mark.parametrize("seed", range(20))
def test_a_report_is_worth_what_it_gains_the_second_of_those_that_want_it(seed):
    rng = np.random.default_rng(seed)
    family, report = rng.integers(0, 4, size=40), rng.integers(0, 7, size=40)
    rank, without = rng.normal(scale=5.0, size=40), rng.normal(scale=5.0, size=4)
    found = second_gains(family, report, rank, without, 9)
    for index in range(9):
        gains = [
            max((without[own] - rank[(family == own) & (report == index)]).tolist(), default=0.0)
            for own in range(4)
        ]
        assert found[index] == max(0.0, sorted(gains)[-2])


def forgotten_of(parent, family, probability, kept, most):
    """Return what is kept, and how much of each family is forgotten."""
    kept, gone = kept | (parent < 0), np.zeros(family.max() + 1)
    order = parent.size - 1 - np.argsort(sum_below(parent, probability)[::-1], kind="stable")
    forget_least(order, parent, family, probability, kept, gone, most)
    return kept, gone


@pytest.mark.parametrize("seed", range(10))
def test_of_sequences_side_by_side_as_many_are_forgotten_as_can_be(seed):
    """By brute force: no choice of more of them is as improbable."""
    rng = np.random.default_rng(seed)
    n, most = 9, 0.2
    probability = np.concatenate([[0.5], rng.dirichlet(np.full(n, 0.5))])
    parent = np.array([-1, *[0] * n])
    fixed = rng.random(n + 1) < 0.2
    kept, gone = forgotten_of(parent, np.zeros(n + 1, np.int64), probability, fixed, most)
    free = probability[1:][~fixed[1:]]
    wanted = max(
        count
        for count in range(free.size + 1)
        if any(sum(some) <= most for some in combinations(free, count))
    )
    assert np.count_nonzero(~kept) == wanted
    assert gone[0] == pytest.approx(probability[~kept].sum())


@pytest.mark.parametrize("seed", range(10))
def test_what_is_forgotten_leaves_sequences_whole_and_nothing_more_could_go(seed):
    rng = np.random.default_rng(seed)
    n, n_families, most = 60, 4, 0.1
    parent, family = np.full(n, -1), np.arange(n) % n_families
    for node in range(n_families, n):
        own = np.flatnonzero(family[:node] == family[node])
        parent[node] = rng.choice(own)
    probability = rng.random(n) ** 6
    probability /= np.bincount(family, probability)[family]
    fixed = rng.random(n) < 0.05
    kept, gone = forgotten_of(parent, family, probability, fixed, most)
    assert kept[fixed | (parent < 0)].all()
    has_parent = kept & (parent >= 0)
    assert kept[parent[has_parent]].all()
    np.testing.assert_allclose(gone, np.bincount(family, probability * ~kept, n_families))
    assert gone.max() <= most
    leaves = np.setdiff1d(np.flatnonzero(kept & ~fixed & (parent >= 0)), parent[kept])
    assert np.all(gone[family[leaves]] + probability[leaves] > most)


def test_silence_of_all_sensors_but_one_may_mean_that_they_cannot_see():
    assert silence_beside(np.empty(0)) == 0.0
    assert silence_beside(np.array([0.3])) == 0.0
    assert silence_beside(np.array([0.1, 0.5, 0.3])) == pytest.approx(-np.log(0.1 * 0.3))


def test_what_begins_where_one_sensor_sees_alone_may_lie_higher():
    """Its own misses and the others' silence together are above the limit for one sensor."""
    nothing = np.empty(0)
    offer = Offer(np.zeros(1, int), np.full(1, -1), np.array([8.0]), np.array([2.0]), nothing)
    families = new_families(np.array([-1]), np.array([2.0]))
    limits = GrowthLimits(new_margin=30.0)
    for silence, is_open in ((0.0, False), (3.0, True)):
        bound, _, is_new = bounds_of(offer, np.zeros(1, int), families, limits, silence)
        assert is_new.tolist() == [True]
        assert (offer.alive[0] <= bound[0]) == is_open
        assert bound[0] == 2.0 + limits.new_ceiling + silence
