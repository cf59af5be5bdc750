"""What ranks best of each family, and what a report is worth before beliefs speak of it."""

import numpy as np
import pytest

from trackweave.association._pruning import best_of, second_gains


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
