"""Datagrams: each stands for itself, whatever came of the one before."""

from typing import Any

import polars as pl
import pytest

from formats.samples import BARE_STATES, BLOCKS
from trackweave.domain.facts import Facts, Skips
from trackweave.formats.reading import chosen
from trackweave.service.inputs.sockets import Feed

WHOLE = {
    "jsonl": b'{"time": 1.0, "x": 1.0, "y": 2.0}',
    "ais": b"!AIVDM,1,1,,B,15M67FC000G?ufbE`FepT@3n00Sa,0*5C",
    "sbs": b"MSG,3,1,1,4CA2D6,1,2026/11/23,10:00:00.000,2026/11/23,10:00:00.000,,35000,,,51.5,-0.1"
    b",,,0,0,0,0",
    "asterix": BLOCKS,
    "opensky": BARE_STATES,
}


class Box:
    """Counts what an input's outbox is given."""

    def __init__(self) -> None:
        self.rows = self.skipped = 0
        self.message = ""

    def add(self, table: Any, facts: Any) -> None:
        self.rows += 0 if table is None else table.height

    def mark(self, times: dict[str, float]) -> None:
        """Take no note of what radars say of time."""


def fed(name: str, *pieces: bytes) -> Box:
    """Return what becomes of datagrams of a format."""
    found, settings = chosen(name)
    assert found.decoder is not None
    make, box = found.decoder, Box()
    feed = Feed(lambda: make(**settings), box)  # type: ignore[arg-type]
    for piece in pieces:
        feed.take_whole(piece)
    return box


@pytest.mark.parametrize("name", sorted(WHOLE))
@pytest.mark.parametrize("end", [b"", b"\r\n"])
def test_a_datagram_is_decoded_at_once_with_or_without_a_line_feed(name: str, end: bytes) -> None:
    one = WHOLE[name] if name == "asterix" else WHOLE[name] + end
    alone, box = fed(name, one), fed(name, one, one, one)
    assert alone.rows > 0
    # One of ASTERIX's records announces more than there is; a state has no place on the Earth.
    assert alone.skipped == (name in ("asterix", "opensky"))
    assert (box.rows, box.skipped) == (3 * alone.rows, 3 * alone.skipped)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(WHOLE))
def test_a_torn_datagram_spoils_no_other(name: str) -> None:
    whole, rows = WHOLE[name], fed(name, WHOLE[name]).rows
    for cut in range(1, len(whole)):
        box = fed(name, whole, whole[:cut], whole, whole)
        # What is torn late enough may still be a report.
        assert 3 * rows <= box.rows <= 4 * rows, cut


def test_a_message_of_two_sentences_may_come_in_two_datagrams() -> None:
    first = b"!AIVDM,2,1,1,A,55?MbV02;H;s<HtKR20EHE:0@T4@Dn2222222216L961O5Gf0NSQEp6ClRp8,0*1C"
    second = b"!AIVDM,2,2,1,A,88888888880,2*25"
    assert fed("ais", first, second, WHOLE["ais"]).rows == 1
    assert fed("ais", first, second).skipped == 0


class Foreign:
    """Somebody else's decoder: it knows letters alone."""

    def __init__(self) -> None:
        self.skips, self.facts = Skips(), Facts()

    def feed(self, data: bytes) -> pl.DataFrame | None:
        if not data.isalpha():
            raise ValueError("no letters")
        return pl.DataFrame({"x": [float(len(data))]})

    def finish(self) -> None:
        return None


def test_a_foreign_decoder_that_fails_is_named_and_the_next_datagram_is_read() -> None:
    box = Box()
    feed = Feed(Foreign, box)  # type: ignore[arg-type]
    for data in (b"abc", b"1", b"de"):
        feed.take_whole(data)
    assert (box.rows, box.skipped) == (2, 1)
    assert "Foreign" in box.message
    assert "feed raised ValueError: no letters" in box.message
    assert "the plug-in is at fault" in box.message


def test_what_of_ours_fails_is_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Foreign, "__module__", "trackweave.formats.ours")
    with pytest.raises(ValueError, match="no letters"):
        Feed(Foreign, Box()).take_whole(b"1")  # type: ignore[arg-type]
