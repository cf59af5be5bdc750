"""ASTERIX category 048: what air surveillance radars send → reports.

    pip install asterix_decoder
    python examples/radar_asterix.py recorded.pcap OUT
    trackweave track OUT/reports.csv --config OUT/tracker.toml --out OUT/result

The file is raw ASTERIX, or a capture of the network (.pcap) with ASTERIX in its UDP packets; a
record that was captured twice counts once. Each radar is a sensor, named by its codes, such as
25-201. Records do not say where a radar stands: enter it in tracker.toml as
[sensors.25-201] position = [x, y]. A flight level becomes ``height_m``, the address of the
aircraft ``identity``.
"""

import argparse
import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import polars as pl

try:
    import asterix
except ImportError:
    sys.exit("examples/radar_asterix.py needs a package: pip install asterix_decoder")

NAUTICAL_MILE_M = 1852.0
FLIGHT_LEVEL_M = 30.48
DAY_S = 86400.0
REPORTS = {
    "time": pl.Float64, "sensor": pl.String, "range_m": pl.Float64, "azimuth_deg": pl.Float64,
    "height_m": pl.Float64, "identity": pl.String,
}  # fmt: skip


def read(path: Path) -> pl.DataFrame:
    """Return the plots, times in seconds from midnight of the first day."""
    seen, rows = set(), []
    for block in _blocks(path.read_bytes()):
        for record in asterix.parse(block, verbose=False):
            key = record.get("hexdata")
            if record["category"] != 48 or key in seen:
                continue
            seen.add(key)
            if {"I010", "I040", "I140"} <= record.keys():
                rows.append(_row(record))
    days = 0.0
    for place in range(1, len(rows)):
        # The time of day starts again at midnight.
        days += DAY_S * (rows[place][0] + days < rows[place - 1][0] - DAY_S / 2)
        rows[place] = (rows[place][0] + days, *rows[place][1:])
    return pl.DataFrame(rows, REPORTS, orient="row").sort("time", maintain_order=True)


def _row(record: dict[str, Any]) -> tuple[Any, ...]:
    radar, place = record["I010"], record["I040"]
    level = record.get("I090", {}).get("FL", {}).get("val")
    return (
        record["I140"]["ToD"]["val"],
        f"{radar['SAC']['val']}-{radar['SIC']['val']}",
        place["RHO"]["val"] * NAUTICAL_MILE_M,
        place["THETA"]["val"] % 360.0,
        None if level is None else level * FLIGHT_LEVEL_M,
        record.get("I220", {}).get("ACAddr", {}).get("val"),
    )


def _blocks(content: bytes) -> Iterator[bytes]:
    """Yield ASTERIX: the file itself, or what each UDP packet of a capture carries."""
    if content[:4] not in (b"\xd4\xc3\xb2\xa1", b"\xa1\xb2\xc3\xd4"):
        yield content
        return
    order = "<" if content[0] == 0xD4 else ">"
    place = 24
    while place + 16 <= len(content):
        (length,) = struct.unpack_from(order + "I", content, place + 8)
        packet = content[place + 16 : place + 16 + length]
        place += 16 + length
        # Ethernet, IPv4 with its own length, UDP.
        if packet[12:14] == b"\x08\x00" and packet[23] == 17:
            yield packet[14 + 4 * (packet[14] & 15) + 8 :]


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("recording", type=Path, help="raw ASTERIX or a .pcap")
    parser.add_argument("out", type=Path, help="folder for reports.csv")
    arguments = parser.parse_args()
    if not arguments.recording.exists():
        sys.exit(f"{arguments.recording}: not there; expected ASTERIX")
    reports = read(arguments.recording)
    if reports.is_empty():
        sys.exit(f"{arguments.recording}: no plots of category 048 with radar, place and time")
    arguments.out.mkdir(parents=True, exist_ok=True)
    reports.write_csv(arguments.out / "reports.csv")
    print(f"{len(reports)} plots of radars {', '.join(reports['sensor'].unique().sort())}")


if __name__ == "__main__":
    main()
