"""A study that takes a moment: two boats, one radar, twelve scans."""

import copy
from typing import Any

SCENE: dict[str, Any] = {
    "duration": 23.0,
    "area": {"low": [0, 0], "high": [600, 600]},
    "sensors": [{"name": "radar", "sigma": 5.0, "scan_period": 2.0, "clutter_per_scan": 3}],
    "targets": [
        {"position": [100, 100], "velocity": [12, 3]},
        {"position": [100, 400], "velocity": [12, -3]},
    ],
}
TOLD: dict[str, Any] = {
    "motion": {"process_noise": 0.1, "max_speed": 30.0},
    "lifecycle": {"new_target_density": 1e-6},
}
STUDY: dict[str, Any] = {
    "study": {"seeds": 2, "tell_sensors": True, "metrics": ["gospa", "idf1"]},
    "scenarios": {"sea": {"scene": SCENE, "sweep": {"sensors": {"clutter_per_scan": [1, 6]}}}},
    "configurations": {
        "window": {"set": TOLD},
        "nearest": {"set": {**TOLD, "tracker": {"kind": "nearest-neighbour"}}},
    },
}


def changed(path: str, value: Any, study: dict[str, Any] = STUDY) -> dict[str, Any]:
    """Return the study with one key changed, named by its dotted path; None to leave it out."""
    found = copy.deepcopy(study)
    *tables, key = path.split(".")
    at = found
    for name in tables:
        at = at.setdefault(name, {})
    if value is None:
        at.pop(key, None)
    else:
        at[key] = value
    return found
