"""The study of three radars, repeated on a fraction of its skies, and what it is made of."""

from collections.abc import Mapping

import numpy as np
import pytest

from trackweave.association.plots_rule import PlotsRule
from trackweave.solvers import Exact
from trackweave.studies import wiranto_plots
from trackweave.studies.judging import Verdict
from trackweave.studies.wiranto_claims import claims_of
from trackweave.studies.wiranto_plots import (
    DEFAULT,
    DOCUMENT,
    EXACT,
    METHODS,
    judged,
    posed,
    search,
    sort_plots,
    sorting,
)  # fmt: skip
from trackweave.studies.wiranto_scenes import (
    SIDE,
    SIGMA,
    SKIES,
    STRAIGHT,
    TURNING,
    RadarSky,
    SkyShape,
    draw_sky,
)  # fmt: skip
from trackweave.studies.wiranto_tracks import (
    IMM,
    LEGS,
    PRESET,
    Offsets,
    figures,
    leg_of,
    offsets_from,
    offsets_of_plots,
    run_tracker,
    tracking,
)  # fmt: skip
from trackweave.studies.writing import Table, frame, numbers
from trackweave.trackers.plot_fusion import PlotFuser

pytestmark = pytest.mark.slow


def nobody(done: int, total: int) -> None:
    """Take no notice of progress."""


@pytest.fixture(scope="module")
def sky() -> RadarSky:
    return draw_sky(SkyShape(false_alarms=12.0, n_scans=40), np.random.default_rng(2))


@pytest.fixture(scope="module")
def whole_sky() -> RadarSky:
    return draw_sky(SkyShape(), np.random.default_rng(3))


def test_two_courses_are_straight_and_one_turns_left_by_a_right_angle() -> None:
    calm = draw_sky(SkyShape(), np.random.default_rng(1))
    for name in STRAIGHT:
        velocity = calm.course(name)[2]
        assert np.ptp(velocity, axis=0) == pytest.approx([0.0, 0.0], abs=1e-6)
    velocity = calm.course(TURNING)[2]
    assert velocity[0] == pytest.approx([-150.0, 0.0])
    assert velocity[-1] == pytest.approx([0.0, -150.0], abs=1e-6)
    assert np.all(calm.truth.position > 0.0)
    assert np.all(calm.truth.position < SIDE)


def test_aircraft_of_a_formation_keep_their_distance() -> None:
    many = draw_sky(SkyShape(abreast=3), np.random.default_rng(1))
    assert len(set(many.truth.target)) == many.shape.n_objects == 9
    first, second = many.course(TURNING)[1], many.course(f"{TURNING}.1")[1]
    assert np.hypot(*(first - second).T) == pytest.approx(np.full(100, 283.0))


def test_radars_report_as_often_and_as_falsely_as_they_should() -> None:
    many = draw_sky(SkyShape(false_alarms=10.0), np.random.default_rng(1))
    assert np.mean(many.target >= 0) * many.target.size / 900 == pytest.approx(0.9, abs=0.04)
    assert np.sum(many.target < 0) / 300 == pytest.approx(10.0, abs=0.8)
    errors = [offsets_of_plots(many, name).row()[0] for name in (*STRAIGHT, TURNING)]
    assert np.mean(errors) == pytest.approx(SIGMA * np.sqrt(2.0), rel=0.06)


@pytest.mark.parametrize("method", [EXACT, DEFAULT])
def test_plots_are_sorted_as_the_fusion_of_plots_does(sky: RadarSky, method: str) -> None:
    cost, solver = METHODS[method]
    instants = posed(sky, cost)
    answers = [solver(problem, rng=np.random.default_rng(1)) for problem in instants.problems]
    found = sort_plots(sky, instants, answers)
    density = sky.shape.n_objects / SIDE**2
    rule = PlotsRule(density, cost, negative_only=cost == "evidence", lone_plots=True)
    fuser = PlotFuser(sky.sensors, rule, Exact())
    first = 0
    for number, scans in enumerate(sky.instants):
        fused = fuser(scans, rng=np.random.default_rng(1))
        own = {frozenset(held.tolist()) for held in fused.members}
        told = range(first, first + int(found.counts[number]))
        assert own == {frozenset(np.flatnonzero(found.group == group).tolist()) for group in told}
        assert answers[number].cost == pytest.approx(fused.certificate.cost)
        first = told.stop


