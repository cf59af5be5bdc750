"""What the study of Huo and others rests on: its methods, scenes and figures."""

import io
from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest

from trackweave.association.chain_rule import track_chains
from trackweave.plotting.strings import StringRow, picture_of_strings
from trackweave.solvers import Exact, ListGenetic
from trackweave.studies.huo_2008 import CHROMOSOME
from trackweave.studies.huo_claims import _better
from trackweave.studies.huo_methods import (
    METHODS,
    TWO_NODES,
    curve,
    decoded,
    groups,
    successive,
    two_nodes,
)
from trackweave.studies.judging import Verdict
from trackweave.studies.scenes import SceneShape, TrackScene, draw_scene


def scene(**shape: object) -> TrackScene:
    return draw_scene(SceneShape(**shape), np.random.default_rng(3))  # type: ignore[arg-type]


def rng() -> np.random.Generator:
    return np.random.default_rng(1)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_is_right_where_objects_are_far_apart(method: str) -> None:
    shown = scene(objects=6, spacing=200.0)
    assert shown.right(groups(shown, [method], rng())[method]) >= 0.8


@pytest.mark.parametrize("method", TWO_NODES)
def test_methods_for_two_nodes_are_right_where_objects_are_far_apart(method: str) -> None:
    shown = scene(sensors=2, objects=8, spacing=200.0)
    assert shown.right(two_nodes(method, shown)) >= 0.7


def test_the_modified_method_tells_apart_what_common_errors_blur() -> None:
    shares = np.zeros(2)
    for seed in range(40):
        shown = draw_scene(
            SceneShape(2, spacing=3.0, seen=0.6, shared=0.9), np.random.default_rng(seed)
        )  # fmt: skip
        shares += [shown.right(two_nodes(method, shown)) for method in TWO_NODES[:2]]
    assert shares[1] > shares[0]
    plain = scene(sensors=2, spacing=3.0)
    same = [two_nodes(method, plain)[1].tolist() for method in TWO_NODES[:2]]
    assert same[0] == same[1]


def test_figure_1_decodes_to_the_documents_tuples() -> None:
    found = decoded(CHROMOSOME)
    assert found == [tuple(column) for column in CHROMOSOME.T.tolist()]
    assert {(1, 9, 4), (2, 10, 7), (10, 5, 2)} <= set(found)


def test_figures_1_and_2_are_drawn() -> None:
    rows = [StringRow("before", ("1", "2", "3"), (0, 2))]
    picture = picture_of_strings({"Fig. 2": rows})
    assert picture == picture_of_strings({"Fig. 2": rows})
    assert matplotlib.image.imread(io.BytesIO(picture)).std() > 0.1


def test_a_curve_never_rises_and_goes_on_as_one_search() -> None:
    problem = track_chains(scene(objects=8).estimates).problem()
    search = ListGenetic(
        population=50, generations=10**6, evaluations=10**6, patience=10**6, seeded=False,
        improvement=False, decompose=False,
    )  # fmt: skip
    found = curve(problem, search, [100, 1_000, 10_000], rng())
    assert found == sorted(found, reverse=True)
    assert found[0] > found[-1] >= Exact()(problem, rng=rng()).cost - 1e-9
    whole = replace(search, evaluations=1_000)(problem, rng=rng())
    assert found[1] == pytest.approx(whole.cost, rel=0.5)


def test_successive_associations_pair_one_track_of_each_sensor() -> None:
    shown = scene(times=3, spacing=50.0)
    outcomes = successive(shown, rng(), full=True)
    assert len(outcomes) == 3
    assert all(len(each) == 3 for outcome in outcomes for each in outcome)
    assert len(outcomes[-1] & shown.tuples()) >= 8


def test_right_counts_tracks_whose_group_is_exactly_their_object() -> None:
    shown = scene(objects=4)
    truth = list(shown.truth)
    assert shown.right(truth) == 1.0
    mixed = [truth[0], truth[1], (truth[2] + 1) % 4]
    assert shown.right(mixed) == 0.0
    apart = [truth[0], truth[1], truth[2] + 100 * (truth[2] == 0)]
    assert shown.right(apart) == pytest.approx(9 / 12)


def test_sensors_miss_objects_at_random() -> None:
    shown = scene(objects=200, seen=0.5)
    assert [80 < mine.size < 120 for mine in shown.truth] == [True] * 3
    assert len(shown.tuples()) == np.unique(np.concatenate(shown.truth)).size


def test_errors_may_have_a_part_in_common() -> None:
    shown = scene(sensors=2, objects=400, shared=0.75)
    alone = scene(sensors=2, objects=400)
    apart = []
    for one in (shown, alone):
        first, second = (
            each.mean[0, np.argsort(mine)]
            for each, mine in zip(one.estimates, one.truth, strict=True)
        )
        apart.append((first - second)[:, 0].std())
    assert apart[0] < 0.7 * apart[1]


def test_a_difference_within_its_own_doubt_tells_nothing() -> None:
    assert _better("default", np.array([1.0, 1.2, np.nan, 0.9])).verdict == Verdict.HOLDS
    assert _better("default", -np.array([1.0, 1.2, 0.9])).verdict == Verdict.DOES_NOT_HOLD
    assert _better("default", np.array([-5.0, 10.0, 0.6, -3.0])).verdict == Verdict.CANNOT_BE_TOLD
