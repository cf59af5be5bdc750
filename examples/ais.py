r"""AIS: what ships say of themselves by radio, as NMEA sentences → reports.

    pip install pyais
    python examples/ais.py received.nmea OUT
    trackweave track OUT/reports.csv --out OUT/result

A sentence does not say when it was received. Receivers write that before it, as a tag block
(\c:1609841515*5A\!AIVDM,...) or a line of its own ($PGHP,...); sentences without either are left
out and counted. The ship's number, the MMSI, becomes ``identity``, which a tracker uses as
evidence; with ``--hide-identities`` it becomes ``target``, the truth, which no tracker reads.
"""

import argparse
import sys
from collections.abc import Iterator
from datetime import UTC
from pathlib import Path
from typing import Any

import polars as pl

try:
    from pyais import FileReaderStream
except ImportError:
    sys.exit("examples/ais.py needs the package pyais: pip install pyais")

POSITIONS = {1, 2, 3, 18, 19, 27}  # message types that hold a ship's own position
REPORTS = {"time": pl.Float64, "lat": pl.Float64, "lon": pl.Float64, "identity": pl.String}


def read(path: Path) -> tuple[pl.DataFrame, int]:
    """Return the reports, and how many positions had no time."""
    rows = list(_rows(path))
    timed = [row for row in rows if row[0] is not None]
    # Several stations hear one message; the second copy tells nothing new.
    reports = pl.DataFrame(timed, REPORTS, orient="row").unique(maintain_order=True)
    return reports.sort("time", maintain_order=True), len(rows) - len(timed)


def _rows(path: Path) -> Iterator[tuple[float | None, float, float, str]]:
    with FileReaderStream(str(path)) as sentences:
        for sentence in sentences:
            try:
                message = sentence.decode()
            except Exception:  # garbled sentences are radio's daily bread
                continue
            if message.msg_type not in POSITIONS:
                continue
            # 91 and 181 degrees say that the ship does not know.
            if abs(message.lat) <= 90 and abs(message.lon) <= 180:
                yield _time_of(sentence), message.lat, message.lon, str(message.mmsi)


def _time_of(sentence: Any) -> float | None:
    """Return when a sentence was received [s since 1970], None where nothing says it."""
    if sentence.tag_block is not None:
        sentence.tag_block.init()
        if sentence.tag_block.receiver_timestamp:
            return float(sentence.tag_block.receiver_timestamp)
    if sentence.wrapper_msg is not None:
        return sentence.wrapper_msg.timestamp.replace(tzinfo=UTC).timestamp()
    return None


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("recording", type=Path, help="file of NMEA sentences")
    parser.add_argument("out", type=Path, help="folder for reports.csv")
    parser.add_argument("--hide-identities", action="store_true", help="as truth, not as evidence")
    arguments = parser.parse_args()
    if not arguments.recording.exists():
        sys.exit(f"{arguments.recording}: not there; expected a file of NMEA sentences")
    reports, n_untimed = read(arguments.recording)
    if reports.is_empty():
        sys.exit(f"{arguments.recording}: {n_untimed} positions, none with a time of receipt")
    if arguments.hide_identities:
        reports = reports.rename({"identity": "target"})
    arguments.out.mkdir(parents=True, exist_ok=True)
    reports.write_csv(arguments.out / "reports.csv")
    print(f"{len(reports)} reports; {n_untimed} positions without a time left out")


if __name__ == "__main__":
    main()
