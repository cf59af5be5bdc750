"""Models from outside the package do what ours do, to rounding."""

import numpy as np
import pytest

import trackweave as tw
from oracles.plugins import Cruising, Place, RangeAzimuth, Straight
from trackweave.errors import InvalidInputError

NOISE, SPEED = 1.0, 60.0
TURN = tw.Rotation(period=4.0, phase=0.3, direction=1)
RADARS = {"west": (-3000.0, 0.0), "north": (500.0, 4000.0)}


def places(steps, seed=3, count=5):
    """Yield time and the places of a few objects."""
    rng = np.random.default_rng(seed)
    place, speed = rng.uniform(-2000, 2000, (count, 2)), rng.normal(0, 12, (count, 2))
    for step in range(steps):
        place = place + 4.0 * speed
        yield 4.0 * step, place, speed


def scans_of_places():
    rng = np.random.default_rng(4)
    for time, place, _ in places(14):
        seen = place[rng.random(len(place)) < 0.9]
        alarms = rng.uniform(-2500, 2500, (4, 2))
        yield tw.Scan(
            time, "radar", np.concatenate([seen + rng.normal(0, 15, seen.shape), alarms])
        )


def scans_of_turns():
    """Yield scans of two turning radars, one of which moves; reports carry their own times."""
    rng = np.random.default_rng(5)
    for time, place, speed in places(10):
        for name, stands in RADARS.items():
            stands = np.array(stands) + (time * 8.0 if name == "north" else 0.0)
            everything = np.concatenate([place, rng.uniform(-2500, 2500, (3, 2))])
            east, north = (everything - stands).T
            moments = TURN.when(np.ceil(TURN.turned(time)) + _share(np.arctan2(east, north)))
            late = (moments - time)[: len(place), None]
            everything[: len(place)] += late * speed
            east, north = (everything - stands).T
            measured = np.stack([np.hypot(east, north), np.arctan2(east, north)], axis=1)
            measured += rng.normal(0, [15.0, 0.004], measured.shape)
            measured[:, 1] %= 2 * np.pi
            seen = rng.random(len(measured)) < 0.9
            yield tw.Scan(
                time=float(moments.max() + 0.01),
                sensor=name,
                measurement=measured[seen],
                moments=moments[seen],
                platform=np.r_[stands, np.zeros(4)] if name == "north" else None,
            )


def _share(azimuth):
    return (azimuth - TURN.azimuth(TURN.when(0.0))) % (2 * np.pi) / (2 * np.pi)


def radar_of(name, kind):
    return tw.Sensor(
        name,
        sigma=(15.0, 0.004),
        measurement=kind,
        clutter_density=3 / (6000 * 2 * np.pi),
        scan_period=4.0,
        rotation=TURN,
        position=RADARS[name],
        field_of_view=tw.FieldOfView(position=RADARS[name], max_range=7000.0),
    )


def tracked(scans, motion, sensors, **options):
    tracker = tw.MultiHypothesisTracker(motion=motion, sensors=sensors, window=4, **options)
    return [tracker.step(scan) for scan in scans]


def assert_equal(ours, foreign, fewest=4, rtol=1e-6):
    assert max(step.n_tracks for step in ours) >= fewest
    for own, other in zip(ours, foreign, strict=True):
        assert other.certificate.cost == pytest.approx(own.certificate.cost, abs=10 * rtol)
        assert other.n_sequences == own.n_sequences
        np.testing.assert_array_equal(other.tracks.track, own.tracks.track)
        np.testing.assert_array_equal(other.tracks.status, own.tracks.status)
        np.testing.assert_allclose(other.tracks.mean, own.tracks.mean, rtol=rtol, atol=1e-5)
        np.testing.assert_allclose(
            other.tracks.covariance, own.tracks.covariance, rtol=10 * rtol, atol=1e-5
        )
        np.testing.assert_array_equal(other.final.track, own.final.track)


OURS = tw.ConstantVelocity(NOISE, SPEED)
THEIRS = Straight(NOISE, SPEED)
POSITION, POLAR = tw.MeasurementKind.POSITION, tw.MeasurementKind.RANGE_AZIMUTH
MANOEUVRING = tw.Imm((OURS, tw.ConstantVelocity(30.0, SPEED)), (60.0, 15.0))


@pytest.mark.parametrize(
    ("motion", "kind"), [(THEIRS, POSITION), (OURS, Place()), (THEIRS, Place())]
)
@pytest.mark.parametrize("estimate", ["average", "best"])
def test_tracks_positions_as_the_compiled_way_does(motion, kind, estimate):
    def sensors(kind):
        return [tw.Sensor("radar", 15.0, clutter_density=2e-7, scan_period=4.0, measurement=kind)]

    scans = list(scans_of_places())
    ours = tracked(scans, OURS, sensors(POSITION), estimate=estimate)
    assert_equal(ours, tracked(scans, motion, sensors(kind), estimate=estimate))


