"""A turning sensor's beam, followed through the scans of a live tracker.

What a caller tells of a turn is as exact as its clock: motors wander, and a period wrong by
one part in a hundred points the other way after fifty turns. The reports' own times and directions
show where the beam is.
"""

from typing import NamedTuple

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.scans import Scan
from trackweave.estimation.following import RESTLESS, Beam, corrected, first_beam, off_beam
from trackweave.models.rotation import FollowedRotation, Rotation
from trackweave.models.sensors import Sensor

__all__ = ["LiveBeam", "beam_with", "rotation_by"]

# Of so many reports over a turn the beam's place is taken, and of no more.
FEWEST, MOST = 5, 64
# So many times in a row reports have to agree, and to tell the beam off by so much [turns].
OFTEN, OFF = 3, 0.01
SURELY = 3.0


class LiveBeam(NamedTuple):
    """A beam, what has been seen of it since it was last corrected, and how often that agreed."""

    beam: Beam
    time: tuple[float, ...] = ()
    angle: tuple[float, ...] = ()
    agreed: int = 0


def beam_with(known: LiveBeam | None, sensor: Sensor, scan: Scan) -> LiveBeam | None:
    """Return a beam after a scan's reports, of a scan not before others."""
    # It is None for a sensor that does not turn or whose turn is known for all times.
    told = sensor.rotation
    if told is None or isinstance(told, FollowedRotation) or scan.moments is None:
        return None
    kind = sensor.measurement
    if isinstance(kind, ForeignKind) and not kind.gives_position(kind.dim or 2):
        return None
    if known is None:
        start = float(scan.moments.min(initial=scan.time))
        turned = told.direction * told.phase / (2.0 * np.pi) + float(told.turned(start))
        known = LiveBeam(first_beam(start, turned, 1.0 / told.period))
    if len(scan) == 0:
        return known
    order = np.argsort(scan.moments, kind="stable")
    angle = told.direction * _azimuth(sensor, scan)[order] / (2.0 * np.pi)
    time = (*known.time, *scan.moments[order].tolist())[-MOST:]
    known = known._replace(time=time, angle=(*known.angle, *angle.tolist())[-MOST:])
    turns = known.beam.rate * (time[-1] - known.beam.time)
    is_enough = len(time) >= FEWEST and turns >= 1.0
    return _checked(known) if is_enough or len(time) == MOST else known


def _checked(known: LiveBeam) -> LiveBeam:
    """Return a beam corrected by the reports that have come since it last was."""
    seen = np.array(known.time), np.array(known.angle)
    found = off_beam(known.beam, *seen)
    if found is None or _is_restless(*found):
        found = off_beam(known.beam, *seen, RESTLESS) or found
    if found is None:
        return LiveBeam(known.beam)
    return LiveBeam(corrected(*found), agreed=known.agreed + 1)


def _is_restless(beam: Beam, off: float, variance: float) -> bool:
    """Tell whether a beam lies farther off than one that wanders would."""
    return bool(off**2 > SURELY**2 * (beam.angle_variance + variance))


def rotation_by(known: LiveBeam | None, told: Rotation) -> Rotation:
    """Return how a beam turns at present."""
    # It is what is told, unless reports have surely shown the beam elsewhere.
    if known is None or known.agreed < OFTEN:
        return told
    beam = known.beam
    said = told.direction * told.phase / (2.0 * np.pi) + float(told.turned(beam.time))
    off = abs(beam.turned - said - round(beam.turned - said))
    if off <= max(OFF, SURELY * float(np.sqrt(beam.angle_variance))):
        return told
    phase = told.direction * 2.0 * np.pi * ((beam.turned - beam.time * beam.rate) % 1.0)
    return Rotation(1.0 / beam.rate, float(phase), told.direction)


def _azimuth(sensor: Sensor, scan: Scan) -> FloatArray:
    """Return where reports come from [rad, clockwise from north]."""
    kind, place = sensor.measurement, scan.measurement
    platform = sensor.platform
    if scan.platform is not None and scan.platform.size:
        platform = np.asarray(scan.platform)
    if isinstance(kind, ForeignKind):
        dim = kind.dim or 2
        sigma = sensor.noise(scan.sigma, scan.measurement, dim)
        reported = kind.reported(scan.measurement, sigma, scan.context, scan.covariance)
        platforms = np.broadcast_to(platform, (len(scan), 6))
        place, _ = kind.first_state(platforms, reported, dim)
    elif not kind.is_position:
        return scan.measurement[:, kind.azimuth]
    east, north = (place[:, :2] - platform[..., :2]).T
    return np.asarray(np.arctan2(east, north))
