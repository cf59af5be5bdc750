"""Heights that nobody told, found from the ranges of several sensors before they are tracked."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.reports import ReportTable
from trackweave.estimation.bias_changes import BiasChange
from trackweave.estimation.displaced import displaced
from trackweave.estimation.height_pairs import STEEPEST
from trackweave.estimation.heights import Heights, heights_of
from trackweave.estimation.sightings import AZIMUTH, N_BIASES, RANGE, Sightings
from trackweave.estimation.turned_apart import turned_apart
from trackweave.run.beams import with_beam_places, with_beam_times
from trackweave.run.biases import as_key, told_biases, unbiased
from trackweave.run.cartesian_to_polar import with_ranges
from trackweave.run.observing import observe, positions_in
from trackweave.run.polar_to_cartesian import EARTH_RADIUS_M, platforms_of
from trackweave.run.registering import (
    Registration,
    may_be,
    may_stand_elsewhere,
    registration_of,
    unfit,
)
from trackweave.run.sighting import tracks_of
from trackweave.run.sweeping import with_sweeps
from trackweave.run.told_places import standing, with_facts

__all__ = ["HeightFinding", "found_heights", "registered"]

CHANGING = {"range_bias_m": RANGE, "azimuth_bias_deg": AZIMUTH}
# Recordings with fewer reports hold no tracks that tell.
FEWEST_REPORTS = 40
# A sensor tells no heights where more of its reports than this share have none.
MISSING = 0.5
# What is slower over so many reports is on the ground [m/s], where its range is its distance.
TAXIING, STRIDE = 40.0, 4


@dataclass(frozen=True, eq=False)
class HeightFinding:
    """Reports with the heights that were found for them."""

    reports: ReportTable
    found: Heights | None = None  # None where nothing was looked for
    n_filled: int = 0  # Reports that had none
    n_zero: int = 0  # Of these told to be at 0 m, as some radars write that do not know
    is_elsewhere: bool = False  # Whether some sensor was taken to stand elsewhere than told

    def notes(self) -> list[str]:
        """Return a sentence where heights were found."""
        if self.found is not None and self.found.change is not None:
            return self._on_change(self.found.change)
        if self.found is None or not self.n_filled:
            return []
        found = self.found
        zero = f", {self.n_zero} of them told as 0 m," if self.n_zero else ""
        return [
            f"height_m: {self.n_filled} of {len(self.reports)} reports{zero} are given that at "
            f"which several sensors see their object at one place ({found.n_objects} objects; of "
            f"{found.n_pairs} pairs of tracks {found.n_clear} tell it clearly); "
            "give height_m where it is known, or trust = true in [sensors.NAME] where ranges are "
            "those on the ground"
        ]

    def _changed(self, change: BiasChange) -> dict[str, dict[str, float]]:
        """Return by how much each sensor's keys change, those that do."""
        every = {
            name: {key: as_key(key, own) for key, place in CHANGING.items() if own[place]}
            for name, own in zip(self.reports.sensors, change.step, strict=True)
        }
        return {name: own for name, own in every.items() if own}

    def _on_change(self, change: BiasChange) -> list[str]:
        """Return a sentence on each sensor whose biases change."""
        return [
            f"sensor {name}: from {change.time:.6g} s on its biases are others than before, by "
            f"{', '.join(f'{value:.4g} ({key})' for key, value in own.items())}, as "
            f"{change.n_pairs} pairs of tracks of two sensors tell; that is taken out of its "
            f"reports from then on; give trust in [sensors.{name}] with the keys to keep it"
            for name, own in self._changed(change).items()
        ]

    def as_record(self) -> dict[str, Any] | None:
        """Return what was found, None where nothing was looked for."""
        if self.found is None:
            return None
        change = self.found.change
        return {
            "objects": self.found.n_objects,
            "reports": self.n_filled,
            "pairs": self.found.n_pairs,
            "clear_pairs": self.found.n_clear,
            "change": change and {"time": change.time, "sensors": self._changed(change)},
        }


