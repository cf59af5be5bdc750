"""The study of Huo and others, repeated on a fraction of its scenes."""

import io

import matplotlib.image
import numpy as np
import polars as pl
import pytest

from trackweave.errors import InvalidInputError
from trackweave.studies import STUDIES, Study, huo_2008, study_of
from trackweave.studies.huo_methods import METHODS, best_by_generation, groups, successive
from trackweave.studies.scenes import SceneShape, TrackScene, draw_scene


def scene(**shape: object) -> TrackScene:
    return draw_scene(SceneShape(**shape), np.random.default_rng(3))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def study() -> Study:
    small = pytest.MonkeyPatch()
    small.setattr(huo_2008, "SPACINGS", (2.0, 16.0))
    small.setattr(huo_2008, "GENERATIONS", (1, 20, 100))
    calls: list[tuple[int, int]] = []
    found = study_of("huo-2008")(
        np.random.default_rng(1), True, lambda done, total: calls.append((done, total))
    )
    small.undo()
    assert calls[-1][0] == calls[-1][1]
    return found


@pytest.mark.slow
def test_the_report_says_that_the_document_prints_no_results(study: Study) -> None:
    assert "prints no result figures" in study.report
    assert study.claims[0].holds is None
    assert all(claim.text in study.report for claim in study.claims)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["spacing", "sizes", "convergence", "confirmation"])
def test_each_figure_is_a_picture_with_its_numbers(study: Study, name: str) -> None:
    picture = matplotlib.image.imread(io.BytesIO(study.files[f"{name}.png"]))
    assert picture.std() > 0.01
    numbers = pl.read_csv(study.files[f"{name}.csv"])
    assert numbers.height >= 2
    assert f"![]({name}.png)" in study.report


@pytest.mark.slow
def test_shares_are_percentages(study: Study) -> None:
    numbers = pl.read_csv(study.files["spacing.csv"])
    assert numbers.columns == ["spacing [σ]", *(f"{name} [%]" for name in METHODS)]
    shares = numbers.drop("spacing [σ]").to_numpy()
    assert shares.min() >= 0.0
    assert shares.max() <= 100.0


@pytest.mark.parametrize("method", METHODS)
def test_every_method_is_right_where_objects_are_far_apart(method: str) -> None:
    shown = scene(objects=6, spacing=200.0)
    assert shown.right(groups(method, shown, np.random.default_rng(1))) >= 0.8


def test_the_best_fitness_never_gets_worse_with_generations() -> None:
    excess = best_by_generation(scene(objects=8), (1, 5, 20, 100), np.random.default_rng(1))
    assert np.all(np.diff(excess) <= 1e-12)
    assert excess[0] > excess[-1] >= 0.0


def test_successive_associations_pair_one_track_of_each_sensor() -> None:
    shown = scene(times=3, spacing=50.0)
    outcomes = successive(shown, np.random.default_rng(1), memory="full")
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


def test_every_study_is_a_preset_and_others_are_refused_by_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert all(callable(study_of(name)) for name in STUDIES)
    monkeypatch.delitem(STUDIES, "hillis-1997")
    with pytest.raises(InvalidInputError, match="hillis-1997: a preset without a study so far"):
        study_of("hillis-1997")
    with pytest.raises(InvalidInputError, match="did you mean huo-2008"):
        study_of("huo2008")


def test_a_difference_within_its_own_doubt_tells_nothing() -> None:
    assert huo_2008._is_above(np.array([1.0, 1.2, np.nan, 0.9])) is True
    assert huo_2008._is_above(-np.array([1.0, 1.2, 0.9])) is False
    assert huo_2008._is_above(np.array([-5.0, 10.0, 0.6, -3.0])) is None
