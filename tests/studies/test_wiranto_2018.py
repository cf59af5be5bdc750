"""The study of three radars, repeated on a fraction of its skies, and what it is made of."""

import io
from collections.abc import Mapping
from dataclasses import replace

import matplotlib.image
import numpy as np
import polars as pl
import pytest

from trackweave.association.plots_rule import PlotsRule
from trackweave.solvers import Exact
from trackweave.studies import Study, study_of, wiranto_parts
from trackweave.studies.wiranto_claims import claims_of
from trackweave.studies.wiranto_parts import SKIES, sort_sky, sorting, spread_of, summary
from trackweave.studies.wiranto_plots import DEFAULT, DOCUMENT, METHODS, judged, seen_alone
from trackweave.studies.wiranto_scenes import (
    SIDE,
    SIGMA,
    STRAIGHT,
    TURNING,
    RadarSky,
    SkyShape,
    draw_sky,
)
from trackweave.studies.wiranto_tracks import (
    IMM,
    LEGS,
    PRESET,
    Offsets,
    leg_of,
    offsets_from,
    offsets_of_plots,
    run_tracker,
)
from trackweave.studies.writing import Table
from trackweave.trackers.plot_fusion import PlotFuser

FIGURES = ("figure3", "figure4", "figure5", "figure6", "noise")


@pytest.fixture(scope="module")
def sky() -> RadarSky:
    return draw_sky(SkyShape(false_alarms=12.0, n_scans=40), np.random.default_rng(2))


@pytest.fixture(scope="module")
def whole_sky() -> RadarSky:
    return draw_sky(SkyShape(), np.random.default_rng(3))


@pytest.fixture(scope="module")
def study() -> Study:
    small = pytest.MonkeyPatch()
    few = {name: replace(shape, n_scans=12) for name, shape in SKIES.items()}
    small.setattr(wiranto_parts, "SKIES", few)
    calls: list[tuple[int, int]] = []
    found = study_of("wiranto-2018")(
        np.random.default_rng(1), True, lambda done, total: calls.append((done, total))
    )
    small.undo()
    assert calls[-1][0] == calls[-1][1]
    return found


@pytest.mark.slow
def test_the_report_judges_every_claim_and_says_what_is_ours(study: Study) -> None:
    assert "prints no numbers" in study.report
    assert "The rest is ours" in study.report
    assert all(claim.text in study.report for claim in study.claims)


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURES)
def test_each_figure_is_a_picture_with_its_numbers(study: Study, name: str) -> None:
    picture = matplotlib.image.imread(io.BytesIO(study.files[f"{name}.png"]))
    assert picture.std() > 0.01
    assert pl.read_csv(study.files[f"{name}.csv"]).height >= 4
    assert f"![]({name}.png)" in study.report


@pytest.mark.slow
def test_times_stand_in_a_file_of_their_own(study: Study) -> None:
    timed = [name for name, content in study.files.items() if b"CPU" in content]
    assert timed == ["cpu.csv"]
    assert "ms/scan" not in study.report


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
    first, second = many.course("3")[1], many.course("3.1")[1]
    assert np.hypot(*(first - second).T) == pytest.approx(np.full(100, 283.0))


def test_radars_report_as_often_and_as_falsely_as_they_should() -> None:
    many = draw_sky(SkyShape(false_alarms=10.0), np.random.default_rng(1))
    assert np.mean(many.target >= 0) * many.target.size / 900 == pytest.approx(0.9, abs=0.04)
    assert np.sum(many.target < 0) / 300 == pytest.approx(10.0, abs=0.8)
    errors = [offsets_of_plots(many, name).rmse for name in (*STRAIGHT, TURNING)]
    assert np.mean(errors) == pytest.approx(SIGMA * np.sqrt(2.0), rel=0.06)


@pytest.mark.parametrize(
    ("method", "cost"), [("exact, eq. 1", "equation-1"), (DEFAULT, "evidence")]
)
def test_plots_are_sorted_as_the_fusion_of_plots_does(
    sky: RadarSky, method: str, cost: str
) -> None:
    found = sort_sky(sky, [method], np.random.default_rng(1))[method]
    density = sky.shape.n_objects / SIDE**2
    rule = PlotsRule(density, cost, negative_only=cost == "evidence", lone_plots=True)  # type: ignore[arg-type]
    fuser = PlotFuser(sky.sensors, rule, Exact())
    first = 0
    for number, scans in enumerate(sky.instants):
        fused = fuser(scans, rng=np.random.default_rng(1))
        own = {frozenset(held.tolist()) for held in fused.members}
        told = range(first, first + int(found.counts[number]))
        assert own == {frozenset(np.flatnonzero(found.group == group).tolist()) for group in told}
        assert found.costs[number] == pytest.approx(fused.certificate.cost)
        first = told.stop


@pytest.mark.parametrize("method", METHODS)
def test_the_judgement_is_that_of_counting_plot_by_plot(sky: RadarSky, method: str) -> None:
    found = sort_sky(sky, [method], np.random.default_rng(1))[method]
    measures = judged(sky, found, found.costs)
    classified = grouped = lone = twice = 0
    for scans in sky.instants:
        plots = np.concatenate([scan.report for scan in scans]).tolist()
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
    assert np.mean(seen_alone(sky)) == pytest.approx(lone / total)
    assert measures["scans with all seen twice [%]"] == pytest.approx(100.0 * twice / 40)
    wrong = [name for name in measures if name.startswith(("aircraft", "false"))]
    assert sum(measures[name] for name in wrong) == pytest.approx(
        100.0 - measures["classified rightly [%]"]
        + 100.0 * np.mean(seen_alone(sky) & (found.group >= 0))
    )  # fmt: skip


