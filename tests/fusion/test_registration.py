"""A sensor's shift, turn and clock recovered within what is said of their errors."""

from dataclasses import replace

import numpy as np
import pytest

from oracles.biased_scenes import Scene, Truth, scene
from trackweave.errors import InvalidInputError
from trackweave.fusion.bias import BiasModel
from trackweave.fusion.bias_fit import NotObservableError
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.registration import Registration, register

TRUTH = Truth()
NOISE = TRUTH.process_noise


def registered(made: Scene, **options: object) -> Registration:
    return register(made.reference, made.other, process_noise=NOISE, **options)  # type: ignore[arg-type]


def squared_error(found: Registration, truth: np.ndarray) -> float:
    known = found.sigma > 0
    error = (found.bias - truth)[known]
    return float(error @ np.linalg.solve(found.covariance[np.ix_(known, known)], error))


@pytest.mark.slow
@pytest.mark.parametrize("is_told", [True, False], ids=["pairs told", "pairs found"])
def test_recovers_shift_turn_and_clock_within_three_sigma(is_told: bool) -> None:
    squared = []
    for seed in range(12):
        made = scene(TRUTH, np.random.default_rng(seed))
        found = registered(made, pairs=made.pairs if is_told else None)
        assert sorted(map(tuple, found.pairs)) == sorted(map(tuple, made.pairs))
        known = found.sigma > 0
        off = np.abs(found.bias - TRUTH.numbers())[known] / found.sigma[known]
        assert off.max() < 3.5
        squared.append(squared_error(found, TRUTH.numbers()))
    # χ² with 48 degrees of freedom, two-sided 0.1 %.
    assert 22.0 < sum(squared) < 84.0


@pytest.mark.parametrize("dim", [2, 3])
def test_recovers_range_and_azimuth_biases_of_a_sensor_elsewhere(dim: int) -> None:
    truth = Truth(
        dim=dim, translation=(0.0, 0.0, 0.0), angle=0.02, range_bias=200.0, late=0.0,
        centre=(30e3, 5e3, 0.0),
    )  # fmt: skip
    made = scene(truth, np.random.default_rng(7))
    model = BiasModel(("range", "azimuth"), position=truth.centre[:dim])
    found = registered(made, model=model)
    assert squared_error(found, truth.numbers("azimuth")) < 14.0
    assert found.range_bias == pytest.approx(200.0, abs=20.0)
    assert found.azimuth_bias == pytest.approx(0.02, abs=1e-3)


def test_names_every_number() -> None:
    made = scene(Truth(dim=3), np.random.default_rng(3))
    found = registered(made, pairs=made.pairs)
    assert found.translation == pytest.approx([1000.0, -300.0, 200.0], abs=40.0)
    assert found.rotation == pytest.approx(np.deg2rad(2.0), abs=2e-3)
    assert found.clock_offset == pytest.approx(0.5, abs=0.2)
    assert (found.range_bias, found.azimuth_bias) == (0.0, 0.0)
    assert len(found.names) == found.bias.shape[0] == 7
    assert (found.reference, found.sensor, found.dim) == ("A", "B", 3)


def test_a_registered_picture_lies_on_the_reference_and_is_as_uncertain_as_it_should() -> None:
    squared = []
    for seed in range(20):
        made = scene(TRUTH, np.random.default_rng(seed))
        picture = registered(made, pairs=made.pairs).apply(made.other[-1])
        order = np.argsort(picture.track)
        place = np.argsort(made.pairs[:, 1])
        error = picture.mean[order] - made.last[place]
        spread = picture.covariance[order]
        squared.append(
            np.einsum("ri,ri->", error, np.linalg.solve(spread, error[..., None])[..., 0])
        )
    # Ten tracks of four numbers each; the bias and the clock's process noise are common to them.
    assert 30.0 < np.mean(squared) < 50.0


def test_one_track_tells_a_translation_but_not_a_clock() -> None:
    truth = Truth(n_objects=1, angle=0.0, late=0.0)
    made = scene(truth, np.random.default_rng(4))
    found = registered(made, pairs=made.pairs, model=BiasModel(("translation",)))
    assert squared_error(found, truth.numbers()) < 14.0
    with pytest.raises(NotObservableError, match=r"clock.* cannot be told apart"):
        registered(made, pairs=made.pairs)


def test_says_what_objects_side_by_side_do_not_tell() -> None:
    truth = Truth(headings=0.0, process_noise=0.01)
    made = scene(truth, np.random.default_rng(5))
    even = [
        LocalPicture(
            p.sensor, p.time, p.track, p.mean - [0, 0, 0, 1] * (p.mean - 200.0), p.covariance
        )
        for p in made.other
    ]
    with pytest.raises(NotObservableError) as refusal:
        register(made.reference, even, process_noise=0.01, pairs=made.pairs)
    assert "translation_y, clock cannot be told apart" in str(refusal.value)
    assert "the tracks differ too little beside their own errors" in str(refusal.value)
    model = BiasModel(prior={"clock": 0.5})
    found = register(made.reference, even, process_noise=0.01, pairs=made.pairs, model=model)
    assert found.sigma[-1] == pytest.approx(0.5, rel=0.2)


