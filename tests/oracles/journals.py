"""Journals with records that say which they are."""

from pathlib import Path

from trackweave.service.disk import Disk
from trackweave.service.journal import Journal
from trackweave.service.segments import Record

FOLDER = Path("/service")


def opened(disk: Disk, **options: int) -> Journal:
    return Journal.open(FOLDER, disk, **options)


def payload(number: int) -> bytes:
    return f"report {number} ".encode() * (number % 5)


def fill(journal: Journal, count: int, batch: int = 3) -> None:
    """Append so many records and sync them in batches."""
    for number in range(journal.last + 1, journal.last + count + 1):
        assert journal.append(number % 7, payload(number)) == number
        if number % batch == 0:
            journal.sync()
    journal.sync()


def expected(first: int, last: int) -> list[Record]:
    return [Record(number, number % 7, payload(number)) for number in range(first, last + 1)]
