"""From times of a day to times."""

import numpy as np
import polars as pl
from numpy.typing import NDArray

from trackweave.formats.asterix.category import Part
from trackweave.io.columns import datetime_column

__all__ = ["DayClock", "ShortClock"]

_DAY_S = 86_400.0
_SHORT_S = 512.0
# The last second of a day may be a leap second.
_LATEST_S = _DAY_S + 1
_NO_TIME = pl.Series([None], dtype=pl.Datetime("us", "UTC"))
# A capture whose clock says an earlier time (1980) has none.
_EARLIEST_S = 315_532_800.0
_LATEST_CLOCK_S = 1e10

Times = NDArray[np.float64]


def _is_sane(clock: Times) -> NDArray[np.bool_]:
    """Return where a capture's clock [s] tells a time that may be."""
    return (clock > _EARLIEST_S) & (clock < _LATEST_CLOCK_S)


class DayClock:
    """Adds days to times of the day.

    Where a capture tells when packets came, a time lies within half a day of that, and has a date.
    Elsewhere each lies within half a day of the one before; seconds count from the midnight
    before the first.
    """

    def __init__(self) -> None:
        self._dated: bool | None = None
        self._clock = 0.0
        self._day = 0.0
        self._last: float | None = None

    def times(self, of_day: Times, clock: Times) -> pl.Series:
        """Return the column ``time`` for times of the day [s] as they came, null where none is."""
        sane = _is_sane(clock)
        if self._dated is None:
            self._dated, self._clock = bool(sane[0]), float(clock[0])
        there = (of_day >= 0) & (of_day <= _LATEST_S)
        moment = np.where(there, of_day, np.nan)
        if self._dated:
            # A clock that was damaged counts as that of the packet before.
            known = np.concatenate(([self._clock], clock[sane]))
            clock = known[np.cumsum(sane)]
            self._clock = float(clock[-1])
            moment += np.round((clock - of_day) / _DAY_S) * _DAY_S
            moment[~there] = 0.0
            return datetime_column("time", moment).zip_with(pl.Series(there), _NO_TIME)
        if there.any():
            told = of_day[there]
            last = told[0] if self._last is None else self._last
            days = self._day - np.cumsum(np.round(np.diff(told, prepend=last) / _DAY_S))
            moment[there] += days * _DAY_S
            self._day, self._last = float(days[-1]), float(told[-1])
        return pl.Series("time", moment, nan_to_null=True)

    def moment(self, of_day: float, clock: float) -> float | None:
        """Return a time of the day [s] as reports would have it; None before the first of them."""
        if self._dated:
            near = clock if _is_sane(np.asarray(clock)) else self._clock
            return of_day + round((near - of_day) / _DAY_S) * _DAY_S
        if self._last is None:
            return None
        return of_day + self._day - round((of_day - self._last) / _DAY_S) * _DAY_S


class ShortClock:
    """Completes times of category 001, of which only what is left over from 512 s is sent.

    They are nearest to the capture's clock. Elsewhere each is nearest to the one before or, behind
    a time that category 002 says, to that; a record without any has that of the one before.
    """

    def __init__(self) -> None:
        self._told: tuple[NDArray[np.int64], Times] = (np.empty(0, dtype=np.int64), np.empty(0))
        self._last = np.nan

    def tell(self, begin: NDArray[np.int64], of_day: Times) -> None:
        """Take the times of the day [s] that category 002 says, and where in the buffer."""
        there = ~np.isnan(of_day)
        self._told = begin[there], of_day[there]

    def complete(self, parts: list[Part]) -> None:
        """Replace the column ``time_within_512_s`` of parts by ``time``."""
        short = [part for part in parts if "time_within_512_s" in part.columns]
        left = [np.asarray(part.columns.pop("time_within_512_s"), dtype=float) for part in short]
        where, told = self._told
        self._told = where[:0], told[:0]
        if short:
            begin = np.concatenate([part.begin for part in short])
            clock = np.concatenate([part.clock for part in short])
            order = np.argsort(begin)
            time = np.empty(begin.size)
            time[order] = self._times(
                np.concatenate(left)[order],
                clock[order],
                (np.searchsorted(where, begin[order]), told),
            )
            for part in short:
                part.columns["time"], time = time[: part.begin.size], time[part.begin.size :]
        elif told.size:
            self._last = float(told[-1])

    def _times(self, short: Times, clock: Times, heard: tuple[NDArray[np.int64], Times]) -> Times:
        """Return times of the day [s]; ``heard``: how many were told before each, and which."""
        near = clock % _DAY_S
        apart = (short - near + _SHORT_S / 2) % _SHORT_S - _SHORT_S / 2
        times: Times = np.where(np.isnan(short), near, near + apart)
        before, told = heard
        blind = ~_is_sane(clock)
        for number in range(told.size + 1):
            if number:
                self._last = float(told[number - 1])
            rows = blind & (before == number)
            if rows.any():
                times[rows] = self._after(self._last, short[rows])
                self._last = float(times[rows][-1])
        return times % _DAY_S

    @staticmethod
    def _after(last: float, short: Times) -> Times:
        """Return times each nearest to the one before, the first to ``last`` if that is known."""
        there = ~np.isnan(np.concatenate(([last], short)))
        known = np.concatenate(([last], short))[there]
        times = np.concatenate(([np.nan], np.unwrap(known, period=_SHORT_S)))
        after: Times = times[np.cumsum(there)][1:]
        return after
