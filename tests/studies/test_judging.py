"""Intervals and verdicts."""

import numpy as np
import pytest
from scipy import stats

from trackweave.studies.judging import (
    Interval,
    Verdict,
    at_least,
    at_most,
    mean_of,
    share_of,
    verdict_of,
)


def test_a_mean_has_students_interval() -> None:
    values = np.array([3.0, 5.0, np.nan, 4.0, 8.0])
    known = values[np.isfinite(values)]
    low, high = stats.t.interval(0.95, 3, loc=known.mean(), scale=stats.sem(known))
    found = mean_of(values, "m")
    assert (found.value, found.count, found.unit) == (5.0, 4, "m")
    assert (found.low, found.high) == pytest.approx((low, high))


def test_no_mean_of_shares_is_told_beyond_what_a_share_can_be() -> None:
    found = mean_of(np.array([80.0, 100.0]), "%")
    assert (found.value, found.low, found.high) == (90.0, 0.0, 100.0)
    assert mean_of(np.array([80.0, 100.0]), "m").high > 100.0


@pytest.mark.parametrize("values", [[], [np.nan], [2.0]])
def test_one_draw_or_none_tells_nothing_of_the_others(values: list[float]) -> None:
    found = mean_of(np.array(values))
    assert (found.low, found.high) == (-np.inf, np.inf)
    assert at_least(found, 1.0) is Verdict.CANNOT_BE_TOLD
    assert at_most(found, 1.0) is Verdict.CANNOT_BE_TOLD


@pytest.mark.parametrize(("hits", "count"), [(0, 10), (10, 10), (3, 10), (299, 300)])
def test_a_share_has_the_exact_binomial_interval(hits: int, count: int) -> None:
    exact = stats.binomtest(hits, count).proportion_ci(0.95, method="exact")
    found = share_of(hits, count)
    assert (found.low, found.high) == pytest.approx((100 * exact.low, 100 * exact.high))
    assert found.value == pytest.approx(100 * hits / count)


def test_nothing_counted_is_no_share() -> None:
    assert str(share_of(0, 0)) == "not measured"
    assert at_least(share_of(0, 0), 5.0) is Verdict.CANNOT_BE_TOLD


@pytest.mark.parametrize(
    ("low", "high", "verdict"),
    [
        (5.0, 9.0, Verdict.HOLDS),
        (4.0, 9.0, Verdict.HOLDS_WITHIN),
        (3.9, 9.0, Verdict.CANNOT_BE_TOLD),
        (1.0, 4.0, Verdict.CANNOT_BE_TOLD),
        (1.0, 3.9, Verdict.DOES_NOT_HOLD),
    ],
)
def test_a_verdict_respects_the_whole_interval(low: float, high: float, verdict: Verdict) -> None:
    middle = (low + high) / 2
    assert at_least(Interval(middle, low, high, 9), 5.0, tolerance=1.0) is verdict
    assert at_most(Interval(-middle, -high, -low, 9), -5.0, tolerance=1.0) is verdict


def test_what_is_counted_or_proven_holds_or_does_not() -> None:
    assert verdict_of(True) is Verdict.HOLDS
    assert verdict_of(False) is Verdict.DOES_NOT_HOLD


def test_a_figure_is_shown_with_its_interval_and_number_of_draws() -> None:
    assert str(Interval(99.28, 99.06, 99.5, 30, "%")) == "99.28 % (99.06 to 99.5, n = 30)"
