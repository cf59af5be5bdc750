"""What no scan concerns is inactive: nothing that is said of tracks may tell."""

import numpy as np
import pytest

from oracles.scenes import all_assignments, groups, run, sensor, tracker
from trackweave.association import inactive
from trackweave.domain.scans import Scan
from trackweave.models.coverage import FieldOfView
from trackweave.solvers import Exact, Greedy

QUARTERS = ("north-east", "south-east", "south-west", "north-west")
AREA = 4000.0
ALL_INACTIVE, NONE_INACTIVE = 0, 10**9


def quarters(**changed):
    """Return four sensors that look at a quarter each, one after the other."""
    return [
        sensor(
            name, scan_period=4.0,
            field_of_view=FieldOfView(azimuth_deg=(90.0 * number, 90.0 * (number + 1))),
            **changed,
        )
        for number, name in enumerate(QUARTERS)
    ]  # fmt: skip


def scans(seed, *, seconds=20, objects=24, clutter=3):
    """Return what they see of objects on straight lines, pairs of which are close."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(-AREA, AREA, (objects, 2))
    start[1::2] = start[::2] + rng.normal(size=start[::2].shape) * 40.0
    speed = rng.uniform(-20.0, 20.0, (objects, 2))
    found = []
    for time in range(seconds):
        quarter = time % 4
        place = start + speed * time
        azimuth = np.degrees(np.arctan2(place[:, 0], place[:, 1])) % 360.0
        seen = place[(azimuth // 90 == quarter) & (rng.random(objects) < 0.9)]
        turn = np.radians(rng.uniform(90.0 * quarter, 90.0 * (quarter + 1), clutter))
        false = AREA * rng.random((clutter, 1)) * np.column_stack([np.sin(turn), np.cos(turn)])
        reports = np.concatenate([seen + rng.normal(size=seen.shape) * 10.0, false])
        found.append(Scan(float(time), QUARTERS[quarter], reports))
    return found


def tracked(monkeypatch, little, given, **changed):
    """Return a tracker and its hypotheses where so few sequences are never made inactive."""
    monkeypatch.setattr(inactive, "LITTLE", little)
    target = tracker(*quarters(), **({"window": 4} | changed))
    return target, run(target, given)


def by_place(tracks):
    """Return statuses, hits, states and scores from west to east, whatever the tracks' names."""
    order = np.argsort(tracks.mean[:, 0])
    return [
        column[order]
        for column in (tracks.status, tracks.hits, tracks.mean, tracks.covariance, tracks.score)
    ]


def assert_same(mine, theirs, *, is_exact):
    """Compare all rows. Averages follow beliefs, which in loops come nearer to their end each
    time that they are gone over, or to another one: nearly all of them have to agree nearly.
    """
    apart = []
    for one, other in zip(mine, theirs, strict=True):
        first, second = by_place(one.tracks), by_place(other.tracks)
        assert first[0].tolist() == second[0].tolist()
        assert first[1].tolist() == second[1].tolist()
        np.testing.assert_allclose(first[4], second[4], atol=1e-6)
        apart.append(np.abs(first[2] - second[2]).max(axis=1, initial=0.0))
        if is_exact:
            np.testing.assert_allclose(first[3], second[3], atol=1e-6)
        assert one.n_tracks == other.n_tracks == len(one.tracks)
        assert len(one.amendments) == len(other.amendments)
    assert np.quantile(np.concatenate(apart), 1.0 if is_exact else 0.9) < (
        1e-6 if is_exact else 1.0
    )


@pytest.mark.parametrize("estimate", ["average", "best"])
@pytest.mark.parametrize("seed", range(3))
def test_changes_nothing_while_nothing_is_fixed(monkeypatch, seed, estimate):
    given = scans(seed, seconds=16)
    target, mine = tracked(monkeypatch, ALL_INACTIVE, given, estimate=estimate)
    other, theirs = tracked(monkeypatch, NONE_INACTIVE, given, estimate=estimate)
    assert target._inactive.n_nodes > 0.5 * target._tree.n_nodes
    assert other._inactive.n_nodes == 0
    # Beliefs in loops come nearer to their end each time that they are gone over.
    assert_same(mine, theirs, is_exact=estimate == "best")
    assert groups(all_assignments(target, mine)) == groups(all_assignments(other, theirs))


