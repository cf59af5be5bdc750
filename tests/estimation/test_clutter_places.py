"""Where false alarms are dense is learned, and what objects do is not taken for it."""

import numpy as np
import polars as pl
import pytest

import trackweave as tw
from estimation.test_estimate import table
from trackweave.estimation.clutter_places import with_clutter_places
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.estimation.refine import Followed

SIGMA, SIDE, SPREAD = 5.0, 6000.0, 150.0
AT = np.array([700.0, -400.0])


def scene(
    n_scans: int = 120, *, sea: float = 6.0, objects: int = 8, seed: int = 1
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times, places, and whose: boats that cross, thin false alarms, and a sea."""
    rng = np.random.default_rng(seed)
    time, place, whose = [], [], []
    start = rng.uniform(-SIDE / 2, SIDE / 2, (objects, 2))
    velocity = -start / (n_scans / 2) + rng.normal(0.0, 2.0, start.shape)
    for scan in range(n_scans):
        seen = rng.random(objects) < 0.9
        boats = start + scan * velocity + rng.normal(0.0, SIGMA, start.shape)
        thin = rng.uniform(-SIDE / 2, SIDE / 2, (rng.poisson(1.0), 2))
        dense = AT + rng.normal(0.0, SPREAD, (rng.poisson(sea), 2))
        place += [boats[seen], thin, dense]
        whose += [np.flatnonzero(seen), np.full(len(thin) + len(dense), -1)]
        time.append(np.full(seen.sum() + len(thin) + len(dense), float(scan)))
    return np.concatenate(time), np.concatenate(place), np.concatenate(whose)


def learned(
    told: tuple[np.ndarray, ...],
    *,
    scans: bool | None = None,
    n_scans: int = 120,
    echoes: tuple[tuple[float, ...], ...] = (),
) -> SensorEstimate:
    """Return what is learned of a sensor whose objects were followed rightly."""
    time, place, whose = told
    density = len(time) / n_scans / SIDE**2
    sensor = SensorEstimate(1.0, SIGMA, 0.9, density, SIDE**2, 8.0, scans=scans, echoes=echoes)
    reports = table(time, place, names=("near",))
    guess = Estimates({"near": sensor}, 0.1, 60.0, 1e-9, 1e-7)
    followed = Followed(whose, {"near": np.arange(float(n_scans))})
    return with_clutter_places(guess, reports, followed).sensors["near"]


@pytest.mark.parametrize("away", [0.0, 150.0])
def test_false_alarms_are_as_dense_as_they_are(away):
    found = learned(scene())
    own = tw.Sensor("near", clutter_density=found.clutter_density, echoes=found.echoes)
    there = AT[None] + np.array([away, 0.0])
    density = own.false_alarms(there, np.ones(1))[0] * found.clutter_density
    true = 6.0 * np.exp(-0.5 * (away / SPREAD) ** 2) / (2 * np.pi * SPREAD**2) + 1.0 / SIDE**2
    assert 0.5 < density / true < 2.0


def test_elsewhere_they_are_fewer_than_on_average():
    found = learned(scene())
    own = tw.Sensor("near", clutter_density=found.clutter_density, echoes=found.echoes)
    assert own.false_alarms(np.array([[-2500.0, 2500.0]]), np.ones(1))[0] == pytest.approx(1.0)
    assert found.clutter_density < 0.4 * 15.0 / SIDE**2


def test_objects_that_all_go_through_one_place_make_none():
    assert learned(scene(sea=0.0, objects=30)).echoes == ()


def test_what_an_earlier_round_took_for_dense_is_forgotten_where_it_was_followed_since():
    assert learned(scene(sea=0.0, objects=30), echoes=((0.0, 0.0, 100.0, 3.0),)).echoes == ()


def test_a_sensor_that_does_not_look_and_a_short_recording_tell_none():
    assert learned(scene(), scans=False).echoes == ()
    assert learned(scene(25), n_scans=25).echoes == ()


def test_tracks_that_wander_through_the_sea_are_no_objects():
    time, place, whose = scene()
    rng = np.random.default_rng(3)
    near = np.hypot(*(place - AT).T) < 2 * SPREAD
    for scan in np.unique(time):
        rows = np.flatnonzero((time == scan) & near & (whose < 0))
        if rows.size:
            whose[rng.choice(rows)] = 100
    found = learned((time, place, whose))
    assert sum(count for *_, count in found.echoes) > 4.0


@pytest.mark.slow
def test_a_sea_makes_few_tracks_and_no_turns():
    time, place, whose = scene(150, seed=5)
    result = tw.track(pl.DataFrame({"time": time, "x": place[:, 0], "y": place[:, 1]}))
    track = result.assignments["track"].fill_null(-1).to_numpy()
    assert np.mean(track[whose < 0] >= 0) < 0.05
    assert np.mean(track[whose >= 0] >= 0) > 0.95
    motion = result.run["configuration"]["motion"]
    assert motion["process_noise"] < 1.0
    assert result.run["configuration"]["sensors"]["default"]["echoes"]


def test_where_three_at_a_time_stand_in_turn_is_no_place():
    time, place, whose = scene(sea=0.0, objects=3)
    rng = np.random.default_rng(3)
    there = np.flatnonzero((np.arange(120) % 30 < 12) & (rng.random(120) < 0.95)).astype(float)
    there = np.repeat(there, 3)
    stands = AT + rng.normal(0.0, SIGMA, (there.size, 2))
    both = np.concatenate([time, there]), np.concatenate([place, stands])
    told = *both, np.concatenate([whose, np.full(there.size, -1)])
    order = np.argsort(told[0], kind="stable")
    assert learned(tuple(each[order] for each in told)).echoes == ()
