"""The parts that the patent's study is made of; the command itself is run in tests/cli."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from oracles.decoding import decode
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers import Exact
from trackweave.studies.hillis_claims import claims_of, last_of
from trackweave.studies.hillis_example import (
    FIGURES,
    decoded_figure,
    drawn,
    least_cost_with,
    name_of,
    run_example,
)
from trackweave.studies.hillis_fitness import (
    BestHypothesis,
    alone_as_tracks,
    decoded,
    document_search,
    sequence,
)
from trackweave.studies.hillis_scenes import TwoSensors, follow, lone_reports, meeting_scene
from trackweave.studies.hillis_search import evolve, full_window, interrupted, least_cost
from trackweave.studies.judging import Verdict
from trackweave.studies.writing import Table, frame

Hypothesis = frozenset[tuple[int, ...]]


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def hypotheses(problem: AssignmentProblem) -> dict[Hypothesis, float]:
    """Return every way to put all items into tracks, and what it costs."""
    nodes = [node for node in range(problem.n_nodes) if np.isfinite(problem.total[node])]
    tracks = {sequence(problem, node): float(problem.total[node]) for node in nodes}
    found: dict[Hypothesis, float] = {}

    def go_on(chosen: list[tuple[int, ...]], cost: float) -> None:
        taken = {item for track in chosen for item in track}
        free = [item for item in range(problem.n_items) if item not in taken]
        if not free:
            found[frozenset(chosen)] = cost
            return
        for track, price in tracks.items():
            if free[0] in track and not taken & set(track):
                go_on([*chosen, track], cost + price)

    go_on([], 0.0)
    return found


@pytest.mark.parametrize("scan", [1, 2])
def test_the_best_hypothesis_is_the_best_of_all(scan: int, rng: np.random.Generator) -> None:
    problem = run_example(5, rng).problems[scan]
    every = hypotheses(problem)
    assert len(every) > 7
    answer = BestHypothesis()(problem, rng=rng)
    assert answer.cost == pytest.approx(min(every.values()))
    said = frozenset(sequence(problem, int(node)) for node in answer.nodes)
    assert every[said] == pytest.approx(answer.cost)
    assert least_cost(problem, rng, lone=True) == pytest.approx(answer.cost)
    assert least_cost(problem, rng, lone=False) < answer.cost - 1.0


def test_a_track_from_before_is_not_taken_for_a_lone_report(rng: np.random.Generator) -> None:
    problem = AssignmentProblem(
        [-1, -1, 0, -1], [0, 1, 1, 2], [3.0, 4.0, 2.0, 5.0], [3.0, 4.0, 2.0, 5.0],
        [True, False, False], [0, 1, 1],
    )  # fmt: skip
    # Items 1 and 2 cost 4 and 5 alone; the track saves 4 by taking item 1.
    changed = alone_as_tracks(problem)
    assert changed.base_cost == 9.0
    assert changed.total.tolist() == [3.0, 0.0, -2.0, 0.0]
    answer = BestHypothesis()(problem, rng=rng)
    assert (answer.cost, answer.nodes.tolist()) == (7.0, [2, 3])


def test_decodes_as_the_slow_and_obvious_decoder_does(rng: np.random.Generator) -> None:
    problem = run_example(5, rng).problems[2]
    for order in itertools.islice(itertools.permutations(range(7)), 0, 5040, 97):
        cost, tracks = decoded(problem, list(order))
        slow_cost, slow_tracks = decode(problem, order, settle=False)
        assert (cost, tracks) == (pytest.approx(slow_cost), slow_tracks)


@pytest.mark.parametrize("figure", FIGURES)
def test_strings_decode_to_their_drawings(figure: str, rng: np.random.Generator) -> None:
    run = run_example(5, rng)
    _, tracks, is_drawing = decoded_figure(figure, run)
    assert is_drawing
    assert set(name_of(tracks).split()) == set(FIGURES[figure][1].split())


def test_costs_with_a_figure_are_the_least_that_say_the_same(rng: np.random.Generator) -> None:
    problem = run_example(5, rng).problems[2]
    every = hypotheses(problem)
    for figure in "123":
        early = decoded_figure(figure, run_example(5, rng))[1]
        alike = [
            cost
            for tracks, cost in every.items()
            if {tuple(item for item in track if item < 5) for track in tracks} - {()} == early
        ]
        cost, tracks = least_cost_with(figure, problem, rng)
        assert cost == pytest.approx(min(alike))
        assert every[tracks] == pytest.approx(cost)


def test_the_early_choice_pays_late_and_is_amended(rng: np.random.Generator) -> None:
    window, one = run_example(5, rng, document_search()), run_example(1, rng)
    early = [least_cost_with(figure, window.problems[1], rng)[0] for figure in "23"]
    late = [least_cost_with(figure, window.problems[2], rng)[0] for figure in "23"]
    assert early[0] < early[1]
    assert late[0] > late[1]
    best = decoded_figure("4", window)[1]
    assert window.hypotheses[-1] == best != one.hypotheses[-1]
    assert [len(amended) for amended in window.amendments] == [0, 0, 1]
    assert not any(one.amendments)


def test_the_search_gets_no_worse_and_stays_above_the_best(rng: np.random.Generator) -> None:
    problem = full_window(rng, 5)
    search = replace(document_search(), population=40, generations=30, evaluations=1_000)
    found = evolve(problem, search, np.random.default_rng(1))
    # The evaluations end the search at the end of a generation.
    assert found.evaluations.tolist() == [40.0 * (k + 1) for k in range(25)]
    assert np.all(np.diff(found.best) <= 1e-12)
    assert np.all(found.best >= least_cost(problem, rng, lone=True) - 1e-9)
    assert found.best[0] > found.best[-1]
    assert np.all(found.spread >= 0.0)
    assert (found.at(39), found.at(85)) == (None, found.best[1])
    again = evolve(problem, search, np.random.default_rng(1))
    assert np.array_equal(found.best, again.best)


def test_an_interrupted_search_is_a_whole_hypothesis(rng: np.random.Generator) -> None:
    problem = full_window(rng, 10)
    costs, whole = interrupted(problem, (1, 4, 16), 3)
    assert all(whole)
    assert np.all(np.diff(costs) <= 0.0)
    assert costs[0] > costs[-1] > least_cost(problem, rng, lone=True) - 1e-9


@pytest.fixture(scope="module")
def scene() -> TwoSensors:
    return meeting_scene(np.random.default_rng(2), n_scans=6)


def test_both_sensors_look_at_each_time(scene: TwoSensors) -> None:
    assert [scan.time for scan in scene.scans] == [float(k // 2) for k in range(12)]
    assert [scan.sensor for scan in scene.scans] == ["A", "B"] * 6
    assert sum(map(len, scene.scans)) == len(scene.target)
    assert len(scene.names()) == 5


def test_right_is_a_report_on_its_objects_own_track(scene: TwoSensors) -> None:
    found = follow(scene, Exact(), 3, np.random.default_rng(1))
    assert found.is_right.shape == (len(scene.target),)
    assert found.right == pytest.approx(100.0 * np.mean(found.is_right))
    assert 70.0 < found.right <= 100.0
    assert len(found.asked.problems) == len(found.asked.answers) == 12
    # Another object's name behind each report makes those wrong that were right.
    names = scene.names()
    other = {"": ""} | dict(zip(names, names[1:] + names[:1], strict=True))
    mixed = replace(scene, target=tuple(other[name] for name in scene.target))
    own = np.array([name != "" for name in scene.target])
    wrong = follow(mixed, Exact(), 3, np.random.default_rng(1)).is_right
    assert not np.any(wrong & found.is_right & own)


def test_lone_reports_come_one_by_one_and_late_in_another_order(scene: TwoSensors) -> None:
    alone = lone_reports(scene, np.random.default_rng(1))
    lone = [scan for scan in alone.scans if scan.sensor == "C"]
    assert [len(scan) for scan in lone] == [1] * (len(alone.target) - len(scene.target))
    assert len(lone) == 3
    late = alone.late(np.random.default_rng(4))
    assert sorted(id(scan) for scan in late.scans) == sorted(id(scan) for scan in alone.scans)
    scanned = [scan.time for scan in late.scans if scan.sensor != "C"]
    assert scanned == sorted(scanned)
    assert [scan.time for scan in late.scans] != sorted(scan.time for scan in late.scans)


def curves(excess: float, n_windows: int) -> Table:
    """Return a table of searches that all end so far above the best, but for a hair."""
    searches = ("population 300", "'931 lists", "by size", "hillis", "default")
    rows = [
        (5, window, 30, search, spent, excess * (1 + (spent == 500)) + 1e-9 * (window % 3) * n)
        for window in range(n_windows)
        for n, search in enumerate(searches)
        for spent in (500, 1_000)
    ]
    head = ("objects", "window", "reports", "search", "evaluations", "excess [nats]")
    return frame(head, rows)


def test_a_search_is_judged_by_where_it_ends() -> None:
    excess, spent = last_of(curves(2.0, 3), 5, "by size")
    assert (excess.tolist(), spent) == (pytest.approx([2.0, 2.0, 2.0]), 1_000.0)


@pytest.fixture(scope="module")
def tables() -> dict[str, Table]:
    """Return tables of a study that found what it looked for."""
    rng = np.random.default_rng(1)
    depths = [
        (depth, method, scene, 80.0 + 2 * depth + scene, 1, 9.0, 0, 0.5 + 1e-9 * scene, 5, 6)
        for depth in (1, 5)
        for method in ("document", "its best", "hillis", "exact", "default")
        for scene in range(9)
    ]
    head = (
        "depth", "method", "scene", "right [%]", "switches", "GOSPA [m]", "amended",
        "excess [nats]", "at the best", "windows",
    )  # fmt: skip
    arrivals = [
        (k, order, 95.0, 94.0, 9.0) for k in range(9) for order in ("none", "in time", "late")
    ]
    ways = ("one population", "kept", "4 islands", "quarters", "nothing sent")
    islands = [
        (k, way, 1.0 + 1e-9 * k * n, 1_000, 4 if n in (2, 3) else None, True if n > 1 else None)
        for k in range(9)
        for n, way in enumerate(ways)
    ]
    return {
        **drawn(rng, True, lambda done, total: None),
        "depths": frame(head, depths),
        "search": curves(0.0, 99),
        "thresholds": frame(
            ("objects", "window", "threshold [nats]", "generation", "of", "excess [nats]"),
            tuple((5, k, 3.0, 9, 20, 0.0) for k in range(9)),
        ),
        "interruptions": frame(
            ("window", "looks", "excess [nats]", "whole"),
            tuple((k, looks, 9.0 / looks, True) for k in range(9) for looks in (1, 2)),
        ),
        "arrivals": frame(
            ("scene", "arrival", "of scans right [%]", "alone right [%]", "GOSPA [m]"),
            tuple(arrivals),
        ),
        "islands": frame(
            ("window", "search", "excess [nats]", "evaluations", "sent", "same on threads"),
            tuple(islands),
        ),
    }


def test_claims_hold_where_the_tables_say_so(tables: dict[str, Table]) -> None:
    claims = claims_of(tables)
    doubtful = [claim.text for claim in claims if not claim.verdict.startswith("holds")]
    # Both genotypes end at the best: neither serves better, and a difference of 0 is not above 0.
    assert doubtful == []
    assert len({claim.text for claim in claims}) == len(claims) >= 20


def test_claims_fail_where_the_tables_say_so(tables: dict[str, Table]) -> None:
    worse = {**tables, "search": curves(9.0, 99)}
    told = {claim.text[:30]: claim.verdict for claim in claims_of(worse)}
    assert told['"A population is formed from r'] is Verdict.DOES_NOT_HOLD
    assert told['Claim 2: "the good hypothesis '] is Verdict.DOES_NOT_HOLD
    few = {**tables, "search": curves(0.0, 3)}
    told = {claim.text[:30]: claim.verdict for claim in claims_of(few)}
    assert told['Claim 2: "the good hypothesis '] is Verdict.CANNOT_BE_TOLD
