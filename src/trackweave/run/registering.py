"""Biases of sensors: those that are told taken out of reports, others looked for."""

from collections.abc import Container, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackweave.arrays import FloatArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.config.sensing import ObservedSensor
from trackweave.domain.foreign_kind import ForeignKind
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import digits
from trackweave.estimation.receivers import receivers_in
from trackweave.estimation.registration import Registered, registered
from trackweave.estimation.sightings import AZIMUTH, EAST, N_BIASES, NORTH, RANGE, SCALE
from trackweave.run.biases import BIAS_KEYS, as_key, keys_of, told_biases, unbiased
from trackweave.run.observing import observe, positions_in
from trackweave.run.sighting import NO_HEIGHT, heard_tracks, hearing, is_looking, sightings_of

__all__ = ["Registration", "may_be", "may_stand_elsewhere", "registration_of", "unfit"]

DIGITS = 6
# Where a sensor stands is no bias of its reports: it moves all of them by these numbers.
POSITION, OF_POSITION, PLACED = "position", (EAST, NORTH), "it stands"


@dataclass(frozen=True, eq=False)
class Registration:
    """Reports without their sensors' biases, and what was found of these."""

    reports: ReportTable
    configuration: Configuration  # With the biases that were taken out
    told: FloatArray  # As told, shape (sensors, 6)
    found: Registered | None = None  # What reports show besides; None where nothing was looked for
    refused: dict[str, str] = field(default_factory=dict)  # Why not, by sensor
    doubt: str = ""  # Why nothing could be looked for at all
    placed: tuple[str, ...] = ()  # Whose places reports told, by the beam that turns there
    polar: tuple[str, ...] = ()  # Whose positions are the ranges and azimuths of such a beam
    # Where sensors that measure ranges are told to stand, x, y[, z] [m], by name.
    places: dict[str, tuple[float, ...]] = field(default_factory=dict)

    def entered(self, settings: Settings) -> Settings:
        """Return a configuration as used, in which what was found counts as estimated."""
        learned = {f"sensors.{name}.{key}": "estimated" for name, _, key in self.found_out()}
        learned |= {f"sensors.{name}.position": "estimated" for name in self.placed}
        learned |= {f"sensors.{name}.measurement": "estimated" for name in self.polar}
        return replace(settings, sources={**settings.sources, **learned})

    def notes(self) -> list[str]:
        """Return a sentence on each sensor of whose biases something was found out."""
        if self.found is None:
            # Heights a user may be able to give; that a sky is a crowd nobody can mend.
            is_mendable = self.doubt == NO_HEIGHT
            return [f"biases of sensors were not looked for: {NO_HEIGHT}"] if is_mendable else []
        words: dict[str, list[str]] = {}
        for name, index, key in self.found_out():
            words.setdefault(name, []).append(self._words(index, key))
        right = [n for n in self.reports.sensors if n not in words and n not in self.refused]
        beside = f" beside {', '.join(right)}" if right else ""
        if len(right) == 1 and len(words) == 1:
            # Clocks and places are told beside each other alone, and those of two are a choice.
            ((_, said),) = words.items()
            if all(each.startswith(("clock_offset", PLACED)) for each in said):
                beside += f", or {right[0]} as much the other way, which nothing tells apart"
        return [
            f"sensor {name}: {', '.join(said)}{beside}; by {self.found.n_objects} objects that "
            "several sensors see; taken out of its reports before they are tracked, so that "
            "times, ranges and directions count without it; mend the sensor, or give the keys "
            f"and trust in [sensors.{name}] to keep what is told"
            for name, said in words.items()
        ]

    def unregistered(self) -> dict[str, str]:
        """Return why nobody knows of a sensor's biases, by its name; others are left out."""
        doubt = self.doubt if self.found is None else self.found.doubt
        doubtful = dict.fromkeys(self.reports.sensors, doubt) if doubt else {}
        return {**doubtful, **self.refused}

    @property
    def is_elsewhere(self) -> bool:
        """Whether some sensor stands elsewhere than told."""
        return any(key == POSITION for *_, key in self.found_out())

    def as_record(self) -> dict[str, Any] | None:
        """Return what was looked for and found of biases; None where nothing was."""
        if self.found is None and not self.doubt:
            return None
        found = self.found
        sensors = {
            name: {key: self._of_key(index, key) for key in self._keys(index)}
            for index, name in enumerate(self.reports.sensors)
            if found is not None and name not in self.refused
        }
        return {
            "objects": 0 if found is None else found.n_objects,
            "reports": 0 if found is None else found.n_reports,
            "doubt": (self.doubt if found is None else found.doubt) or None,
            "sensors": sensors,
            "refused": dict(self.refused),
        }

    def told_record(self) -> list[dict[str, Any]]:
        """Return what was told, learned and used of each key that was told otherwise."""
        return [
            {"key": f"sensors.{name}.{key}", **self._of_key(index, key)}
            for name, index, key in self.found_out()
            if key == POSITION or self.told[index, list(_numbers(key))].any()
        ]

    @property
    def _sigmas(self) -> FloatArray:
        assert self.found is not None
        return np.sqrt(np.diagonal(self.found.covariance)).reshape(self.told.shape)

    def found_out(self) -> Iterator[tuple[str, int, str]]:
        """Yield name and number of each sensor with each of its keys that is not as told."""
        if self.found is None:
            return
        for index, name in enumerate(self.reports.sensors):
            for key in self._keys(index):
                if self.found.bias[index, list(_numbers(key))].any():
                    yield name, index, key

    def used(self, index: int, key: str) -> Any:
        """Return the value of a sensor's key that is used."""
        assert self.found is not None
        return _rounded(self._value(index, key, self.found.bias))

    def _words(self, index: int, key: str) -> str:
        """Return what was found of a key, and how sure it is."""
        assert self.found is not None
        numbers = np.atleast_1d(self._value(index, key, self.found.bias))
        sure = np.atleast_1d(_sigma(key, self._sigmas[index]))
        if key == POSITION:
            east, north = self.found.bias[index, list(OF_POSITION)].tolist()
            # Places are wrong the other way.
            moved = [f"{abs(east):.4g} m {'west' if east > 0 else 'east'}"] if east else []
            moved += [f"{abs(north):.4g} m {'south' if north > 0 else 'north'}"] if north else []
            at = ", ".join(f"{each:.6g}" for each in numbers)
            by = ", ".join(f"{each:.2g}" for each in sure[[east != 0.0, north != 0.0]])
            return f"{PLACED} {' and '.join(moved)} of its position, at [{at}] (± {by} m)"
        said = ", ".join(f"{a:.4g} ± {b:.2g}" for a, b in zip(numbers, sure, strict=True))
        return f"{key} {said}"

    def _of_key(self, index: int, key: str) -> dict[str, Any]:
        assert self.found is not None
        sigma = _finite(_sigma(key, self.found.sigma[index]))
        learned = _finite(self._value(index, key, self.found.likely))
        return {
            "told": self._value(index, key, np.zeros_like(self.told)),
            "learned": None if sigma is None else learned,
            "sigma": sigma,
            "used": self.used(index, key),
        }

    def _keys(self, index: int) -> tuple[str, ...]:
        own = keys_of(self.reports.kind_of(index))
        return (*own, POSITION) if self.reports.sensors[index] in self.places else own

    def _value(self, index: int, key: str, besides: FloatArray) -> Any:
        """Return what a key says where a sensor has biases besides those that are told."""
        if key != POSITION:
            return as_key(key, self.told[index] + besides[index])
        place = list(self.places[self.reports.sensors[index]])
        east, north = besides[index, list(OF_POSITION)].tolist()
        return [place[0] - east, place[1] - north, *place[2:]]


