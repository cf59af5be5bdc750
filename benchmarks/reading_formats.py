"""Formats: records a second that decoders take, and damaged files that they have to bear."""

import argparse
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from bench_data import BESIDE
from text_tables import command, heading, table

from trackweave.errors import DataFormatError
from trackweave.formats.format import Decoder, Format
from trackweave.formats.registry import formats

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from formats.samples import SAMPLES

CHUNK = 1 << 20
LEAST_BYTES = 8 << 20
SLOWEST_S, MOST_BYTES = 2.0, 1 << 30
REAL = {
    "ais": "ais_pyais/tests/nmea_data_sample.txt",
    "kitti": "kitti/0000/labels.txt",
    "mot": "mot_tud_campus/dets/det/det.txt",
    "opensky": "opensky/OpenSky_Plane_States.csv",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=Path, default=BESIDE / "data")
    parser.add_argument("--fuzz", type=int, default=0, help="damaged files of each sample")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    print(heading(command("reading_formats.py")))
    print(table(["format", "records", "records/s"], speeds(arguments.recordings)), flush=True)
    if arguments.fuzz:
        rows = fuzz(arguments.fuzz, np.random.default_rng(arguments.seed))
        print(table(["sample", "files", "refused", "slowest s", "process MB"], rows))


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


def fuzz(n_files: int, rng: np.random.Generator) -> list[list[object]]:
    """Damage samples in many ways; complain of exceptions, slowness and thirst for memory."""
    rows: list[list[object]] = []
    for name, (known, data, *_) in SAMPLES.items():
        refused, slowest = 0, 0.0
        for _ in range(n_files):
            damaged = _damaged(data, rng)
            begun = time.process_time()
            refused += _is_refused(lambda: _decoder(formats()[known]), damaged, rng)  # noqa: B023
            slowest = max(slowest, time.process_time() - begun)
        most = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        if slowest > SLOWEST_S or most > MOST_BYTES:
            raise SystemExit(f"{name}: {slowest:.1f} s, {most / 1e6:.0f} MB")
        rows.append([name, n_files, refused, f"{slowest:.3f}", f"{most / 1e6:.1f}"])
    return rows


def _decoder(known: Format) -> Decoder:
    assert known.decoder is not None
    return known.decoder(**known.settings())


def _damaged(data: bytes, rng: np.random.Generator) -> bytes:
    content = bytearray(data * int(rng.integers(1, 4)))
    for _ in range(int(rng.integers(1, 9))):
        place = int(rng.integers(len(content)))
        how = rng.integers(5)
        if how == 0:
            content[place] = int(rng.integers(256))
        elif how == 1:
            del content[place : place + int(rng.integers(1, 40))]
        elif how == 2:
            content[place:place] = rng.bytes(int(rng.integers(1, 40)))
        elif how == 3:
            content[place:place] = content[place : place + 200]
        else:
            content[place:place] = rng.choice([b"nan", b"1e999", b"-0", b'"', b"\n", b"9" * 400])
        if not content:
            break
    return bytes(content)


def _is_refused(make: Callable[[], Decoder], data: bytes, rng: np.random.Generator) -> bool:
    """Decode in random pieces; tell whether the document was refused as a whole."""
    decoder = make()
    ends = np.sort(rng.integers(0, len(data) + 1, int(rng.integers(0, 6))))
    try:
        for begin, end in zip([0, *ends], [*ends, len(data)], strict=True):
            decoder.feed(data[begin:end])
        decoder.finish()
    except DataFormatError:
        return True
    return False


if __name__ == "__main__":
    main()
