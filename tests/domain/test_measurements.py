"""What a kind of measurement says of its numbers, by which the house treats it."""

import pytest

from trackweave.domain.foreign_kind import kind_of
from trackweave.domain.measurements import MeasurementKind as Kind


class Lines:
    columns = ("line",)

    def expect(self, mean, platform, reported):
        raise NotImplementedError


OURS = [kind for kind in Kind if kind is not Kind.RANGE_RATE]


@pytest.mark.parametrize("kind", OURS)
@pytest.mark.parametrize("dim", [2, 3])
def test_the_azimuth_is_the_number_whose_column_says_so(kind, dim):
    columns = kind.columns(dim)
    told = {"azimuth_deg", "bearing_deg"}.intersection(columns)
    found = None if kind.azimuth is None else columns[kind.azimuth]
    assert [found] == (list(told) or [None])


@pytest.mark.parametrize("kind", OURS)
def test_only_places_stand_without_the_sensors_own(kind):
    assert kind.needs_place != kind.is_position == (kind.columns(3) == ("x", "y", "z"))


@pytest.mark.parametrize("kind", OURS)
def test_a_kind_is_a_place_a_direction_or_has_a_range(kind):
    assert [kind.is_position, kind.is_bearing_only, kind.has_range].count(True) == 1


@pytest.mark.parametrize("kind", OURS)
def test_without_its_rate_a_kind_has_the_same_columns_but_for_it(kind):
    left = tuple(name for name in kind.columns(2) if name != "range_rate_mps")
    assert kind.without_rate.columns(2) == left
    assert not kind.without_rate.has_rate


def test_of_a_kind_from_outside_none_of_it_is_known():
    kind = kind_of(Lines())
    known = kind.is_position, kind.is_bearing_only, kind.has_range, kind.needs_place
    assert not any(known)
    assert kind.azimuth is None
