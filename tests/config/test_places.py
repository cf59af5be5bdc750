"""Where sensors stand is asked for, of all at once."""

from dataclasses import replace

import pytest

from trackweave.config import load_configuration
from trackweave.config.fill import fill
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.errors import InvalidInputError

RADAR = ObservedSensor(Kind.RANGE_AZIMUTH, needs_place=True, extent=1e6)


def refused(names: tuple[str, ...], told: dict[str, object]) -> str:
    observed = dict.fromkeys(names, RADAR)
    with pytest.raises(InvalidInputError) as caught:
        fill(load_configuration({"sensors": told}), None, names, observed=observed)
    return str(caught.value)


def test_all_sensors_without_a_position_are_named_at_once() -> None:
    told = refused(("B", "025/011", "C"), {"C": {"position": [5.0, 6.0]}})
    assert told.startswith("sensors.B.position, sensors.025/011.position: left out; expected")
    assert 'under [sensors."B"], [sensors."025/011"] a line such as position = [0.0, 0' in told
    assert "sensors.C" not in told


def test_very_many_are_counted() -> None:
    told = refused(tuple(f"s{number}" for number in range(30)), {})
    assert "sensors.s19.position and 10 more: left out" in told
    assert '[sensors."s2"], …' in told


def test_it_is_said_from_where_a_place_counts_and_how_degrees_are_told() -> None:
    radar = replace(RADAR, plane="x counts east of Fiji")
    with pytest.raises(InvalidInputError) as caught:
        fill(load_configuration({}), None, ("A", "B"), observed={"A": RADAR, "B": radar})
    told = str(caught.value)
    assert told.endswith("of any format). x counts east of Fiji")
    assert "or sensor_lat,sensor_lon in degrees, of a table" in told