def registration_of(
    every: ReportTable,
    configuration: Configuration,
    *,
    looks: bool = True,
    flat: bool = False,
    elsewhere: bool = True,
) -> Registration:
    """Return reports without the biases that are told, and those that the reports show clearly."""
    # Only with ``looks`` are any looked for; ``flat`` where ranges clearly are on the ground;
    # with ``elsewhere`` sensors may stand elsewhere than told.
    told = told_biases(every, configuration.sensor)
    reports = unbiased(every, told)
    known = Registration(reports, configuration, told)
    if not looks or len(reports.sensors) < 2 or reports.has_foreign:
        return known
    observed = observe(reports, configuration)
    refused = unfit(reports, configuration, observed)
    known = replace(known, refused=refused)
    chosen = [i for i, name in enumerate(reports.sensors) if name not in refused]
    if len(chosen) < 2:
        return replace(known, doubt="fewer than two sensors tell places")
    alone = hearing(reports, configuration, observed, chosen)
    seen = sightings_of(reports, configuration, observed, chosen, flat=flat)
    if isinstance(seen, str):
        return replace(known, doubt=seen)
    places = _places(reports, configuration, refused) if elsewhere else {}
    may = may_be(reports, configuration, refused, places)
    # Who reports by itself knows where it is, though maybe not when its reports come.
    may[np.ix_(alone, OF_POSITION)] = False
    found = registered(seen[0], may, seen[1])
    known = replace(known, found=found, places=places)
    if not found.bias.any():
        return known
    sensors = configuration.table("sensors")
    for name, index, key in known.found_out():
        sensors[name] = {**sensors.get(name, {}), key: known.used(index, key)}
    changed = configuration.changed(sensors=sensors)
    # What is used is what is written down, to the last digit.
    return replace(
        known, reports=unbiased(every, told_biases(every, changed.sensor)), configuration=changed
    )


