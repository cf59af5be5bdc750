"""Random records of a layout, and what ASTERIX comes in."""

import struct

import numpy as np

from trackweave.formats.asterix.layout import Chained, Compound, Explicit, Fixed, Item, Repeated


def random_record(layout: Compound, rng: np.random.Generator, share: float = 0.5) -> bytes:
    """Return a record with some share of a layout's items, of any content."""
    used = [number for number, item in enumerate(layout.items) if item is not None]
    there = [number for number in used if rng.random() < share] or used[:1]
    specification = bytearray(max(there) // 7 + 1)
    for number in there:
        specification[number // 7] |= 0x80 >> number % 7
    for octet in range(len(specification) - 1):
        specification[octet] |= 1
    items = (layout.items[number] for number in there)
    return bytes(specification) + b"".join(
        _item(item[1], rng, share) for item in items if item is not None
    )


def _item(item: Item, rng: np.random.Generator, share: float) -> bytes:
    if isinstance(item, Fixed):
        return rng.bytes(item.size)
    if isinstance(item, Compound):
        return random_record(item, rng, share)
    if isinstance(item, Repeated):
        count = int(rng.integers(0, 4))
        return bytes([count]) + rng.bytes(count * item.element.size)
    if isinstance(item, Explicit):
        return b"\x03" + rng.bytes(2)
    assert isinstance(item, Chained)
    count = int(rng.integers(1, 1 + (3 if item.repeated else len(item.parts))))
    octets = bytearray(rng.bytes(count * item.parts[0].size))
    for number in range(1, count + 1):
        last = number * item.parts[0].size - 1
        octets[last] = octets[last] & 0xFE | (number < count)
    return bytes(octets)


def block(category: int, *records: bytes) -> bytes:
    """Return a data block."""
    content = b"".join(records)
    return struct.pack(">BH", category, 3 + len(content)) + content


def record(**items: str) -> bytes:
    """Return a record of items in hexadecimal, named by their numbers in the profile: ``n4``."""
    numbers = sorted(int(name[1:]) for name in items)
    specification = bytearray((numbers[-1] + 6) // 7)
    for number in numbers:
        specification[(number - 1) // 7] |= 0x80 >> (number - 1) % 7
    for octet in range(len(specification) - 1):
        specification[octet] |= 1
    return bytes(specification) + b"".join(bytes.fromhex(items[f"n{n}"]) for n in numbers)


def udp(payload: bytes) -> bytes:
    """Return a datagram in an IPv4 packet, checksums left out."""
    header = struct.pack(">HHHH", 4000, 4001, 8 + len(payload), 0)
    total = 20 + len(header) + len(payload)
    return struct.pack(">BBHHHBBH8s", 0x45, 0, total, 0, 0, 64, 17, 0, bytes(8)) + header + payload


def ethernet(packet: bytes, kind: int = 0x0800, tags: int = 0) -> bytes:
    """Return a frame of Ethernet, perhaps of a virtual network."""
    return bytes(12) + tags * struct.pack(">HH", 0x8100, 7) + struct.pack(">H", kind) + packet


def pcap(*packets: tuple[float, bytes], link: int = 1, order: str = "<") -> bytes:
    """Return a capture of packets, each with its time."""
    capture = struct.pack(order + "IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, link)
    for moment, packet in packets:
        micro = round(moment % 1 * 1e6)
        head = struct.pack(order + "IIII", int(moment), micro, len(packet), len(packet))
        capture += head + packet
    return capture


def pcapng(*packets: tuple[float, bytes], order: str = "<") -> bytes:
    """Return a capture in the newer format, its clock in nanoseconds."""

    def part(kind: int, content: bytes) -> bytes:
        content += bytes(-len(content) % 4)
        size = struct.pack(order + "I", 12 + len(content))
        return struct.pack(order + "I", kind) + size + content + size

    capture = part(0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1))
    options = struct.pack(order + "HHB3xHH", 9, 1, 9, 0, 0)
    capture += part(1, struct.pack(order + "HHI", 1, 0, 65535) + options)
    for moment, packet in packets:
        ticks = round(moment * 1e9)
        head = (0, ticks >> 32, ticks & 0xFFFFFFFF, len(packet), len(packet))
        capture += part(6, struct.pack(order + "5I", *head) + packet)
    return capture


def final(*payloads: bytes) -> bytes:
    """Return a recorder's frames of the final format."""
    return b"".join(
        struct.pack(">HBBB3s", 12 + len(payload), 0, 1, 2, b"\0\0\7") + payload + b"\xa5" * 4
        for payload in payloads
    )
