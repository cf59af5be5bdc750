"""What a recording tells beside its reports, and what of it could not be read."""

from dataclasses import dataclass, field

__all__ = ["Facts", "Place", "Skipped", "Skips"]

MOST_LISTED = 1000
"""As many skipped records are listed; all are counted."""
_LONGEST_REASON = 120


@dataclass(frozen=True, slots=True)
class Skipped:
    """A record that could not be decoded: where it begins [bytes], what was wrong with it."""

    offset: int
    what: str


@dataclass(slots=True)
class Skips:
    """The records that a decoder could not use: all are counted, the first are listed."""

    count: int = 0
    listed: list[Skipped] = field(default_factory=list)

    def add(self, offset: int, what: str) -> None:
        """Enter a record, by where it begins [bytes] and what is wrong with it."""
        self.count += 1
        if len(self.listed) < MOST_LISTED:
            self.listed.append(Skipped(int(offset), what[:_LONGEST_REASON]))

    def take(self, others: "Skips", name: str) -> None:
        """Enter those of another file, called by its name."""
        self.count += others.count
        room = max(0, MOST_LISTED - len(self.listed))
        self.listed += [Skipped(s.offset, f"{name}: {s.what}") for s in others.listed[:room]]


@dataclass(frozen=True, slots=True)
class Place:
    """Where a sensor stands: WGS-84 [degrees], height above the ellipsoid [m]."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0


@dataclass(slots=True)
class Facts:
    """What a recording tells beside its reports.

    ``places``, ``positions`` on the reports' plane [m] and ``scan_periods`` [s] are by the names
    that the column ``sensor`` has and count as told; ``notes`` are sentences on what was assumed
    and why; ``left_out`` counts the records that are whole but no reports, by what they are.
    """

    places: dict[str, Place] = field(default_factory=dict)
    positions: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    scan_periods: dict[str, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    left_out: dict[str, int] = field(default_factory=dict)

    def leave_out(self, what: str, count: int = 1) -> None:
        """Count records that are no reports."""
        if count:
            self.left_out[what] = self.left_out.get(what, 0) + int(count)

    def sentences(self) -> list[str]:
        """Return the notes, and what was left out."""
        return [*self.notes, *(f"{what}: {n:,}" for what, n in sorted(self.left_out.items()))]
