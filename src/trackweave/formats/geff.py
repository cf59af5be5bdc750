"""GEFF: a graph of spots in a Zarr folder (Graph Exchange File Format, 1.0)."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from trackweave.errors import DataFormatError, InvalidInputError
from trackweave.formats.format import Facts, Format, Output
from trackweave.formats.track_rows import family_of, framed_rows, joined, parents

__all__ = ["FORMAT"]

_ROOT = "tracks.geff"
_SPATIAL = ("z", "y", "x")


def _write(output: Output) -> dict[str, bytes]:
    rows = framed_rows(output, "geff")
    ids = np.arange(len(rows), dtype=np.uint64)
    edges = joined(rows).astype(np.uint64)
    columns = {name: rows[name].cast(pl.Float64).to_numpy() for name in ("seconds", *_SPATIAL)}
    columns = {"t": columns.pop("seconds"), **columns}
    of, track = parents(rows), rows["track"].cast(pl.Int64).to_numpy()
    family = np.array([family_of(number, of) for number in track.tolist()], np.int64)
    numbers = {**columns, "track_id": track, "lineage_id": family}
    metadata = {
        "geff_version": "1.0.0",
        "directed": True,
        "axes": [_axis(name, values) for name, values in columns.items()],
        "node_props_metadata": {
            name: {"identifier": name, "dtype": str(values.dtype), "varlength": False}
            for name, values in numbers.items()
        },
        "edge_props_metadata": {},
        "track_node_props": {"tracklet": "track_id", "lineage": "lineage_id"},
    }
    files = _group("", {"geff": metadata})
    for folder in ("nodes", "nodes/props", "edges", "edges/props"):
        files |= _group(folder, {})
    files |= _array("nodes/ids", ids)
    files |= _array("edges/ids", edges.reshape(-1, 2))
    for name, values in numbers.items():
        files |= _group(f"nodes/props/{name}", {})
        files |= _array(f"nodes/props/{name}/values", values)
    return files


def _axis(name: str, values: np.ndarray) -> dict[str, Any]:
    told = {"name": name, "type": "time" if name == "t" else "space"}
    told |= {"unit": "second"} if name == "t" else {}
    if len(values) == 0:
        return told
    return {**told, "min": float(values.min()), "max": float(values.max())}


def _group(path: str, attributes: dict[str, Any]) -> dict[str, bytes]:
    folder = f"{_ROOT}/{path}".rstrip("/")
    return {
        f"{folder}/.zgroup": b'{"zarr_format": 2}',
        f"{folder}/.zattrs": json.dumps(attributes, indent=1).encode("utf-8"),
    }


def _array(path: str, values: np.ndarray) -> dict[str, bytes]:
    """Return an array of one chunk without compression, as Zarr 2 has it."""
    told = {
        "zarr_format": 2, "shape": list(values.shape), "order": "C", "filters": None,
        "chunks": [max(1, size) for size in values.shape], "compressor": None, "fill_value": 0,
        "dtype": values.dtype.newbyteorder("<").str,
    }  # fmt: skip
    chunk = ".".join(["0"] * values.ndim)
    files = {f"{_ROOT}/{path}/.zarray": json.dumps(told, indent=1).encode("utf-8")}
    if values.size:
        data = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
        files[f"{_ROOT}/{path}/{chunk}"] = data
    return files


def _read(folder: Path) -> tuple[pl.DataFrame, Facts]:
    try:
        import zarr
    except ImportError as err:
        raise InvalidInputError(
            "format geff: reading needs zarr; pip install 'trackweave[geff]'"
        ) from err
    try:
        root: Any = zarr.open_group(str(folder), mode="r")
        props = root["nodes/props"]
        axes = root.attrs["geff"]["axes"]
        time = next(axis["name"] for axis in axes if axis["type"] == "time")
        names = [axis["name"] for axis in axes if axis["type"] == "space"]
        columns = {"time": np.asarray(props[f"{time}/values"][:], np.float64)}
        # The last axis of an image runs to the right.
        for ours, theirs in zip("xyz", names[::-1], strict=False):
            columns[ours] = np.asarray(props[f"{theirs}/values"][:], np.float64)
        ids, edges = np.asarray(root["nodes/ids"][:]), np.asarray(root["edges/ids"][:])
        table = pl.DataFrame(columns).with_columns(target=_components(ids, edges))
    except Exception as err:  # Zarr's trouble with damaged stores has many names
        raise DataFormatError(f"{folder}: no graph of GEFF ({str(err)[:80]!r})") from err
    return table, Facts()


def _components(ids: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return for each node the number of the part of the graph that it is in."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    order = np.argsort(ids)
    ends = order[np.searchsorted(ids[order], edges.reshape(-1, 2))]
    size = (len(ids), len(ids))
    graph = coo_array((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=size)
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


def _recognise(head: bytes, name: str) -> bool:
    folder = Path(name)
    if head or not folder.is_dir():
        return False
    told = [folder / each for each in ("zarr.json", ".zattrs") if (folder / each).is_file()]
    return any(b'"geff"' in path.read_bytes()[:65_536] for path in told)


FORMAT = Format(
    name="geff",
    title="GEFF, a graph in a Zarr folder",
    endings=(".geff",),
    carries="positions, times; tracks as target; divisions are written",
    loses="other properties of nodes and edges, uncertainty; a division is one target",
    recognise=_recognise,
    folder=_read,
    writer=_write,
    extra="geff",
)
