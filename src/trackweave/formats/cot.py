"""Cursor on Target 2.0: an event for each state of a track, one a line, as ATAK and others take.

``ce`` and ``le`` are standard deviations [m], ``hae`` is the height over the ellipsoid; 9999999
stands for what is not known, as the standard says.
"""

import re
from collections.abc import Mapping, Set

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.formats.format import Format, Output
from trackweave.formats.track_rows import (
    EarthTrack,
    earth_tracks,
    moments,
    most_said,
    tracks_that_say,
)  # fmt: skip

__all__ = ["FORMAT"]

_UNKNOWN = 9_999_999.0
_STALE_S = 60.0
# Whose they are is unknown; with a height, their own or most of their reports', they are in the
# air: on the ground aircraft tell none.
_GROUND, _AIR, _SEA = "a-u-G", "a-u-A", "a-u-S"
# Maritime identities (ITU-R M.585): of ships, and of aircraft in search and rescue.
_SHIP, _RESCUE = re.compile("[2-7][0-9]{8}"), re.compile("111[2-7][0-9]{5}")


def _write(output: Output) -> dict[str, bytes]:
    identity, aloft = most_said(output, "identity"), tracks_that_say(output, "height_m")
    events = [
        event
        for each in earth_tracks(output, "cot")
        for event in _events(each, _kind(identity, aloft, each))
    ]
    # In the order in which they would have been sent.
    lines = [line for _, _, line in sorted(events)]
    return {"tracks.cot": "".join(f"{line}\n" for line in lines).encode("utf-8")}


def _kind(identity: Mapping[str, str], aloft: Set[str], track: EarthTrack) -> str:
    """Return what an object is where its states tell no height."""
    name = identity.get(str(track.track)) or track.name
    if str(track.track) in aloft or _RESCUE.fullmatch(name):
        return _AIR
    return _SEA if _SHIP.fullmatch(name) else _GROUND


def _events(track: EarthTrack, otherwise: str) -> list[tuple[float, int, str]]:
    stale, _ = moments(pl.Series(track.seconds + _STALE_S))
    height, sigma, up = (
        _known(values, len(stale)) for values in (track.altitude, track.sigma, track.sigma_up)
    )
    # Imports half of what the web is made of: whoever writes no such file need not wait.
    from xml.sax.saxutils import quoteattr

    uid, callsign = quoteattr(f"trackweave-{track.track}"), quoteattr(track.name)
    found = []
    for k, time in enumerate(track.time):
        kind = otherwise if height[k] == _UNKNOWN else _AIR
        detail = f"<contact callsign={callsign}/>"
        if track.speed is not None and track.course is not None and np.isfinite(track.speed[k]):
            detail += f'<track course="{track.course[k]:.2f}" speed="{track.speed[k]:.3f}"/>'
        found.append(
            (
                float(track.seconds[k]),
                track.track,
                f'<event version="2.0" uid={uid} type="{kind}" how="m-f" time="{time}" '
                f'start="{time}" stale="{stale[k]}"><point lat="{track.latitude[k]:.8f}" '
                f'lon="{track.longitude[k]:.8f}" hae="{height[k]:.3f}" ce="{sigma[k]:.3f}" '
                f'le="{up[k]:.3f}"/><detail>{detail}</detail></event>',
            )
        )
    return found


def _known(values: FloatArray | None, count: int) -> FloatArray:
    if values is None:
        return np.full(count, _UNKNOWN)
    return np.where(np.isfinite(values), values, _UNKNOWN)


FORMAT = Format(
    name="cot",
    title="Cursor on Target 2.0 (ATAK)",
    endings=(".cot",),
    carries="positions in WGS-84, heights over the ellipsoid, times, speed, course, uncertainty",
    loses="full covariances, tentative rows, affiliation (all are unknown)",
    writer=_write,
)
