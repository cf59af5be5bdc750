"""How often false alarms come again, from pairs of reports at one place."""

import numpy as np
import pytest

from estimation.test_estimate import table
from trackweave.estimation.estimates import Estimates, SensorEstimate
from trackweave.estimation.persistence import notes_on_persistence, with_persistence
from trackweave.estimation.refine import Followed

SIGMA, SIDE, N_SCANS = 10.0, 4000.0, 80
NAME = table(np.zeros(1), np.zeros((1, 2))).sensors[0]


def estimates():
    sensor = SensorEstimate(
        scan_period=2.0, sigma=SIGMA, detection_probability=0.9, clutter_density=1e-6,
        covered=SIDE**2, n_objects=5.0,
    )  # fmt: skip
    return Estimates({NAME: sensor}, 0.1, 20.0, 1e-9, 1e-7)


def persistence(places):
    """Return what is found in the places of each scan, of which none is on a track."""
    time = np.repeat(2.0 * np.arange(N_SCANS), [len(each) for each in places])
    reports = table(time, np.concatenate(places))
    looks = {NAME: 2.0 * np.arange(N_SCANS)}
    followed = Followed(np.full(len(reports), -1), looks)
    return with_persistence(estimates(), reports, followed)


def lasting(rng, lives, count=15, stands=0):
    """Return places that begin at random and last for some scans each, and some that stay."""
    stay = rng.uniform(0, SIDE, (stands, 2))
    places = [[*stay] for _ in range(N_SCANS)]
    for scan in range(N_SCANS):
        for place in rng.uniform(0, SIDE, (count, 2)):
            for later in range(scan, min(N_SCANS, scan + lives(rng))):
                places[later].append(place)
    return [rng.normal(each, SIGMA) for each in places]


@pytest.mark.parametrize("chance", [0.25, 0.4, 0.55])
def test_the_chance_is_found_beside_what_stands(chance):
    places = lasting(np.random.default_rng(1), lambda rng: rng.geometric(1 - chance), stands=8)
    found = persistence(places)
    assert found.sensors[NAME].clutter_persistence == pytest.approx(chance, abs=0.08)
    assert "come again at their place" in notes_on_persistence(found, {})[0]
    assert notes_on_persistence(found, {NAME: chance}) == []
    assert "is told as 0.9, but" in notes_on_persistence(found, {NAME: 0.9})[0]


@pytest.mark.parametrize(
    ("lives", "stands"),
    [
        (lambda rng: 1, 0),
        (lambda rng: 1, 20),
        (lambda rng: 12, 0),
        (lambda rng: rng.geometric(0.1), 5),
    ],
    ids=["each for itself", "what stands", "short-lived objects", "objects of all ages"],
)
def test_nothing_is_found_where_none_comes_again(lives, stands):
    found = persistence(lasting(np.random.default_rng(2), lives, stands=stands))
    assert found.sensors[NAME].clutter_persistence == 0.0
    assert notes_on_persistence(found, {}) == []


def test_few_scans_or_reports_tell_nothing():
    places = lasting(np.random.default_rng(1), lambda rng: rng.geometric(0.6), count=1)
    assert persistence(places).sensors[NAME].clutter_persistence == 0.0


@pytest.mark.parametrize("chance", [0.4, 0.55])
def test_a_chance_stays_one_where_several_lie_at_a_place(chance):
    rng = np.random.default_rng(1)
    places = lasting(rng, lambda rng: rng.geometric(1 - chance))
    many = [rng.normal(np.repeat(each, 4, axis=0), SIGMA) for each in places]
    found = persistence(many).sensors[NAME].clutter_persistence
    assert found == pytest.approx(chance, abs=0.08)
