"""What reports tell of sensors and objects."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trackweave.models.strength import StrengthModel

__all__ = ["Estimates", "SensorEstimate", "bounded", "digits"]


@dataclass(frozen=True, slots=True)
class SensorEstimate:
    """What one sensor's reports tell of it.

    Parameters
    ----------
    scan_period
        Time from scan to scan [s]; None where it does not scan.
    sigma
        Standard deviation of a report along an axis [m]; or of each number of a report, as a
        tuple [m, rad, m/s].
    detection_probability
        Chance that a scan reports an object.
    clutter_density
        False alarms per m² (m³) and scan.
    covered
        Area [m²] or volume [m³] from which its reports come.
    n_objects
        Objects present at a time, on average.
    density
        Reports per m² (m³) and scan; 0 for unknown.
    scans
        Whether it looks; None for unknown. Of one that does not, chances are per second.
    disagreement
        By how much else it puts objects elsewhere than other sensors do, as a standard
        deviation along an axis that is part of ``sigma`` [m].
    strength
        What the strength of its reports tells of their origin; None for nothing.
    """

    scan_period: float | None
    sigma: float | tuple[float, ...]
    detection_probability: float
    clutter_density: float
    covered: float
    n_objects: float
    density: float = 0.0
    scans: bool | None = None
    disagreement: float = 0.0
    strength: StrengthModel | None = None

    @property
    def plane_sigma(self) -> float:
        """Standard deviation along an axis [m]: sigma, or the first of its numbers."""
        return self.sigma[0] if isinstance(self.sigma, tuple) else self.sigma


@dataclass(frozen=True, slots=True)
class Estimates:
    """What the reports tell.

    Parameters
    ----------
    sensors
        Estimates by name of the sensor.
    process_noise
        Power spectral density of the acceleration along an axis [m²/s³].
    max_speed
        Greatest speed of an object [m/s].
    new_target_density
        Objects newly present per m² (m³) and scan.
    initial_target_density
        Objects present per m² (m³) at a time.
    hidden_share, mean_silence
        Share of their time for which objects are where no sensor can see them, and how long on
        average [s]; None for unknown.
    delete_after_misses
        Misses in succession after which a track ends; None for no such number.
    max_scans, depth
        Scans, and instants, that a window should hold; None for the usual number.
    period
        Time between rows of a track [s]; None for every scan.
    together
        Within how long hardly any object reports twice where no sensor looks [s].
    ways
        Ways between which objects change, as in ``[motion.imm]``.
    doubts
        Why a sensor's estimates are doubtful, by its name; sensors without doubt are left out.
    remarks
        On what a value rests and how sure it is, by its key in a configuration file.
    notes
        Sentences on what was left out or not believed.
    speed_of_few
        Greatest speed of the few that are faster than the others [m/s]; 0 for unknown.
    """

    sensors: Mapping[str, SensorEstimate]
    process_noise: float
    max_speed: float
    new_target_density: float
    initial_target_density: float
    hidden_share: float | None = None
    mean_silence: float | None = None
    delete_after_misses: int | None = None
    max_scans: int | None = None
    depth: int | None = None
    period: float | None = None
    together: float | None = None
    ways: Mapping[str, Any] | None = None
    doubts: Mapping[str, str] = field(default_factory=dict)
    remarks: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    speed_of_few: float = 0.0


def bounded(value: float, least: float = 1e-9) -> float:
    """Return a value that a configuration takes: the data's scale may be anything.

    Parameters
    ----------
    value
        Any number.
    least
        Least value that makes sense. Must be positive.

    Returns
    -------
    A number between, rounded.
    """
    return digits(float(np.clip(value, least, 1e8)))


def digits(value: float, count: int = 4) -> float:
    """Return a value without digits that no estimate can be sure of.

    Parameters
    ----------
    value
        Any finite number.
    count
        How many significant digits stay.

    Returns
    -------
    The rounded number.
    """
    return float(f"{value:.{count}g}")
