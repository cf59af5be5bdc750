"""Tracks of several sensors, chained by the distances of neighbours."""

from itertools import pairwise, permutations, product

import numpy as np
import pytest
from scipy.stats import chi2

from trackweave.association.chain_rule import (
    Chains,
    TrackEstimates,
    accumulated_distance,
    complete_chains,
    same_object_threshold,
    track_chains,
)
from trackweave.association.problem import Status
from trackweave.errors import InvalidInputError
from trackweave.solvers import Exact, solve


def estimates(
    rng: np.random.Generator, n_tracks: int, *, n_times: int = 1, dim: int = 2, spread: float = 5.0
) -> TrackEstimates:
    """Return tracks at random places with random covariances."""
    root = rng.normal(size=(n_times, n_tracks, dim, dim))
    covariance = root @ np.swapaxes(root, -1, -2) + np.eye(dim)
    return TrackEstimates(spread * rng.normal(size=(n_times, n_tracks, dim)), covariance)


def at(places: list[list[float]], variance: float = 0.5) -> TrackEstimates:
    """Return tracks at these places, equally sure of each axis."""
    mean = np.array(places, dtype=float).reshape(len(places), 2)
    return TrackEstimates(mean, np.tile(variance * np.eye(2), (len(places), 1, 1)))


def answer_of(chains: Chains) -> tuple[float, set[tuple[int, ...]]]:
    """Return the optimum, and the tuples of two tracks and more in it."""
    problem = chains.problem()
    answer = solve(problem, Exact(), rng=np.random.default_rng(0))
    assert answer.status is Status.OPTIMAL
    assert problem.row is not None
    chosen = chains.tuples[problem.row[answer.nodes]]
    return answer.cost, {tuple(row) for row in chosen.tolist() if np.count_nonzero(row) > 1}


def test_the_distance_is_that_of_a_hand_computed_pair() -> None:
    first = TrackEstimates([[1.0, 2.0]], [[[2.0, 0.5], [0.5, 1.0]]])
    second = TrackEstimates([[3.0, 1.0]], [[[1.0, -0.5], [-0.5, 2.0]]])
    # C = diag(3, 3), t = (-2, 1): (4 + 1) / 3.
    assert accumulated_distance(first, second) == pytest.approx(5.0 / 3.0)


def test_covariances_that_turn_count_as_they_lie() -> None:
    first = TrackEstimates([[0.0, 0.0]], [[[1.0, 0.5], [0.5, 1.0]]])
    second = TrackEstimates([[1.0, 1.0]], [[[1.0, 0.5], [0.5, 1.0]]])
    # C = [[2, 1], [1, 2]], C⁻¹ = [[2, -1], [-1, 2]] / 3, t = -(1, 1): 2 / 3.
    assert accumulated_distance(first, second) == pytest.approx(2.0 / 3.0)


def test_the_recursion_over_times_is_the_closed_sum() -> None:
    rng = np.random.default_rng(1)
    first, second = estimates(rng, 3, n_times=4, dim=3), estimates(rng, 5, n_times=4, dim=3)
    recursive = np.zeros((3, 5))
    for time in range(4):
        for i, j in product(range(3), range(5)):
            t = first.mean[time, i] - second.mean[time, j]
            c = first.covariance[time, i] + second.covariance[time, j]
            recursive[i, j] += t @ np.linalg.inv(c) @ t
    assert accumulated_distance(first, second) == pytest.approx(recursive)


