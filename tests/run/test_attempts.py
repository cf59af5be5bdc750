"""Attempts begin again where something is contradicted, and go on where nothing is in the end."""

from itertools import count

import numpy as np
import polars as pl
import pytest

from trackweave.config import load_configuration
from trackweave.run.attempts import agreed
from trackweave.run.course import attempt_of
from trackweave.run.tracking import report_table

SENSOR = {"sigma": 5.0, "detection_probability": 0.9, "clutter_density": 2e-6, "scan_period": 1.0}
TOLD = {
    "motion": {"process_noise": 0.1, "max_speed": 20.0},
    "sensors": {"default": SENSOR},
    "lifecycle": {"new_target_density": 1e-6, "initial_target_density": 5e-6},
}


class Doubts:
    """Contradict at a step, try something else for as long, and find what was told right."""

    def __init__(self, at):
        self._told, self._at = load_configuration(TOLD), at
        self._number, self._is_on_trial = count(), False

    @property
    def configuration(self):
        if not self._is_on_trial:
            return self._told
        return self._told.changed(motion={"process_noise": 9.0, "max_speed": 20.0})

    def contradict(self, reports, settings, track, *, at_end=False):
        if next(self._number) not in (self._at, 2 * self._at):
            return False
        self._is_on_trial = not self._is_on_trial
        return True


def followed(doubts):
    """Return the tracks of three objects' reports, and how many attempts were set out."""
    rng = np.random.default_rng(2)
    start, velocity = rng.uniform(-200, 200, (3, 2)), rng.uniform(-9, 9, (3, 2))
    place = start + velocity * np.arange(14.0)[:, None, None] + rng.normal(0, 5, (14, 3, 2))
    reports = pl.DataFrame(
        {"time": np.repeat(np.arange(14.0), 3), "x": place[..., 0].ravel(),
         "y": place[..., 1].ravel()}
    )  # fmt: skip
    table, _ = report_table(reports, doubts.configuration)
    made = []

    def attempted(configuration):
        made.append(attempt_of(table, configuration, None, None))
        return made[-1]

    attempt, (rows, log, assigned) = agreed(
        attempted, doubts, (np.random.default_rng(0), None, None), None
    )
    assert attempt.settings.motion.process_noise == 0.1
    return len(made), rows.table(2), [scan["time"] for scan in log.scans], assigned.by_row()


@pytest.mark.parametrize("at", [1, 6, 13])
def test_what_was_doubted_and_proves_right_goes_on_where_it_was_left_off(at):
    once, tracks, times, assigned = followed(Doubts(at=10**6))
    again, same, same_times, same_assigned = followed(Doubts(at=at))
    assert (once, again) == (1, 2)
    assert same_times == times
    assert same_assigned == assigned
    assert same.track.tolist() == tracks.track.tolist()
    np.testing.assert_array_equal(same.mean, tracks.mean)
