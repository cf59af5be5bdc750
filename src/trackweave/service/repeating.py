"""The run of a service once more, from its journal alone."""

from dataclasses import dataclass
from pathlib import Path

from trackweave.service.engine import Engine
from trackweave.service.office import unpacked
from trackweave.service.recovery import StoredJournal
from trackweave.service.snapshots import Snapshots
from trackweave.service.track_files import TrackFiles

__all__ = ["Repeated", "repeated"]


@dataclass(frozen=True, slots=True)
class Repeated:
    """What a journal held.

    Parameters
    ----------
    first, last
        The records that were taken; ``first`` is 1 unless earlier ones were forgotten.
    engine
        The engine after the last.
    parts
        How many tracks files were written.
    """

    first: int
    last: int
    engine: Engine
    parts: int


def repeated(folder: Path, out: Path) -> Repeated:
    """Write the tracks files that follow from a service's journal.

    Parameters
    ----------
    folder
        The service's folder; nothing is written there, and a service may have it open.
    out
        Where ``tracks-00001.csv`` and those that follow go. They are the same bytes as the
        service's own, as far as its journal reaches: where its beginning was forgotten, they
        begin with what the oldest snapshot was followed by.

    Returns
    -------
    What the journal held.
    """
    journal = StoredJournal(folder / "journal")
    engine, files = Engine(), TrackFiles(out)
    if journal.first > 1:
        newest = Snapshots(folder / "journal").newest(journal.first, journal.last)
        assert newest is not None
        engine, place = unpacked(newest.content)
        files.begin_after(place)
    begin = engine.sequence + 1
    for record in journal.records(after=engine.sequence):
        change = engine.take(record.sequence, record.kind, record.payload)
        if change.rows and engine.spec is not None:
            files.add(change.rows, engine.spec)
    return Repeated(begin, journal.last, engine, files.part)
