"""What is said of a rule of hits that is told."""

import pytest

from trackweave.config import load_configuration
from trackweave.config.fill import fill

KNOWN = {
    "motion": {"process_noise": 1.0, "max_speed": 20.0},
    "sensors": {"a": {"sigma": 3.0, "detection_probability": 0.9, "clutter_density": 1e-7}},
}


@pytest.mark.parametrize(
    ("told", "is_said"),
    [
        ({"confirm": "6/8"}, True),
        ({"confirm": "2/3"}, False),
        ({"confirm": "6/8", "certain_probability": 0.99}, False),
        ({}, False),
    ],
)
def test_says_that_certain_tracks_have_fewer_hits_than_are_told(told, is_said) -> None:
    notes = fill(load_configuration({**KNOWN, "lifecycle": told}), None, ["a"]).notes
    assert any("is confirmed before it has 6 hits" in note for note in notes) == is_said
