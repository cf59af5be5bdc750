"""What categories 034 and 002 say of radars: where they stand, how they turn, where they are."""

import numpy as np

from trackweave.formats.asterix.records import Records
from trackweave.formats.asterix.values import TIME_S, sensor_names
from trackweave.formats.format import Facts, Place

__all__ = ["Stations"]

# Kinds of messages: the beam passes north, or the beginning of a sector.
_NORTH_MARK, _SECTOR = 1, 2
_DAY_S = 86_400.0
# As many turns of each radar are remembered: the median of them is taken.
_MOST_TURNS = 1000
_ANGLE_DEG = 180 / 2**23


class Stations:
    """Gathers what radars say of themselves.

    Parameters
    ----------
    facts
        Takes places and turns.
    """

    def __init__(self, facts: Facts) -> None:
        self._facts = facts
        self._told: dict[str, list[float]] = {}
        self._measured: dict[str, list[float]] = {}
        self._passed: dict[tuple[str | None, int, int], float] = {}

    def tell(self, records: Records) -> list[tuple[str, float, int]]:
        """Take records of category 034 or 002.

        Returns
        -------
        For each beam that crossed north or a sector's border: the radar, the time of the day [s],
        and where in the buffer that is said.
        """
        names = sensor_names(records).tolist()
        kind, _ = records.read("000")
        moment, turn = (records.number(item, scale=TIME_S) for item in ("030", "041"))
        for row in np.flatnonzero(turn > 0):
            self._enter(self._told, names[row], float(turn[row]))
        sector, _ = records.read("020")
        crossed = np.flatnonzero(np.isin(kind, (_NORTH_MARK, _SECTOR)) & ~np.isnan(moment))
        for row in crossed:
            passed = (names[row], int(kind[row]), int(sector[row]))
            since = (moment[row] - self._passed.get(passed, moment[row])) % _DAY_S
            # A message that was captured twice is one.
            if since > 0.0:
                self._enter(self._measured, names[row], float(since))
            self._passed[passed] = float(moment[row])
        if records.knows("120"):
            self._places(records, names)
        # As the radar says, else by north marks and sectors.
        for turns in (self._measured, self._told):
            for name, known in turns.items():
                self._facts.scan_periods[name] = float(np.median(known))
        return [
            (names[row], float(moment[row]), int(records.begin[row]))
            for row in crossed
            if names[row] is not None
        ]

    def _places(self, records: Records, names: list[str | None]) -> None:
        latitude, there = records.read("120", "LAT")
        longitude, _ = records.read("120", "LON")
        height, _ = records.read("120", "HGT")
        for row in np.flatnonzero(there):
            name = names[row]
            north, east = (float(each[row]) * _ANGLE_DEG for each in (latitude, longitude))
            place = Place(north, east, float(height[row]))
            if name is not None and abs(place.latitude_deg) <= 90.0:
                self._facts.places[name] = place

    @staticmethod
    def _enter(turns: dict[str, list[float]], name: str | None, turn: float) -> None:
        if name is not None and len(known := turns.setdefault(name, [])) < _MOST_TURNS:
            known.append(turn)
