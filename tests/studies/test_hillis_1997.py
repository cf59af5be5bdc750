"""The patent's study, repeated on a fraction of its scenes, and the parts that it is made of."""

import io
import itertools
from dataclasses import replace

import matplotlib.image
import numpy as np
import polars as pl
import pytest

from oracles.decoding import decode
from trackweave.association.problem import AssignmentProblem
from trackweave.solvers import Exact
from trackweave.studies import Study, hillis_1997, hillis_parts, study_of
from trackweave.studies.hillis_example import (
    FIGURES,
    decoded_figure,
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
    found = evolve(problem, np.random.default_rng(1))
    assert found.best.shape == found.mean.shape == found.spread.shape == (200,)
    assert np.all(np.diff(found.best) <= 1e-12)
    assert np.all(found.best >= 0.0)
    assert np.all(found.mean >= found.best - 1e-9)
    assert found.best[0] > found.best[-1]
    again = evolve(problem, np.random.default_rng(1))
    assert np.array_equal(found.mean, again.mean)


def test_an_interrupted_search_is_a_whole_hypothesis(rng: np.random.Generator) -> None:
    problem = full_window(rng, 10)
    costs, whole = interrupted(problem, (1, 4, 16), 3)
    assert whole
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


@pytest.fixture(scope="module")
def study() -> Study:
    small = pytest.MonkeyPatch()
    small.setattr(hillis_1997, "SIZES", (5,))
    small.setattr(hillis_1997, "SIZE_OF_STOPS", 5)
    calls: list[tuple[int, int]] = []
    found = study_of("hillis-1997")(
        np.random.default_rng(1), True, lambda done, total: calls.append((done, total))
    )
    small.undo()
    assert calls == [(done, calls[-1][1]) for done in range(1, calls[-1][1] + 1)]
    return found


@pytest.mark.slow
def test_the_report_tells_every_claim(study: Study) -> None:
    assert "prints no results" in study.report
    assert all(claim.text in study.report for claim in study.claims)
    assert all(f"![]({name})" in study.report for name in study.files if name.endswith("png"))


@pytest.mark.slow
def test_what_the_drawings_and_the_example_say_holds(study: Study) -> None:
    assert [claim.holds for claim in study.claims[:9]] == [True] * 9
    assert study.claims[-1].holds
    assert "island" in study.claims[-1].text
    islands = pl.read_csv(study.files["islands.csv"])
    assert islands["search"].to_list()[0] == "one population"
    assert (islands["excess [nats]"] >= 0.0).all()


@pytest.mark.slow
def test_each_file_is_a_picture_or_numbers(study: Study) -> None:
    for name, content in study.files.items():
        if name.endswith(".png"):
            assert matplotlib.image.imread(io.BytesIO(content)).std() > 0.01
        else:
            assert pl.read_csv(content).height >= 1
    depths = pl.read_csv(study.files["depths.csv"])
    assert set(depths["method"]) == set(hillis_parts.METHODS)
    assert depths["right [%]"].is_between(0.0, 100.0).all()
    assert depths.filter(pl.col("method") == "document")["excess [nats]"].min() >= 0.0
