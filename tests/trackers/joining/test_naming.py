"""Who bears a name that nobody else has at the time is one, wherever a tracker lost it."""

import numpy as np
import pytest

from trackweave.trackers.joining.naming import elsewhere, named_by, whose
from trackweave.trackers.joining.segments import segments_of

NEVER = 1e-5


def followed(tracks, names, error=NEVER):
    """Return from which track's segment each one follows, by times and names of each track."""
    rows = sorted(
        (time, number, name)
        for number, (times, own) in enumerate(zip(tracks, names, strict=True))
        for time, name in zip(times, own, strict=True)
    )
    time, track, identity = (np.array(each) for each in zip(*rows, strict=True))
    segments, of = segments_of(track, time, range(len(tracks)))
    before = named_by(segments, of, identity, error).before
    return {int(a): int(segments.track[b]) for a, b in zip(segments.track, before, strict=True)
            if b >= 0}  # fmt: skip


def test_a_segment_is_who_most_of_its_reports_say():
    of = np.array([0, 0, 0, 1, 1, -1, 2, 1])
    identity = np.array([4, 4, 7, 5, -1, 6, -1, 5])
    most, is_clear = whose(of, identity, 4)
    np.testing.assert_array_equal(most, [4, 5, -1, -1])
    np.testing.assert_array_equal(is_clear[:2], [False, True])


EARLY, LATE, LATER = range(20), range(25, 45), range(50, 70)


def test_segments_of_one_name_follow_one_another():
    names = [[7, -1] * 10, [8] * 20, [7] * 20, [7] * 20]
    assert followed([EARLY, EARLY, LATE, LATER], names) == {2: 0, 3: 2}


def test_a_name_of_two_at_once_says_nothing():
    assert followed([EARLY, range(10, 30), LATER], [[7] * 20] * 3) == {}


def test_reports_may_go_to_both_tracks_for_a_while():
    assert followed([EARLY, [16.5, 18.5, *range(20, 40)]], [[7] * 20, [7] * 22]) == {1: 0}


def test_a_wrong_report_meanwhile_does_not_matter():
    assert followed([EARLY, [5, 6], LATE], [[7] * 20, [7, 7], [7] * 20]) == {2: 0}


@pytest.mark.parametrize(("error", "names"), [(0.02, [7] * 20), (NEVER, [7] * 17 + [8] * 3)])
def test_names_that_are_often_wrong_prove_nothing(error, names):
    assert followed([EARLY, LATE], [names, [7] * 20], error) == {}


@pytest.mark.parametrize("scrap", [[], [(30.0, 2, 7)]], ids=["alone", "beside a scrap"])
def test_nameless_reports_after_an_object_went_on_elsewhere_are_no_longer_its(scrap):
    rows = [(float(t), 0, 7 if t % 2 else -1) for t in range(34)]
    rows += [(34.0, 0, -1), (60.0, 0, -1)]
    rows += [(20.5, 1, -1), *((float(t), 1, 7) for t in range(40, 50)), (70.0, 1, -1)]
    time, track, identity = (np.array(each) for each in zip(*sorted(rows + scrap), strict=True))
    found = elsewhere(track, time, identity, identity < 0)
    assert time[found].tolist() == [20.5, 60.0]
    # Those of a sensor that names nobody tell nothing.
    assert not elsewhere(track, time, identity, np.zeros(time.size, dtype=bool)).any()