def test_no_method_is_cheaper_than_the_exact_one(sky: RadarSky) -> None:
    every = sort_sky(sky, list(METHODS), np.random.default_rng(1))
    for name, (cost, _) in METHODS.items():
        exact = every["exact, eq. 1" if cost == "equation-1" else "exact, evidence"]
        assert exact.proven.all()
        assert np.all(every[name].costs >= exact.costs - 1e-6)
    assert every[DEFAULT].costs == pytest.approx(every["exact, evidence"].costs)
    assert np.any(every[DOCUMENT].costs > every["exact, eq. 1"].costs + 1e-3)


def test_same_seed_same_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wiranto_parts, "SKIES", {"few": SkyShape(n_scans=4)})
    tables = [sorting(np.random.default_rng(7), {"few": 2}, lambda: None).rows for _ in range(2)]
    timed = sorting(np.random.default_rng(7), {"few": 1}, lambda: None).head.index("CPU [ms/scan]")
    kept = [[row[:timed] + row[timed + 1 :] for row in rows] for rows in tables]
    assert kept[0] == kept[1]
    assert kept[0][: len(METHODS)] != kept[0][len(METHODS) :]


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
    assert turn.rmse == pytest.approx(np.hypot(20.0, 5.0))
    assert turn.scatter == pytest.approx(0.0, abs=1e-3)


def test_offsets_take_the_nearest_place_and_none_beyond_the_cutoff(whole_sky: RadarSky) -> None:
    time, where, _ = whole_sky.course("1")
    places = np.concatenate([where + np.array([0.0, 200.0]), where[:50] - np.array([0.0, 30.0])])
    found = offsets_from(whole_sky, "1", np.concatenate([time, time[:50]]), places)
    assert found.distance == pytest.approx([30.0] * 50 + [200.0] * 50)
    nothing = offsets_from(whole_sky, "1", time, where + np.array([300.0, 0.0]))
    assert nothing.time.size == 0


def test_the_turn_has_two_parts_and_straight_courses_are_two() -> None:
    every = Offsets(np.arange(100.0), np.zeros(100), np.arange(100.0))
    offsets = {name: every for name in (*STRAIGHT, TURNING)}
    parts = [leg_of(offsets, leg).time for leg in LEGS]
    assert parts[0].size == 2 * 90
    assert np.concatenate(parts[2:]).tolist() == parts[1].tolist()


def test_the_preset_is_displaced_in_the_turn_and_imm_less(whole_sky: RadarSky) -> None:
    right = {}
    for tracker in (PRESET, IMM):
        found = run_tracker(whole_sky, tracker, np.random.default_rng(1))
        right[tracker] = [float(leg_of(found.offsets, leg).right.mean()) for leg in LEGS[:2]]
        assert found.measures["classified rightly [%]"] > 98.0
    assert right[PRESET][1] > right[PRESET][0] + 15.0
    assert right[IMM][1] < right[PRESET][1] - 10.0


def test_spreads_are_told_to_the_digits_that_count() -> None:
    assert spread_of(np.array([1.0, 3.0])) == "2.0 ± 1.0 (1.0 to 3.0)"
    assert spread_of(np.array([-0.02, 0.04])) == "0.010 ± 0.030 (−0.020 to 0.040)"
    assert spread_of(np.array([100.0, 160.0])) == "130 ± 30 (100 to 160)"
    assert spread_of(np.array([5.0])) == "5.00 ± 0.00 (5.00 to 5.00)"


def test_a_summary_keeps_apart_what_it_is_told_to() -> None:
    table = Table(("a", "b", "x"), ((1, "u", 1.0), (1, "u", 3.0), (1, "v", 7.0), (2, "u", 5.0)))
    found = summary(table, ("a", "b"), ("x",))
    assert [row[:2] for row in found.rows] == [(1, "u"), (1, "v"), (2, "u")]
    assert found.rows[0][2] == "2.0 ± 1.0 (1.0 to 3.0)"


def _judged_with(tables: tuple[Table, Table, Table], changes: Mapping[str, float]) -> list[bool]:
    """Return whether claims hold where numbers are multiplied, by tracker or method."""
    changed = []
    for table in tables:
        rows = []
        for row in table.rows:
            factor = next((changes[cell] for cell in row if cell in changes), 1.0)
            rows.append(tuple(c * factor if isinstance(c, float) else c for c in row))
        changed.append(Table(table.head, tuple(rows)))
    return [bool(claim.holds) for claim in claims_of(*changed)]


def test_claims_follow_the_numbers() -> None:
    few = {"as chosen": 2, "dense clutter": 1, "dense clutter, formations": 1}
    small = pytest.MonkeyPatch()
    shapes = {name: replace(shape, n_scans=6) for name, shape in SKIES.items()}
    small.setattr(wiranto_parts, "SKIES", shapes)
    sorted_plots = sorting(np.random.default_rng(1), few, lambda: None)
    small.undo()
    small.setattr(wiranto_parts, "draw_sky", lambda shape, rng: draw_sky(SkyShape(), rng))
    tables = (sorted_plots, *wiranto_parts.tracking(np.random.default_rng(1), 2, lambda: None))
    small.undo()
    plain = _judged_with(tables, {})
    assert plain[3] is False  # the exact solver proves every instant best
    assert plain[6:9] == [True, True, True]
    worse = _judged_with(tables, {DOCUMENT: 0.5, PRESET: 5.0, DEFAULT: 0.9})
    assert worse[0] is worse[1] is worse[6] is worse[7] is worse[9] is False
    inside = _judged_with(tables, {PRESET: -1.0})
    assert inside[8] is False
