"""TrackMate's XML: spots, and the tracks that join them (Fiji)."""

import xml.etree.ElementTree as ET

import polars as pl

from trackweave.errors import DataFormatError
from trackweave.formats.format import Format, Output
from trackweave.formats.json_stream import finite
from trackweave.formats.lines import Document
from trackweave.formats.track_rows import family_of, framed_rows, joined, parents

__all__ = ["FORMAT", "TrackmateDecoder"]

_RADIUS = 5.0
# Seconds from 1970 are more than any place is; beyond this is no time.
_LATEST = 1e12
_SCHEMA = {
    "time": pl.Float64, "x": pl.Float64, "y": pl.Float64, "z": pl.Float64, "strength": pl.Float64,
    "radius": pl.Float64, "frame": pl.Float64, "target": pl.String, "spot": pl.String,
}  # fmt: skip


class TrackmateDecoder(Document):
    """Turns spots into positions; the track of a spot becomes ``target``."""

    def _decoded(self, document: bytes) -> pl.DataFrame | None:
        try:
            root = ET.fromstring(document)
        except (ET.ParseError, ValueError, LookupError) as err:
            raise DataFormatError(f"no XML of TrackMate ({' '.join(str(err).split())})") from err
        tracks = {
            spot: each.get("TRACK_ID", "")
            for each in root.iter("Track")
            for edge in each.iter("Edge")
            for spot in (edge.get("SPOT_SOURCE_ID"), edge.get("SPOT_TARGET_ID"))
        }
        rows = []
        for number, spot in enumerate(root.iter("Spot")):
            place = [_attribute(spot, f"POSITION_{axis}") for axis in "XYZ"]
            frame = _attribute(spot, "FRAME")
            time = _attribute(spot, "POSITION_T", _LATEST)
            time = frame if time is None else time
            if place[0] is None or place[1] is None or time is None:
                self.skips.add(0, f"spot {number}: no position or time")
                continue
            extra = (_attribute(spot, "QUALITY"), _attribute(spot, "RADIUS"), frame)
            name = spot.get("ID")
            rows.append((time, *place, *extra, tracks.get(name), name))
        table = pl.DataFrame(rows, _SCHEMA, orient="row")
        if table["z"].null_count():
            table = table.drop("z")
        said = [column.name for column in table.get_columns() if column.null_count() < len(table)]
        return table.select(said) if len(table) else None


def _attribute(spot: ET.Element, name: str, most: float = 1e9) -> float | None:
    try:
        return finite(float(spot.get(name, "")), -most, most)
    except ValueError:
        return None


def _write(output: Output) -> dict[str, bytes]:
    rows = framed_rows(output, "trackmate").with_row_index("spot")
    frames = []
    for (frame,), part in rows.sort("frame", maintain_order=True).group_by(
        "frame", maintain_order=True
    ):
        spots = "".join(_spot(row) for row in part.iter_rows(named=True))
        frames.append(f'<SpotsInFrame frame="{frame}">\n{spots}</SpotsInFrame>\n')
    of, tracks, filtered = parents(rows), [], []
    # A track of TrackMate is a whole family: it branches where cells divide.
    edges_of: dict[int, str] = {family_of(track, of): "" for track in rows["track"].unique()}
    owner = rows["track"].to_list()
    for a, b in joined(rows).tolist():
        edge = f'<Edge SPOT_SOURCE_ID="{a}" SPOT_TARGET_ID="{b}" LINK_COST="-1.0"/>\n'
        edges_of[family_of(owner[b], of)] += edge
    for number, edges in sorted(edges_of.items()):
        name = f'"Track_{number}"'
        tracks.append(f'<Track name={name} TRACK_ID="{number}">\n{edges}</Track>\n')
        filtered.append(f'<TrackID TRACK_ID="{number}"/>\n')
    text = (
        '<?xml version="1.0" encoding="UTF-8"?>\n<TrackMate version="7.11.1">\n'
        '<Model spatialunits="pixel" timeunits="sec">\n'
        f'<AllSpots nspots="{len(rows)}">\n{"".join(frames)}</AllSpots>\n'
        f"<AllTracks>\n{''.join(tracks)}</AllTracks>\n"
        f"<FilteredTracks>\n{''.join(filtered)}</FilteredTracks>\n</Model>\n</TrackMate>\n"
    )
    return {"tracks.trackmate.xml": text.encode("utf-8")}


def _spot(row: dict[str, float]) -> str:
    place = "".join(f' POSITION_{axis.upper()}="{row[axis]:.6f}"' for axis in "xyz")
    return (
        f'<Spot ID="{row["spot"]}" name="ID{row["spot"]}" QUALITY="-1.0" VISIBILITY="1" '
        f'RADIUS="{_RADIUS}" FRAME="{row["frame"]}" POSITION_T="{row["seconds"]:.6f}"{place}/>\n'
    )


def _recognise(head: bytes, name: str) -> bool:
    return b"<TrackMate" in head[:4096]


FORMAT = Format(
    name="trackmate",
    title="TrackMate XML (Fiji)",
    endings=(".trackmate.xml", ".xml"),
    carries="positions, times, frames, quality, radius; tracks as target; divisions are written",
    loses="features, filters, settings and the image; uncertainty",
    recognise=_recognise,
    decoder=TrackmateDecoder,
    writer=_write,
)