def found_heights(
    reports: ReportTable,
    configuration: Configuration,
    *,
    looks: bool = True,
    elsewhere: bool = False,
) -> HeightFinding:
    """Return reports with heights where ranges of several sensors tell them."""
    # With ``elsewhere`` sensors may stand far from where they are told to.
    # Only with ``looks`` are any looked for: where a sensor tells slant ranges without heights of
    # what is faster than on the ground, and another sees the same.
    nothing, told = HeightFinding(reports), reports.height
    needy = _needy(reports, configuration)
    if told is not None:
        # Of others a height of 0 m is one.
        is_none = needy[reports.sensor] & (told == 0.0)
        reports = replace(reports, height=np.where(is_none, np.nan, told))
    if not looks or reports.dim != 2 or not needy.any() or len(reports) < FEWEST_REPORTS:
        return nothing
    observed = observe(reports, configuration)
    refused = unfit(reports, configuration, observed)
    chosen = [i for i, name in enumerate(reports.sensors) if name not in refused]
    if len(chosen) < 2 or not needy[chosen].any():
        return nothing
    followed = tracks_of(reports, configuration, observed, chosen, every=True)
    if isinstance(followed, str):
        return nothing
    seen, _ = followed
    rows = np.flatnonzero(seen.track >= 0)
    if not rows.size:
        return nothing
    level = platforms_of(reports, positions_in(reports, configuration))[:, 2]
    # What is told to be wrong with a sensor is no height.
    sightings = seen.part(seen.track >= 0).without(told_biases(reports, configuration.sensor))
    bias = np.zeros((sightings.n_sensors, N_BIASES))
    if elsewhere:
        bias = displaced(sightings, may_stand_elsewhere(reports, configuration, refused))
        sightings = sightings.without(bias)
    nothing = replace(nothing, is_elsewhere=bool(bias.any()))
    is_slant = needy[reports.sensor] & np.isnan(seen.height)
    is_slant[rows] &= _is_fast(sightings)
    if not is_slant[rows].any():
        return nothing
    curve = 0.0 if reports.frame is None else 1.0 / EARTH_RADIUS_M
    found = _heights_or_turns(sightings, level[rows], is_slant[rows], curve)
    filled = rows[is_slant[rows] & np.isfinite(found.height)]
    if not filled.size:
        # What is trusted stays, and is not said to have gone.
        found = found.allowed(may_be(reports, configuration, refused, ()))
        return replace(nothing, reports=_unchanged(nothing.reports, found.change), found=found)
    height = np.full(len(reports), np.nan) if told is None else told.copy()
    n_zero = int(np.sum(height[filled] == 0.0))
    # Nothing is higher above a sensor than it is far off.
    highest = level[filled] + STEEPEST * seen.slant[filled]
    height[filled] = np.minimum(found.height[np.searchsorted(rows, filled)], highest)
    return replace(
        nothing,
        reports=replace(reports, height=height),
        found=found,
        n_filled=int(filled.size),
        n_zero=n_zero,
    )


def _unchanged(reports: ReportTable, change: BiasChange | None) -> ReportTable:
    """Return reports without what changed of biases from then on."""
    if change is None:
        return reports
    shifted = unbiased(reports, change.step).measurement
    is_late = (reports.time >= change.time)[:, None]
    return replace(reports, measurement=np.where(is_late, shifted, reports.measurement))


def _heights_or_turns(
    sightings: Sightings, level: FloatArray, is_slant: NDArray[np.bool_], curve: float
) -> Heights:
    """Return the heights of objects, those beside norths that are far off where none show."""
    found = heights_of(sightings, level, is_slant, curve)
    if found.n_objects or found.is_on_ground:
        return found
    every = np.ones((sightings.n_sensors, N_BIASES), dtype=np.bool_)
    turned, _ = turned_apart(sightings, every)
    return heights_of(sightings.without(turned), level, is_slant, curve) if turned.any() else found


def registered(
    reports: ReportTable, configuration: Configuration, *, looks: bool = True
) -> tuple[HeightFinding, Registration]:
    """Return what was found of sweeps, of heights and then of biases, where any are looked for."""
    reports, configuration = with_sweeps(reports, configuration)
    reports = standing(reports, configuration)
    told, polar = with_facts(configuration, reports), tuple[str, ...]()
    reports, told, placed = with_beam_places(reports, told)
    if looks:
        where = positions_in(reports, told)
        reports, told, polar = with_ranges(reports, told)
        placed = (*placed, *(name for name in polar if name not in where))
    reports = with_beam_times(reports, told)
    heights, found = _registered(reports, told, looks=looks, elsewhere=True)
    if heights.is_elsewhere and not found.is_elsewhere:
        heights, found = _registered(reports, told, looks=looks, elsewhere=False)
    return heights, replace(found, placed=placed, polar=polar)


def _registered(
    reports: ReportTable, told: Configuration, *, looks: bool, elsewhere: bool
) -> tuple[HeightFinding, Registration]:
    """Return what was found of heights and then of biases."""
    heights = found_heights(reports, told, looks=looks, elsewhere=elsewhere)
    flat = heights.found is not None and heights.found.is_on_ground
    # A height that is found takes up a part of what a wrong place near by does.
    may = not heights.n_filled or heights.is_elsewhere
    return heights, registration_of(heights.reports, told, looks=looks, flat=flat, elsewhere=may)


def _is_fast(sightings: Sightings) -> NDArray[np.bool_]:
    """Tell which reports are of tracks that are faster than what taxies."""
    place = sightings.corrected(np.zeros((sightings.n_sensors, N_BIASES)))[1]
    fast = np.zeros(sightings.time.size, dtype=np.bool_)
    for rows in sightings.rows:
        # Over several reports, so that noise is no speed, and turns hardly take any.
        step = min(STRIDE, rows.size - 1)
        way = np.linalg.norm(place[rows[step:]] - place[rows[:-step]], axis=1)
        lasting = sightings.time[rows[step:]] - sightings.time[rows[:-step]]
        fast[rows] = np.median(way / np.maximum(lasting, 1e-9)) > TAXIING
    return fast


def _needy(reports: ReportTable, configuration: Configuration) -> NDArray[np.bool_]:
    """Tell which sensors measure ranges without elevations, and lack heights."""
    needy = np.zeros(len(reports.sensors), dtype=np.bool_)
    for index, name in enumerate(reports.sensors):
        kind = reports.kind_of(index)
        if isinstance(kind, ForeignKind) or not kind.has_range or kind.has_elevation:
            continue
        own = reports.sensor == index
        if not own.any():
            continue
        # False alarms tell no heights, some transponders do not, and some radars write 0 m then.
        height = np.full(1, np.nan) if reports.height is None else reports.height[own]
        missing = float(np.mean(np.isnan(height) | (height == 0.0)))
        needy[index] = missing > MISSING and configuration.sensor(name).get("trust") is not True
    return needy
