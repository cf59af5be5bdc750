"""Damaged files of every format: no traceback, no hang, bounded memory, nothing silently lost.

    python benchmarks/damaged_files.py --each 100000

Samples are changed by octets and by what texts are made of, put in, taken out, replaced, repeated
and moved, by numbers that none expects, and by other encodings. Each goes through its decoder, or
its folder's or table's reader. Where records are lines, a hundred damaged samples are a stream,
which is decoded whole and in pieces split anywhere; the counts of what is read, skipped and left
out are those of the lines. Every eighth trial is of one sample, of which more is asked: that
pieces give what the whole gives; that the file, read as ``track`` reads it, becomes reports or one
message; and that what follows the damage is either read or counted as skipped.
"""

import argparse
import gzip
import logging
import multiprocessing
import os
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from damaged_kinds import damaged, odd_table
from damaged_streams import LINES, Sample, ask_more, decoded, joined, untold
from text_tables import command, heading, table

from trackweave.errors import InvalidInputError
from trackweave.formats.format import Output
from trackweave.formats.reading import read_reports
from trackweave.formats.registry import format_named

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from formats.samples import SAMPLES

SLOWEST_S, HANGS_S, HANGS_CPU_S, MOST_MB = 2.0, 900, 20, 1024
EVERY = 8
"""Of so many trials one asks more, and is of a single sample."""
STREAM, SPLITS = 100, 12
"""Samples in a stream, and where it is split into pieces."""
REPORTS = pl.DataFrame(
    {
        "time": [0.0, 1.0, 2.0, 3.0], "sensor": ["north", "south", "north", "a, b"],
        "x": [1.0, 2.5, -3e3, 4.0], "y": [5.0, 6.0, 7.25, 8.0], "sigma_x": [None, 1.0, 2.0, 3.0],
        "sigma_y": [None, 1.0, 2.0, 3.0], "identity": ["4ca2d6", None, 'a "b"', "x"],
    }
)  # fmt: skip
CELLS = pl.DataFrame(
    {"time": [0.0, 1.0, 2.0, 2.0], "track": [1, 1, 2, 3], "parent": [None, None, 1, 1],
     "x": [9.0, 9.5, 14.0, 6.0], "y": [9.0] * 4}
)  # fmt: skip
FOLDERS = ("ctc", "geff")
LOT = 200
"""Files of Parquet that one process reads."""
SHARE = {
    "nmea": 0.5, "nmea parts": 0.5, "aircraft": 0.34, "aircraft lines": 0.34, "trace": 0.34,
    "states": 0.34, "bare states": 0.34, "state table": 0.34, "kitti detections": 0.5,
    "kitti labels": 0.5, "csv lines": 0.1, "csv": 0.3, "csv.gz": 0.2, "parquet": 0.1, "ctc": 0.05,
    "geff": 0.03,
}  # fmt: skip
"""Samples of one format share; where a library's own reader takes the time, there are fewer."""


