"""Ends and beginnings far apart are joined where one object explains both."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from trackweave.association.problem import Status
from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.trackers.joining import joins
from trackweave.trackers.joining.joins import joins_of
from trackweave.trackers.joining.naming import Named
from trackweave.trackers.joining.segments import segments_of

Piece = tuple[float, float]
"""From when to when an object is seen [s]."""


def seen(
    pieces: list[list[Piece]], seed: int = 1, *, together: bool = False
) -> tuple[joins.Segments, TrackTable, list[int]]:
    """Return segments of objects that wander at 5 to 15 m/s, states of each, and whose each is."""
    # Each piece is a track of its own, or all of one object are where ``together``.
    rng = np.random.default_rng(seed)
    rows, whose, track = [], [], 0
    for number, own in enumerate(pieces):
        heading, speed = rng.uniform(0, 2 * np.pi), rng.uniform(5, 15)
        place, time = rng.uniform(0, 8000, 2), 0.0
        for first, last in own:
            while time <= last:
                if time >= first:
                    velocity = speed * np.array([np.cos(heading), np.sin(heading)])
                    rows.append((time, track, *(place + rng.normal(0, 2, 2)), *velocity))
                heading += rng.normal(0.0, 0.01)
                place = place + speed * np.array([np.cos(heading), np.sin(heading)])
                time += 1.0
            whose.append(number)
            track += not together
        track += together
    table = np.array(sorted(rows))
    return *cut(table), whose


def cut(table: np.ndarray) -> tuple[joins.Segments, TrackTable]:
    """Return segments of rows of time, track and state by time, and the states of each."""
    time, number = table[:, 0], table[:, 1].astype(np.int64)
    segments, of = segments_of(number, time, np.unique(number).tolist())
    n = len(table)
    covariance = np.tile(np.diag([4.0, 4.0, 0.1, 0.1]), (n, 1, 1))
    states = TrackTable(
        time, of, np.full(n, CONFIRMED), table[:, 2:], covariance, np.zeros(n),
        np.ones(n, np.int64), time,
    )  # fmt: skip
    return segments, states


WHOLE = [[(0.0, 400.0)]] * 8
BROKEN = [[(0.0, 100.0), (220.0, 400.0)], [(0.0, 180.0), (280.0, 400.0)]]


@pytest.mark.parametrize("seed", range(3))
def test_names_tell_who_goes_on(seed):
    segments, states, whose = seen([*WHOLE, *BROKEN], seed)
    right = np.array(whose)
    nobody = np.full(right.size, -1)
    found = joins_of(segments, states, named=Named(right, nobody, 1e-4))
    assert {(whose[join.before], whose[join.after]) for join in found.found} == {(8, 8), (9, 9)}
    # Whoever begins late is somebody else by name.
    other = np.where(segments.begin > 1.0, right + 20, right)
    assert joins_of(segments, states, named=Named(other, nobody, 1e-12)).found == ()


@pytest.mark.parametrize("seed", range(3))
def test_who_alone_has_a_name_is_one_whatever_way_it_went(seed):
    segments, states, whose = seen([*WHOLE, *BROKEN], seed)
    right = np.array(whose)
    moved = states.mean.copy()
    moved[np.isin(states.track, np.flatnonzero((right >= 8) & (segments.begin > 1.0))), :2] += 1e6
    states = replace(states, mean=moved)
    alone = joins_of(segments, states)
    assert alone is None or alone.found == ()
    before = np.full(right.size, -1)
    for name in (8, 9):
        early, late = np.flatnonzero(right == name)[np.argsort(segments.begin[right == name])]
        before[late] = early
    found = joins_of(segments, states, named=Named(right, before, 1e-4))
    assert {(whose[join.before], whose[join.after]) for join in found.found} == {(8, 8), (9, 9)}
    assert all(join.probability > 0.99 for join in found.found)


@pytest.mark.parametrize("seed", range(5))
def test_an_object_that_hid_is_joined_with_itself(seed):
    segments, states, whose = seen([*WHOLE, *BROKEN], seed)
    found = joins_of(segments, states)
    assert found is not None
    assert len(found.found) == 2
    assert all(whose[join.before] == whose[join.after] for join in found.found)
    assert {join.silence for join in found.found} == {120.0, 100.0}
    assert all(0.5 < join.probability <= 1.0 for join in found.found)
    assert found.certificate.status == Status.OPTIMAL


def test_a_silence_longer_than_told_joins_nothing():
    segments, states, _ = seen([*WHOLE, *BROKEN])
    found = joins_of(segments, states, longest=110.0)
    assert found is not None
    assert [join.silence for join in found.found] == [100.0]


def test_what_the_tracker_held_to_be_one_object_stays_so():
    segments, states, _ = seen([*WHOLE, *BROKEN], together=True)
    assert np.count_nonzero(segments.before >= 0) == 2
    found = joins_of(segments, states)
    assert found is not None
    assert found.before.tolist() == segments.before.tolist()
    assert found.found == ()
    assert found.parted == ()


def standing(seed: int, *, together: bool) -> tuple[joins.Segments, TrackTable, list[int]]:
    """Return eight cars that nobody sees while they stand, for 20 to 60 s, and ten that drive."""
    rng = np.random.default_rng(seed)
    rows, whose, track = [], [], 0
    for number in range(18):
        heading, speed = rng.uniform(0, 2 * np.pi), rng.uniform(5, 15)
        velocity = speed * np.array([np.cos(heading), np.sin(heading)])
        place, wait = rng.uniform(0, 3000, 2), rng.uniform(20, 60) if number < 8 else 0.0
        stop = rng.uniform(40, 100)
        for time in np.arange(0.0, 200.0):
            if stop <= time < stop + wait:
                continue
            own = track + (not together and number < 8 and time >= stop)
            gone = min(time, stop) + max(0.0, time - stop - wait)
            rows.append((time, own, *(place + gone * velocity + rng.normal(0, 1, 2)), *velocity))
        whose += [number] * (2 if number < 8 else 1)
        track += 1 if together or number >= 8 else 2
    return *cut(np.array(sorted(rows))), whose


@pytest.mark.parametrize("seed", range(3))
def test_who_is_not_seen_while_it_stands_keeps_its_name(seed):
    segments, states, _ = standing(seed, together=True)
    found = joins_of(segments, states)
    assert found.parted == ()
    np.testing.assert_array_equal(found.before, segments.before)
    segments, states, whose = standing(seed, together=False)
    found = joins_of(segments, states)
    assert len(found.found) >= 7
    assert all(whose[join.before] == whose[join.after] for join in found.found)


def airport(seed: int, links: int) -> tuple[joins.Segments, TrackTable]:
    """Return segments of arrivals at one place whose tracks go on as departures from another."""
    _, states, _ = seen(WHOLE, seed)
    rng = np.random.default_rng(seed)
    rows = [np.column_stack([states.time, states.track, states.mean])]
    for number in range(8, 8 + links):
        for first, last, place, heading in (
            (0.0, rng.uniform(80, 140), (0.0, 0.0), 0.0),
            (rng.uniform(200, 300), 400.0, (600.0, 0.0), rng.uniform(-1.0, 1.0)),
        ):
            time = np.arange(np.ceil(first), last)
            velocity = 10.0 * np.array([np.cos(heading), np.sin(heading)])
            since = time - time[-1 if first == 0.0 else 0]
            at = np.array(place) + since[:, None] * velocity
            at += rng.normal(0.0, 2.0, at.shape)
            rows.append(
                np.column_stack([time, 0 * time + number, at, np.tile(velocity, (len(time), 1))])
            )
    table = np.concatenate(rows)
    return cut(table[np.argsort(table[:, 0], kind="stable")])


@pytest.mark.parametrize("seed", range(3))
def test_what_lands_is_not_what_takes_off_where_many_do(seed):
    segments, states = airport(seed, 10)
    found = joins_of(segments, states)
    assert found is not None
    assert len(found.parted) > 5
    for parted in found.parted:
        assert segments.before[parted.after] == parted.before
        assert found.before[parted.after] != parted.before
        assert parted.probability < joins.DOUBTED
    assert found.deaths > 5.0


def test_objects_that_end_and_others_that_begin_elsewhere_stay_two():
    ended = [[(0.0, 100.0 + 20 * k)] for k in range(4)]
    begun = [[(200.0 + 20 * k, 400.0)] for k in range(4)]
    segments, states, whose = seen([*WHOLE, *ended, *begun], 4)
    found = joins_of(segments, states)
    joined = () if found is None else found.found
    assert all(whose[join.before] == whose[join.after] for join in joined)


def test_nobody_is_in_two_joins_at_one_end():
    segments, states, _ = seen([*WHOLE, *(BROKEN * 4)], 9)
    found = joins_of(segments, states)
    assert found is not None
    taken = found.before[found.before >= 0]
    assert np.unique(taken).size == taken.size


def test_the_order_of_tracks_changes_nothing():
    pieces = [*WHOLE, *BROKEN]
    segments, states, _ = seen(pieces)
    first = joins_of(segments, states)
    # The same states, their tracks numbered from the other end.
    last = len(segments) - 1
    names = ("track", "begin", "end", "count", "interval", "before")
    turned = joins.Segments(*(getattr(segments, name)[::-1] for name in names))
    back = joins_of(
        turned, TrackTable(states.time, last - states.track, *(
            getattr(states, name) for name in
            ("status", "mean", "covariance", "score", "hits", "last_update")
        )),
    )  # fmt: skip
    assert first is not None
    assert back is not None
    assert [(last - j.before, last - j.after) for j in back.found] == [
        (j.before, j.after) for j in first.found
    ]
    assert [j.probability for j in back.found] == pytest.approx(
        [j.probability for j in first.found]
    )


def test_a_track_known_beforehand_is_joined_to_nobody_before_it():
    segments, states, whose = seen([*WHOLE, *BROKEN])
    late = [n for n in range(len(whose)) if segments.begin[n] > 0.0]
    found = joins_of(segments, states, known=segments.track[late].tolist())
    assert found is None or found.found == ()


def test_tracks_of_one_report_each_are_joined_with_nobody():
    time, track = np.arange(5.0), np.arange(5)
    segments, of = segments_of(track, time, range(5))
    n = np.ones(5, np.int64)
    covariance = np.tile(np.eye(4), (5, 1, 1))
    states = TrackTable(time, of, n, np.zeros((5, 4)), covariance, time, n, time)
    assert joins_of(segments, states) is None


def test_objects_that_stand_as_if_nailed_are_joined_where_they_stand():
    time = np.tile([float(t) for t in (*range(20), *range(200, 220))], 3)
    track = np.repeat(np.arange(6), 20)
    order = np.argsort(time, kind="stable")
    time, track = time[order], track[order]
    segments, of = segments_of(track, time, range(6))
    place = np.where(track < 2, 0.0, np.where(track < 4, 50.0, 90.0))
    mean = np.stack([place, place, 0 * place, 0 * place], axis=1)
    n = np.ones(time.size, np.int64)
    states = TrackTable(time, of, n, mean, np.zeros((time.size, 4, 4)), time, n, time)
    found = joins_of(segments, states)
    assert found is not None
    assert found.before.tolist() == [-1, 0, -1, 2, -1, 4]


def test_too_little_to_learn_from_joins_nothing():
    segments, states, _ = seen([[(0.0, 4.0), (80.0, 84.0)], [(0.0, 6.0)]])
    assert joins_of(segments, states) is None


def marginals_by_hand(n_ends: int, n_begins: int, pairs: dict[tuple[int, int], float]):
    total, share = 0.0, dict.fromkeys(pairs, 0.0)
    for chosen in product([False, True], repeat=len(pairs)):
        own = [pair for pair, is_in in zip(pairs, chosen, strict=True) if is_in]
        if len({e for e, _ in own}) < len(own) or len({b for _, b in own}) < len(own):
            continue
        weight = np.exp(sum(pairs[pair] for pair in own))
        total += weight
        for pair in own:
            share[pair] += weight
    return [value / total for value in share.values()]


def test_probabilities_are_those_of_all_choices_where_pairs_make_no_circle():
    pairs = {(0, 0): 1.0, (0, 1): -0.5, (1, 1): 2.0, (1, 2): 0.3, (2, 2): -1.0}
    end, begin = (np.array(each) for each in zip(*pairs, strict=True))
    table = joins._Pairs(np.arange(3), np.arange(3), end, begin, np.ones(5))
    found = joins._marginals(table, np.array(list(pairs.values())))
    np.testing.assert_allclose(found, marginals_by_hand(3, 3, pairs), rtol=1e-9)


def bursting(seed: int = 1) -> tuple[joins.Segments, TrackTable]:
    """Return balloons that drift, and fall at once in another direction after a while."""
    rng, rows = np.random.default_rng(seed), []
    for number in range(4):
        place = np.array([20e3 * number, 0.0]) + rng.uniform(-1e3, 1e3, 2)
        burst = rng.uniform(800.0, 1200.0)
        for time in np.arange(5.0 * number, 1800.0, 10.0):
            late = max(time - burst, 0.0)
            velocity = np.array([6.0, 2.0 if late == 0.0 else -45.0])
            at = place + np.array([6.0 * time, 2.0 * min(time, burst) - 45.0 * late])
            track = 2 * number + int(late > 0.0)
            rows.append((time, track, *(at + rng.normal(0, 2, 2)), *velocity))
    return cut(np.array(sorted(rows)))


def test_what_goes_on_as_nobody_did_before_is_one_where_it_can_be():
    segments, states = bursting()
    found = joins_of(segments, states)
    assert found is not None
    pairs = {(int(segments.track[j.before]), int(segments.track[j.after])) for j in found.found}
    assert pairs == {(0, 1), (2, 3), (4, 5), (6, 7)}
