"""Every field of every record, side by side with libasterix."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("asterix.generated", reason="compares only where libasterix is installed")

from oracles import libasterix
from oracles.asterix_records import block, random_record
from trackweave.formats.asterix.decoding import categories_of
from trackweave.formats.asterix.gathering import Gathering
from trackweave.formats.asterix.packets import datagram
from trackweave.formats.format import Skips

EDITIONS = {"cat021ed0.26.bin": "0.26"}


def fields(data: bytes, edition: str = "2") -> list[dict[str, int]] | None:
    """Return every field of a data block's records, None where one is refused."""
    skips = Skips()
    gathering = Gathering(data, 0, categories_of(edition), skips, {})
    gathering.block(0, len(data))
    found: dict[int, dict[str, int]] = {}
    for records in gathering.records(data[0]):
        for begin in records.begin:
            found[int(begin)] = {}
        for name, numbers, there in records.every_field():
            for place in np.flatnonzero(there):
                found[int(records.begin[place])][name] = int(numbers[place])
    return None if skips.count else [found[begin] for begin in sorted(found)]


def payloads(path: Path) -> list[bytes]:
    """Return what holds data blocks: the file, or each datagram, without envelopes."""
    content = path.read_bytes()
    if path.suffix != ".pcap":
        return [content]
    found, place = [], 24
    while place < len(content):
        stop = place + 16 + int.from_bytes(content[place + 8 : place + 12], "little")
        span = datagram(content, place + 16, stop, 1)
        assert isinstance(span, tuple)
        found += opened(content[slice(*span)])
        place = stop
    return found


def opened(payload: bytes) -> list[bytes]:
    """Return the data blocks of a datagram in which each may have six octets before it."""
    if int.from_bytes(payload[1:3], "big") <= len(payload):
        return [payload]
    found = []
    while payload:
        size = int.from_bytes(payload[:2], "big")
        found.append(payload[6:size])
        payload = payload[size:]
    return found


@pytest.mark.shared
def test_every_field_of_every_recorded_record_is_equal(shared: Path) -> None:
    compared, refused = 0, list[str]()
    folder = shared / "data" / "asterix"
    for path in sorted(file for file in folder.rglob("*.*") if file.suffix != ".txt"):
        edition = EDITIONS.get(path.name, "2")
        for payload in payloads(path):
            for category, content in libasterix.blocks(payload):
                if category not in categories_of():
                    continue
                spec = libasterix.specification(category, edition if edition != "2" else "")
                expected = libasterix.records(spec, content)
                assert fields(block(category, content), edition) == expected, path.name
                if expected is None:
                    refused.append(path.name)
                else:
                    compared += len(expected)
    assert compared == 189
    assert refused == ["cat010ed0.24_sensis.bin"]


@pytest.mark.parametrize(
    ("category", "edition", "theirs"),
    [(1, "2", ""), (2, "2", ""), (10, "2", ""), (20, "2", ""), (21, "2", ""), (21, "2", "2.1"),
     (21, "0.26", "0.26"), (21, "0.26", "0.24"), (21, "0.23", "0.23"), (34, "2", ""),
     (48, "2", ""), (62, "2", "")],
)  # fmt: skip
def test_every_field_of_records_made_up_is_equal(category: int, edition: str, theirs: str) -> None:
    rng = np.random.default_rng(7)
    spec = libasterix.specification(category, theirs)
    compared = 0
    for share in (0.1, 0.5, 0.9) * 6:
        kind = int(rng.integers(len(categories_of(edition)[category].layouts)))
        made = random_record(categories_of(edition)[category].layouts[kind], rng, share)
        expected = libasterix.records(spec, made)
        if expected is None:  # an older edition, or a plot that says that it is a track
            continue
        found = fields(block(category, made), edition)
        assert found is not None
        if theirs in ("", edition):
            assert found == expected
        else:  # an older edition calls some fields by other names
            same = found[0].keys() & expected[0].keys()
            assert {name: found[0][name] for name in same} == {k: expected[0][k] for k in same}
            assert len(same) >= 0.8 * len(expected[0])
        compared += 1
    assert compared >= 5
