"""CZML: tracks as Cesium plays them; heights are over the ellipsoid, as there."""

import json
from typing import Any

import numpy as np
import polars as pl

from trackweave.formats.format import Format, Output
from trackweave.formats.track_rows import EarthTrack, earth_tracks, moments

__all__ = ["FORMAT"]

_PLAYED_S = 60.0  # as long as the whole takes to play
_COLOURS = ((31, 119, 180), (255, 127, 14), (44, 160, 44), (214, 39, 40), (148, 103, 189))


def _write(output: Output) -> dict[str, bytes]:
    tracks = list(earth_tracks(output, "czml"))
    document: dict[str, Any] = {"id": "document", "name": "trackweave", "version": "1.0"}
    if tracks:
        begin = min(float(each.seconds[0]) for each in tracks)
        end = max(float(each.seconds[-1]) for each in tracks)
        (first, last), _ = moments(pl.Series([begin, end]))
        document["clock"] = {
            "interval": f"{first}/{last}",
            "currentTime": first,
            "multiplier": max(1.0, round((end - begin) / _PLAYED_S, 3)),
            "range": "LOOP_STOP",
        }
    packets = [document, *(_packet(each) for each in tracks)]
    text = json.dumps(packets, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return {"tracks.czml": text.encode("utf-8")}


def _packet(track: EarthTrack) -> dict[str, Any]:
    after = track.seconds - track.seconds[0]
    height = np.zeros(len(after)) if track.altitude is None else track.altitude
    places = np.stack([after, track.longitude, track.latitude, height], axis=-1)
    colour = [*_COLOURS[track.track % len(_COLOURS)], 255]
    ground = (
        {}
        if track.altitude is not None
        else {"heightReference": {"heightReference": "CLAMP_TO_GROUND"}}
    )
    packet: dict[str, Any] = {
        "id": f"track-{track.track}",
        "name": track.name,
        "availability": f"{track.time[0]}/{track.time[-1]}",
        "position": {
            "epoch": track.time[0],
            "cartographicDegrees": np.round(places, 8).ravel().tolist(),
            "interpolationAlgorithm": "LINEAR",
        },
        "point": {"pixelSize": 7, "color": {"rgba": colour}, **ground},
        "path": {
            "width": 2,
            "material": {"solidColor": {"color": {"rgba": colour}}},
            "leadTime": 0,
        },
    }
    numbers = {"speed_mps": track.speed, "sigma_m": track.sigma}
    told = {
        name: {
            "epoch": track.time[0],
            "number": np.round(np.stack([after, values], axis=-1), 3).ravel().tolist(),
        }
        for name, values in numbers.items()
        if values is not None and np.isfinite(values).all()
    }
    if told:
        packet["properties"] = told
    return packet


FORMAT = Format(
    name="czml",
    title="CZML (Cesium)",
    endings=(".czml",),
    carries="positions in WGS-84, heights over the ellipsoid, times, speed, uncertainty along the "
    "worst axis",
    loses="full covariances, tentative rows",
    writer=_write,
)
