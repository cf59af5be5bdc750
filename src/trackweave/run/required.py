"""What nothing can be estimated of: keys that must be told where a kind is from outside."""

import numpy as np

from trackweave.config import Configuration
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.reports import ReportTable
from trackweave.errors import InvalidInputError

__all__ = ["require_told"]


def require_told(reports: ReportTable, configuration: Configuration) -> None:
    """Refuse a configuration that leaves open what no report of a kind from outside can tell."""
    kinds = dict(zip(reports.sensors, reports.kinds, strict=False))
    foreign = {name: kind for name, kind in kinds.items() if isinstance(kind, ForeignKind)}
    missing = []
    for index, name in enumerate(reports.sensors):
        if name in foreign:
            own = reports.sigma[reports.sensor == index][:, : foreign[name].n_components(2)]
            missing += _missing(
                configuration, name, foreign[name], is_sigma_told=not np.isnan(own).any()
            )
    if foreign and len(foreign) == len(reports.sensors):
        motion = configuration.table("motion")
        if configuration.plugins.motion is None:
            keys = ("process_noise", "max_speed")
            missing += [f"motion.{key}" for key in keys if key not in motion]
        if configuration.said("lifecycle", "new_target_density") is None:
            missing.append("lifecycle.new_target_density")
    if missing:
        words = sorted({kind.word for kind in foreign.values()})
        raise InvalidInputError(
            f"{configuration.name}: {', '.join(missing)} left out; expected to be told, because "
            f"nothing can be estimated from reports of measurement {', '.join(words)}, which is a "
            "plug-in"
        )


def _missing(
    configuration: Configuration, name: str, kind: ForeignKind, *, is_sigma_told: bool
) -> list[str]:
    """Return the keys of a sensor that are left out."""
    own = configuration.sensor(name)
    given = {
        "sigma": "sigma" in own or is_sigma_told or kind.has_own_covariance,
        "detection_probability": "detection_probability" in own,
        "clutter_density": "clutter_density" in own or "clutter_per_scan" in own,
        "scan_period (or scans = false)": "scan_period" in own or "scans" in own,
    }
    return [f"sensors.{name}.{key}" for key, is_given in given.items() if not is_given]
