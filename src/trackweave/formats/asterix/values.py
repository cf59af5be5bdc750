"""Columns of a reports table made of fields that several categories have."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from trackweave.formats.asterix.records import Records

__all__ = [
    "DEGREES_16",
    "FLIGHT_LEVEL_M",
    "FOOT_M",
    "NAUTICAL_MILE_M",
    "QUARTER_LEVEL_M",
    "TIME_S",
    "Columns",
    "Numbers",
    "Texts",
    "address",
    "callsign",
    "chosen",
    "latitude_longitude",
    "level",
    "mode_a",
    "sensor_names",
    "spelled",
    "words",
]

Numbers: TypeAlias = NDArray[np.float64]
"""NaN where there is none."""
Flags: TypeAlias = NDArray[np.bool_]
Texts: TypeAlias = NDArray[np.object_]
"""None where there is none."""
Columns: TypeAlias = dict[str, Numbers | Flags | Texts]

NAUTICAL_MILE_M = 1852.0
FOOT_M = 0.3048
FLIGHT_LEVEL_M = 100 * FOOT_M
QUARTER_LEVEL_M = FLIGHT_LEVEL_M / 4
TIME_S = 1 / 128
DEGREES_16 = 360 / 2**16
_LETTERS = " ABCDEFGHIJKLMNOPQRSTUVWXYZ" + " " * 5 + " " + " " * 15 + "0123456789" + " " * 6


def spelled(values: NDArray[np.int64], there: Flags, spell: Callable[[int], str]) -> Texts:
    """Return the text of each number, None where there is none; each number is spelled once."""
    distinct, number = np.unique(values[there], return_inverse=True)
    names = np.array([spell(int(value)) or None for value in distinct], dtype=object)
    texts = np.full(values.size, None, dtype=object)
    texts[there] = names[number]
    return texts


def sensor_names(records: Records) -> Texts:
    """Return the code of area and station that a record begins with, such as "025/201"."""
    area, there = records.read("010", "SAC")
    station, _ = records.read("010", "SIC")
    return spelled(area << 8 | station, there, lambda code: f"{code >> 8:03d}/{code & 255:03d}")


def address(records: Records, item: str) -> Texts:
    """Return aircraft addresses as six hexadecimal digits."""
    return spelled(*records.read(item), "{:06x}".format)


def callsign(records: Records, item: str, field: str = "") -> Texts:
    """Return what eight characters of six bits say, None where all are blank."""
    return spelled(*records.read(item, field), _characters)


def _characters(code: int) -> str:
    return "".join(_LETTERS[code >> shift & 63] for shift in range(42, -1, -6)).strip()


def words(records: Records, item: str, field: str, names: tuple[str, ...]) -> Texts:
    """Return the words for a field's numbers."""
    return spelled(*records.read(item, field), lambda code: names[code])


def mode_a(records: Records, item: str = "070") -> Columns:
    """Return Mode A codes as four octal digits, and what is said against them."""
    return {
        "mode_a": spelled(*records.read(item, "MODE3A"), "{:04o}".format),
        "mode_a_garbled": records.flag(item, "G"),
        "mode_a_unvalidated": records.flag(item, "V"),
    }


def level(records: Records, *better: Numbers, field: str = "FL") -> Columns:
    """Return heights, better ones or else Mode C's unless garbled, and what is said of Mode C."""
    garbled = records.flag("090", "G")
    height = records.number("090", field, QUARTER_LEVEL_M)
    return {
        "height_m": chosen(*better, np.where(garbled, np.nan, height)),
        "height_garbled": garbled,
        "height_unvalidated": records.flag("090", "V"),
    }


def latitude_longitude(records: Records, item: str, scale: float) -> dict[str, Numbers]:
    """Return latitudes and longitudes [degrees], neither where they are nowhere on the Earth."""
    north, east = (records.number(item, name, scale) for name in ("LAT", "LON"))
    off = (np.abs(north) > 90.0) | (np.abs(east) > 180.0)
    return {"lat": np.where(off, np.nan, north), "lon": np.where(off, np.nan, east)}


def chosen(*numbers: Numbers) -> Numbers:
    """Return the first of several numbers that is there."""
    result = numbers[0]
    for other in numbers[1:]:
        result = np.where(np.isnan(result), other, result)
    return result