def test_refuses_a_sensor_whose_tracks_are_all_false() -> None:
    made = scene(TRUTH, np.random.default_rng(1))
    others = scene(TRUTH, np.random.default_rng(99)).other
    with pytest.raises(NotObservableError, match="the tracks of B show no pattern of those of A"):
        register(made.reference, others, process_noise=NOISE)


def test_unlikely_pairs_count_by_their_probability() -> None:
    made = scene(TRUTH, np.random.default_rng(6))
    wrong = np.stack([made.pairs[:, 0], np.roll(made.pairs[:, 1], 1)], axis=1)
    soft = np.concatenate([np.c_[made.pairs, np.full(10, 0.8)], np.c_[wrong, np.full(10, 0.2)]])
    found = registered(made, pairs=soft)
    assert found.used[:10].min() > 0.9
    assert found.used[10:].max() < 0.2
    assert squared_error(found, TRUTH.numbers()) < 20.0


def test_sensors_of_different_rates_are_set_side_by_side() -> None:
    made = scene(TRUTH, np.random.default_rng(8))
    for reference, other in ((made.reference[::4], made.other), (made.reference, made.other[::4])):
        found = register(reference, other, process_noise=NOISE, pairs=made.pairs)
        assert squared_error(found, TRUTH.numbers()) < 20.0


@pytest.mark.slow
@pytest.mark.parametrize("apart", [0.7, 2.0])
@pytest.mark.parametrize("process_noise", [1e-3, 0.5])
def test_sensors_that_look_at_other_times_tell_as_much(apart: float, process_noise: float) -> None:
    squared = []
    truth = replace(TRUTH, n_times=40, late=0.5 + apart, process_noise=process_noise)
    for seed in range(12):
        made = scene(truth, np.random.default_rng(seed))
        other = [replace(picture, time=picture.time - apart) for picture in made.other]
        found = register(made.reference, other, process_noise=process_noise)
        assert np.all(found.sigma[:2] < 30.0)
        squared.append(squared_error(found, TRUTH.numbers()))
    # χ² with 48 degrees of freedom, two-sided 0.1 %.
    assert 22.0 < sum(squared) < 84.0


def test_the_same_pictures_give_the_same_bytes() -> None:
    made = scene(TRUTH, np.random.default_rng(9))
    first, second = registered(made), registered(made)
    assert first.bias.tobytes() == second.bias.tobytes()
    assert first.covariance.tobytes() == second.covariance.tobytes()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"process_noise": -1.0}, "process_noise: -1.0; expected a number ≥ 0"),
        ({"reference": []}, "reference: no pictures; expected at least one"),
        ({"other": ["A"]}, "other.*: 'A'; expected an instance of LocalPicture"),
        ({"pairs": [[1, 999]]}, "pairs, row 0: track 999; expected a track of the sensor"),
        ({"pairs": [[1, 101, 1.5]]}, "a third column beyond 0 to 1; expected probabilities"),
        ({"pairs": [[1]]}, "pairs: 1 columns; expected two track numbers"),
    ],
)
def test_refuses_what_it_cannot_use(change: dict[str, object], message: str) -> None:
    made = scene(Truth(n_times=3), np.random.default_rng(1))
    arguments = {
        "reference": made.reference, "other": made.other, "process_noise": NOISE,
        "pairs": made.pairs,
    } | change  # fmt: skip
    reference, other = arguments.pop("reference"), arguments.pop("other")
    with pytest.raises(InvalidInputError, match=message):
        register(reference, other, **arguments)  # type: ignore[arg-type]


def test_refuses_pictures_that_do_not_go_together() -> None:
    made = scene(Truth(n_times=3), np.random.default_rng(1))
    for other, message in (
        (made.reference, "pictures of A, the reference itself; expected another sensor"),
        (made.other[::-1], "other: times that do not rise"),
        ([made.other[0], made.reference[1]], "other: pictures of several sensors"),
        ([LocalPicture.empty("B", 0.0, 3)], "in 2 and in 3 dimensions; expected one of both"),
        ([LocalPicture.empty("B", 900.0, 2)], "expected times that overlap"),
    ):
        with pytest.raises(InvalidInputError, match=message):
            register(made.reference, other, process_noise=NOISE, pairs=made.pairs)
    kept = made.other[0], LocalPicture.empty("B", made.other[1].time, 2)
    gone = LocalPicture.empty("A", made.reference[0].time, 2), made.reference[1]
    with pytest.raises(NotObservableError, match="1 pairs of tracks, none of them there at one"):
        register(gone, kept, process_noise=NOISE, pairs=made.pairs[:1])


def test_applies_to_pictures_of_its_own_sensor_only() -> None:
    made = scene(TRUTH, np.random.default_rng(1))
    found = registered(made, pairs=made.pairs)
    with pytest.raises(InvalidInputError, match="of sensor A in 2 dimensions; expected sensor B"):
        found.apply(made.reference[0])
