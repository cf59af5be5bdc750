"""The practice that plots' association is compared with is priced and grouped as it should be."""

import importlib
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from trackweave.association.plots_rule import PlotsRule, scene_plots
from trackweave.simulation.scenes import BearingKind, PositionKind, draw_scene

KINDS = [PositionKind(4, 6, 12.0), BearingKind(4, 4)]


@pytest.fixture
def practice(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parents[2] / "benchmarks"), *sys.path])
    return importlib.import_module("plots_practice")


@pytest.fixture
def scenes(practice: Any) -> Any:
    return importlib.import_module("plots_scenes")


@pytest.mark.parametrize("kind", KINDS)
def test_groups_cost_what_their_evidence_does(
    kind: PositionKind | BearingKind, practice: Any
) -> None:
    scene = draw_scene(kind, np.random.default_rng(1))
    scored = PlotsRule(scene.object_density, area=scene.area)(scene_plots(scene))
    fit = practice._Fit(scene)
    cost, _, places, is_sound = fit.judged(scored.tuples - 1, range(kind.n_sensors))
    # Where bearings hardly cross, the two begin their steps from different places.
    same = np.abs(places - scored.positions).max(axis=1) < 1e-4 * kind.side
    assert np.mean(same & is_sound) > 0.9
    assert cost[same] == pytest.approx(scored.costs[same], abs=1e-3)


@pytest.mark.parametrize("pricing", ["distance", "evidence"])
def test_what_is_far_apart_is_grouped_rightly(pricing: str, practice: Any, scenes: Any) -> None:
    kind = PositionKind(4, 6, 300.0, clutter_per_object=0.0)
    scene = draw_scene(kind, np.random.default_rng(2))
    told = practice.by_pairs(scene, pricing)
    assert {tuple(group) for group in told.groups.tolist()} == scenes.true_groups(scene)
    measures = scenes.judged(scene, told.groups, told.places, 50.0)
    assert measures["right"] == 1.0
    assert measures["false"] == 0.0
    assert measures["GOSPA"] < 50.0


def test_triples_of_bearings_are_confirmed_by_the_rest(practice: Any, scenes: Any) -> None:
    scene = draw_scene(BearingKind(5, 3, 0.0005), np.random.default_rng(3))
    told = practice.by_triples(scene)
    assert scenes.judged(scene, told.groups, told.places, 90.0)["right"] == 1.0


@pytest.mark.parametrize("kind", KINDS)
def test_no_plot_is_used_twice(kind: PositionKind | BearingKind, practice: Any) -> None:
    scene = draw_scene(kind, np.random.default_rng(4))
    for order in ((0, 1, 2, 3), (3, 1, 0, 2)):
        groups = practice.sequential(scene, "distance", order).groups
        for column in groups.T:
            used = column[column >= 0]
            assert np.unique(used).size == used.size
