"""Keys of a sensor beside those of all."""

import pytest

from config.test_fill import filled


@pytest.mark.parametrize(("usual", "own"), [("scan_period", "scans"), ("scans", "scan_period")])
def test_a_sensors_own_way_to_scan_leaves_no_room_for_the_others(usual: str, own: str) -> None:
    way = {"scan_period": 4.0, "scans": False}
    sensors = {"default": {usual: way[usual]}, "B": {own: way[own]}}
    told = {(sensor.scans, sensor.scan_period) for sensor in filled({"sensors": sensors}).sensors}
    assert told == {(True, 4.0), (False, None)}
