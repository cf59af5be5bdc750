"""What one sensor's tracker says: checked once, and predicted."""

import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.fusion.pictures import LocalPicture


def picture(**changes: object) -> LocalPicture:
    parts: dict[str, object] = {
        "sensor": "A",
        "time": 1.0,
        "track": [7, 9],
        "mean": [[0.0, 0.0, 1.0, 2.0], [5.0, 5.0, 0.0, 0.0]],
        "covariance": np.tile(np.diag([4.0, 4.0, 1.0, 1.0]), (2, 1, 1)),
    }
    return LocalPicture(**(parts | changes))  # type: ignore[arg-type]


def second(matrix: object) -> object:
    return [np.eye(4), matrix]


def test_prediction_moves_and_widens() -> None:
    later = picture().predicted(3.0, 0.3)
    assert later.time == 3.0
    assert later.mean[0].tolist() == [2.0, 4.0, 1.0, 2.0]
    # 4 + 2² · 1 + 0.3 · 2³ / 3, and 2 · 1 + 0.3 · 2² / 2 beside it.
    assert later.covariance[0, 0, 0] == pytest.approx(8.8)
    assert later.covariance[0, 0, 2] == pytest.approx(2.6)
    assert later.track.tolist() == [7, 9]


def test_prediction_over_no_time_is_the_picture_itself() -> None:
    now = picture()
    assert now.predicted(1.0, 0.3) is now


def test_an_empty_picture_has_no_tracks_and_can_be_predicted() -> None:
    empty = LocalPicture.empty("A", 1.0, 3)
    assert len(empty.predicted(2.0, 0.1)) == 0
    assert empty.dim == 3


def test_takes_what_rounding_made_of_units_that_are_worlds_apart() -> None:
    tiny = np.diag([1e8, 1e8, 1e-6, 1e-6])
    assert len(picture(covariance=[tiny, tiny])) == 2


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sensor": ""}, "sensor: ''; expected a name"),
        ({"time": np.nan}, "sensor A, time: nan; expected a finite number"),
        ({"track": [7, 7]}, "sensor A: track 7 is there 2 times; expected each track once"),
        ({"track": [7.5, 8]}, "sensor A, track: .*expected whole numbers"),
        ({"mean": np.zeros((2, 3))}, "sensor A, mean: 3 numbers a track; expected position"),
        ({"mean": np.full((2, 4), np.nan)}, "sensor A, track 7: a mean that is not finite"),
        ({"covariance": None}, "sensor A: tracks without covariance; expected one of each"),
        ({"covariance": np.eye(4)}, "sensor A, covariance: an array of shape"),
        (
            {"covariance": second(np.full((4, 4), np.inf))},
            "track 9: a covariance that is not finite",
        ),
        ({"covariance": second(np.tri(4))}, "sensor A, track 9: a covariance that is not symm"),
        ({"covariance": second(-np.eye(4))}, "sensor A, track 9: .*not positive definite"),
        ({"covariance": second(np.ones((4, 4)))}, "sensor A, track 9: .*not positive definite"),
        ({"covariance": np.zeros((2, 4, 4))}, "sensor A, track 7: .*not positive definite"),
    ],
)
def test_refuses_what_is_no_picture(changes: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        picture(**changes)


@pytest.mark.parametrize(
    ("time", "noise", "message"),
    [
        (0.5, 0.1, "tracks of 1 s are wanted at 0.5 s; expected a time not before theirs"),
        (2.0, -0.1, "process_noise: -0.1; expected a number ≥ 0"),
    ],
)
def test_refuses_to_predict_backwards(time: float, noise: float, message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        picture().predicted(time, noise)