@pytest.mark.parametrize(
    ("motion", "kind"), [(THEIRS, POLAR), (OURS, RangeAzimuth()), (THEIRS, RangeAzimuth())]
)
def test_tracks_what_turning_radars_see_as_the_compiled_way_does(motion, kind):
    scans = list(scans_of_turns())
    ours = tracked(scans, OURS, [radar_of(name, POLAR) for name in RADARS])
    assert_equal(ours, tracked(scans, motion, [radar_of(name, kind) for name in RADARS]))


def test_a_foreign_kind_serves_several_modes_of_motion():
    scans = list(scans_of_turns())
    ours = tracked(scans, MANOEUVRING, [radar_of(name, POLAR) for name in RADARS])
    kind = RangeAzimuth()
    theirs = tracked(scans, MANOEUVRING, [radar_of(name, kind) for name in RADARS])
    # Slopes of our own kinds are taken anew where a report is far from what was foreseen.
    assert_equal(ours, theirs, rtol=1e-3)


def scans_of_bearings():
    """Yield scans of two sensors that see directions, one after the other."""
    rng = np.random.default_rng(6)
    for time, place, _ in places(12, count=3):
        for number, (name, stands) in enumerate(RADARS.items()):
            seen = place[rng.random(len(place)) < 0.95]
            east, north = (seen - stands).T
            bearing = np.arctan2(east, north) + rng.normal(0, 0.002, len(seen))
            yield tw.Scan(time + 0.5 * number, name, bearing[:, None] % (2 * np.pi))


def test_bearings_cross_for_a_foreign_motion_as_for_ours():
    sensors = [
        tw.Sensor(
            name,
            sigma=0.002,
            measurement=tw.MeasurementKind.BEARING,
            clutter_density=0.01,
            scan_period=4.0,
            position=stands,
        )
        for name, stands in RADARS.items()
    ]
    scans = list(scans_of_bearings())
    ours, theirs = (tracked(scans, motion, sensors) for motion in (OURS, THEIRS))
    assert_equal(ours, theirs, fewest=2)


def test_a_late_scan_finds_its_place():
    scans = list(scans_of_places())
    scans[8], scans[9] = scans[9], scans[8]
    sensor = tw.Sensor("radar", 15.0, clutter_density=2e-7, scan_period=4.0)
    assert_equal(tracked(scans, OURS, [sensor]), tracked(scans, THEIRS, [sensor]))


@pytest.mark.parametrize("pairing", ["one-to-one", "nearest"])
def test_the_nearest_neighbour_tracker_takes_them_too(pairing):
    found = []
    for motion, kind in ((OURS, POSITION), (THEIRS, Place())):
        sensor = tw.Sensor("radar", 15.0, clutter_density=2e-7, scan_period=4.0, measurement=kind)
        tracker = tw.NearestNeighbourTracker(motion=motion, sensors=[sensor], pairing=pairing)
        found.append([tracker.step(scan) for scan in scans_of_places()])
    for own, other in zip(*found, strict=True):
        np.testing.assert_allclose(other.tracks.mean, own.tracks.mean, rtol=1e-6, atol=1e-5)
        np.testing.assert_array_equal(other.final.track, own.final.track)


def test_priors_begin_with_what_the_model_knows_of_the_rest():
    first = tracked(list(scans_of_places())[:6], OURS, [tw.Sensor("radar", 15.0)])[-1].tracks
    later = list(scans_of_places())[6:]
    sensor = tw.Sensor("radar", 15.0, clutter_density=2e-7, scan_period=4.0)
    ours, theirs = (tracked(later, each, [sensor], priors=first) for each in (OURS, THEIRS))
    assert_equal(ours, theirs)


def test_a_model_may_tell_velocities_in_its_own_way():
    scans = [tw.Scan(4.0 * k, "radar", [[3.0 * k, 60.0 * k]]) for k in range(12)]
    sensor = tw.Sensor("radar", 5.0, clutter_density=1e-8, scan_period=4.0)
    last = tracked(scans, Cruising(), [sensor])[-1].tracks
    np.testing.assert_allclose(last.mean[0], [33.0, 660.0, 0.75, 15.0], atol=1.5)
    assert np.linalg.eigvalsh(last.covariance[0]).min() > 0.0
    after = tracked([tw.Scan(48.0, "radar", [[36.0, 720.0]])], Cruising(), [sensor], priors=last)
    assert after[-1].tracks.track.tolist() == last.track.tolist()


