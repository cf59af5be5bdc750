"""A history is smoothed over all of a track's reports."""

import numpy as np
import pytest

from trackweave.config import load_configuration
from trackweave.domain.reports import ReportTable
from trackweave.domain.tracks import COASTING, CONFIRMED, TENTATIVE, TrackTable
from trackweave.run import settings_for
from trackweave.run.history import _not_astray, smoothed_history

CONFIG = {
    "motion": {"process_noise": 0.1, "max_speed": 20.0},
    "sensors": {
        "default": {
            "sigma": 5.0,
            "detection_probability": 0.9,
            "clutter_density": 1e-6,
            "scan_period": 1.0,
        }
    },
    "lifecycle": {"new_target_density": 1e-6},
}
TIMES = np.array([0.0, 1.0, 2.0, 4.0, 5.0])


def reports(dim: int = 2) -> ReportTable:
    rng = np.random.default_rng(1)
    truth = np.outer(TIMES, np.array([3.0, -2.0, 1.0])[:dim])
    return ReportTable(
        time=TIMES,
        sensor=np.zeros(5, np.int64),
        sensors=("A",),
        measurement=truth + rng.normal(0, 5.0, truth.shape),
        sigma=np.full((5, dim), np.nan),
        report=np.arange(5).astype(str).astype(object),
    )


def known(track: int, times: list[float], dim: int = 2) -> TrackTable:
    n = len(times)
    return TrackTable(
        time=np.array(times),
        track=np.full(n, track),
        status=np.full(n, CONFIRMED),
        mean=np.zeros((n, 2 * dim)),
        covariance=np.tile(np.eye(2 * dim), (n, 1, 1)),
        score=np.arange(n, dtype=float),
        hits=np.arange(n),
        last_update=np.array(times),
    )


def least_squares(table: ReportTable, moments: np.ndarray, dim: int) -> np.ndarray:
    """The same estimate by solving for all states at once."""
    n_states, n = moments.size, 2 * dim
    rows, values = [], []
    for time, place in zip(table.time, table.measurement, strict=True):
        k = int(np.flatnonzero(moments == time)[0])
        for axis in range(dim):
            row = np.zeros(n_states * n)
            row[k * n + axis] = 1 / 5.0
            rows.append(row)
            values.append(place[axis] / 5.0)
    for axis in range(dim):
        row = np.zeros(n_states * n)
        row[dim + axis] = 1 / np.sqrt(20.0**2 / (dim + 2))
        rows.append(row)
        values.append(0.0)
    for k, dt in enumerate(np.diff(moments)):
        noise = 0.1 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
        root = np.linalg.inv(np.linalg.cholesky(noise))
        for axis in range(dim):
            step = np.zeros((2, n_states * n))
            step[0, k * n + axis], step[0, k * n + dim + axis] = -1, -dt
            step[1, k * n + dim + axis] = -1
            step[0, (k + 1) * n + axis] = step[1, (k + 1) * n + dim + axis] = 1
            rows += list(root @ step)
            values += [0.0, 0.0]
    solution, *_ = np.linalg.lstsq(np.array(rows), np.array(values), rcond=None)
    return solution.reshape(n_states, n)


@pytest.mark.parametrize("dim", [2, 3])
def test_equals_the_least_squares_estimate_of_all_states(dim: int) -> None:
    table = reports(dim)
    settings = settings_for(table, load_configuration(CONFIG))
    moments = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    found = smoothed_history(table, dict.fromkeys(range(5), 7), known(7, moments, dim), settings)
    assert found.time.tolist() == moments[:6]
    assert found.mean == pytest.approx(least_squares(table, found.time, dim), abs=1e-6)
    assert np.all(np.linalg.eigvalsh(found.covariance) > 0)


def test_tells_coasting_hits_and_score() -> None:
    table = reports()
    settings = settings_for(table, load_configuration(CONFIG))
    found = smoothed_history(
        table, dict.fromkeys(range(5), 7), known(7, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), settings
    )
    assert found.status.tolist() == [CONFIRMED] * 3 + [COASTING] + [CONFIRMED] * 2
    assert found.hits.tolist() == [1, 2, 3, 3, 4, 5]
    assert found.last_update.tolist() == [0.0, 1.0, 2.0, 2.0, 4.0, 5.0]
    assert set(found.score) == {5.0}


def test_a_track_that_was_never_confirmed_stays_tentative() -> None:
    table = reports()
    settings = settings_for(table, load_configuration(CONFIG))
    found = smoothed_history(table, {0: 3, 1: 3}, known(7, [0.0, 1.0]), settings)
    assert found.status.tolist() == [TENTATIVE, TENTATIVE]
    assert np.all(np.isnan(found.score))


def test_a_prior_is_where_a_track_sets_out() -> None:
    table = reports()
    settings = settings_for(table, load_configuration(CONFIG))
    prior = TrackTable(
        time=np.array([-1.0]),
        track=np.array([7]),
        status=np.array([CONFIRMED]),
        mean=np.array([[-3.0, 2.0, 3.0, -2.0]]),
        covariance=np.eye(4)[None] * 1e-6,
        score=np.zeros(1),
        hits=np.ones(1, np.int64),
        last_update=np.array([-1.0]),
    )
    found = smoothed_history(
        table, dict.fromkeys(range(5), 7), known(7, [0.0, 5.0]), settings, prior
    )
    assert found.time[0] == 0.0
    assert np.abs(found.mean[0, :2]).max() < 0.3


def test_no_tracks_give_an_empty_history() -> None:
    table = reports()
    settings = settings_for(table, load_configuration(CONFIG))
    assert len(smoothed_history(table, {}, TrackTable.empty(2), settings)) == 0


def test_a_period_thins_the_history_and_leaves_no_track_out():
    table, assignment = reports(), {0: 3, 1: 3, 2: 3, 3: 3, 4: 5}
    shown = TrackTable.concatenate([known(3, [0.0, 3.0]), known(5, [3.0])], 2)
    every, thinned = (
        smoothed_history(
            table, assignment, shown,
            settings_for(table, load_configuration({**CONFIG, "output": output})),
        )
        for output in ({}, {"period": 3.0})
    )  # fmt: skip
    assert thinned.time.tolist() == [0.0, 3.0, 5.0]
    assert thinned.track.tolist() == [3, 3, 5]
    assert thinned.status.tolist() == [CONFIRMED] * 3
    for time, track, mean in zip(thinned.time, thinned.track, thinned.mean, strict=True):
        row = np.flatnonzero((every.time == time) & (every.track == track))
        np.testing.assert_allclose(every.mean[row], mean[None], rtol=1e-6, atol=1e-6)


def test_a_history_that_went_astray_is_as_it_was_known_then():
    def table(place: np.ndarray) -> TrackTable:
        count = len(place)
        covariance = np.broadcast_to(np.eye(4), (count, 4, 4)).copy()
        return TrackTable(
            time=np.arange(float(count)), track=np.ones(count, dtype=np.int64),
            status=np.full(count, 2), mean=np.column_stack([place, np.zeros((count, 2))]),
            covariance=covariance, score=np.zeros(count), hits=np.arange(count),
            last_update=np.arange(float(count)), acceleration=np.empty((count, 0)),
        )  # fmt: skip

    live = np.random.default_rng(1).normal(0, 1, (9, 2))
    near, far = live + 2.0, live + np.linspace(0, 9000, 9)[:, None]
    assert np.array_equal(_not_astray(table(near), table(live)).mean, table(near).mean)
    assert np.array_equal(_not_astray(table(far), table(live)).mean, table(live).mean)