@dataclass
class Found:
    """What came of the damaged files of a sample."""

    files: int = 0
    refused: int = 0
    reports: int = 0
    skipped: int = 0
    left_out: int = 0
    slowest: float = 0.0
    seconds: float = 0.0
    wrong: list[str] = field(default_factory=list)

    def take(self, other: "Found") -> None:
        """Add what came of others."""
        for name in ("files", "refused", "reports", "skipped", "left_out", "seconds", "wrong"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        self.slowest = max(self.slowest, other.slowest)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--each", type=int, default=2_000, help="damaged samples of each format")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", help="names of samples")
    parser.add_argument("--processes", type=int, default=1)
    arguments = parser.parse_args()
    os.environ["POLARS_MAX_THREADS"] = "1"  # of the processes to come: tables of a few rows
    # ASTERIX has mutants of its own, in asterix_speed.py.
    names = [name for name, (known, *_) in SAMPLES.items() if known != "asterix"]
    names = [name for name in (*names, "csv", "csv.gz", "parquet", *FOLDERS)
             if name in (arguments.only or name)]  # fmt: skip
    jobs = [(name, round(arguments.each * SHARE.get(name, 1.0)), arguments.seed) for name in names]
    with ThreadPoolExecutor(arguments.processes) as pool:
        found = []
        for name, one in zip(names, pool.map(_alone, jobs), strict=True):
            print(name, one, file=sys.stderr, flush=True)
            found.append(one)
    print(heading(command("damaged_files.py")), end="\n\n")
    rows = [
        [
            SAMPLES.get(name, (name,))[0].partition(".")[0],
            name,
            *map(_thousands, (one.files, one.refused, one.reports, one.skipped, one.left_out)),
            f"{one.slowest:.2f}", f"{one.seconds:.0f}", f"{most:.0f}",
        ]
        for name, (one, most) in zip(names, found, strict=True)
    ]  # fmt: skip
    rows.append(["**all**", "", f"{sum(one.files for one, _ in found):,}", *[""] * 7])
    head = ["format", "sample", "damaged", "refused", "reports", "skipped", "left out"]
    print(table([*head, "slowest CPU s", "CPU s", "process MB"], rows))
    wrong = [line for one, _ in found for line in one.wrong]
    if wrong:
        raise SystemExit("\n".join(wrong[:40]))


def _thousands(number: int) -> str:
    return f"{number:,}"


def _alone(job: tuple[str, int, int]) -> tuple[Found, float]:
    """Fuzz a sample in processes of its own; so is their peak memory, and their death."""
    name, count, seed = job
    context, whole, most = multiprocessing.get_context("spawn"), Found(), 0.0
    # What has ended a process takes with it what it had not told yet.
    lot = LOT if name == "parquet" else count
    for number, begin in enumerate(range(0, count, lot)):
        part = (name, min(lot, count - begin), seed + 1000 * number)
        with ProcessPoolExecutor(1, mp_context=context) as pool:
            try:
                one, memory = pool.submit(_fuzzed, part).result()
            except BrokenProcessPool:
                whole.wrong.append(f"{name}, {part[1]} files of seed {part[2]}: the process died")
                continue
        whole.take(one)
        most = max(most, memory)
    return whole, most


def _fuzzed(job: tuple[str, int, int]) -> tuple[Found, float]:
    for each in (signal.SIGALRM, signal.SIGPROF):
        signal.signal(each, _hangs)
    logging.disable(logging.CRITICAL)  # libraries complain of what they raise
    return fuzzed(*job)


def fuzzed(name: str, count: int, seed: int) -> tuple[Found, float]:
    """Damage a sample many times; return what came of it, and the process's peak memory [MB]."""
    rng, found = np.random.default_rng([seed, *name.encode()]), Found()
    begun, before = time.process_time(), _peak_mb()
    with tempfile.TemporaryDirectory() as place:
        try_one, number = _trial(name, Path(place)), 0
        while found.files < count:
            # By the clock only what waits for nothing: others may have the machine meanwhile.
            signal.alarm(HANGS_S)
            signal.setitimer(signal.ITIMER_PROF, HANGS_CPU_S)
            begin = time.process_time()
            try:
                try_one(rng, found, number % EVERY == 0)
            except Exception as err:  # whatever it is, it should have been a message
                told = " ".join(f"{type(err).__name__}: {err}".split())[:300]
                found.wrong.append(f"{name}, trial {number}: {told}")
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            signal.alarm(0)
            found.slowest = max(found.slowest, time.process_time() - begin)
            number += 1
    found.seconds = time.process_time() - begun
    most = _peak_mb()
    # What a process used before it damaged anything is not of the damage.
    if most - before > MOST_MB or found.slowest > SLOWEST_S:
        found.wrong.append(f"{name}: {most:.0f} MB, slowest {found.slowest:.1f} s")
    return found, most


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _hangs(*_: Any) -> None:
    raise TimeoutError(f"nothing after {HANGS_CPU_S} s of CPU, or {HANGS_S} s")


