"""What the journal holds: everything that decides an answer, in the order in which it counts."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import polars as pl

from trackweave.domain.facts import Facts, Place
from trackweave.errors import DataFormatError
from trackweave.service.columns import packed_table, unpacked_table

__all__ = ["Arrived", "Kind", "arrived", "as_json", "from_json", "packed_reports"]


class Kind(IntEnum):
    """What a record says; the numbers are in files and never change."""

    REPORTS = 1
    """Reports as a decoder left them."""
    CONFIGURE = 2
    """With what the tracker runs from here on, complete."""
    CLOSE = 3
    """Up to when nothing is waited for any more."""
    BOUND = 4
    """How much work a step may take from here on."""
    DROP = 5
    """How many reports were not taken, because more came than can be."""


@dataclass(frozen=True, slots=True, eq=False)
class Arrived:
    """Reports as they are in the journal.

    Parameters
    ----------
    table
        Columns of a reports table.
    source
        Who sent them.
    facts
        What was told beside them.
    """

    table: pl.DataFrame
    source: str
    facts: Facts


def packed_reports(table: pl.DataFrame, source: str, facts: Facts) -> bytes:
    """Return the payload of a record of reports."""
    told: dict[str, Any] = {"source": source}
    if facts.places:
        told["places"] = {
            name: [place.latitude_deg, place.longitude_deg, place.altitude_m]
            for name, place in facts.places.items()
        }
    if facts.scan_periods:
        told["periods"] = facts.scan_periods
    return packed_table(table, told)


def arrived(payload: bytes) -> Arrived:
    """Return the reports of a record."""
    table, told = unpacked_table(payload)
    places = {name: Place(*where) for name, where in told.get("places", {}).items()}
    facts = Facts(places, dict(told.get("periods", {})))
    return Arrived(table, str(told["source"]), facts)


def as_json(value: Mapping[str, Any]) -> bytes:
    """Return the payload of a record of anything else; what is not finite becomes null."""
    return json.dumps(
        _finite(value), separators=(",", ":"), sort_keys=True, ensure_ascii=False, allow_nan=False
    ).encode()


def from_json(payload: bytes) -> dict[str, Any]:
    """Return what a record of anything else says."""
    try:
        value = json.loads(payload)
    except ValueError as err:
        raise DataFormatError(f"a record of the journal: no JSON ({err})") from err
    if not isinstance(value, dict):
        raise DataFormatError("a record of the journal: expected an object")
    return value


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