@pytest.mark.parametrize("seed", range(3))
def test_changes_hardly_anything_when_the_past_is_fixed_later(monkeypatch, seed):
    given = scans(seed, seconds=80)
    one, mine = tracked(monkeypatch, ALL_INACTIVE, given)
    other, theirs = tracked(monkeypatch, NONE_INACTIVE, given)
    first, second = all_assignments(one, mine), all_assignments(other, theirs)
    assert first.keys() == second.keys()
    same = sum((first[report] < 0) == (second[report] < 0) for report in first)
    assert same >= 0.99 * len(first)
    assert abs(len(mine[-1].tracks) - len(theirs[-1].tracks)) <= 1


@pytest.mark.parametrize("seed", range(3))
def test_scans_that_are_searched_together_find_what_was_inactive(monkeypatch, seed):
    """What the second of a step brings back must have been fixed with all else."""
    given = scans(seed, seconds=80)
    pairs = [tuple(given[k : k + 2]) for k in range(0, len(given), 2)]
    monkeypatch.setattr(inactive, "LITTLE", ALL_INACTIVE)
    one = tracker(*quarters(), window=4)
    mine = [one.step(pair, rng=0) for pair in pairs]
    assert one._inactive.n_nodes > 0
    other, theirs = tracked(monkeypatch, NONE_INACTIVE, given)
    first, second = all_assignments(one, mine), all_assignments(other, theirs)
    assert first.keys() == second.keys()
    same = sum((first[report] < 0) == (second[report] < 0) for report in first)
    assert same >= 0.98 * len(first)


@pytest.mark.parametrize("seed", range(3))
def test_a_late_scan_finds_everything_where_it_was(monkeypatch, seed):
    given = scans(seed, seconds=30)
    given.insert(-1, given.pop(-4))
    _, mine = tracked(monkeypatch, ALL_INACTIVE, given[:-1])
    _, theirs = tracked(monkeypatch, NONE_INACTIVE, given[:-1])
    assert mine[-1].late == ()
    assert mine[-1].n_sequences == pytest.approx(theirs[-1].n_sequences, rel=0.05)
    one, other = by_place(mine[-1].tracks), by_place(theirs[-1].tracks)
    assert one[0].tolist() == other[0].tolist()
    assert np.quantile(np.abs(one[2] - other[2]).max(axis=1), 0.95) < 1.0


def test_says_what_gap_was_left_open(monkeypatch):
    given = scans(4, seconds=16, objects=60, clutter=10)
    _, greedy = tracked(monkeypatch, ALL_INACTIVE, given, search=Greedy())
    _, best = tracked(monkeypatch, NONE_INACTIVE, given, search=Exact())
    assert any(one.certificate.gap > 1e-3 for one in greedy)
    for one, other in zip(greedy, best, strict=True):
        assert one.certificate.lower_bound <= other.certificate.cost + 1e-6
        assert one.certificate.lower_bound <= one.certificate.cost + 1e-9


def test_tells_the_tracks_of_inactive_clusters(monkeypatch):
    monkeypatch.setattr(inactive, "LITTLE", ALL_INACTIVE)
    given = scans(5)
    shown, silent = tracker(*quarters()), tracker(*quarters())
    mine, theirs = run(shown, given), run(silent, given, tracks=False)
    assert [one.n_tracks for one in theirs] == [len(one.tracks) for one in mine]
    np.testing.assert_array_equal(silent.tracks().mean, mine[-1].tracks.mean)


def test_rows_of_inactive_clusters_are_used_again(monkeypatch):
    monkeypatch.setattr(inactive, "LITTLE", ALL_INACTIVE)
    target, held = tracker(*quarters(), search=Greedy()), []
    for each in scans(6, seconds=240):
        run(target, [each])
        held.append(target._inactive.n_rows)
    assert max(held[120:]) < 1.5 * max(held[:120])
    assert target._inactive.families.track.shape[0] <= 2 * target._inactive.n_rows
