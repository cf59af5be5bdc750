"""What a fusion leaves behind, update by update."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from trackweave.fusion.fuser import FusedPicture
from trackweave.fusion.pairings import Pairings
from trackweave.fusion.pictures import LocalPicture

__all__ = ["FusionLog"]


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
