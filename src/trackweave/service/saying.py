"""How the service is: what it says of its sensors, its load and its health."""

import logging
import time
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from trackweave.config import Configuration
from trackweave.models.coverage import FieldOfView
from trackweave.models.sensors import Sensor
from trackweave.service.desk import Json
from trackweave.service.inputs.process import Input
from trackweave.service.learning import Learned, waiting_for
from trackweave.service.log import say
from trackweave.service.office import Office, Outcome

__all__ = ["Saying"]

SILENT_PERIODS, SILENT_S = 3.0, 15.0
"""A sensor is silent that was not heard for so many periods, and so many seconds."""
EDGES = 48

_log = logging.getLogger("trackweave.service")


@dataclass
class _Heard:
    """What is known of one sensor's reports."""

    reports: int = 0
    last: float = -np.inf
    """By the sensor's own time [s]."""
    when: float = -np.inf
    """By the monotonic clock [s]."""
    counts: deque[tuple[float, int]] = field(default_factory=lambda: deque(maxlen=200))

    def rate(self, now: float) -> float:
        """Return how many reports come a second."""
        own = [(when, count) for when, count in self.counts if now - when <= 15.0]
        return sum(count for _, count in own) / 15.0


class Saying:
    """Gathers what was heard and done, and says how it is.

    Parameters
    ----------
    office
        Of which it speaks.
    """

    def __init__(self, office: Office) -> None:
        self._office = office
        self._sensors: dict[str, _Heard] = {}
        self._reports = self._reports_before = 0
        self._cpu = self._cpu_before = 0.0
        self._latency: deque[float] = deque(maxlen=64)
        self._begun = time.monotonic()

    def heard(self, told: Mapping[str, Sequence[float]]) -> None:
        """Take in what sensors told: first and last time, and how often."""
        now = time.monotonic()
        for name, (_, last, *count) in told.items():
            heard = self._sensors.setdefault(name, _Heard())
            number = int(count[0]) if count else 1
            heard.reports += number
            heard.last, heard.when = max(heard.last, last), now
            heard.counts.append((now, number))
            self._reports += number

    def took(self, outcome: Outcome) -> None:
        """Take in what the tracker did."""
        self._cpu += outcome.cpu
        if outcome.reports:
            self._latency.append(outcome.latency)

    def learned(self, found: Learned) -> None:
        """Log with what the tracker runs from now on."""
        spec = found.spec
        say(_log, logging.INFO, "configured", sensors=len(spec.configuration["sensors"]),
            **({} if spec.regions is None else {"regions": len(spec.regions)}))  # fmt: skip
        for note in found.notes:
            say(_log, logging.INFO, "note", note=note)

    def status(self, lag: float, over: float) -> Json:
        """Return the message of type "status" on the last seconds."""
        cpu, self._cpu_before = self._cpu - self._cpu_before, self._cpu
        reports, self._reports_before = self._reports - self._reports_before, self._reports
        counts, engine = self._office.engine.counts, self._office.engine
        gap = engine.gap
        ordered = sorted(self._latency)
        return {
            "type": "status",
            "load": round(cpu / over, 4),
            "gap": gap if gap is not None and np.isfinite(gap) else None,
            "latency_s": round(ordered[len(ordered) // 2], 4) if ordered else None,
            "lag_s": round(lag, 3),
            "reports_per_s": round(reports / over, 2),
            "set_aside": counts.set_aside + counts.held,
            "dropped": counts.dropped,
            "late": counts.late,
            "sequence": self._office.journal.synced,
            "bound": self._office.pace.level,
        }

    def sensors(self) -> list[Json]:
        """Return the sensors, those that the configuration does not know yet too."""
        known: dict[str, Sensor] = dict(self._office.engine.sensors)
        names = [*known, *(name for name in self._sensors if name not in known)]
        return [self._sensor(name, known.get(name)) for name in names]

    def health(
        self,
        refused: str,
        lag: float,
        inputs: Sequence[Input],
        configuration: Configuration | None = None,
    ) -> Json:
        """Return how the service is; without a configuration, that is not ready yet."""
        engine = self._office.engine
        status, message = self._state(refused, inputs, configuration)
        counts = engine.counts
        workers = engine.house.workers()
        return {
            **({} if workers is None else {"regions": workers}),
            "status": status,
            "message": message or None,
            "listening": all(each.is_ready for each in inputs),
            "sequence": self._office.journal.synced,
            "lag_s": round(lag, 3),
            "configured": engine.is_configured,
            "configured_by": engine.configured_by,
            "set_aside": counts.set_aside + counts.held,
            "late": counts.late,
            "unfit": counts.unfit,
            "refused": counts.refused,
            "strange": counts.strange,
            "dropped": counts.dropped,
            "inputs": [
                {
                    "url": each.source.url,
                    "reports": each.reports,
                    "ended": each.has_ended,
                    **{key: each.state[key] for key in ("clients", "skipped", "dropped")},
                    "listening": each.is_ready,
                    "message": each.state["message"] or None,
                }
                for each in inputs
            ],
        }

    def _state(
        self, refused: str, inputs: Sequence[Input], configuration: Configuration | None
    ) -> tuple[str, str]:
        """Return the status, and a sentence on it."""
        engine, missing = self._office.engine, self._office.missing
        if refused:
            return "failing", refused
        for each in inputs:
            if not each.is_ready:
                why = each.state["message"] or "what is sent there is lost"
                return "starting", f"{each.source.url}: does not listen yet ({why})"
        if configuration is None:
            return "starting", "kernels are loaded, or compiled once"
        if engine.is_configured:
            return "ok", missing or self._left_out()
        return "waiting", missing or waiting_for(
            configuration, engine.heard, is_cut=self._office.most_regions is not None
        )

    def _left_out(self) -> str:
        """Return a sentence on sensors whose reports cannot be used, empty where all can be."""
        unfit = sorted(self._office.unfit)
        if not unfit:
            return ""
        which = f"sensor {unfit[0]}" if len(unfit) == 1 else f"sensors {', '.join(unfit)}"
        return (
            f"{which}: reports measure otherwise than those by which it was configured, as x,y "
            "beside lat,lon, and are left out (unfit); give them a sensor of their own, and "
            "[frame] origin where only some are of the Earth"
        )

    def counters(self, inputs: Sequence[Input]) -> dict[str, float]:
        """Return numbers for ``/metrics``."""
        counts = self._office.engine.counts
        return {
            "reports_total": float(self._reports),
            "late_reports_total": float(counts.late),
            "set_aside_reports_total": float(counts.set_aside),
            "held_reports": float(counts.held),
            "refused_rows_total": float(counts.refused),
            "strange_reports_total": float(counts.strange),
            "unfit_reports_total": float(counts.unfit),
            "dropped_reports_total": float(counts.dropped),
            "undecoded_records_total": float(sum(i.state["skipped"] for i in inputs)),
            "scans_total": float(counts.scans),
            "tracker_cpu_seconds_total": self._cpu,
            "work_bound_level": float(self._office.pace.level),
            "journal_sequence": float(self._office.journal.synced),
            "uptime_seconds": time.monotonic() - self._begun,
        }

    def _sensor(self, name: str, sensor: Sensor | None) -> Json:
        heard, now = self._sensors.get(name, _Heard()), time.monotonic()
        period = None if sensor is None else sensor.scan_period
        patience = max(SILENT_S, SILENT_PERIODS * (period or 0.0))
        found: dict[str, Any] = {
            "name": name,
            "reports": heard.reports,
            "reports_per_s": round(heard.rate(now), 2),
            "silent": now - max(heard.when, self._begun) > patience,
        }
        told = self._office.engine.told().get(name, heard.last)
        if np.isfinite(told):
            found["last_heard"] = told
        if sensor is None:
            return {**found, "known": False}
        found["kind"] = getattr(sensor.measurement, "word", "plug-in")
        if sensor.position is not None:
            found["place"] = self._on_map(np.array([sensor.position[:2]]))[0]
        if isinstance(sensor.field_of_view, FieldOfView):
            outline = _outline(sensor.field_of_view)
            if outline is not None:
                found["coverage"] = self._on_map(outline)
        return found

    def _on_map(self, places: np.ndarray[Any, Any]) -> list[list[float]]:
        """Return places as they are sent: longitude and latitude where they are on the Earth."""
        spec = self._office.engine.spec
        if spec is None or spec.frame is None:
            return [[round(x, 2), round(y, 2)] for x, y in places.tolist()]
        latitude, longitude, _ = spec.frame.to_geodetic(places)
        return [
            [round(x, 6), round(y, 6)]
            for x, y in zip(longitude.tolist(), latitude.tolist(), strict=True)
        ]


def _outline(view: FieldOfView) -> np.ndarray[Any, Any] | None:
    """Return the corners of what a sensor covers; None where that has no end."""
    if view.polygon is not None:
        return np.asarray(view.polygon, dtype=np.float64)
    if not np.isfinite(view.max_range):
        return None
    first, last = np.radians(view.azimuth_deg)
    width = (last - first) % (2.0 * np.pi) or 2.0 * np.pi
    angle = first + np.linspace(0.0, width, EDGES)
    arc = view.max_range * np.stack([np.sin(angle), np.cos(angle)], axis=-1)
    place = np.asarray(view.position[:2])
    corners = arc + place
    return corners if width > 6.2 else np.concatenate([[place], corners])
