"""A live tracker goes by where reports show a turning sensor's beam, not by what is told of it."""

import copy

import numpy as np
import pytest

from trackweave.domain.measurements import MeasurementKind as Kind
from trackweave.domain.scans import Scan
from trackweave.models.motion import ConstantVelocity
from trackweave.models.rotation import FollowedRotation, Rotation
from trackweave.models.sensors import Sensor
from trackweave.trackers.live_beam import beam_with, rotation_by
from trackweave.trackers.multi_hypothesis import MultiHypothesisTracker


def radar(told: Rotation, **changed) -> Sensor:
    values = {
        "sigma": (4.0, 4.0), "detection_probability": 0.95, "clutter_density": 1e-7,
        "scan_period": 4.0, "rotation": told, "position": (0.0, 0.0),
    }  # fmt: skip
    return Sensor("radar", **(values | changed))


def sweeps(true: Rotation, n_turns: int, parts: int):
    """Yield parts of a beam's turns with reports of six objects that stand or move."""
    rng = np.random.default_rng(4)
    place = rng.uniform(-2500, 2500, (6, 2))
    speed = np.outer([0, 0, 0, 1, 1, 1], rng.normal(0, 5, 2))
    number = 0
    for part in range(n_turns * parts):
        begin, end = part / parts, (part + 1) / parts
        now = place + speed * float(true.when(begin))
        turn = np.arctan2(*now.T) - true.phase
        ahead = (true.direction * turn / (2 * np.pi) - begin) % 1.0
        met = np.flatnonzero((ahead < 1 / parts) & (rng.random(6) < 0.95))
        met = met[np.argsort(ahead[met])]
        moments = true.when(begin + ahead[met])
        seen = now[met] + rng.normal(0, 4, (met.size, 2))
        names = number + np.arange(met.size)
        number += met.size
        yield Scan(float(true.when(end)), "radar", seen, report=names, moments=moments), met


@pytest.mark.parametrize("parts", [1, 8], ids=["turns", "eighths"])
@pytest.mark.parametrize(
    ("true", "told"),
    [
        (Rotation(4.12), Rotation(4.0)),
        (Rotation(3.9), Rotation(4.0)),
        (Rotation(4.12, 0.0, -1), Rotation(4.0, 0.0, -1)),
    ],
    ids=["longer", "shorter", "reversed"],
)
def test_loses_and_doubles_nothing_where_a_turn_is_not_as_told(true, told, parts):
    tracker = MultiHypothesisTracker(
        motion=ConstantVelocity(0.05, 30.0), sensors=[radar(told)], window=4
    )
    names: dict[int, int] = {}
    track: dict[int, int] = {}
    for scan, met in sweeps(true, 40, parts):
        final = tracker.step(scan, rng=1).final
        names |= dict(zip(scan.report.tolist(), met.tolist(), strict=True))
        track |= dict(zip(final.report.tolist(), final.track.tolist(), strict=True))
    rest = tracker.pending()
    track |= dict(zip(rest.report.tolist(), rest.track.tolist(), strict=True))
    pairs = {(names[report], found) for report, found in track.items() if found >= 0}
    assert len(pairs) == len({found for _, found in pairs}) == 6
    # It takes some turns to show that the beam is elsewhere.
    assert np.mean([found < 0 for report, found in track.items() if report > 60]) < 0.01


@pytest.mark.parametrize("true", [Rotation(4.1), Rotation(4.0, 2.0)], ids=["period", "phase"])
def test_finds_the_beam(true):
    sensor = radar(Rotation(4.0))
    known = None
    for scan, _ in sweeps(true, 60, 8):
        known = beam_with(known, sensor, scan)
    found = rotation_by(known, sensor.rotation)
    assert found.period == pytest.approx(true.period, rel=2e-3)
    off = found.azimuth(scan.time) - true.azimuth(scan.time)
    assert abs((off + np.pi) % (2 * np.pi) - np.pi) < 0.03


def test_follows_turns_each_of_which_has_a_length_of_its_own():
    lengths = 4.0 * (1.0 + 0.05 * np.random.default_rng(6).normal(size=101))
    true = FollowedRotation(4.0, knots=np.r_[0.0, np.cumsum(lengths)], turns=np.arange(102.0))
    known, sensor, off = None, radar(Rotation(4.0)), []
    for scan, _ in sweeps(true, 100, 8):
        known = beam_with(known, sensor, scan)
        found = rotation_by(known, sensor.rotation)
        off.append(found.azimuth(scan.time) - true.azimuth(scan.time))
    beside = np.abs((np.array(off) + np.pi) % (2 * np.pi) - np.pi)
    # From one look to the next, a turn later, it may be off by what a turn differs.
    assert np.quantile(beside[80:], 0.95) < 2 * np.pi * 0.2


def test_a_beam_that_is_as_told_stays_so():
    told = Rotation(4.0, 0.3)
    known, sensor = None, radar(told)
    for scan, _ in sweeps(told, 40, 8):
        known = beam_with(known, sensor, scan)
        assert rotation_by(known, told) is told


def test_ranges_and_azimuths_show_a_beam_too():
    true, known = Rotation(4.1), None
    sensor = radar(Rotation(4.0), measurement=Kind.RANGE_AZIMUTH, sigma=(4.0, 0.002))
    for scan, _ in sweeps(true, 40, 1):
        east, north = scan.measurement.T
        polar = np.stack([np.hypot(east, north), np.arctan2(east, north)], axis=1)
        own = Scan(scan.time, "radar", polar, moments=scan.moments)
        known = beam_with(known, sensor, own)
    assert rotation_by(known, sensor.rotation).period == pytest.approx(4.1, rel=2e-3)


def test_reports_from_anywhere_show_no_beam():
    rng = np.random.default_rng(1)
    told = Rotation(4.0)
    known, sensor = None, radar(told)
    for end in np.arange(0.5, 400.0, 0.5):
        moments = np.sort(rng.uniform(end - 0.5, end, 2))
        scan = Scan(end, "radar", rng.uniform(-3e3, 3e3, (2, 2)), moments=moments)
        known = beam_with(known, sensor, scan)
        assert rotation_by(known, told) is told


def test_a_copy_follows_on_its_own():
    scans = [scan for scan, _ in sweeps(Rotation(4.12), 30, 8)]
    tracker = MultiHypothesisTracker(
        motion=ConstantVelocity(0.05, 30.0), sensors=[radar(Rotation(4.0))], window=4
    )
    for scan in scans[:120]:
        tracker.step(scan, rng=1)
    twin = copy.copy(tracker)
    for scan in scans[120:]:
        tracker.step(scan, rng=1)
    for scan in scans[120:]:
        mine = twin.step(scan, rng=1).tracks
    np.testing.assert_array_equal(mine.mean, tracker.tracks().mean)
