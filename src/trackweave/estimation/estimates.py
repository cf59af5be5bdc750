"""What reports tell of sensors and objects."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trackweave.models.strength import StrengthModel

__all__ = ["Estimates", "SensorEstimate", "bounded", "digits", "positive"]


@dataclass(frozen=True, slots=True)
class SensorEstimate:
    """What one sensor's reports tell of it."""

    scan_period: float | None  # Time from scan to scan [s]; None where it does not scan
    # Standard deviation of a report along an axis [m]; or of each number of a report, as a tuple
    # [m, rad, m/s].
    sigma: float | tuple[float, ...]
    detection_probability: float  # Chance that a scan reports an object
    clutter_density: float  # False alarms per m² (m³) and scan
    covered: float  # Area [m²] or volume [m³] from which its reports come
    n_objects: float  # Objects present at a time, on average
    density: float = 0.0  # Reports per m² (m³) and scan; 0 for unknown
    # Whether it looks; None for unknown. Of one that does not, chances are per second.
    scans: bool | None = None
    # Noise along each axis of a position [m], where it is not alike; None for sigma along all.
    axes: tuple[float, ...] | None = None
    # Noise at some places, where it is not alike everywhere, as in ``[sensors.NAME] sigma_at``.
    sigma_at: tuple[tuple[float, ...], ...] = ()
    # By how much else it puts objects elsewhere than other sensors do, as a standard deviation
    # along an axis that is part of ``sigma`` [m].
    disagreement: float = 0.0
    tail_share: float = 0.0  # Share of its reports whose noise is wider
    tail_scale: float | None = None  # How many times as wide theirs is; None for unknown
    tail_persistence: float = 0.0  # How much wide noise is that of the same objects
    sigma_height: float | None = None  # Noise of its heights beside places [m]; None as usual
    height_offset: float = 0.0  # By how much they are above those of others [m]
    # Each number's noise in the middle of all tracks, where sigma is that over all; None as sigma.
    sigma_of_most: tuple[float, ...] | None = None
    # Noise across the line of sight however near an object is [m], as an object's width makes it.
    across: float = 0.0
    # Share of their time for which it alone does not see objects, and for how long [s].
    hidden_share: float = 0.0
    mean_silence: float | None = None
    # Places of false alarms that come again and again, as in ``[sensors.NAME] echoes``.
    echoes: tuple[tuple[float, ...], ...] = ()
    clutter_persistence: float = 0.0  # Chance that a false alarm comes again in the next scan
    identity_error: float | None = None  # Share of its reports under another's identity
    strength: StrengthModel | None = None  # What the strength of its reports tells of their origin

    @property
    def plane_sigma(self) -> float:
        """Standard deviation along an axis [m]: sigma, or the first of its numbers."""
        return self.sigma[0] if isinstance(self.sigma, tuple) else self.sigma


@dataclass(frozen=True, slots=True)
class Estimates:
    """What the reports tell."""

    sensors: Mapping[str, SensorEstimate]
    process_noise: float  # Power spectral density of the acceleration along an axis [m²/s³]
    max_speed: float  # [m/s]
    new_target_density: float  # Objects newly present per m² (m³) and scan
    initial_target_density: float  # Objects present per m² (m³) at a time
    # Share of their time for which objects are where no sensor can see them; None for unknown.
    hidden_share: float | None = None
    mean_silence: float | None = None  # How long they are there on average [s]; None for unknown
    survival: float | None = None  # Chance that an object lives on for a scan; None as usual
    # Misses in succession after which a track ends; None for no such number.
    delete_after_misses: int | None = None
    max_scans: int | None = None  # Scans that a window should hold; None for the usual number
    depth: int | None = None  # Instants in it, likewise
    period: float | None = None  # Time between rows of a track [s]; None for every scan
    # Within how long hardly any object reports twice where no sensor looks [s].
    together: float | None = None
    # Ways between which objects change, as in ``[motion.imm]``.
    ways: Mapping[str, Any] | None = None
    # Why a sensor's estimates are doubtful, by its name.
    doubts: Mapping[str, str] = field(default_factory=dict)
    # Told keys, by which tracks are far likelier than by what reports seem to say of them.
    confirmed: tuple[str, ...] = ()
    # On what a value rests and how sure it is, by its key in a configuration file.
    remarks: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # Sentences on what was left out or not believed
    # Greatest speed of the few that are faster than the others [m/s]; 0 for unknown.
    speed_of_few: float = 0.0
    of_one_object: bool = False  # Whether all reports are of one object, in their noise


def bounded(value: float, least: float = 1e-12) -> float:
    """Return a value, rounded, that a configuration takes: the data's scale may be anything."""
    # Features of glaciers go 1e-6 m/s, and change that by 1e-24 m²/s³.
    return digits(float(np.clip(value, least, 1e8)))


def positive(value: float) -> float:
    """Return a density or a process noise, rounded, in whatever units its numbers are."""
    return digits(float(np.clip(value, 1e-30, 1e30)))


def digits(value: float, count: int = 4) -> float:
    """Return a value with so many significant digits: no estimate can be sure of more."""
    return float(f"{value:.{count}g}")
