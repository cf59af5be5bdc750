"""Which scans of different sensors are of one instant."""

from collections.abc import Iterable, Sequence

from trackweave.domain.scans import Scan

__all__ = ["instants_of"]


def instants_of(scans: Iterable[Scan], within: float) -> list[tuple[Scan, ...]]:
    """Return scans, in order of time, by the instants at which they were taken, within [s] ≥ 0."""
    # An instant begins with the first scan that is of none yet, and takes in those that follow
    # within the time, up to the first of a sensor that it has already. Its scans are in order of
    # their sensors' names.
    instants: list[list[Scan]] = []
    for scan in scans:
        last: Sequence[Scan] = instants[-1] if instants else ()
        is_near = bool(last) and scan.time - last[0].time <= within
        if is_near and all(scan.sensor != other.sensor for other in last):
            instants[-1].append(scan)
        else:
            instants.append([scan])
    return [tuple(sorted(instant, key=lambda scan: scan.sensor)) for instant in instants]
