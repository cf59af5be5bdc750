"""Tracks as category 062 (edition 1.21)."""

import re
from collections.abc import Iterator, Mapping

import numpy as np
import polars as pl
from numpy.typing import NDArray

from trackweave.formats.asterix.values import FOOT_M, TIME_S
from trackweave.formats.format import Output
from trackweave.formats.track_rows import most_said

__all__ = ["FILE_NAME", "track_messages"]

FILE_NAME = "tracks.ast"

_CATEGORY = 62
# As much as a datagram takes on any network.
_LONGEST_BLOCK = 1400
_DAY_S = 86_400.0
_ADDRESS = re.compile(r"[0-9a-fA-F]{6}")
_MODE_A = re.compile(r"[0-7]{4}")
# Six bits of each character; what is none becomes a blank.
_CODES = {" ": 32, **{chr(64 + code): code for code in range(1, 27)}} | {
    str(digit): 48 + digit for digit in range(10)
}

Items = list[bytes]
"""What an item holds in each row, nothing where it is not there."""


def track_messages(output: Output) -> Mapping[str, bytes]:
    """Return tracks as data blocks of category 062, of at most 1,400 octets each.

    Parameters
    ----------
    output
        What was known after each scan; where reports told addresses, callsigns and Mode A codes,
        a track has those that most of its reports have.

    Returns
    -------
    The file by its name.
    """
    rows = output.tracks
    told = _told(output)
    items: dict[int, Items] = {
        1: [bytes(2)] * len(rows),
        4: _packed(rows, (("time", TIME_S, 3),)),
        5: _packed(rows, (("lat", 180 / 2**25, 4), ("lon", 180 / 2**25, 4))),
        6: _packed(rows, (("x", 0.5, 3), ("y", 0.5, 3))),
        7: _packed(rows, (("vx", 0.25, 2), ("vy", 0.25, 2))),
        8: _packed(rows, (("ax", 0.25, 1), ("ay", 0.25, 1))),
        9: [_mode_a(code) for code in told["mode_a"]],
        10: [_characters(name, b"\0") for name in told["callsign"]],
        11: [_address(identity) for identity in told["identity"]],
        12: [number.to_bytes(2, "big") for number in _numbers(rows["track"])],
        13: _statuses(rows),
        14: _ages(rows),
        18: _packed(rows, ((_height(rows), 6.25 * FOOT_M, 2),)),
        20: _packed(rows, (("vz", 6.25 * FOOT_M / 60, 2),)),
        27: _accuracies(rows),
    }
    blocks = _blocks(_records(items, len(rows)), rows["time"].to_list())
    return {FILE_NAME: b"".join(blocks)}


def _records(items: dict[int, Items], count: int) -> Iterator[bytes]:
    known: dict[tuple[int, ...], bytes] = {}
    for row in range(count):
        there = tuple(number for number, item in items.items() if item[row])
        if there not in known:
            known[there] = _specification(there)
        yield known[there] + b"".join(items[number][row] for number in there)


