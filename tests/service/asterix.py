"""A radar that speaks ASTERIX: plots in category 048, where it stands in category 034."""

import struct

import numpy as np

PLACE = (45.5, 15.5, 200.0)
"""Latitude and longitude [degrees], height [m]."""
PERIOD = 4.0
NAUTICAL_MILE = 1852.0
SOURCE = b"\x19\x0b"  # 025/011


def _block(category: int, records: bytes) -> bytes:
    return struct.pack(">BH", category, 3 + len(records)) + records


def _of_day(time: float) -> bytes:
    return round(time * 128.0).to_bytes(3, "big")


def marker(time: float, sector: float) -> bytes:
    """Return a message of category 034: a sector that was crossed, turn and place."""
    latitude, longitude = (
        round(number * 2**23 / 180.0).to_bytes(3, "big", signed=True) for number in PLACE[:2]
    )
    kind = b"\x01" if sector == 0.0 else b"\x02"
    body = SOURCE + kind + _of_day(time) + bytes([int(sector / 360.0 * 256.0)])
    body += struct.pack(">H", round(PERIOD * 128.0)) + struct.pack(">h", int(PLACE[2]))
    return _block(34, b"\xf9\x10" + body + latitude + longitude)


def plot(time: float, distance: float, azimuth_deg: float) -> bytes:
    """Return a message of category 048: one plot by its slant range [m] and azimuth."""
    rho = round(distance / NAUTICAL_MILE * 256.0)
    theta = round(azimuth_deg / 360.0 * 65536.0) % 65536
    body = SOURCE + _of_day(time) + b"\x40" + struct.pack(">HH", rho, theta)
    return _block(48, b"\xf0" + body)


def traffic(seed: int = 1, n_aircraft: int = 20, n_turns: int = 16) -> list[bytes]:
    """Return the messages of a radar that sees aircraft, in order of time."""
    rng, begin = np.random.default_rng(seed), 36_000.0
    said = []
    for turn in range(n_turns):
        for sector in range(0, 360, 45):
            time = begin + (turn + sector / 360.0) * PERIOD
            said.append((time, marker(time, float(sector))))
    for _ in range(n_aircraft):
        place, velocity = rng.uniform(-4e4, 4e4, 2), rng.normal(0, 120, 2)
        for turn in range(n_turns):
            time = turn * PERIOD
            for _ in range(3):
                x, y = place + velocity * time
                azimuth = np.degrees(np.arctan2(x, y)) % 360.0
                time = (turn + azimuth / 360.0) * PERIOD
            if rng.random() < 0.95:
                noise = rng.normal(0, 1, 2)
                measured = np.hypot(x, y) + 40 * noise[0], azimuth + 0.06 * noise[1]
                said.append((begin + time, plot(begin + time, measured[0], measured[1] % 360.0)))
    return [message for _, message in sorted(said)]