@pytest.mark.parametrize("method", [DOCUMENT, DEFAULT])
def test_the_judgement_is_that_of_counting_plot_by_plot(sky: RadarSky, method: str) -> None:
    cost, solver = METHODS[method]
    instants = posed(sky, cost)
    answers = [solver(problem, rng=np.random.default_rng(1)) for problem in instants.problems]
    found = sort_plots(sky, instants, answers)
    measures = judged(sky, found)
    classified = grouped = lone = twice = 0
    for number, scans in enumerate(sky.instants):
        plots = np.concatenate([scan.report for scan in scans]).tolist()
        assert set(sky.instant[plots].tolist()) <= {number}
        seen = []
        for plot in plots:
            mates = {p for p in plots if sky.target[p] == sky.target[plot]}
            told = {p for p in plots if found.group[p] == found.group[plot]}
            is_object, is_told = sky.target[plot] >= 0, found.group[plot] >= 0
            classified += is_object == is_told
            grouped += (is_object and is_told and mates == told) or not (is_object or is_told)
            lone += is_object and len(mates) == 1
            if is_object and len(mates) > 1:
                seen.append(sky.target[plot])
        twice += len(set(seen)) == sky.shape.n_objects
    total = sky.target.size
    assert measures["classified rightly [%]"] == pytest.approx(100.0 * classified / total)
    assert measures["grouped rightly [%]"] == pytest.approx(100.0 * grouped / total)
    assert measures["aircraft seen by one radar [%]"] == pytest.approx(100.0 * lone / total)
    assert measures["scans with all seen twice [%]"] == pytest.approx(100.0 * twice / 40)


def test_offsets_are_ahead_and_to_the_right_which_is_outside_of_the_turn(
    whole_sky: RadarSky,
) -> None:
    time, where, velocity = whole_sky.course(TURNING)
    # The centre lies to the left of the course at the turn's beginning.
    centre = where[35] + np.array([0.0, -150.0 / np.radians(3.0)])
    outward = (where - centre) / np.linalg.norm(where - centre, axis=1, keepdims=True)
    along = velocity / np.linalg.norm(velocity, axis=1, keepdims=True)
    found = offsets_from(whole_sky, TURNING, time, where + 20.0 * outward + 5.0 * along)
    turn = leg_of({TURNING: found}, "turn")
    assert turn.time.tolist() == list(range(36, 66))
    assert turn.right == pytest.approx(np.full(30, 20.0), abs=1e-3)
    assert turn.ahead == pytest.approx(np.full(30, 5.0), abs=1e-3)
    assert turn.row() == pytest.approx((np.hypot(20.0, 5.0), 0.0, 20.0, 5.0), abs=1e-3)


def test_offsets_take_the_nearest_place_and_none_beyond_the_cutoff(whole_sky: RadarSky) -> None:
    time, where, _ = whole_sky.course(STRAIGHT[0])
    places = np.concatenate([where + np.array([0.0, 200.0]), where[:50] - np.array([0.0, 30.0])])
    found = offsets_from(whole_sky, STRAIGHT[0], np.concatenate([time, time[:50]]), places)
    distance = np.hypot(found.ahead, found.right)
    assert distance == pytest.approx([30.0] * 50 + [200.0] * 50)
    nothing = offsets_from(whole_sky, STRAIGHT[0], time, where + np.array([300.0, 0.0]))
    assert nothing.time.size == 0


def test_straight_courses_are_two_and_begin_when_velocities_are_known() -> None:
    every = Offsets(np.arange(100.0), np.zeros(100), np.arange(100.0))
    parts = [leg_of(dict.fromkeys((*STRAIGHT, TURNING), every), leg).time for leg in LEGS]
    assert [part.size for part in parts] == [2 * 90, 30]


