"""What was posted becomes reports: in whatever format it says, or is."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from trackweave.arrays import IntArray
from trackweave.domain.facts import Facts, Skips
from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.formats.format import HEAD_BYTES, Format
from trackweave.formats.reading import chosen
from trackweave.formats.registry import formats, recognised
from trackweave.io.columns import typed_column
from trackweave.io.tables import RawTable, table_in, with_our_names, within_calendars
from trackweave.plugin_faults import told_as_theirs
from trackweave.service.desk import Rejected

__all__ = ["MOST_REJECTED", "Decoded", "decoded", "told_by"]

MOST_REJECTED = 1000
"""As many rejected reports are listed; all are counted."""
# What senders call formats that are found by their content as well.
_TYPES = {
    "application/json": "jsonl",
    "application/jsonl": "jsonl",
    "application/x-ndjson": "jsonl",
    "application/x-jsonlines": "jsonl",
    "text/csv": "csv",
    "application/vnd.apache.parquet": "parquet",
    "application/x-parquet": "parquet",
}


@dataclass(frozen=True, slots=True, eq=False)
class Decoded:
    """What a body holds.

    Parameters
    ----------
    table
        Its reports, shape (rows, columns).
    row
        Number of each in the body, from 1.
    facts
        What it tells beside them.
    rejected
        What could not be decoded: the first of it.
    rejected_count
        All of it.
    """

    table: pl.DataFrame
    row: IntArray
    facts: Facts
    rejected: tuple[Rejected, ...]
    rejected_count: int


def told_by(content_type: str, query: list[tuple[str, str]]) -> str | None:
    """Return the format that a request names, as ``--from`` takes it; None where it names none.

    Parameters
    ----------
    content_type
        The header, which counts where the query says nothing. One that tells nothing of reports,
        as what ``curl -d`` sends of itself, is as good as none.
    query
        Names and values of the query: ``format``, and what its reader may be told.

    Returns
    -------
    Such as "asterix" or "mot?frame_rate=30".

    Raises
    ------
    InvalidInputError
        If options come without a format, or the format cannot be read.
    """
    told = dict(query)
    name = told.pop("format", None)
    if name is None:
        if told:
            raise InvalidInputError(f"{next(iter(told))!r:.60}: expected format= with it")
        return _TYPES.get(content_type.partition(";")[0].strip().lower())
    from urllib.parse import urlencode

    whole = f"{name}?{urlencode(told)}" if told else name
    chosen(whole)
    return whole


def decoded(data: bytes, told: str | None) -> Decoded:
    """Return the reports of a body.

    Parameters
    ----------
    data
        The body.
    told
        Its format and what the reader is told; None to find it by the content.

    Returns
    -------
    Reports, and what could not be decoded.

    Raises
    ------
    InvalidInputError
        If there is no such format; a DataFormatError if it is of none that is known, or no
        document of that format as a whole.
    """
    if not data.strip():
        return Decoded(pl.DataFrame(), np.empty(0, np.int64), Facts(), (), 0)
    found, settings = _format_of(data, told)
    if found.is_table:
        raw = table_in(data, "body", found.endings[0])
    elif found.decoder is not None:
        raw = _streamed(found, settings, data)
    else:
        raise InvalidInputError(f"format {found.name}: a directory; expected what one body holds")
    raw = within_calendars(with_our_names(raw), may_be_empty=True)
    columns = raw.columns
    if raw.is_text:
        columns = pl.DataFrame([typed_column(each) for each in columns.get_columns()])
    rejected, count = _rejected(raw, data if found.name == "jsonl" else None)
    return Decoded(columns, raw.row, raw.facts, rejected, count)


def _format_of(data: bytes, told: str | None) -> tuple[Format, dict[str, Any]]:
    if told is not None:
        return chosen(told)
    found = recognised(data[:HEAD_BYTES], "body")
    if found is None and data.lstrip()[:1] in (b"{", b"["):
        found = formats()["jsonl"]
    if found is None or not found.can_read:
        known = ", ".join(each.name for each in formats().values() if each.can_read)
        raise InvalidInputError(
            f"body: of no format that is known by its content; expected one of {known}; ?format= "
            "says which"
        )
    return found, {}


def _streamed(found: Format, settings: dict[str, Any], data: bytes) -> RawTable:
    assert found.decoder is not None
    decoder = found.decoder(**settings)
    is_list = found.name == "jsonl" and data.lstrip()[:1] == b"["
    # A list of objects is as good as objects one after the other; offsets stay.
    body = data.replace(b"[", b" ", 1).rstrip().removesuffix(b"]") if is_list else data
    try:
        frames = [frame for frame in (decoder.feed(body), decoder.finish()) if frame is not None]
    except DataFormatError:
        raise
    except Exception:
        with told_as_theirs(decoder, "readers", "decoder", found.name):
            raise
    columns = pl.concat(frames, how="diagonal_relaxed") if frames else pl.DataFrame()
    row = _numbers(body, decoder.skips, len(columns)) if found.name == "jsonl" else None
    if row is None:
        row = np.arange(1, len(columns) + 1)
    return RawTable("body", columns, row, facts=decoder.facts, undecoded=decoder.skips)


def _numbers(data: bytes, skips: Skips, n_reports: int) -> IntArray | None:
    """Return the lines of reports, None where lines and reports do not go together."""
    lines = np.array([bool(line.strip()) for line in data.split(b"\n")])
    bad = {_line(data, each.offset) - 1 for each in skips.listed}
    lines[sorted(bad)] = False
    if len(bad) != skips.count or int(lines.sum()) != n_reports:
        return None
    return np.asarray(np.flatnonzero(lines) + 1, dtype=np.int64)


def _line(data: bytes, offset: int) -> int:
    return data.count(b"\n", 0, offset) + 1


def _rejected(raw: RawTable, lines: bytes | None) -> tuple[tuple[Rejected, ...], int]:
    """Return what could not be decoded, by the number of its line where it has one."""
    found = [Rejected(bad.row, raw.message_of(bad)) for bad in raw.skipped]
    for each in raw.undecoded.listed:
        row = None if lines is None else _line(lines, each.offset)
        found.append(Rejected(row, f"byte {each.offset}: {each.what}"))
    return tuple(found[:MOST_REJECTED]), len(raw.skipped) + raw.undecoded.count
