import numpy as np
import pytest

from trackweave.errors import InvalidInputError
from trackweave.models.rotation import Rotation

CLOCKWISE = Rotation(4.0, 0.5)
COUNTER = Rotation(4.0, 0.5, -1)


@pytest.mark.parametrize(("time", "turned"), [(0.0, 0.0), (1.0, 0.25), (2.5, 0.625), (9.0, 0.25)])
def test_the_beam_turns_either_way(time, turned):
    angle = 2 * np.pi * turned
    assert CLOCKWISE.azimuth(time) == pytest.approx((0.5 + angle) % (2 * np.pi))
    assert COUNTER.azimuth(time) == pytest.approx((0.5 - angle) % (2 * np.pi))


def test_times_counted_from_1970_do_not_blur_the_beam():
    # A thousandth of a degree is some hundredth of a microsecond of a turn.
    assert CLOCKWISE.azimuth(1.6e9 + 1.0) == pytest.approx(CLOCKWISE.azimuth(1.0), abs=1e-5)


@pytest.mark.parametrize("rotation", [CLOCKWISE, COUNTER], ids=["clockwise", "counter"])
@pytest.mark.parametrize(("start", "end"), [(0.0, 1.0), (3.0, 5.5), (-2.0, -1.5)])
def test_a_sector_holds_where_the_beam_was_and_nothing_else(rotation, start, end):
    first, width = rotation.sector(start, end)
    assert width == pytest.approx(2 * np.pi * (end - start) / 4.0)
    for time in np.linspace(start, start + 4.0, 41)[1:-1]:
        inside = (rotation.azimuth(time) - first) % (2 * np.pi) <= width + 1e-9
        assert inside == (time <= end + 1e-9)


def test_more_than_a_turn_is_a_turn():
    assert CLOCKWISE.sector(0.0, 11.0)[1] == pytest.approx(2 * np.pi)
    assert CLOCKWISE.sector(3.0, 3.0)[1] == 0.0
    assert CLOCKWISE.sector(3.0, 2.0)[1] == 0.0


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"period": 0.0}, "period 0.0; expected a number > 0"),
        ({"period": -4.0}, "period"),
        ({"period": np.nan}, "period"),
        ({"period": np.inf}, "period"),
        ({"phase": np.nan}, "phase"),
        ({"direction": 0}, "direction 0; expected 1 or -1"),
        ({"direction": 2}, "direction"),
    ],
)
def test_refuses_what_does_not_turn(values, message):
    with pytest.raises(InvalidInputError, match=message):
        Rotation(**({"period": 4.0} | values))
