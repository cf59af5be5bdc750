"""What ASTERIX comes in: data blocks one after another, frames of a recorder, network captures."""

from typing import Literal, Protocol, TypeAlias

from trackweave.formats.asterix.gathering import KNOWN_CATEGORIES, Gathering
from trackweave.formats.asterix.packets import UNREAD, datagram

__all__ = ["CAPTURES", "Framing", "framing_of"]

_PASSED_OVER = "octets passed over in search of what is right"
_HEADER = 3
_PADDING = b"\xa5" * 4
_FINAL_HEADER = 8
_LARGEST_PACKET = 1 << 18
_LARGEST_PCAPNG = 1 << 20
_SECTION = 0x0A0D0D0A
_Order: TypeAlias = Literal["little", "big"]
_PCAP_MAGICS: dict[bytes, tuple[_Order, float]] = {
    b"\xd4\xc3\xb2\xa1": ("little", 1e-6),
    b"\xa1\xb2\xc3\xd4": ("big", 1e-6),
    b"\x4d\x3c\xb2\xa1": ("little", 1e-9),
    b"\xa1\xb2\x3c\x4d": ("big", 1e-9),
}


CAPTURES = (*_PCAP_MAGICS, _SECTION.to_bytes(4, "big"))
"""What captures of a network begin with."""


class _Frames(Protocol):
    """A way of laying one thing behind another."""

    header: int
    """As many octets tell how long a thing is."""
    what: str
    """What messages call it."""

    def size(self, buffer: bytes, place: int) -> int:
        """Return the length of what begins at a place, 0 where nothing does."""

    def take(self, gathering: Gathering, start: int, stop: int) -> int:
        """Decode it; return how far that went."""

    def sure(self, gathering: Gathering, start: int, stop: int) -> bool | None:
        """Return whether it is one, among octets that are none; None where it may become one."""


class Framing:
    """Goes from one thing to the next, and finds the next after what is none.

    What it does depends on the octets alone, not on how they were split.
    """

    def __init__(self, frames: _Frames) -> None:
        self._frames = frames
        self._lost = False

    def scan(self, gathering: Gathering, *, at_end: bool) -> int:
        """Decode what is complete in a buffer; return how much of it is done with."""
        buffer, place = gathering.buffer, 0
        while place < len(buffer):
            was_lost = self._lost
            if was_lost:
                after = self._search(gathering, place, at_end)
                gathering.count(_PASSED_OVER, after - place)
            else:
                after = self._step(gathering, place, at_end)
            if after == place and self._lost == was_lost:
                break
            place = after
        return place

    def _step(self, gathering: Gathering, place: int, at_end: bool) -> int:
        """Take what begins at a place; return where to go on, there again for want of octets."""
        buffer, frames = gathering.buffer, self._frames
        if len(buffer) - place < frames.header:
            if at_end:
                gathering.skip(place, f"{frames.what} that is cut off")
                return len(buffer)
            return place
        size = frames.size(buffer, place)
        stop = place + size
        if size and stop <= len(buffer):
            reached = frames.take(gathering, place, stop)
            # Of one that goes wrong the length may be wrong, too.
            self._lost = reached < stop
            return reached
        if size and not at_end:
            return place
        cut_off = f"{frames.what} that is cut off" if size else f"no {frames.what}"
        gathering.skip(place, cut_off)
        self._lost = True
        return place

    def _search(self, gathering: Gathering, place: int, at_end: bool) -> int:
        """Return where one surely begins, because another follows; else how far there is none."""
        buffer, frames = gathering.buffer, self._frames
        # What is there is what went wrong, or what had no place in the search before.
        for start in range(place, len(buffer)):
            if len(buffer) - start < frames.header:
                return len(buffer) if at_end else start
            size = frames.size(buffer, start)
            if not size:
                continue
            stop = start + size
            right = frames.sure(gathering, start, stop)
            if right is False:
                continue
            if stop + frames.header > len(buffer) and not at_end:
                return start
            if right and self._follows(buffer, stop):
                self._lost = False
                return start
        return len(buffer)

    def _follows(self, buffer: bytes, stop: int) -> bool:
        """Return whether something begins at a place, or the end is there."""
        if stop + self._frames.header > len(buffer):
            return stop == len(buffer)
        return self._frames.size(buffer, stop) > 0


class _Blocks:
    """Data blocks."""

    header = _HEADER
    what = "data block"

    def size(self, buffer: bytes, place: int) -> int:
        size = buffer[place + 1] << 8 | buffer[place + 2]
        return size if size > _HEADER and buffer[place] in KNOWN_CATEGORIES else 0

    def take(self, gathering: Gathering, start: int, stop: int) -> int:
        return gathering.block(start, stop)

    def sure(self, gathering: Gathering, start: int, stop: int) -> bool | None:
        return gathering.decodes(start, stop)


class _FinalFormat:
    """Frames of a recorder: a header with the length, data blocks, four octets of A5."""

    header = 2
    what = "frame of the final format"

    def size(self, buffer: bytes, place: int) -> int:
        size = buffer[place] << 8 | buffer[place + 1]
        stop = place + size
        if size < _FINAL_HEADER + len(_PADDING) or stop > len(buffer):
            return size if size >= _FINAL_HEADER + len(_PADDING) else 0
        return size if buffer[stop - len(_PADDING) : stop] == _PADDING else 0

    def take(self, gathering: Gathering, start: int, stop: int) -> int:
        gathering.payload(start + _FINAL_HEADER, stop - len(_PADDING))
        return stop

    def sure(self, gathering: Gathering, start: int, stop: int) -> bool:
        return True