def unfit(
    reports: ReportTable, configuration: Configuration, observed: dict[str, ObservedSensor]
) -> dict[str, str]:
    """Return why nothing can be told of a sensor's biases, by name; others are left out."""
    places = positions_in(reports, configuration)
    receivers = receivers_in(reports)
    refused = {}
    for index, name in enumerate(reports.sensors):
        seen, kind = observed[name], reports.kind_of(index)
        if isinstance(kind, ForeignKind) or not kind.gives_position(reports.dim):
            refused[name] = "its reports do not say where objects are"
        elif name in receivers:
            refused[name] = "it reports one place alone, where it stands"
        elif seen.says_where:
            refused[name] = "it moves, or may: its reports say where it was"
        elif kind.has_range and name not in places and seen.needs_place:
            refused[name] = "nobody says where it stands"
        elif not is_looking(seen) and np.all(heard_tracks(reports, index) < 0):
            refused[name] = "it has no scans, and nothing tells whose its reports are"
    return refused


def _places(
    reports: ReportTable, configuration: Configuration, refused: Container[str]
) -> dict[str, tuple[float, ...]]:
    """Return where sensors that measure ranges are told to stand, by name."""
    return {
        name: place
        for name, place in positions_in(reports, configuration).items()
        if name not in refused and reports.kind_of(reports.sensors.index(name)).has_range
    }


def may_stand_elsewhere(
    reports: ReportTable, configuration: Configuration, refused: Container[str]
) -> NDArray[np.bool_]:
    """Tell by which biases sensors may stand elsewhere than told, shape (sensors, 6)."""
    # Those that are ``refused`` are not looked at.
    may = np.zeros((len(reports.sensors), N_BIASES), dtype=np.bool_)
    every = may_be(reports, configuration, refused, _places(reports, configuration, refused))
    for index in range(may.shape[0]):
        if reports.kind_of(index).has_range:
            may[index, list(OF_POSITION)] = every[index, list(OF_POSITION)]
    return may


def may_be(
    reports: ReportTable,
    configuration: Configuration,
    refused: Container[str],
    places: Container[str],
) -> NDArray[np.bool_]:
    """Tell which biases may be other than told, shape (sensors, 6)."""
    # ``refused`` has none that can be told, and who is in ``places`` may stand elsewhere.
    may = np.ones((len(reports.sensors), N_BIASES), dtype=np.bool_)
    for index, name in enumerate(reports.sensors):
        kind, said = reports.kind_of(index), configuration.sensor(name)
        if name in refused:
            may[index] = False
            continue
        if kind.is_position:
            may[index, [RANGE, SCALE, AZIMUTH]] = False
        elif name not in places:
            may[index, list(OF_POSITION)] = False
        trust = said.get("trust", False)
        for key in (*keys_of(kind), POSITION):
            # A place on the Earth is a position by now.
            words = {key, "place"} if key == POSITION else {key}
            if key in said and (trust is True or (trust and words & set(trust))):
                may[index, list(_numbers(key))] = False
    return may


def _numbers(key: str) -> tuple[int, ...]:
    """Return which of a sensor's six numbers a key tells."""
    return OF_POSITION if key == POSITION else BIAS_KEYS[key]


def _sigma(key: str, numbers: FloatArray) -> Any:
    """Return how sure a key is, by the standard deviations of a sensor's six numbers."""
    if key == POSITION:
        return [float(each) for each in numbers[list(OF_POSITION)]]
    return as_key(key, numbers, is_sigma=True)


def _finite(value: Any) -> Any:
    """Return a number, or a list of them, rounded, for JSON; None where it is not finite."""
    return _rounded(value) if np.all(np.isfinite(value)) else None


def _rounded(value: Any) -> Any:
    """Return a number, or a list of them, with as many digits as are ever told."""
    if isinstance(value, list):
        return [_rounded(each) for each in value]
    return digits(value, DIGITS)
