"""Turning radars that speak ASTERIX in real time, and what a service has to be told of them."""

import socket
import time
from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np
from pymap3d import geodetic2aer

from trackweave.domain.frames import LocalFrame

PERIOD, SECTORS = 4.0, 32
PLACE = (45.5, 15.5)
MORNING = 36_000.0
"""The time of the day at which the traffic begins [s]."""
HALF_WIDTH = 1.5e5
"""Aircraft fly within so many metres of the centre; one that leaves is followed by another."""
MOST_IN_A_DATAGRAM = 100


@dataclass(frozen=True, slots=True)
class Datagram:
    """What is sent, when [s after the beginning], and how many plots are in it."""

    when: float
    content: bytes
    plots: int


@dataclass(slots=True)
class Sent:
    """When the first and the last datagram of each sector's end were really sent."""

    first: dict[float, float] = field(default_factory=dict)
    last: dict[float, float] = field(default_factory=dict)


def traffic(  # noqa: PLR0913 what a benchmark turns
    aircraft: int,
    radars: int,
    seconds: float,
    *,
    seed: int = 1,
    marks: bool = True,
    crowd: int = 0,
) -> list[Datagram]:
    """Return the datagrams of radars that see aircraft, a sector's when it ends.

    Parameters
    ----------
    aircraft, radars
        How many there are.
    seconds
        For how long.
    seed
        Of where they fly, and of noise.
    marks
        Whether each sector ends with a message of category 034 that says so.
    crowd
        So many more aircraft are seen in the second third of the time.

    Returns
    -------
    The datagrams in order of time.
    """
    rng = np.random.default_rng(seed)
    most = aircraft + crowd
    place = rng.uniform(-HALF_WIDTH, HALF_WIDTH, (most, 2))
    velocity = rng.normal(0.0, 150.0, (most, 2))
    found: list[tuple[float, int, Datagram]] = []
    for turn in range(int(seconds / PERIOD)):
        for radar in range(radars):
            start = _start(radar, radars) + turn * PERIOD
            when, distance, azimuth = _seen(radar, start, place, velocity)
            true = azimuth.copy()
            distance += rng.normal(0, 60, most)
            azimuth += np.radians(rng.normal(0, 0.07, most))
            seen = rng.random(most) < 0.95
            is_crowded = seconds / 3 <= start < 2 * seconds / 3
            seen &= np.arange(most) < (most if is_crowded else aircraft)
            for sector in range(SECTORS):
                end = start + (sector + 1) / SECTORS * PERIOD
                rows = np.flatnonzero(seen & (true * SECTORS // (2 * np.pi) == sector))
                for k in range(0, len(rows), MOST_IN_A_DATAGRAM):
                    some = rows[k : k + MOST_IN_A_DATAGRAM]
                    plots = _plots(radar, when[some], distance[some], azimuth[some])
                    found.append((end, radar, Datagram(end, plots, len(some))))
                if marks:
                    found.append((end, radar, Datagram(end, _mark(radar, end, sector + 1), 0)))
    return [each for _, _, each in sorted(found, key=lambda each: each[:2])]


def configuration(radars: int) -> str:
    """Return all that the tracker has to be told of the radars."""
    lines = [
        "[frame]", f"origin = [{PLACE[0]}, {PLACE[1]}]",
        "[motion]", "process_noise = 1.0", "max_speed = 600.0",
        "[lifecycle]", "new_target_density = 1e-12",
        "[output]", "period = 4.0",
    ]  # fmt: skip
    for radar in range(radars):
        x, y = _centre(radar)
        phase = (-_start(radar, radars) / PERIOD * 360.0 - MORNING / PERIOD * 360.0) % 360.0
        lines += [
            f'[sensors."025/{radar:03d}"]', 'measurement = "range-azimuth"',
            f"position = [{x}, {y}]", "sigma = {range_m = 60.0, azimuth_deg = 0.07}",
            "detection_probability = 0.95", "clutter_density = 1e-9",
            f"scan_period = {PERIOD}", 'rotation = "clockwise"', f"phase_deg = {phase}",
        ]  # fmt: skip
    return "\n".join(lines) + "\n"


def send(datagrams: list[Datagram], out: socket.socket, begun: float, sent: Sent) -> None:
    """Send datagrams when it is time, and note when that was [s of the monotonic clock]."""
    for each in datagrams:
        time.sleep(max(0.0, begun + each.when - time.monotonic()))
        with suppress(ConnectionRefusedError):  # the service is away
            out.send(each.content)
        now = time.monotonic()
        sent.first.setdefault(each.when, now)
        sent.last[each.when] = now


def _start(radar: int, radars: int) -> float:
    """Return when a radar passes north [s]."""
    return radar / radars * PERIOD


def _seen(
    radar: int, start: float, place: np.ndarray, velocity: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return when a turn's beam passes aircraft [s], their distance [m] and azimuth [rad]."""
    frame, centre = LocalFrame(*PLACE), _centre(radar)
    here, there, _ = frame.to_geodetic(centre[None])
    when = np.full(len(place), start)
    for _ in range(3):
        now = (place + velocity * when[:, None] + HALF_WIDTH) % (2 * HALF_WIDTH) - HALF_WIDTH
        latitude, longitude, _ = frame.to_geodetic(now)
        azimuth, _, distance = geodetic2aer(latitude, longitude, 0.0, here[0], there[0], 0.0)
        azimuth = np.radians(azimuth) % (2 * np.pi)
        when = start + azimuth / (2 * np.pi) * PERIOD
    return when, np.asarray(distance), azimuth


def _plots(radar: int, when: np.ndarray, distance: np.ndarray, azimuth: np.ndarray) -> bytes:
    rows = zip(when.tolist(), distance.tolist(), azimuth.tolist(), strict=True)
    return _block(48, b"".join(_plot(radar, MORNING + t, r, a) for t, r, a in rows))


def _plot(radar: int, time_: float, distance: float, azimuth: float) -> bytes:
    rho = int(distance / 1852.0 * 256.0 + 0.5) & 0xFFFF
    theta = int(azimuth / (2 * np.pi) * 65536.0 + 0.5) % 65536
    return (
        b"\xf0\x19"
        + bytes([radar])
        + int(time_ * 128.0).to_bytes(3, "big")
        + b"\x40"
        + (rho.to_bytes(2, "big") + theta.to_bytes(2, "big"))
    )


def _mark(radar: int, time_: float, sector: int) -> bytes:
    """Return a message of category 034: north, or the border at which a sector begins."""
    border = sector % SECTORS
    kind = 2 if border else 1
    return _block(
        34,
        b"\xf0\x19"
        + bytes([radar, kind])
        + int((MORNING + time_) * 128.0).to_bytes(3, "big")
        + bytes([border * 256 // SECTORS]),
    )


def _block(category: int, records: bytes) -> bytes:
    return bytes([category]) + (3 + len(records)).to_bytes(2, "big") + records


def _centre(radar: int) -> np.ndarray:
    return np.array([radar * 4e4, 0.0])
