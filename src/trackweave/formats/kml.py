"""KML 2.2 with Google's ``gx:Track``: positions with times, as Google Earth plays them.

KML's altitudes count from the sea level of EGM96, ours from the ellipsoid: they differ by up to
100 m, and no model of the sea level is applied.
"""

from html import escape

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.formats.format import Format, Output
from trackweave.formats.track_rows import EarthTrack, earth_tracks

__all__ = ["FORMAT"]

_HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">
<Document>
<name>trackweave</name>
<description>Altitudes count from the WGS-84 ellipsoid, not from the sea level as KML has it: up to 100 m apart.</description>
<Style id="track"><IconStyle><scale>0.5</scale></IconStyle><LineStyle><width>2</width></LineStyle></Style>
<Schema id="states">
<gx:SimpleArrayField name="speed_mps" type="float"><displayName>Speed [m/s]</displayName></gx:SimpleArrayField>
<gx:SimpleArrayField name="sigma_m" type="float"><displayName>Uncertainty [m]</displayName></gx:SimpleArrayField>
</Schema>
"""  # noqa: E501


def _write(output: Output) -> dict[str, bytes]:
    placemarks = "".join(_placemark(each) for each in earth_tracks(output, "kml"))
    return {"tracks.kml": f"{_HEAD}{placemarks}</Document>\n</kml>\n".encode()}


def _placemark(track: EarthTrack) -> str:
    solid = track.altitude is not None
    altitude = np.zeros(len(track.time)) if track.altitude is None else track.altitude
    places = zip(track.longitude, track.latitude, altitude, strict=True)
    whens = "".join(f"<when>{time}</when>\n" for time in track.time)
    coords = "".join(f"<gx:coord>{x:.8f} {y:.8f} {z:.3f}</gx:coord>\n" for x, y, z in places)
    arrays = _array("speed_mps", track.speed) + _array("sigma_m", track.sigma)
    data = (
        f'<ExtendedData><SchemaData schemaUrl="#states">\n{arrays}</SchemaData></ExtendedData>\n'
    )
    return (
        f'<Placemark id="track-{track.track}">\n<name>{escape(track.name, quote=False)}</name>\n'
        "<styleUrl>#track</styleUrl>\n<gx:Track>\n"
        f"<altitudeMode>{'absolute' if solid else 'clampToGround'}</altitudeMode>\n"
        f"{whens}{coords}{data if arrays else ''}</gx:Track>\n</Placemark>\n"
    )


def _array(name: str, values: FloatArray | None) -> str:
    if values is None or not np.isfinite(values).all():
        return ""
    cells = "".join(f"<gx:value>{value:.3f}</gx:value>" for value in values)
    return f'<gx:SimpleArrayData name="{name}">{cells}</gx:SimpleArrayData>\n'


FORMAT = Format(
    name="kml",
    title="KML 2.2 with time (Google Earth)",
    endings=(".kml",),
    carries="positions in WGS-84, times, speed, uncertainty along the worst axis",
    loses="the height of the sea level over the ellipsoid, full covariances, tentative rows",
    writer=_write,
)
