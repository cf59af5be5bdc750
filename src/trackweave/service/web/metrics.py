"""Numbers in Prometheus' text format, version 0.0.4."""

import math
import re
import time
from collections.abc import Iterable, Mapping

from trackweave.service.desk import Json

__all__ = ["CONTENT_TYPE", "Sample", "exposition", "of_process", "of_sensors"]

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
_NAME = re.compile(r"[a-z_][a-z0-9_]*")
_PREFIX = "trackweave_"
_ESCAPES = str.maketrans({"\\": r"\\", '"': r"\"", "\n": r"\n"})

Sample = tuple[str, Mapping[str, str], float]
"""A name, labels and a value. A name that ends in ``_total`` only ever grows."""


def exposition(samples: Iterable[Sample]) -> str:
    """Return numbers as Prometheus reads them.

    Parameters
    ----------
    samples
        In any order. Names of ours get the prefix ``trackweave_``; those that begin with
        ``process_`` are everybody's. A name of other letters, and labels told twice, are left out:
        one bad line would cost all others.

    Returns
    -------
    The text, with the kind of each metric.
    """
    metrics: dict[str, dict[str, float]] = {}
    for name, labels, value in samples:
        if _NAME.fullmatch(name):
            whole = name if name.startswith("process_") else _PREFIX + name
            metrics.setdefault(whole, {}).setdefault(_labels(labels), value)
    lines = []
    for name, values in sorted(metrics.items()):
        lines.append(f"# TYPE {name} {'counter' if name.endswith('_total') else 'gauge'}")
        lines += [f"{name}{labels} {_number(value)}" for labels, value in values.items()]
    return "".join(f"{line}\n" for line in lines)


def of_sensors(sensors: Iterable[Json]) -> list[Sample]:
    """Return what is known of each sensor as numbers."""
    found: list[Sample] = []
    for sensor in sensors:
        labels = {"sensor": str(sensor.get("name", ""))}
        for key, name in (
            ("reports", "sensor_reports_total"),
            ("reports_per_s", "sensor_reports_per_second"),
            ("last_heard", "sensor_last_heard_seconds"),
            ("silent", "sensor_silent"),
        ):
            value = sensor.get(key)
            if isinstance(value, bool | int | float):
                found.append((name, labels, float(value)))
    return found


def of_process() -> list[Sample]:
    """Return what the process takes, as far as the system tells: CPU time and memory."""
    found: list[Sample] = [("process_cpu_seconds_total", {}, time.process_time())]
    try:
        import resource
        from pathlib import Path

        pages = int(Path("/proc/self/statm").read_text().split()[1])
    except (ImportError, OSError, ValueError):
        return found
    return [*found, ("process_resident_memory_bytes", {}, float(pages * resource.getpagesize()))]


def _labels(labels: Mapping[str, str]) -> str:
    if not labels:
        return ""
    parts = [f'{name}="{_printable(value)}"' for name, value in labels.items()]
    return "{" + ",".join(parts) + "}"


def _printable(value: str) -> str:
    # Some readers split lines at more than \n, and none can use what is no letter.
    text = value.encode("utf-8", "replace").decode("utf-8").translate(_ESCAPES)
    return "".join(each if each.isprintable() else "?" for each in text)[:200]


def _number(value: float) -> str:
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "+Inf" if value > 0 else "-Inf"
    return repr(float(value)) if value != int(value) else str(int(value))
