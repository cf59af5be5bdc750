"""What a recording tells of its sensors counts as told, where the configuration is silent."""

from typing import Any

import numpy as np

from trackweave.config import Configuration
from trackweave.domain.reports import ReportTable

__all__ = ["with_facts"]


def with_facts(configuration: Configuration, reports: ReportTable) -> Configuration:
    """Return a configuration with what the recording tells of places and turns of its sensors."""
    sensors: dict[str, dict[str, Any]] = {}
    for name in reports.sensors:
        told, own = configuration.sensor(name), dict[str, Any]()
        place = reports.facts.places.get(name)
        if place is not None and "position" not in told and reports.frame is not None:
            angles = np.array([[place.latitude_deg], [place.longitude_deg], [place.altitude_m]])
            on_plane = reports.frame.to_plane(*angles)[0, : 2 if reports.dim == 2 else 3]
            own["position"] = [round(float(number), 3) for number in on_plane]
        period = reports.facts.scan_periods.get(name)
        if period is not None and "scan_period" not in told:
            own["scan_period"] = period
        if own:
            sensors[name] = own
    if not sensors:
        return configuration
    given = configuration.table("sensors")
    merged = {name: {**given.get(name, {}), **own} for name, own in sensors.items()}
    return configuration.changed(sensors={**given, **merged})