def _specification(there: tuple[int, ...]) -> bytes:
    """Return the octets that announce items by their numbers in the category's profile."""
    octets = bytearray((there[-1] + 6) // 7)
    for number in there:
        octets[(number - 1) // 7] |= 0x80 >> (number - 1) % 7
    for octet in range(len(octets) - 1):
        octets[octet] |= 1
    return bytes(octets)


def _blocks(records: Iterator[bytes], moments: list[object]) -> Iterator[bytes]:
    """Yield data blocks, each of one moment."""
    waiting, size, last = list[bytes](), 0, None
    for record, moment in zip(records, moments, strict=True):
        if waiting and (moment != last or size + len(record) > _LONGEST_BLOCK):
            yield _block(waiting)
            waiting, size = [], 0
        waiting.append(record)
        size, last = size + len(record), moment
    if waiting:
        yield _block(waiting)


def _block(records: list[bytes]) -> bytes:
    content = b"".join(records)
    return bytes([_CATEGORY]) + (len(content) + 3).to_bytes(2, "big") + content


def _values(rows: pl.DataFrame, name: str) -> NDArray[np.float64]:
    """Return a column's numbers, times as seconds of the day; NaN where there is none."""
    if name not in rows.columns:
        return np.full(len(rows), np.nan)
    column = rows[name]
    if isinstance(column.dtype, pl.Datetime):
        column = column.dt.epoch("us") / 1e6
    values = column.cast(pl.Float64).fill_null(np.nan).to_numpy()
    return values % _DAY_S if name == "time" else values


def _packed(rows: pl.DataFrame, fields: tuple[tuple[str, float, int], ...]) -> Items:
    """Return numbers of some columns, each with its unit and octets; all or nothing."""
    octets, there = list[NDArray[np.uint8]](), np.ones(len(rows), dtype=np.bool_)
    for name, unit, size in fields:
        number = np.rint(_values(rows, name) / unit)
        reach = 2.0 ** (8 * size - 1)
        # Times are never negative; all else has a sign.
        low, high = (0.0, 2 * reach) if name == "time" else (-reach, reach)
        right = (number >= low) & (number < high)
        there &= right
        octets.append(_octets(np.where(right, number, 0.0), size))
    return _listed(np.hstack(octets), there)


def _octets(numbers: NDArray[np.float64], size: int) -> NDArray[np.uint8]:
    whole = np.ascontiguousarray(numbers.astype(">i8"))
    return whole.view(np.uint8).reshape(-1, 8)[:, 8 - size :]


def _listed(octets: NDArray[np.uint8], there: NDArray[np.bool_]) -> Items:
    content, size = octets.tobytes(), octets.shape[1]
    return [
        content[row * size : (row + 1) * size] if is_there else b""
        for row, is_there in enumerate(there.tolist())
    ]


def _height(rows: pl.DataFrame) -> str:
    return "alt_m" if "alt_m" in rows.columns else "z"


def _numbers(names: pl.Series) -> list[int]:
    """Return numbers of 16 bits for tracks: their own where they are such, else in order."""
    own = names.cast(pl.Int64, strict=False)
    if own.null_count() == 0 and own.is_between(0, 0xFFFF).all():
        return own.to_list()
    found: dict[object, int] = {}
    return [found.setdefault(name, len(found) + 1) & 0xFFFF for name in names.to_list()]


def _statuses(rows: pl.DataFrame) -> Items:
    """Return whether each track is tentative or coasts, and whether it begins."""
    begins = rows["track"].is_first_distinct().to_list()
    status = rows["status"].to_list() if "status" in rows.columns else [""] * len(rows)
    statuses = list[bytes]()
    for state, is_first in zip(status, begins, strict=True):
        octets = [2 * (state == "tentative"), 32 * is_first]
        if state == "coasting":
            octets += [0, 128]
        chained = [octet | 1 for octet in octets[:-1]]
        statuses.append(bytes([*chained, octets[-1]]))
    return statuses


def _ages(rows: pl.DataFrame) -> Items:
    """Return how long each track has been there, up to 63.75 s."""
    since = rows["time"] - rows.select(pl.col("time").min().over("track")).to_series()
    if isinstance(since.dtype, pl.Duration):
        since = since.dt.total_microseconds() / 1e6
    quarters = np.minimum(since.cast(pl.Float64).to_numpy() * 4, 255).astype(np.uint8)
    return [bytes((0x80, quarter)) for quarter in quarters.tolist()]


def _accuracies(rows: pl.DataFrame) -> Items:
    """Return standard deviations of position and velocity, and what x and y have in common."""
    squares = {
        name: _values(rows, f"p_{name}") for name in ("x_x", "y_y", "x_y", "vx_vx", "vy_vy", "z_z")
    }
    with np.errstate(invalid="ignore"):
        deviation = {name: np.sqrt(np.abs(square)) for name, square in squares.items()}
    there = ~np.isnan(sum(squares[name] for name in ("x_x", "y_y", "x_y", "vx_vx", "vy_vy")))
    parts = [
        _limited(deviation["x_x"] / 0.5, 2),
        _limited(deviation["y_y"] / 0.5, 2),
        _limited(np.sign(squares["x_y"]) * deviation["x_y"] / 0.5, 2, signed=True),
    ]
    announced = 0xC4
    if not np.isnan(squares["z_z"]).any() and len(rows):
        announced |= 0x10
        parts.append(_limited(deviation["z_z"] / (6.25 * FOOT_M), 1))
    parts += [_limited(deviation[name] / 0.25, 1) for name in ("vx_vx", "vy_vy")]
    head = np.full((len(rows), 1), announced, dtype=np.uint8)
    return _listed(np.hstack([head, *parts]), there)


def _limited(
    numbers: NDArray[np.float64], size: int, *, signed: bool = False
) -> NDArray[np.uint8]:
    """Return numbers of which the largest that can be said stands for all that are larger."""
    most = 2.0 ** (8 * size - signed) - 1
    return _octets(np.nan_to_num(np.clip(np.rint(numbers), -most * signed, most)), size)


def _told(output: Output) -> dict[str, list[str | None]]:
    """Return what most of each track's reports say of whom they are, row for row of the tracks."""
    tracks, found = output.tracks["track"].cast(pl.String).to_list(), {}
    for name in ("identity", "callsign", "mode_a"):
        names = most_said(output, name)
        found[name] = [names.get(track) for track in tracks]
    return found


def _mode_a(code: str | None) -> bytes:
    return int(code, 8).to_bytes(2, "big") if code and _MODE_A.fullmatch(code) else b""


def _characters(name: str | None, before: bytes) -> bytes:
    if not name:
        return b""
    number = 0
    for character in name.upper()[:8].ljust(8):
        number = number << 6 | _CODES.get(character, 32)
    return before + number.to_bytes(6, "big")


def _address(identity: str | None) -> bytes:
    return b"\x80" + bytes.fromhex(identity) if identity and _ADDRESS.fullmatch(identity) else b""
