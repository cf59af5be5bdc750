"""Fixed echoes and rows without a position capture no estimate."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.test_estimate import scene, table
from trackweave.config import load_configuration
from trackweave.domain.reports import ReportTable
from trackweave.estimation.echoes import without_echoes
from trackweave.estimation.estimates import Estimates
from trackweave.run.refining import estimates_for


def with_echo(reports: ReportTable, jitter: float) -> ReportTable:
    rng, moments = np.random.default_rng(5), np.unique(reports.time)
    place = np.array([700.0, 700.0]) + jitter * rng.normal(size=(moments.size, 2))
    return table(
        np.concatenate([reports.time, moments]), np.concatenate([reports.measurement, place])
    )


def with_zeros(reports: ReportTable) -> ReportTable:
    place = reports.measurement.copy()
    place[np.random.default_rng(5).random(len(place)) < 0.1] = 0.0
    return replace(reports, measurement=place)


def found_in(reports: ReportTable) -> Estimates:
    found = estimates_for(reports, load_configuration(None))
    assert found is not None
    return found


@pytest.mark.parametrize("jitter", [0.0, 0.01])
def test_a_motionless_echo_in_every_scan_changes_hardly_any_estimate(jitter: float) -> None:
    found = found_in(with_echo(scene(), jitter))
    assert 8 < found.sensors["A"].sigma < 13
    assert 8 < found.max_speed < 60


def test_rows_without_a_position_change_hardly_any_estimate() -> None:
    found = found_in(with_zeros(scene()))
    assert 8 < found.sensors["A"].sigma < 13
    assert 8 < found.max_speed < 60


def test_what_is_left_out_is_said() -> None:
    (note,) = found_in(with_echo(scene(), 0.0)).notes
    assert note.startswith("sensor A: 40 of ")
    assert "repeat one place exactly ((700, 700))" in note


def test_reports_without_repeats_and_those_of_repeats_alone_stay() -> None:
    assert without_echoes(scene())[1] == []
    still = table(np.arange(30.0), np.zeros((30, 2)))
    assert len(without_echoes(still)[0]) == 30


def test_what_moves_is_learnt_from_though_most_reports_rest() -> None:
    moving = scene(clutter=0.0)
    times = np.unique(moving.time)
    places = np.stack([np.arange(30.0) * 50.0, np.full(30, 7.0)], axis=1)
    both = table(
        np.r_[moving.time, np.repeat(times, 30)],
        np.concatenate([moving.measurement, np.tile(places, (times.size, 1))]),
    )
    kept, notes = without_echoes(both)
    assert len(kept) == len(moving) < 0.5 * len(both)
    assert len(notes) == 1