class _Pcap:
    """Packets of a capture by libpcap; the file's own header is the first frame."""

    header = 24
    what = "packet"

    def __init__(self, magic: bytes) -> None:
        self._order, self._tick = _PCAP_MAGICS[magic]
        self._link = -1

    def _word(self, buffer: bytes, place: int) -> int:
        return int.from_bytes(buffer[place : place + 4], self._order)

    def size(self, buffer: bytes, place: int) -> int:
        if self._link < 0:
            return 24
        fraction, kept, sent = (self._word(buffer, place + 4 * k) for k in (1, 2, 3))
        right = fraction * self._tick < 1.0 and kept <= min(sent, _LARGEST_PACKET)
        return 16 + kept if right else 0

    def take(self, gathering: Gathering, start: int, stop: int) -> int:
        if self._link < 0:
            self._link = self._word(gathering.buffer, start + 20) & 0xFFFF
            self.header = 16
            return stop
        seconds, fraction = (self._word(gathering.buffer, start + 4 * k) for k in (0, 1))
        _packet(gathering, (start + 16, stop), self._link, seconds + fraction * self._tick)
        return stop

    def sure(self, gathering: Gathering, start: int, stop: int) -> bool:
        return stop > start + 16


class _Pcapng:
    """Blocks of a capture in the newer format."""

    header = 12
    what = "block of the capture"

    def __init__(self) -> None:
        self._order: _Order = "little"
        self._interfaces = list[tuple[int, float]]()

    def _word(self, buffer: bytes, place: int, size: int = 4) -> int:
        return int.from_bytes(buffer[place : place + size], self._order)

    def size(self, buffer: bytes, place: int) -> int:
        order = self._order_at(buffer, place)
        size = int.from_bytes(buffer[place + 4 : place + 8], order)
        stop = place + size
        if size < 12 or size % 4 or size > _LARGEST_PCAPNG:
            return 0
        if stop <= len(buffer) and buffer[stop - 4 : stop] != buffer[place + 4 : place + 8]:
            return 0
        return size

    def take(self, gathering: Gathering, start: int, stop: int) -> int:
        buffer, kind = gathering.buffer, self._word(gathering.buffer, start)
        if kind == _SECTION:
            self._order, self._interfaces = self._order_at(buffer, start), []
        elif kind == 1:
            resolution = self._resolution(buffer, start + 16, stop - 4)
            self._interfaces.append((self._word(buffer, start + 8, 2), resolution))
        elif kind == 6 and stop - start >= 32:
            self._enhanced(gathering, start, stop)
        elif kind == 3 and self._interfaces:
            kept = min(self._word(buffer, start + 8), stop - start - 16)
            _packet(gathering, (start + 12, start + 12 + kept), self._interfaces[0][0], 0.0)
        return stop

    def _order_at(self, buffer: bytes, place: int) -> _Order:
        """Return the order of a block's octets, which a section says of itself."""
        if self._word(buffer, place) != _SECTION:
            return self._order
        return "big" if buffer[place + 8 : place + 12] == b"\x1a\x2b\x3c\x4d" else "little"

    def _enhanced(self, gathering: Gathering, start: int, stop: int) -> None:
        buffer = gathering.buffer
        number, high, low, kept = (self._word(buffer, start + 8 + 4 * k) for k in range(4))
        if number >= len(self._interfaces) or kept > stop - start - 32:
            gathering.skip(start, "a packet that is longer than its block, or of no interface")
            return
        link, tick = self._interfaces[number]
        _packet(gathering, (start + 28, start + 28 + kept), link, (high << 32 | low) * tick)

    def _resolution(self, buffer: bytes, place: int, stop: int) -> float:
        """Return the seconds of a clock's tick, which an option may say."""
        while place + 4 <= stop:
            code, size = self._word(buffer, place, 2), self._word(buffer, place + 2, 2)
            if code == 9 and size == 1:
                exponent = buffer[place + 4]
                return 2.0 ** -(exponent & 127) if exponent & 128 else 10.0**-exponent
            if code == 0:
                break
            place += 4 + -(-size // 4) * 4
        return 1e-6

    def sure(self, gathering: Gathering, start: int, stop: int) -> bool:
        return True


def _packet(gathering: Gathering, span: tuple[int, int], link: int, clock: float) -> None:
    """Decode what a packet carries."""
    found = datagram(gathering.buffer, *span, link)
    if isinstance(found, str):
        if found in UNREAD:
            gathering.count(found)
        else:
            gathering.skip(span[0], found)
        return
    gathering.payload(*found, clock)


def framing_of(buffer: bytes, *, at_end: bool) -> Framing | None:
    """Return what a file's beginning shows that it is, None where more of it has to be seen."""
    if len(buffer) < 4 and not at_end:
        return None
    if buffer[:4] in _PCAP_MAGICS:
        return Framing(_Pcap(buffer[:4]))
    if buffer[:4] in CAPTURES:
        return Framing(_Pcapng())
    if len(buffer) < 4 or not _may_be_final(buffer):
        return Framing(_Blocks())
    size = buffer[0] << 8 | buffer[1]
    if len(buffer) < size and not at_end:
        return None
    return Framing(_FinalFormat() if buffer[:size].endswith(_PADDING) else _Blocks())


def _may_be_final(buffer: bytes) -> bool:
    """Return whether the first octets may be a recorder's frame rather than a data block."""
    size = buffer[1] << 8 | buffer[2]
    is_block = buffer[0] in KNOWN_CATEGORIES and 3 < size <= 8192
    # A frame begins with its length and an error code of 0.
    return buffer[0] < 16 and (buffer[2] == 0 or not is_block)
