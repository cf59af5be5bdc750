"""What a configuration leaves to be estimated."""

from trackweave.config import load_configuration
from trackweave.config.fill import left_out


def test_what_is_left_out_and_can_be_estimated_is_named_by_its_key() -> None:
    own = {"sigma": 3.0, "scans": False, "clutter_per_scan": 1.0}
    told = load_configuration({"motion": {"process_noise": 1.0}, "sensors": {"a": own}})
    assert left_out(told, ["a"]) == [
        "motion.max_speed",
        "lifecycle.new_target_density",
        "sensors.a.detection_probability",
        "sensors.a.clutter_density",  # clutter_per_scan says it only with a field of view
    ]
