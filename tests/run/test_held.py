"""What a receiver goes on saying of an aircraft that it no longer hears is old news."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from service.recordings import held_places
from trackweave.models.sensors import Sensor
from trackweave.run.held import HeldPlaces

EVERY = 10.0


def said(ways: list[list[float]]) -> list[list[bool]]:
    """Return of each look which places are held; objects go along one axis, a column each."""
    known = HeldPlaces.of(Sensor("adsb", scan_period=EVERY), is_on_earth=True)
    assert known is not None
    looks = zip(*ways, strict=True)
    return [
        known.take(EVERY * number, np.array([[x, 1e4 * k] for k, x in enumerate(look)]))
        for number, look in enumerate(looks)
    ]


def test_what_flew_and_stands_still_to_the_last_digit_is_held_until_it_goes_on():
    looks = said([[0.0, 1000.0, 2010.0, 3000.0, 3000.0, 3000.0, 6000.0, 7000.0]])
    assert [look[0] for look in looks] == [False] * 4 + [True] * 2 + [False] * 2


@pytest.mark.parametrize(
    "way",
    [
        [500.0] * 8,  # at rest
        [0.0, 100.0, 150.0, 160.0, 160.0, 160.0, 160.0, 160.0],  # brakes
        [0.0, 10.0, 20.0, 30.0, 30.0, 30.0, 30.0, 30.0],  # may have stopped there
        [0.0, 9e4, 18e4, 27e4, 27e4, 27e4, 27e4, 27e4],  # from one to the next
    ],
)
def test_what_rests_or_brakes_is_no_old_news(way):
    assert not any(look[0] for look in said([way]))


def test_a_look_at_which_it_was_missed_changes_nothing():
    known = HeldPlaces.of(Sensor("adsb", scan_period=EVERY), is_on_earth=True)
    assert known is not None
    none = np.empty((0, 2))
    at = {0: 0.0, 1: 1000.0, 3: 3000.0, 5: 3000.0, 6: 3000.0, 8: 3000.0, 13: 3000.0}
    told = {
        look: known.take(EVERY * look, np.array([[at[look], 0.0]]) if look in at else none)
        for look in range(14)
    }
    assert [look for look, again in told.items() if again == [True]] == [5, 6, 8]


@pytest.mark.parametrize("sensor", [Sensor("a", scans=False), Sensor("b", scan_period=1.0)])
def test_only_who_looks_and_tells_latitudes_is_asked(sensor):
    assert HeldPlaces.of(sensor, is_on_earth=False) is None
    assert (HeldPlaces.of(sensor, is_on_earth=True) is None) == (sensor.scans is False)


def test_aircraft_keep_their_names_while_their_last_places_are_said():
    frame, configuration = held_places()
    found = tw.track(frame, configuration)
    (note,) = [note for note in found.run["notes"] if "old news" in note]
    assert note.startswith(f"{found.run['totals']['doubles']} of {len(frame)} reports say a place")
    track = found.assignments["track"].fill_null(-1)
    for each in found.run["doubles"]:
        assert track[int(each["report"]) - 1] == track[int(each["of"]) - 1]
    on_a_plane = {key: value for key, value in configuration.items() if key != "frame"}
    plane = frame.select("time", x=pl.col("lon") * 70e3, y=(pl.col("lat") - 51.0) * 111e3)
    there = tw.track(plane, on_a_plane)
    assert there.run["totals"]["doubles"] == 0
    # Of twelve aircraft four are not heard for minutes.
    assert track.n_unique() <= 13 < there.assignments["track"].n_unique()