def test_large_lists_are_taken_block_by_block(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    first, second = estimates(rng, 7), estimates(rng, 5)
    whole = accumulated_distance(first, second)
    monkeypatch.setattr("trackweave.association.chain_rule._BLOCK", 40)
    assert accumulated_distance(first, second) == pytest.approx(whole, rel=1e-12)


def test_the_threshold_is_that_of_chi_square() -> None:
    assert same_object_threshold(0.05, 1, 2) == pytest.approx(-2.0 * np.log(0.05))
    assert same_object_threshold(0.01, 3, 4) == pytest.approx(chi2.isf(0.01, 12))


def test_pairs_of_one_object_are_rejected_as_often_as_was_asked() -> None:
    rng = np.random.default_rng(3)
    n_times, n_tracks = 3, 2000
    truth = rng.normal(size=(n_times, n_tracks, 2))
    covariance = np.broadcast_to(np.eye(2), (n_times, n_tracks, 2, 2))
    seen = [TrackEstimates(truth + rng.normal(size=truth.shape), covariance) for _ in range(2)]
    own = np.diag(accumulated_distance(*seen))
    assert np.mean(own > same_object_threshold(0.05, n_times, 2)) == pytest.approx(0.05, abs=0.015)


def test_every_tuple_costs_the_sum_over_consecutive_sensors() -> None:
    rng = np.random.default_rng(4)
    sensors = [estimates(rng, 3, n_times=2) for _ in range(4)]
    links = [accumulated_distance(a, b) for a, b in pairwise(sensors)]
    chains = track_chains(sensors)
    assert chains.threshold == np.inf
    assert {tuple(row) for row in chains.tuples.tolist()} == set(product([1, 2, 3], repeat=4))
    for row, cost in zip(chains.tuples - 1, chains.costs, strict=True):
        b = sum(links[s][row[s], row[s + 1]] for s in range(3))
        assert cost == pytest.approx(b)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_the_best_answer_is_that_of_all_permutations(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sensors = [estimates(rng, 3, spread=2.0) for _ in range(3)]
    first, second = accumulated_distance(*sensors[:2]), accumulated_distance(*sensors[1:])
    best = min(
        sum(first[i, p[i]] + second[p[i], q[i]] for i in range(3))
        for p in permutations(range(3))
        for q in permutations(range(3))
    )
    cost, chosen = answer_of(track_chains(sensors))
    assert cost == pytest.approx(best)
    assert [sorted(row[s] for row in chosen) for s in range(3)] == [[1, 2, 3]] * 3


def test_one_object_seen_by_many_sensors_is_one_tuple() -> None:
    assert track_chains([at([[0.0, 0.0]])] * 70).tuples.tolist() == [[1] * 70]


@pytest.mark.parametrize("false_rejection", [None, 0.05])
def test_sensors_without_tracks_make_an_empty_problem(false_rejection: float | None) -> None:
    empty = TrackEstimates(np.zeros((0, 2)), np.zeros((0, 2, 2)))
    chains = track_chains([empty, empty, empty], false_rejection=false_rejection)
    assert chains.tuples.shape == (0, 3)
    assert answer_of(chains) == (0.0, set())


def test_chains_within_the_threshold_are_all_and_only_those_grown() -> None:
    rng = np.random.default_rng(6)
    sensors = [estimates(rng, n, spread=2.5) for n in (4, 3, 5, 2)]
    chains = track_chains(sensors, false_rejection=0.1)
    delta = same_object_threshold(0.1, 1, 2)
    expected = {}
    for row in product(*(range(sensor.n_tracks + 1) for sensor in sensors)):
        seen = [s for s in range(4) if row[s]]
        links = [
            accumulated_distance(sensors[r], sensors[s])[row[r] - 1, row[s] - 1]
            for r, s in pairwise(seen)
        ]
        if seen and all(link <= delta for link in links):
            expected[row] = sum(links) + delta
    grown = dict(zip(map(tuple, chains.tuples.tolist()), chains.costs.tolist(), strict=True))
    assert len(grown) == len(chains.tuples)
    assert len(grown) > 30
    assert grown == pytest.approx(expected)


def test_joining_two_tracks_pays_exactly_below_the_threshold() -> None:
    delta = same_object_threshold(0.05, 1, 2)
    for distance, together in ((delta - 0.01, True), (delta + 0.01, False)):
        chains = track_chains([at([[0, 0]]), at([[distance**0.5, 0]])], false_rejection=0.05)
        cost, chosen = answer_of(chains)
        assert bool(chosen) is together
        assert cost == pytest.approx(delta + distance if together else 2 * delta)


def test_lists_may_differ_and_be_empty_where_tracks_may_be_left_alone() -> None:
    sensors = [at([[0, 0], [50, 0]]), at([]), at([[50.5, 0], [90, 0], [0, 0.5]])]
    cost, chosen = answer_of(track_chains(sensors, false_rejection=0.01))
    assert chosen == {(1, 0, 3), (2, 0, 1)}
    # Three objects; the track at 90 is alone.
    assert cost == pytest.approx(3 * same_object_threshold(0.01, 1, 2) + 0.5)


def test_refuses_lists_that_differ_where_every_track_has_to_be_taken() -> None:
    with pytest.raises(InvalidInputError, match=r"sensors: \[1, 2\] tracks; expected equally"):
        track_chains([at([[0, 0]]), at([[0, 0], [1, 1]])])


@pytest.mark.parametrize("false_rejection", [None, 1e-9])
def test_refuses_more_tuples_than_may_be(false_rejection: float | None) -> None:
    close = at([[0.0, 0.0]] * 10)
    assert len(track_chains([close] * 3, max_tuples=1330).costs) == 1000
    with pytest.raises(InvalidInputError, match="left of max_tuples; expected fewer"):
        track_chains([close] * 12, false_rejection=false_rejection, max_tuples=1330)


@pytest.mark.parametrize(
    ("mean", "covariance", "message"),
    [
        ([1.0, 2.0], np.eye(2), "mean: an array of 1 axes"),
        ([["a", "b"]], [np.eye(2)], "mean: .*expected numbers"),
        ([[1.0, 2.0]], np.eye(2), "covariance: an array of shape"),
        ([[1.0, np.nan]], [np.eye(2)], "mean.*nan; expected a finite number"),
        ([[1.0, 2.0]], [np.inf * np.ones((2, 2))], "covariance.*inf; expected a finite"),
        ([[1.0, 2.0]], [[[1.0, 0.5], [0.4, 1.0]]], "covariance: not symmetric"),
        ([[1.0, 2.0]], [[[1.0, 2.0], [2.0, 1.0]]], "covariance: not positive definite"),
        (np.zeros((0, 3, 2)), np.zeros((0, 3, 2, 2)), "at least one time"),
        (np.zeros((3, 0)), np.zeros((3, 0, 0)), "at least one time and dimension"),
    ],
)
def test_refuses_what_are_no_estimates(mean: object, covariance: object, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        TrackEstimates(mean, covariance)  # type: ignore[arg-type]


def test_refuses_sensors_that_do_not_fit_each_other() -> None:
    rng = np.random.default_rng(7)
    flat, deep = estimates(rng, 2), estimates(rng, 2, dim=3)
    long = estimates(rng, 2, n_times=3)
    with pytest.raises(InvalidInputError, match=r"dim \[2, 3\]; expected one for all"):
        track_chains([flat, deep])
    with pytest.raises(InvalidInputError, match=r"n_times \[1, 3\]; expected one for all"):
        accumulated_distance(flat, long)
    with pytest.raises(InvalidInputError, match="sensors: 1; expected at least two"):
        track_chains([flat])
    with pytest.raises(InvalidInputError, match="expected an instance of TrackEstimates"):
        track_chains([flat, 3])  # type: ignore[list-item]


@pytest.mark.parametrize("false_rejection", [0.0, 1.0, -0.1, np.nan])
def test_refuses_what_is_no_probability(false_rejection: float) -> None:
    with pytest.raises(InvalidInputError, match="expected a probability between 0 and 1"):
        track_chains([at([[0, 0]])] * 2, false_rejection=false_rejection)


@pytest.mark.parametrize(("n_times", "dim"), [(0, 2), (1, 0)])
def test_refuses_a_threshold_over_nothing(n_times: int, dim: int) -> None:
    with pytest.raises(InvalidInputError, match="expected both at least 1"):
        same_object_threshold(0.05, n_times, dim)


@pytest.mark.parametrize("max_tuples", [0, 2.5, True])
def test_refuses_a_limit_that_counts_nothing(max_tuples: int) -> None:
    with pytest.raises(InvalidInputError, match=r"max_tuples: .*; expected a whole number"):
        track_chains([at([[0, 0]])] * 2, max_tuples=max_tuples)


def test_chains_from_distances_are_those_from_estimates() -> None:
    rng = np.random.default_rng(8)
    sensors = [estimates(rng, 4) for _ in range(3)]
    distances = [accumulated_distance(first, second) for first, second in pairwise(sensors)]
    one, other = complete_chains(distances), track_chains(sensors)
    assert one.costs.tolist() == other.costs.tolist()
    assert one.tuples.tolist() == other.tuples.tolist()
    with pytest.raises(InvalidInputError, match="distances: none; expected those of at least"):
        complete_chains([])
    with pytest.raises(InvalidInputError, match=r"sensors: \[4, 4, 3\] tracks"):
        complete_chains([distances[0], distances[1][:, :3]])
