"""Keys of a sensor beside those of all."""

import pytest

from config.test_fill import filled
from trackweave.association.growth_limits import GrowthLimits
from trackweave.config.presets import PRESETS, preset_notes


@pytest.mark.parametrize(("usual", "own"), [("scan_period", "scans"), ("scans", "scan_period")])
def test_a_sensors_own_way_to_scan_leaves_no_room_for_the_others(usual: str, own: str) -> None:
    way = {"scan_period": 4.0, "scans": False}
    sensors = {"default": {usual: way[usual]}, "B": {own: way[own]}}
    told = {(sensor.scans, sensor.scan_period) for sensor in filled({"sensors": sensors}).sensors}
    assert told == {(True, 4.0), (False, None)}


@pytest.mark.parametrize("preset", [name for name in PRESETS if preset_notes(name)])
def test_a_preset_to_the_letter_trusts_what_is_told_unless_the_file_does_not(preset: str) -> None:
    sensors = {"default": {"sigma": 3.0}, "B": {"trust": False}}
    settings = filled({"sensors": sensors}, preset=preset)
    assert [sensor.trusts("sigma") for sensor in settings.sensors] == [True, False]
    assert not any("says otherwise" in note for note in settings.notes)


@pytest.mark.parametrize("trust", [True, ["sigma"], False, []])
def test_a_sensor_trusts_the_keys_that_are_named(trust: object) -> None:
    sensor = filled({"sensors": {"A": {"trust": trust}}}).sensors[0]
    assert sensor.trusts("sigma") == bool(trust)
    assert filled({}).sensors[0].trust is False


@pytest.mark.parametrize(
    ("scans", "limits"),
    [
        ((False, False), GrowthLimits.of_lone_reports()),
        ((False, True), GrowthLimits()),
        ((None, None), GrowthLimits()),
    ],
)
def test_where_no_sensor_looks_what_begins_has_wider_limits(
    scans: tuple[bool | None, bool | None], limits: GrowthLimits
) -> None:
    own = {
        name: {} if word is None else {"scans": word}
        for name, word in zip("AB", scans, strict=True)
    }
    assert filled({"sensors": own}).growth == limits