def test_velocities_of_its_own_do_not_go_with_range_rates():
    kind = tw.MeasurementKind.RANGE_AZIMUTH_RATE
    sensor = tw.Sensor("radar", (5.0, 0.01, 1.0), measurement=kind)
    with pytest.raises(InvalidInputError, match="Cruising: sensor radar measures range-azimuth-r"):
        tracked([tw.Scan(0.0, "radar", [[50.0, 1.0, 2.0]])], Cruising(), [sensor])


class _Without:
    """A motion model that lacks something, or returns something else."""

    max_speed = 50.0

    def begin(self, position, covariance):
        return THEIRS.begin(position, covariance)

    def predict(self, mean, covariance, interval):
        return THEIRS.predict(mean, covariance, interval)


def _lacking(name, **changes):
    class Lacking(_Without):
        locals().update(changes)

    if name is not None:
        setattr(Lacking, name, None)
    return Lacking()


@pytest.mark.parametrize(
    ("model", "message"),
    [
        (_lacking("predict"), "motion Lacking: no method predict; expected predict(mean, "),
        (_lacking("begin"), "motion Lacking: no method begin; expected begin(position, "),
        (_lacking(None, max_speed=-1.0), "motion Lacking: max_speed -1.0; expected a finite"),
        (
            _lacking(None, begin=lambda self, place, spread: (place, spread)),
            "motion Lacking: begin returned means of shape (1, 2); expected (1, size)",
        ),
        (
            _lacking(None, predict=lambda self, mean, covariance, interval: (mean, covariance)),
            "motion Lacking: predict returned shape (",
        ),
        (
            _lacking(
                None,
                predict=lambda self, mean, covariance, interval: (
                    mean * np.nan,
                    covariance,
                    covariance,
                ),
            ),
            "motion Lacking: predict returned no finite number in row 0",
        ),
    ],
)
def test_a_bad_motion_model_is_named_with_what_was_expected(model, message):
    sensor = tw.Sensor("radar", 15.0, clutter_density=2e-7, scan_period=4.0)
    with pytest.raises(InvalidInputError) as refused:
        tracked(scans_of_places(), model, [sensor])
    assert str(refused.value).startswith(message)


class _Kind:
    columns = ("x", "y")

    def expect(self, mean, platform, reported):
        return Place().expect(mean, platform, reported)


def _kind(**changes):
    return type("Kind", (_Kind,), changes)()


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (_kind(columns="xy"), "measurement Kind: columns 'xy'; expected the names"),
        (_kind(expect=None), "measurement Kind: no method expect; expected expect(mean, "),
        (_kind(dim=5), "measurement Kind: dim 5; expected 2 or 3"),
        (
            _kind(first_state=lambda self, platform, reported: (reported.values, 0.0)),
            "measurement Kind: first_state returned shape (7, 2) and (); expected (7, 2) and "
            "(7, 2, 2)",
        ),
        (
            _kind(
                first_state=Place.first_state,
                expect=lambda self, mean, platform, reported: (mean[:, :2], mean),
            ),
            "measurement Kind: expect returned shape (7, 2) and (7, 4); expected (7, 2) and "
            "(7, 2, 4)",
        ),
        (
            _kind(context=("height_m",)),
            "measurement Kind: context of shape (7, 0); expected (7, 1)",
        ),
    ],
)
def test_a_bad_kind_is_named_with_what_was_expected(kind, message):
    with pytest.raises(InvalidInputError) as refused:
        tracked(scans_of_places(), OURS, [tw.Sensor("radar", 15.0, measurement=kind)])
    assert str(refused.value).startswith(message)


def test_an_empty_scan_needs_no_context():
    kind = _kind(context=("height_m",), first_state=Place.first_state)
    sensor = tw.Sensor("radar", 15.0, clutter_density=2e-7, scan_period=4.0, measurement=kind)
    scans = [
        tw.Scan(4.0 * k, "radar", [[3.0 * k, 5.0]] * (k != 3), context=[[8.0]] if k != 3 else None)
        for k in range(6)
    ]
    assert tracked(scans, OURS, [sensor])[-1].n_tracks == 1


def test_reports_of_a_kind_without_a_first_state_update_tracks_and_begin_none():
    known = tracked(scans_of_places(), OURS, [tw.Sensor("radar", 15.0)])[5].tracks
    sensor = tw.Sensor("radar", 15.0, clutter_density=2e-7, scan_period=4.0, measurement=_kind())
    alone = tracked(list(scans_of_places())[6:], OURS, [sensor])
    assert all(step.n_tracks == 0 for step in alone)
    steps = tracked(list(scans_of_places())[6:], OURS, [sensor], priors=known)
    assert set(steps[-1].tracks.track) <= set(known.track)
    assert steps[-1].tracks.hits.max() > known.hits.max() + 5
