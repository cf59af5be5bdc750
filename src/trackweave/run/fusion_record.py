"""What a fusion takes and leaves behind, update by update, and its record, as in run.json."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.domain.tracks import TrackTable
from trackweave.filters.kalman import predicted
from trackweave.fusion.fuser import FusedPicture
from trackweave.fusion.pairings import Pairings
from trackweave.fusion.pictures import LocalPicture
from trackweave.fusion.registration import Registration
from trackweave.io.tracks_in import LocalTracks
from trackweave.run.record import certainty_of, timing_of

__all__ = ["FusionLog", "fusion_record", "local_pictures"]

PATIENCE = 3.0
"""How many usual times between rows of a track it may have none and still be the same."""


def local_pictures(name: str, tracks: TrackTable, process_noise: float) -> list[LocalPicture]:
    """Return what a sensor said at each of its times, from its rows sorted by time."""
    # A track that has no row at a time, but one before and one after not long apart, was there all
    # the same: it is predicted from the row before. The process noise is the power spectral
    # density of the acceleration along each axis [m²/s³].
    times, moment = np.unique(tracks.time, return_inverse=True)
    source, place = _gaps(tracks, moment.reshape(-1))
    mean, covariance = predicted(
        tracks.mean[source], tracks.covariance[source], times[place] - tracks.time[source],
        process_noise,
    )  # fmt: skip
    covariance = (covariance + covariance.swapaxes(1, 2)) / 2.0
    every = np.concatenate([moment.reshape(-1), place])
    order = np.argsort(every, kind="stable")
    number = np.concatenate([tracks.track, tracks.track[source]])[order]
    means = np.concatenate([tracks.mean, mean])[order]
    spreads = np.concatenate([tracks.covariance, covariance])[order]
    start = np.searchsorted(every[order], np.arange(times.size + 1))
    return [
        LocalPicture(name, float(time), number[begin:end], means[begin:end], spreads[begin:end])
        for time, begin, end in zip(times, start[:-1], start[1:], strict=True)
    ]


def _gaps(tracks: TrackTable, moment: IntArray) -> tuple[IntArray, IntArray]:
    """Return times at which tracks have no row: the row before each, and which time it is."""
    order = np.lexsort((tracks.time, tracks.track))
    same = np.diff(tracks.track[order]) == 0
    wait: FloatArray = np.diff(tracks.time[order])
    usual = float(np.median(wait[same])) if np.any(same) else 0.0
    missed = np.where(same & (wait <= PATIENCE * usual), np.diff(moment[order]) - 1, 0)
    row = np.repeat(np.arange(missed.size), missed)
    turn = np.arange(row.size) - np.repeat(np.cumsum(missed) - missed, missed)
    source = order[row]
    return source.astype(np.int64), (moment[source] + 1 + turn).astype(np.int64)


@dataclass(slots=True)
class FusionLog:
    """Pairings, changes and a line per update."""

    pairings: Pairings = field(default_factory=Pairings)
    scans: list[dict[str, Any]] = field(default_factory=list)
    changes: list[dict[str, Any]] = field(default_factory=list)
    timing: list[dict[str, float]] = field(default_factory=list)
    _last: dict[str, set[int]] = field(default_factory=dict)

    def add(
        self, found: FusedPicture, news: Mapping[str, LocalPicture], cpu: float, wall: float
    ) -> None:
        """Take what was found at an update, from which news, and how long it took [s]."""
        association = found.association
        self._last |= {name: set(picture.track.tolist()) for name, picture in news.items()}
        self.pairings.add(association, self._last)
        certificate = association.certificate
        self.scans.append(
            {
                "time": found.time,
                "sensors": sorted(news),
                "tracks": len(association),
                "objects": len(found.tracks),
                "tuples": association.n_tuples,
                "pruned": association.n_pruned,
                "cost": certificate.cost,
                "lower_bound": certificate.lower_bound,
                "gap": certificate.gap,
                "status": certificate.status.value,
                "changes": len(association.changes),
            }
        )
        self.changes += [
            {
                "time": found.time, "kind": change.kind, "object": change.object,
                "others": list(change.others), "reason": change.reason,
                "statistic": change.statistic, "threshold": change.threshold,
            }
            for change in association.changes
        ]  # fmt: skip
        self.timing.append({"cpu_ms": round(1e3 * cpu, 3), "wall_ms": round(1e3 * wall, 3)})


if TYPE_CHECKING:
    from trackweave.run.fusing import FusionValues


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


def _remaining(tracks: TrackTable, log: FusionLog) -> int:
    """Return how many objects there were but for those that turned out to be others."""
    number, place = np.unique(tracks.track, return_inverse=True)
    last = np.full(number.size, -np.inf)
    np.maximum.at(last, place.reshape(-1), tracks.time)
    merged = {
        other: change["time"]
        for change in log.changes
        if change["kind"] == "merged"
        for other in change["others"]
    }
    return sum(
        end >= merged.get(own, -np.inf)
        for own, end in zip(number.tolist(), last.tolist(), strict=True)
    )


def _totals(
    tables: Mapping[str, LocalTracks], values: "FusionValues", log: FusionLog
) -> dict[str, Any]:
    kinds = [change["kind"] for change in log.changes]
    return {
        "sensors": len(tables),
        "local_tracks": sum(np.unique(table.tracks.track).size for table in tables.values()),
        "objects": _remaining(values.tracks, log),
        "names": int(np.unique(values.tracks.track).size),
        "common_objects": len(log.pairings.common),
        "updates": len(log.scans),
        "merged": kinds.count("merged"),
        "split": kinds.count("split"),
        "left_out_rows": sum(table.n_left_out for table in tables.values()),
        **certainty_of(log.scans, "updates"),
    }
