"""The record of a fusion, as in run.json."""

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from trackweave.fusion.registration import Registration
from trackweave.io.tracks_in import LocalTracks
from trackweave.run.fusion_log import FusionLog
from trackweave.run.record import certainty_of, timing_of

if TYPE_CHECKING:
    from trackweave.run.fusing import FusionValues

__all__ = ["fusion_record"]


def fusion_record(
    tables: Mapping[str, LocalTracks],
    values: "FusionValues",
    log: FusionLog,
    notes: Sequence[str],
) -> dict[str, Any]:
    """Return the record of a fusion, for JSON, but for the seed."""
    # Only ``timing`` differs from run to run with the same seed.
    frame = values.frame
    return {
        "trackweave": version("trackweave"),
        "seed": None,
        "configuration": values.settings.values,
        "sources": values.settings.sources,
        "notes": list(notes),
        "input": {
            "sensors": {name: _told(table) for name, table in tables.items()},
            "dimensions": values.tracks.dim,
            "frame_origin": None if frame is None else [frame.latitude_deg, frame.longitude_deg],
        },
        "registrations": {
            name: _registered(found) for name, found in values.registrations.items()
        },
        "totals": _totals(tables, values, log),
        "scans": log.scans,
        "changes": log.changes,
        "timing": timing_of(log.timing),
    }


def _told(table: LocalTracks) -> dict[str, Any]:
    time = table.tracks.time
    return {
        "table": table.name,
        "rows": len(table),
        "left_out": table.n_left_out,
        "tracks": int(np.unique(table.tracks.track).size),
        "first_time": float(time[0]) if time.size else None,
        "last_time": float(time[-1]) if time.size else None,
    }


def _registered(found: Registration) -> dict[str, Any]:
    return {
        "reference": found.reference,
        "estimated": list(found.model.estimate),
        "position": list(found.model.position),
        "bias": dict(zip(found.names, found.bias.tolist(), strict=True)),
        "sigma": dict(zip(found.names, found.sigma.tolist(), strict=True)),
        "pairs": found.pairs.tolist(),
        "scale": found.scale,
    }


def _totals(
    tables: Mapping[str, LocalTracks], values: "FusionValues", log: FusionLog
) -> dict[str, Any]:
    kinds = [change["kind"] for change in log.changes]
    return {
        "sensors": len(tables),
        "local_tracks": sum(np.unique(table.tracks.track).size for table in tables.values()),
        "objects": int(np.unique(values.tracks.track).size),
        "common_objects": len(log.pairings.common),
        "updates": len(log.scans),
        "merged": kinds.count("merged"),
        "split": kinds.count("split"),
        "left_out_rows": sum(table.n_left_out for table in tables.values()),
        **certainty_of(log.scans, "updates"),
    }
