"""Tracks are cut at silences that are long for them, and speeds are told from what is known."""

import numpy as np

from trackweave.domain.tracks import CONFIRMED, TrackTable
from trackweave.trackers.joining.segments import USUAL, Paths, segments_of


def cut(*tracks: list[float]) -> tuple[list[int], list[list[float]]]:
    """Return the track of each segment, and the times of its reports."""
    rows = sorted((time, number) for number, times in enumerate(tracks) for time in times)
    time, track = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
    segments, of = segments_of(track, time, range(len(tracks)))
    own = [time[of == number].tolist() for number in range(len(segments))]
    assert segments.begin.tolist() == [times[0] for times in own]
    assert segments.end.tolist() == [times[-1] for times in own]
    return segments.track.tolist(), own


REGULAR = [float(t) for t in range(0, 100, 2)]


def test_a_track_without_silences_is_one_segment():
    assert cut(REGULAR) == ([0], [REGULAR])


def test_a_track_is_cut_where_it_falls_silent_for_long():
    late = [200.0 + t for t in REGULAR]
    assert cut([*REGULAR, *late]) == ([0, 0], [REGULAR, late])


def test_what_is_long_is_measured_by_the_track_itself():
    slow = [float(t) for t in range(0, 2000, 180)]
    assert cut(REGULAR, slow)[0] == [0, 1]


def test_bursts_are_no_silences():
    bursts = [180.0 * k + t for k in range(10) for t in (0.0, 1.0, 3.0)]
    assert cut(bursts) == ([0], [bursts])


def test_of_a_track_of_two_reports_their_wait_tells_nothing_of_a_silence():
    assert cut(REGULAR, [10.0, 60.0])[0] == [0, 1]


def test_reports_of_one_moment_count_once_and_others_are_of_no_segment():
    time = np.array([0.0, 0.0, 1.0, 2.0, 2.0, 3.0])
    segments, of = segments_of(np.array([4, 4, 4, -1, 7, 4]), time, [4])
    assert segments.count.tolist() == [3]
    assert of.tolist() == [0, 0, 0, -1, -1, 0]


def path(velocity: float, spread: float, n: int = 40) -> Paths:
    rng = np.random.default_rng(3)
    mean = np.zeros((n, 4))
    mean[:, 2:] = rng.normal((velocity, 0.0), spread, (n, 2))
    covariance = np.tile(np.diag([1.0, 1.0, spread**2, spread**2]), (n, 1, 1))
    time = np.arange(float(n))
    kinds = np.zeros(n, np.int64), np.full(n, CONFIRMED)
    return Paths(TrackTable(time, *kinds, mean, covariance, time, kinds[1], time))


def test_a_speed_is_better_known_from_many_states():
    few, many = path(10.0, 2.0).speed(np.array([0, 39]), onwards=False)[1]
    assert many < few / 10


def test_noise_makes_no_speed():
    speed, variance = path(0.0, 2.0).speed(np.array([39]), onwards=False)
    assert np.exp(speed[0]) < 2.0
    assert path(10.0, 2.0).speed(np.array([39]), onwards=False)[1][0] < variance[0]


def test_each_track_is_judged_by_its_own_pauses():
    """As numpy's quantile of each has them, and of a few by those of all."""
    rng = np.random.default_rng(4)
    tracks = [np.cumsum(rng.exponential(1.0 + n, n + 1)).tolist() for n in range(12)]
    rows = sorted((time, number) for number, times in enumerate(tracks) for time in times)
    time, track = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
    segments, _ = segments_of(track, time, range(len(tracks)))
    usual = float(np.median(np.concatenate([np.diff(times) for times in tracks])))
    for number, times in enumerate(tracks):
        waits = np.diff(times)
        few = max(usual, float(waits.max(initial=0.0)))
        expected = float(np.quantile(waits, USUAL)) if waits.size > 2 else few
        found = segments.interval[segments.track == number]
        np.testing.assert_allclose(found, expected, rtol=1e-12)
