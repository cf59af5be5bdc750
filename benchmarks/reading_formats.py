"""Formats: records a second that decoders take."""

import argparse
import sys
import time
from pathlib import Path

from bench_data import BESIDE
from text_tables import command, heading, table

from trackweave.formats.format import Decoder, Format
from trackweave.formats.registry import formats

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from formats.samples import SAMPLES

CHUNK = 1 << 20
LEAST_BYTES = 8 << 20
REAL = {
    "ais": "ais_pyais/tests/nmea_data_sample.txt",
    "kitti": "kitti/0000/labels.txt",
    "mot": "mot_tud_campus/dets/det/det.txt",
    "opensky": "opensky/OpenSky_Plane_States.csv",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=Path, default=BESIDE / "data")
    arguments = parser.parse_args()
    print(heading(command("reading_formats.py")))
    print(table(["format", "records", "records/s"], speeds(arguments.recordings)), flush=True)


def speeds(recordings: Path) -> list[list[object]]:
    """Return CPU rates of one core on real files, or samples, over and over."""
    rows: list[list[object]] = []
    for name, (known, sample, *_) in SAMPLES.items():
        path = recordings / REAL.get(known, "none")
        real = path.is_file() and known not in {row[0] for row in rows}
        data = path.read_bytes() if real else sample
        if known in {"coco", "trackmate"}:
            continue  # documents, which do not repeat
        data = (data + b"\n") * (1 + LEAST_BYTES // (4 * len(data)))
        decoder = _decoder(formats()[known])
        begun, count = time.process_time(), 0
        for place in range(0, len(data), CHUNK):
            found = decoder.feed(data[place : place + CHUNK])
            count += 0 if found is None else len(found)
        last = decoder.finish()
        count += (0 if last is None else len(last)) + decoder.skips.count
        spent = time.process_time() - begun
        rows.append([known if real else name, count, f"{count / spent:,.0f}"])
    return rows


def _decoder(known: Format) -> Decoder:
    assert known.decoder is not None
    return known.decoder(**known.settings())


if __name__ == "__main__":
    main()
