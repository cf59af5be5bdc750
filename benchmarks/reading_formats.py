"""Formats: records a second that readers take, beside what users read them with today.

    python benchmarks/reading_formats.py

Real files over and over where there is one, samples else, and for documents and folders what our
own writers make of many tracks. Ours goes to checked columns of reports with units converted;
theirs to rows of whatever the file has.
"""

import argparse
import contextlib
import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import polars as pl
from bench_data import BESIDE
from reading_peers import PEERS
from text_tables import command, heading, table

from trackweave.formats.format import Decoder, Format, Output
from trackweave.formats.reading import load
from trackweave.formats.registry import formats

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from formats.samples import SAMPLES

CHUNK = 1 << 20
LEAST_BYTES = 8 << 20
REAL = {
    "nmea": "ais_pyais/tests/nmea_data_sample.txt",
    "kitti labels": "kitti/0000/labels.txt",
    "kitti detections": "kitti/0000/pointrcnn_Car.txt",
    "mot": "mot_tud_campus/dets/det/det.txt",
    "state table": "opensky/OpenSky_Plane_States.csv",
}
WITH_HEADER = {"state table"}
DOCUMENTS = ("coco", "trackmate", "ctc", "geff", "csv", "parquet")
# Others measure these: ASTERIX has a page of its own, and streams of CSV are for live inputs.
NOT_HERE = {"blocks", "capture", "csv lines", "nmea parts", "bare states"}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--recordings", type=Path, default=BESIDE / "data")
    parser.add_argument("--only", nargs="+", help="names of samples")
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as place:
        for name, known, path, read in _cases(arguments.recordings, Path(place)):
            if name not in (arguments.only or (name,)):
                continue
            count, rate = _rate(read)
            peer, theirs = PEERS.get(name, ("", None))
            said = ""
            if theirs is not None:
                data = path.read_bytes() if path.is_file() else b""
                said = f"{peer}: " + _theirs(lambda d=data, p=path, t=theirs: t(d, p))  # type: ignore[misc]
            rows.append([known, name, f"{count:,}", f"{rate:,.0f}", said])
    print(heading(command("reading_formats.py")), end="\n\n")
    head = ["format", "sample", "records", "records/s", "beside, records/s"]
    print(table(head, rows), flush=True)


def _cases(recordings: Path, place: Path) -> Iterator[tuple[str, str, Path, Callable[[], int]]]:
    """Yield each sample's name and format, a long file of it, and what reads that."""
    for name, (known, sample, *_) in SAMPLES.items():
        if name in NOT_HERE or name in DOCUMENTS:
            continue
        real = recordings / REAL.get(name, "none")
        data = real.read_bytes() if real.is_file() else sample
        if name == "json lines":  # others give up at the first line that is none
            data = b"\n".join(data.split(b"\n")[:2])
        head, _, rest = data.partition(b"\n") if name in WITH_HEADER else (b"", b"", data)
        rest = rest.rstrip(b"\n") + b"\n"
        data = (head + b"\n" if head else b"") + rest * (1 + LEAST_BYTES // (4 * len(rest)))
        path = place / name.replace(" ", "_")
        path.write_bytes(data)
        yield name, known, path, lambda d=data, k=known: _decoded(d, k)  # type: ignore[misc]
    for name in DOCUMENTS:
        path = _document(name, place)
        yield name, name, path, lambda p=path, n=name: len(load(p, n).columns)  # type: ignore[misc]


def _document(name: str, place: Path) -> Path:
    """Write many states as one document or folder; return where it is."""
    frames, cells = (20, 200) if name == "ctc" else (200, 200)
    frame, cell = (each.ravel() for each in np.mgrid[:frames, :cells])
    rows = pl.DataFrame(
        {"time": frame / 1.0, "track": cell + 1, "x": 12.0 + 20.0 * (cell % 20) + frame % 5,
         "y": 12.0 + 20.0 * (cell // 20) + frame % 7}
    ).sort("track", "time")  # fmt: skip
    if name == "coco":
        boxes = [
            {"id": k, "image_id": int(f), "category_id": 1, "bbox": [float(c), 2.0, 4.0, 8.0],
             "score": 0.5}
            for k, (f, c) in enumerate(zip(frame, cell, strict=True))
        ]  # fmt: skip
        images = [{"id": k, "frame_id": k} for k in range(frames)]
        kinds = [{"id": 1, "name": "person"}]
        files = {
            "tracks.json": json.dumps(
                {"images": images, "categories": kinds, "annotations": boxes}
            ).encode()
        }
    elif name in {"csv", "parquet"}:
        path = place / f"rows.{name}"
        rows.write_csv(path) if name == "csv" else rows.write_parquet(path)
        return path
    else:
        writer = formats()[name].writer
        assert writer is not None
        files = dict(writer(Output(rows)))
    for each, content in files.items():
        (place / each).parent.mkdir(parents=True, exist_ok=True)
        (place / each).write_bytes(content)
    return place / next(iter(files)).partition("/")[0]


def _decoded(data: bytes, known: str) -> int:
    """Return how many records a decoder takes; what it skips and leaves out are some."""
    decoder = _decoder(formats()[known])
    count = 0
    for place in range(0, len(data), CHUNK):
        found = decoder.feed(data[place : place + CHUNK])
        count += 0 if found is None else len(found)
    last = decoder.finish()
    count += (0 if last is None else len(last)) + decoder.skips.count
    return count + sum(decoder.facts.left_out.values())


def _rate(read: Callable[[], int]) -> tuple[int, float]:
    """Return records, and records a second of CPU, the better of two."""
    best, count = 0.0, 0
    for _ in range(2):
        begin = time.process_time()
        count = read()
        best = max(best, count / (time.process_time() - begin))
    return count, best


def _theirs(read: Callable[[], int]) -> str:
    with contextlib.suppress(ImportError):
        return f"{_rate(read)[1]:,.0f}"
    return "not installed"


def _decoder(known: Format) -> Decoder:
    assert known.decoder is not None
    return known.decoder()


if __name__ == "__main__":
    main()
