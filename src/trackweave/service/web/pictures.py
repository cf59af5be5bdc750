"""``GET /tracks`` in any format that can be written, and ``GET /tracks/ID``."""

import asyncio
import io
import json
import zipfile
from collections.abc import Mapping

import polars as pl
from starlette.requests import Request
from starlette.responses import Response

from trackweave.errors import InvalidInputError
from trackweave.formats.format import Format, Output
from trackweave.formats.registry import format_named
from trackweave.service.desk import Desk, Json, Picture
from trackweave.service.messages import track_messages
from trackweave.service.web.answers import DATA_HEADERS, answer, refusal

__all__ = ["Pictures", "plane_geojson"]

_TYPES = {
    ".geojson": "application/geo+json",
    ".kml": "application/vnd.google-earth.kml+xml",
    ".czml": "application/json",
    ".json": "application/json",
    ".jsonl": "application/x-ndjson",
    ".csv": "text/csv; charset=utf-8",
    ".parquet": "application/vnd.apache.parquet",
    ".xml": "application/xml",
    # An event a line is no document of XML.
    ".cot": "text/plain; charset=utf-8",
    ".txt": "text/plain; charset=utf-8",
}
_LONGEST = 64
_PLANE = {
    "type": "name",
    "properties": {
        "name": 'ENGCRS["plane",EDATUM["plane"],CS[Cartesian,2],AXIS["x",east],AXIS["y",north],'
        'LENGTHUNIT["metre",1]]'
    },
}
_NONE = pl.DataFrame(
    schema={"time": pl.Float64, "track": pl.Int64, "status": pl.String}
    | dict.fromkeys(("x", "y", "vx", "vy", "lat", "lon"), pl.Float64)
)


class Pictures:
    """Shows tracks.

    Parameters
    ----------
    desk
        Who knows them.
    """

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        # Writing holds a core; more than one at once would make all wait.
        self._one_at_a_time = asyncio.Semaphore(1)

    async def tracks(self, request: Request) -> Response:
        """Answer ``GET /tracks``."""
        name = request.query_params.get("format", "geojson")
        try:
            chosen = _writable(name)
            async with self._one_at_a_time:
                files = await asyncio.to_thread(_files, self._desk.picture(), chosen)
        except InvalidInputError as err:
            return refusal(400, str(err))
        if len(files) == 1:
            [(file, data)] = files.items()
            kind = _TYPES.get(f".{file.rpartition('.')[2]}", "application/octet-stream")
        else:
            file, data, kind = f"{name}.zip", _packed(files), "application/zip"
        shown = f'inline; filename="{file.rpartition("/")[2]}"'
        headers = {**DATA_HEADERS, "content-disposition": shown, "content-type": kind}
        return Response(data, headers=headers)

    async def track(self, request: Request) -> Response:
        """Answer ``GET /tracks/ID``."""
        identifier: str = request.path_params["identifier"]
        found = self._desk.track(identifier) if len(identifier) <= _LONGEST else None
        return refusal(404, "no live track of that name") if found is None else answer(found)


def plane_geojson(picture: Picture) -> Json:
    """Return tracks whose places on the Earth are not known as GeoJSON of a plane.

    Coordinates are metres east and north. ``crs`` says so, as GeoJSON did before RFC 7946: without
    it readers take them for longitudes and latitudes, and GDAL does so even where it is null.

    Parameters
    ----------
    picture
        The tracks.

    Returns
    -------
    A collection of points, whose properties are what a listener of the stream is told.
    """
    features = []
    for track in track_messages(picture.tracks):
        place = [track.pop(axis, None) for axis in ("x", "y", "z")]
        at = [each for each in place if each is not None]
        features.append(
            {
                "type": "Feature",
                "id": track["track"],
                "geometry": {"type": "Point", "coordinates": at} if len(at) > 1 else None,
                "properties": track,
            }
        )
    return {"type": "FeatureCollection", "crs": _PLANE, "features": features}


def _writable(name: str) -> Format:
    found = format_named(name, writes=True)
    if found.extra is not None:
        # Images of whatever size positions ask for.
        raise InvalidInputError(f"format {name}: expected one that is no folder of images")
    return found


def _files(picture: Picture, chosen: Format) -> Mapping[str, bytes]:
    # Before the first picture nobody knows whether tracks will have places on the Earth.
    is_none_yet = picture.time is None or picture.tracks.width == 0
    tracks = _NONE if is_none_yet else picture.tracks
    if chosen.name == "geojson" and not {"lat", "lon"} <= set(tracks.columns):
        text = json.dumps(plane_geojson(picture), ensure_ascii=False, separators=(",", ":"))
        return {"tracks.geojson": text.encode("utf-8", "replace")}
    # Lists, such as a track's sensors, are no column of a file.
    lists = [n for n, kind in tracks.schema.items() if isinstance(kind, pl.List | pl.Struct)]
    assert chosen.writer is not None
    return chosen.writer(Output(tracks.drop(lists), None, None, picture.frame))


def _packed(files: Mapping[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(zipfile.ZipInfo(name), data)
    return packed.getvalue()