def test_the_preset_is_displaced_in_the_turn_and_imm_less(whole_sky: RadarSky) -> None:
    right = {}
    for tracker in (PRESET, IMM):
        found = run_tracker(whole_sky, tracker, np.random.default_rng(1))
        told = found.tracks.status >= 1
        off = {
            name: offsets_from(
                whole_sky, name, found.tracks.time[told], found.tracks.mean[told, :2]
            )
            for name in (*STRAIGHT, TURNING)
        }
        right[tracker] = [float(leg_of(off, leg).right.mean()) for leg in LEGS]
        assert found.measures["classified rightly [%]"] > 98.0
    assert right[PRESET][1] > right[PRESET][0] + 15.0
    assert right[IMM][1] < right[PRESET][1] - 10.0


@pytest.fixture(scope="module")
def tables() -> dict[str, Table]:
    """Return tables of two skies of each kind, as few scans as will do."""
    made = sorting(np.random.default_rng(1), dict.fromkeys(SKIES, 2), 8, nobody)
    small = pytest.MonkeyPatch()
    small.setattr(wiranto_plots, "SEARCHED_SCANS", 3)
    made |= search(np.random.default_rng(2), 2, nobody)
    small.undo()
    return made


def test_no_answer_is_cheaper_than_the_exact_one(tables: dict[str, Table]) -> None:
    name = "above the least cost [nats]"
    assert np.all(numbers(tables["sorting"], name) >= 0.0)
    assert not numbers(tables["sorting"], name, method=EXACT).any()
    proven = numbers(tables["sorting"], "scans proven best", method=EXACT)
    assert proven.tolist() == numbers(tables["sorting"], "scans", method=EXACT).tolist()


def test_curves_do_not_rise_and_cost_a_colony_of_tours_a_cycle(tables: dict[str, Table]) -> None:
    for method in wiranto_plots.COLONIES:
        where = {"sky": "as chosen", "draw": 0, "method": method}
        excess = numbers(tables["search"], "above the least cost [nats]", **where)
        tours = numbers(tables["search"], "evaluations", **where)
        assert np.all(np.diff(excess) <= 1e-9)
        assert np.all(np.diff(tours) >= 0.0)
        if method == "10 ants":
            assert tours[0] == 10.0
            assert tours[1] <= 30.0


def test_same_seed_same_numbers() -> None:
    first, second, other = (
        sorting(np.random.default_rng(seed), {"as chosen": 1}, 4, nobody)["sorting"].rows()
        for seed in (7, 7, 8)
    )
    assert first == second
    assert first != other


def test_figures_have_the_points_that_they_plot() -> None:
    made = figures(np.random.default_rng(1), nobody)
    assert sorted(made) == ["figure3", "figure4", "figure5", "figure6"]
    whats = {row[0] for row in made["figure4"].rows()}
    assert whats == {"truth", "estimate", "selected, fused"}
    assert len(numbers(made["figure4"], "x", what="truth")) == 300
    for name in ("figure5", "figure6"):
        assert np.isfinite(numbers(made[name], "to the right [m]")).all()


def judged_with(tables: Mapping[str, Table], factors: Mapping[str, float]) -> list[Verdict]:
    """Return the verdicts where numbers are multiplied, by tracker or method."""
    changed = {}
    for name, table in tables.items():
        rows = []
        for row in table.rows():
            factor = next((factors[cell] for cell in row if cell in factors), 1.0)
            rows.append(tuple(c * factor if isinstance(c, float) else c for c in row))
        changed[name] = frame(table.columns, rows)
    return [claim.verdict for claim in claims_of(changed)]


@pytest.mark.slow
def test_claims_follow_the_numbers(tables: dict[str, Table]) -> None:
    tables |= tracking(np.random.default_rng(3), 2, nobody)
    plain = claims_of(tables)
    assert plain[3].verdict == Verdict.DOES_NOT_HOLD  # the exact solver proves every instant best
    assert all(claim.judged_by and "n = " in claim.found for claim in plain)
    worse = judged_with(tables, {DOCUMENT: 0.5, PRESET: 5.0, DEFAULT: 0.9})
    assert worse[0] == worse[1] == Verdict.DOES_NOT_HOLD
    assert Verdict.HOLDS not in {worse[8], worse[9], worse[11]}
    assert judged_with(tables, {PRESET: -1.0})[10] != Verdict.HOLDS
