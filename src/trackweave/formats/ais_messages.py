"""AIS messages that hold a position: six bits a character, decoded many at once."""

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray, IntArray

__all__ = ["PAYLOAD", "positions_in"]

PAYLOAD = 28
"""Characters of a payload that hold what is read here."""
_KNOT = 1852.0 / 3600.0
# Of each type of message: where longitude, latitude, speed, course and heading begin, and how many
# bits they have; then parts of a degree, of a knot and of a degree of course.
_CLASS_A = ((61, 28), (89, 27), (50, 10), (116, 12), (128, 9), 600_000.0, 10.0, 10.0)
_CLASS_B = ((57, 28), (85, 27), (46, 10), (112, 12), (124, 9), 600_000.0, 10.0, 10.0)
_AIRCRAFT = ((61, 28), (89, 27), (50, 10), (116, 12), None, 600_000.0, 1.0, 10.0)
_LONG_RANGE = ((44, 18), (62, 17), (79, 6), (85, 9), None, 600.0, 1.0, 1.0)
_LAYOUTS = {
    1: _CLASS_A, 2: _CLASS_A, 3: _CLASS_A, 9: _AIRCRAFT, 18: _CLASS_B, 19: _CLASS_B,
    27: _LONG_RANGE,
}  # fmt: skip
# As far as each is read, and any message that says whose it is.
_FEWEST_BITS = {**dict.fromkeys(_LAYOUTS, 137), 27: 94}
_NAMED_BITS = 38
_NO_LATITUDE, _NO_LONGITUDE = 91.0, 181.0


def positions_in(payload: pl.Series, fill: IntArray) -> tuple[pl.DataFrame, IntArray, IntArray]:
    """Return the positions that messages tell.

    Parameters
    ----------
    payload
        Characters of each message.
    fill
        How many bits at its end do not count.

    Returns
    -------
    A table with ``lat`` and ``lon`` [degrees] (91 and 181 where the ship does not know),
    ``identity``, ``speed_mps``, ``course_deg``, ``heading_deg`` and ``message``; the message of
    each row; and the messages that end too early.
    """
    kind = np.zeros(len(payload), np.int64)
    texts = payload.str.slice(0, PAYLOAD).str.pad_end(PAYLOAD, "0")
    if len(payload) == 0:
        return pl.DataFrame(), kind, kind
    every = np.array(texts.to_list(), dtype=f"S{PAYLOAD}").view(np.uint8)
    codes: IntArray = every.reshape(-1, PAYLOAD).astype(np.int64)
    kind[:] = _six_bits(codes[:, 0])
    length = 6 * payload.str.len_bytes().to_numpy().astype(np.int64) - fill
    is_short = length < np.array([_FEWEST_BITS.get(k, _NAMED_BITS) for k in range(64)])[kind]
    is_wanted = np.isin(kind, list(_LAYOUTS))
    some, short = np.flatnonzero(is_wanted & ~is_short), np.flatnonzero(is_short)
    each = (_six_bits(codes[some])[:, :, np.newaxis] >> np.arange(5, -1, -1)) & 1
    bits: FloatArray = each.reshape(len(some), 6 * PAYLOAD).astype(np.float64)
    values = np.full((len(some), 5), np.nan)
    for number, layout in _LAYOUTS.items():
        rows = np.flatnonzero(kind[some] == number)
        if rows.size:
            values[rows] = _read(bits[rows], layout)
    mmsi = _field(bits, (8, 30)).astype(np.int64)
    names = ("lon", "lat", "speed_mps", "course_deg", "heading_deg")
    table = pl.DataFrame(
        {
            "lat": values[:, 1],
            "lon": values[:, 0],
            "identity": pl.Series(mmsi).cast(pl.String).str.zfill(9),
            **{
                name: pl.Series(values[:, place], nan_to_null=True)
                for place, name in enumerate(names[2:], start=2)
            },
            "message": kind[some],
        }
    )
    return table, some, short


def _six_bits(codes: IntArray) -> IntArray:
    """Return the six bits of each character: 0 to W are 0 to 39, ` to w are 40 to 63."""
    return np.asarray(codes - np.where(codes >= ord("`"), 56, 48)) & 63


def _field(bits: FloatArray, where: tuple[int, int], *, signed: bool = False) -> FloatArray:
    begin, size = where
    weights = 2.0 ** np.arange(size - 1, -1, -1)
    if signed:
        weights[0] = -weights[0]
    number: FloatArray = bits[:, begin : begin + size] @ weights
    return number


def _read(bits: FloatArray, layout: tuple) -> FloatArray:  # type: ignore[type-arg]
    """Return longitude, latitude, speed [m/s], course and heading, NaN where not available."""
    east, north, speed, course, heading, per_degree, per_knot, per_course = layout
    longitude = _field(bits, east, signed=True) / per_degree
    latitude = _field(bits, north, signed=True) / per_degree
    unknown = (np.abs(longitude) > 180.0) | (np.abs(latitude) > 90.0)
    knots, angle = _field(bits, speed), _field(bits, course) / per_course
    slow = knots < 2 ** speed[1] - 1
    ahead = np.full(len(bits), np.nan) if heading is None else _field(bits, heading)
    return np.stack(
        [
            np.where(unknown, _NO_LONGITUDE, longitude),
            np.where(unknown, _NO_LATITUDE, latitude),
            np.where(slow, knots / per_knot * _KNOT, np.nan),
            np.where(angle < 360.0, angle, np.nan),
            np.where(ahead < 360.0, ahead, np.nan),
        ],
        axis=-1,
    )