def _trial(name: str, place: Path) -> Callable[[np.random.Generator, Found, bool], None]:
    """Return what damages a sample once and reads it."""
    if name in FOLDERS:
        return partial(_try_folder, name, place)
    if name in SAMPLES:
        return partial(_try_stream, name, place)
    buffer = BytesIO()
    REPORTS.write_parquet(buffer) if name == "parquet" else REPORTS.write_csv(buffer)
    data = gzip.compress(buffer.getvalue()) if name == "csv.gz" else buffer.getvalue()
    return partial(_try_table, data, place / f"reports.{name}")


def _try_stream(
    name: str, place: Path, rng: np.random.Generator, found: Found, is_thorough: bool
) -> None:
    known, sample, *_ = SAMPLES[name]
    count = STREAM if name in LINES and not is_thorough else 1
    data = joined(sample, count, rng)
    found.files += count
    whole = decoded(known, [data])
    if whole is None:
        found.refused += count
    else:
        found.take(Found(0, 0, whole.reports, whole.skips, whole.left_out))
        if wrong := untold(name, data, whole):
            raise AssertionError(f"{wrong}: {data!r:.90}")
    if is_thorough:
        ask_more(Sample(name, known, sample), data, whole, rng)
        _read(_written(place / "stream", data), known)
    elif count > 1:
        ends = np.sort(rng.integers(0, len(data) + 1, SPLITS)).tolist()
        pieces = [data[a:b] for a, b in zip([0, *ends], [*ends, len(data)], strict=True)]
        parts = decoded(known, pieces)
        if (parts and parts.told) != (whole and whole.told):
            raise AssertionError("pieces of a stream give other reports than the whole")


def _try_table(
    data: bytes, path: Path, rng: np.random.Generator, found: Found, is_thorough: bool
) -> None:
    is_odd = rng.random() < 0.5
    if is_odd and path.suffix == ".parquet":
        content = odd_table(REPORTS, rng)
    elif is_odd and path.suffix == ".gz":
        content = gzip.compress(damaged(gzip.decompress(data), rng), 1)
    else:
        content = damaged(data, rng)
    found.files += 1
    table = _read(_written(path, content), None)
    if table is None:
        found.refused += 1
        return
    found.reports += len(table)
    unavailable = len(table.unavailable) if table.unavailable is not None else 0
    found.skipped += len(table.skipped)
    found.left_out += unavailable
    if is_odd and path.suffix == ".parquet":
        there = len(pl.read_parquet(BytesIO(content)))
        if len(table) + len(table.skipped) + unavailable != there:
            raise AssertionError(f"{there} rows, {len(table)} read, {len(table.skipped)} skipped")
    if path.suffix == ".csv" and b'"' not in content and b"\r" not in content:
        # Every line with something in it is a report, or is told.
        lines = sum(bool(line.strip()) for line in content.split(b"\n")) - 1
        told = len(table) + len(table.skipped) + unavailable
        if told < lines:
            raise AssertionError(f"{lines} lines, {told} told: {content!r:.60}")


def _try_folder(
    name: str, place: Path, rng: np.random.Generator, found: Found, is_thorough: bool
) -> None:
    writer = format_named(name, writes=True).writer
    assert writer is not None
    files = dict(writer(Output(CELLS)))
    chosen = list(files)[int(rng.integers(len(files)))]
    found.files += 1
    folder = place / next(iter(files)).partition("/")[0]
    shutil.rmtree(folder, ignore_errors=True)
    for each, content in files.items():
        (place / each).parent.mkdir(parents=True, exist_ok=True)
        if each != chosen or rng.random() < 0.9:  # else it is not there
            (place / each).write_bytes(damaged(content, rng) if each == chosen else content)
    table = _read(folder, name if is_thorough else None)
    found.refused += table is None
    found.reports += 0 if table is None else len(table)


def _written(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


def _read(path: Path, told: str | None) -> Any:
    """Return the reports of a file as ``track`` reads it; None where it is refused."""
    try:
        return read_reports(path, told=told, on_bad_row="skip")
    except InvalidInputError as err:
        if not str(err) or "\n" in str(err):
            raise AssertionError(f"a message of no line or of several: {str(err)!r:.80}") from err
        return None


if __name__ == "__main__":
    main()
