"""From a captured packet to what its UDP datagram carries."""

__all__ = ["UNREAD", "datagram"]

_NO_UDP = "packets of other protocols than UDP"
_CUT_OFF = "a packet that is cut off"
_FRAGMENT = "a fragment of an IP packet"
UNREAD = (_NO_UDP,)
"""Reasons that are no faults."""

_ETHERNET, _RAW_IP, _COOKED, _IPV4, _IPV6, _COOKED_2 = 1, 101, 113, 228, 229, 276
_NULL, _LOOPBACK = 0, 108
_TAGS = (0x8100, 0x88A8, 0x9100)
_UDP = 17
_EXTENSIONS = (0, 43, 60)
_FRAGMENT_HEADER = 44


def datagram(buffer: bytes, start: int, stop: int, link: int) -> tuple[int, int] | str:
    """Return where a packet's datagram begins and ends, or why there is none.

    Parameters
    ----------
    buffer
        Octets.
    start, stop
        Where the packet lies in them.
    link
        The capture's link type, as libpcap numbers them.

    Returns
    -------
    Beginning and end of what UDP carries, or a reason.
    """
    place = _network(buffer, start, stop, link)
    if isinstance(place, str):
        return place
    if isinstance(place, tuple):
        return place
    if stop - place < 1:
        return _CUT_OFF
    version = buffer[place] >> 4
    if version == 4:
        return _over_ipv4(buffer, place, stop)
    return _over_ipv6(buffer, place, stop) if version == 6 else _NO_UDP


def _network(buffer: bytes, place: int, stop: int, link: int) -> int | tuple[int, int] | str:
    """Return where the network's header begins, or the datagram itself where there is none."""
    if link in (_RAW_IP, _IPV4, _IPV6):
        return place
    if link in (_NULL, _LOOPBACK):
        return place + 4
    at = {_ETHERNET: 12, _COOKED: 14, _COOKED_2: 0}.get(link)
    if at is None:
        return f"a packet of link type {link}; expected Ethernet, cooked or IP"
    kind = _number(buffer, place + at)
    place += 20 if link == _COOKED_2 else at + 2
    if place > stop:
        return _CUT_OFF
    while kind in _TAGS and place + 4 <= stop:
        kind, place = _number(buffer, place + 2), place + 4
    if kind in (0x0800, 0x86DD):
        return place
    if link == _ETHERNET and kind <= 1500 and place + kind <= stop and kind > 3:
        return place + 3, place + kind  # no network at all: a logical link of three octets
    return _NO_UDP


def _over_ipv4(buffer: bytes, place: int, stop: int) -> tuple[int, int] | str:
    if stop - place < 20:
        return _CUT_OFF
    if buffer[place + 9] != _UDP:
        return _NO_UDP
    if _number(buffer, place + 6) & 0x3FFF:
        return _FRAGMENT
    return _over_udp(buffer, place + 4 * (buffer[place] & 15), stop)


def _over_ipv6(buffer: bytes, place: int, stop: int) -> tuple[int, int] | str:
    if stop - place < 40:
        return _CUT_OFF
    kind, place = buffer[place + 6], place + 40
    while kind in _EXTENSIONS and place + 8 <= stop:
        kind, place = buffer[place], place + 8 * (buffer[place + 1] + 1)
    if kind == _FRAGMENT_HEADER:
        return _FRAGMENT
    return _over_udp(buffer, place, stop) if kind == _UDP else _NO_UDP


def _over_udp(buffer: bytes, place: int, stop: int) -> tuple[int, int] | str:
    if stop - place < 8:
        return _CUT_OFF
    end = place + _number(buffer, place + 4)
    if end < place + 8 or end > stop:
        return _CUT_OFF
    return place + 8, end


def _number(buffer: bytes, place: int) -> int:
    return int.from_bytes(buffer[place : place + 2], "big")
