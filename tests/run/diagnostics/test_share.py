"""How few reports are in tracks is said, and what to look at."""

from dataclasses import replace

import numpy as np
import pytest

from run.diagnostics.scenes import case_of, positions
from trackweave.run.diagnostics.share import few_assigned


@pytest.mark.parametrize(("in_tracks", "is_said"), [(0, True), (40, True), (60, False)])
def test_less_than_half_in_tracks_is_said_with_what_to_look_at(
    in_tracks: int, is_said: bool
) -> None:
    time = np.arange(100.0)
    case = case_of(positions(list(time), np.c_[time, time % 7]))
    found = list(few_assigned(replace(case, track=np.where(time < in_tracks, 1, -1))))
    assert bool(found) == is_said
    for each in found:
        assert each.sentence.startswith(f"only {in_tracks} of 100 reports are in tracks")
        assert "sigma, max_speed, clutter and detection_probability" in each.sentence


def test_false_alarms_explain_it_only_where_they_are_told() -> None:
    time = np.arange(100.0)
    reports = positions(list(time), np.c_[time, time % 7])
    case = case_of(reports, lidar={"clutter_density": 1e-3})
    case = replace(case, track=np.where(time < 40, 1, -1), looks={"lidar": time})
    assert list(few_assigned(case)) == []
    sources = {**case.settings.sources, "sensors.lidar.clutter_density": "estimated"}
    case = replace(case, settings=replace(case.settings, sources=sources))
    assert len(list(few_assigned(case))) == 1
