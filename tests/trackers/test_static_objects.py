"""Objects found in plots, against brute force and against the truth of scenes."""

from typing import Any

import numpy as np
import pytest

from oracles.assignment import least_cost_of_tuples
from trackweave.association.plots_rule import PlotsRule, ScoredTuples, SensorPlots, scene_plots
from trackweave.association.sampling import Sampling
from trackweave.errors import InvalidInputError
from trackweave.metrics import gospa
from trackweave.simulation.scenes import PositionKind, Scene, draw_scene
from trackweave.solvers import Auto
from trackweave.trackers.static_objects import FoundObjects, ObjectFinder

pytestmark = pytest.mark.slow

REACH = 50.0


def rng(seed: int = 1) -> np.random.Generator:
    return np.random.default_rng(seed)


def found_in(scene: Scene, **options: Any) -> tuple[ScoredTuples, FoundObjects]:
    scored = PlotsRule(scene.object_density, area=scene.area)(scene_plots(scene))
    return scored, ObjectFinder(REACH, **options)(scored, rng=rng())


def n_right(scene: Scene, tuples: np.ndarray) -> int:
    """Return how many tuples are all that one object made."""
    right = 0
    for row in tuples.tolist():
        seen = {int(label[n - 1]) for label, n in zip(scene.label, row, strict=True) if n}
        if len(seen) == 1 and (number := seen.pop()) >= 0:
            right += [int(np.sum(label == number)) for label in scene.label] == [
                int(n > 0) for n in row
            ]
    return right


SCENES = [draw_scene(PositionKind(3, 20, 5.0), rng(seed)) for seed in range(1, 13)]


@pytest.fixture(scope="module")
def found() -> list[tuple[Scene, ScoredTuples, FoundObjects]]:
    """Return what is found in each scene."""
    return [(scene, *found_in(scene)) for scene in SCENES]


def test_one_object_far_from_false_alarms_is_found_where_it_is() -> None:
    plots = [[[0.0, 3.0], [500.0, 0.0]], [[3.0, 0.0], [0.0, 900.0]], [[3.0, 3.0]]]
    sensors = [SensorPlots(np.array(value), 5.0, 1e6, 1.0) for value in plots]
    scored = PlotsRule(1e-6)(sensors)
    found = ObjectFinder(25.0)(scored, rng=rng())
    assert scored.tuples[found.groups].tolist()[0] == [1, 1, 1]
    assert found.groups.tolist() == found.likeliest.tolist()
    assert found.group_probability[0] > 0.95
    assert found.existence == pytest.approx([1.0], abs=0.02)
    assert found.positions == pytest.approx(np.array([[2.0, 2.0]]), abs=0.2)
    assert found.covariances[0] == pytest.approx(np.eye(2) * 25.0 / 3.0, abs=0.5)
    assert found.certificate.gap == 0.0


def test_groups_have_the_greatest_sum_of_probabilities() -> None:
    scene = draw_scene(PositionKind(3, 3, 3.0), rng(3))
    scored, found = found_in(scene)
    chance = found.draws.probability
    rows = np.flatnonzero(chance > 0)
    assert rows.size > 10
    best = -least_cost_of_tuples(scored.tuples[rows], -chance[rows])
    assert chance[found.groups].sum() == pytest.approx(best)
    assert found.group_probability == pytest.approx(chance[found.groups])


def test_more_groups_are_right_than_those_of_the_most_probable_answer(
    found: list[tuple[Scene, ScoredTuples, FoundObjects]],
) -> None:
    right, expected, likeliest = 0, 0.0, 0
    for scene, scored, objects in found:
        right += n_right(scene, scored.tuples[objects.groups])
        expected += float(objects.group_probability.sum())
        likeliest += n_right(scene, scored.tuples[objects.likeliest])
    assert right > likeliest
    # What it says of itself is so, within three standard deviations of some eighty.
    assert right == pytest.approx(expected, abs=3.0 * np.sqrt(expected))


def test_places_are_nearer_to_the_truth_than_those_of_the_most_probable_answer(
    found: list[tuple[Scene, ScoredTuples, FoundObjects]],
) -> None:
    told, likeliest = [], []
    for scene, scored, objects in found:
        told.append(gospa(scene.objects, objects.positions, REACH).total)
        places = scored.positions[objects.likeliest]
        likeliest.append(gospa(scene.objects, places, REACH).total)
    assert np.mean(told) < np.mean(likeliest)


def test_a_least_probability_leaves_out_what_is_less_probable() -> None:
    _, found = found_in(SCENES[0])
    _, few = found_in(SCENES[0], least_probability=0.3)
    assert (found.group_probability < 0.3).any()
    assert (few.group_probability > 0.3).all()
    assert few.groups.size > 0


def test_the_same_seed_finds_the_same() -> None:
    (_, first), (_, second) = found_in(SCENES[1]), found_in(SCENES[1])
    assert first.groups.tolist() == second.groups.tolist()
    assert first.positions.tobytes() == second.positions.tobytes()


def test_a_stop_at_once_still_tells_something() -> None:
    scored = PlotsRule(SCENES[0].object_density)(scene_plots(SCENES[0]))
    found = ObjectFinder(REACH)(scored, rng=rng(), stop=lambda: True)
    assert len(found.draws.answers) == 1
    assert found.positions.shape[1] == 2


def test_nothing_is_found_in_nothing() -> None:
    scored = PlotsRule(1e-6)([SensorPlots(np.empty((0, 2)), 5.0, 1e6, 1.0)] * 3)
    found = ObjectFinder(REACH)(scored, rng=rng())
    assert found.groups.size == found.likeliest.size == found.existence.size == 0
    assert found.positions.shape == (0, 2)
    assert found.covariances.shape == (0, 2, 2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"cutoff": 0.0}, "cutoff: 0.0; expected a finite number > 0"),
        ({"cutoff": "far"}, "cutoff: 'far'; expected a finite number"),
        ({"least_probability": 1.0}, "least_probability: 1.0; expected at least 0 and below 1"),
        ({"solver": Auto}, "solver"),
        ({"sampling": 500}, "sampling"),
    ],
)
def test_parameters_out_of_range_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        ObjectFinder(**{"cutoff": REACH, **options})


def test_arguments_of_other_kinds_are_refused() -> None:
    scored = PlotsRule(1e-6)([SensorPlots(np.empty((0, 2)), 5.0, 1e6, 1.0)] * 2)
    with pytest.raises(InvalidInputError, match="scored"):
        ObjectFinder(REACH)("tuples", rng=rng())  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match="rng"):
        ObjectFinder(REACH)(scored, rng=1.5)  # type: ignore[arg-type]
    assert Sampling() == ObjectFinder(REACH).sampling
