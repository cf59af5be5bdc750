"""What a recording tells of its sensors counts as told, where the configuration is silent."""

from typing import Any

import numpy as np

from trackweave.config import Configuration
from trackweave.config.sensing import section_of
from trackweave.domain.reports import ReportTable

__all__ = ["with_facts"]


def with_facts(configuration: Configuration, reports: ReportTable) -> Configuration:
    """Return a configuration with what the recording tells of places and turns of its sensors."""
    sensors: dict[str, dict[str, Any]] = {}
    for name in reports.sensors:
        section, own = section_of(configuration, name), dict[str, Any]()
        place = reports.facts.places.get(name)
        if place is not None and section.position is None and reports.frame is not None:
            angles = np.array([[place.latitude_deg], [place.longitude_deg], [place.altitude_m]])
            on_plane = reports.frame.to_plane(*angles)[0, : 2 if reports.dim == 2 else 3]
            own["position"] = [round(float(number), 3) for number in on_plane]
        period = reports.facts.scan_periods.get(name)
        if period is not None and section.scan_period is None:
            own["scan_period"] = period
        if own:
            sensors[name] = own
    if not sensors:
        return configuration
    values = configuration.as_file()
    given = values.get("sensors", {})
    merged = {name: {**given.get(name, {}), **own} for name, own in sensors.items()}
    changed = Configuration.model_validate({**values, "sensors": {**given, **merged}})
    return changed.called(configuration.name)
