"""Damaged files of every format: no traceback, no hang, bounded memory, nothing silently lost.

    python benchmarks/damaged_files.py --files 40000

Samples are changed by octets put in, taken out, replaced and repeated. Each goes through its
decoder, or its folder's or table's reader, whole. Of every tenth, three more things are asked:
that pieces give what the whole gives; that the file, read as ``track`` reads it, becomes reports
or one message; and that what follows the damage is either read or counted as skipped.
"""

import argparse
import gzip
import logging
import multiprocessing
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
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
from text_tables import command, heading, table

from trackweave.errors import InvalidInputError
from trackweave.formats.format import Output
from trackweave.formats.reading import read_reports
from trackweave.formats.registry import format_named

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from formats.samples import SAMPLES

EVERY, SLOWEST_S, HANGS_S, MOST_MB = 10, 2.0, 60, 1024
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
# One after the other they are no such file, or have a context of their own.
NOT_APPENDED = {"trackmate", "coco"}
# What one snapshot repeats of the one before counts once.
COUNTS_ONCE = {"aircraft"}
FOLDERS = ("ctc", "geff")
LOT = 200
"""Files of Parquet that one process reads."""
WORDS = (b"nan", b"1e999", b"-0", b'"', b"\n", b"9" * 400, b"{", b"[[", b"\xff\xfe", b",")


@dataclass
class Found:
    """What came of the damaged files of a sample."""

    files: int = 0
    refused: int = 0
    skipped: int = 0
    reports: int = 0
    slowest: float = 0.0
    wrong: list[str] = field(default_factory=list)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--files", type=int, default=40_000, help="of all formats together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", help="names of samples")
    parser.add_argument("--processes", type=int, default=2)
    arguments = parser.parse_args()
    # ASTERIX has mutants of its own, in asterix_speed.py.
    streams = [name for name, (known, *_) in SAMPLES.items() if known != "asterix"]
    shares = {**dict.fromkeys((*streams, "csv", "parquet"), 4.0), "csv.gz": 1.0}
    shares |= dict.fromkeys(FOLDERS, 1.0)
    shares = {name: n for name, n in shares.items() if name in (arguments.only or shares)}
    unit = arguments.files / sum(shares.values())
    jobs = [(name, round(unit * share), arguments.seed) for name, share in shares.items()]
    with ThreadPoolExecutor(arguments.processes) as pool:
        found = []
        for (name, *_), one in zip(jobs, pool.map(_alone, jobs), strict=True):
            print(name, one, file=sys.stderr, flush=True)
            found.append(one)
    print(heading(command("damaged_files.py")), end="\n\n")
    rows = [
        [name, f"{one.files:,}", f"{one.refused:,}", f"{one.skipped:,}", f"{one.reports:,}",
         f"{one.slowest:.2f}", f"{most:.0f}"]
        for (name, *_), (one, most) in zip(jobs, found, strict=True)
    ]  # fmt: skip
    rows.append(["**all**", f"{sum(one.files for one, _ in found):,}", *[""] * 5])
    head = ["sample", "files", "refused", "with skips counted", "reports", "slowest CPU s"]
    print(table([*head, "process MB"], rows))
    wrong = [line for one, _ in found for line in one.wrong]
    if wrong:
        raise SystemExit("\n".join(wrong[:40]))


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
        whole.files += one.files
        whole.refused += one.refused
        whole.skipped += one.skipped
        whole.reports += one.reports
        whole.wrong += one.wrong
        whole.slowest, most = max(whole.slowest, one.slowest), max(most, memory)
    return whole, most


def _fuzzed(job: tuple[str, int, int]) -> tuple[Found, float]:
    return fuzzed(*job)


def fuzzed(name: str, count: int, seed: int) -> tuple[Found, float]:
    """Damage a sample many times; return what came of it, and the process's peak memory [MB]."""
    rng, found = np.random.default_rng([seed, *name.encode()]), Found()
    signal.signal(signal.SIGALRM, _hangs)
    logging.disable(logging.CRITICAL)  # libraries complain of what they raise
    with tempfile.TemporaryDirectory() as place:
        try_one = _trial(name, Path(place))
        for number in range(count):
            state = rng.bit_generator.state
            signal.alarm(HANGS_S)
            begin = time.process_time()
            try:
                try_one(rng, found, number % EVERY == 0)
            except Exception as err:  # whatever it is, it should have been a message
                told = " ".join(f"{type(err).__name__}: {err}".split())[:160]
                found.wrong.append(f"{name}, file {number}: {told} ({state['state']})")
            signal.alarm(0)
            found.slowest = max(found.slowest, time.process_time() - begin)
            found.files += 1
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    if most > MOST_MB or found.slowest > SLOWEST_S:
        found.wrong.append(f"{name}: {most:.0f} MB, slowest {found.slowest:.1f} s")
    return found, most


def _hangs(*_: Any) -> None:
    raise TimeoutError(f"nothing after {HANGS_S} s")


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
    data = damaged(sample, rng)
    whole = _decoded(known, [data])
    if whole is None:
        found.refused += 1
    else:
        found.reports += whole[0]
        found.skipped += whole[1] > 0
    if not is_thorough:
        return
    ends = np.sort(rng.integers(0, len(data) + 1, 5)).tolist()
    pieces = [data[a:b] for a, b in zip([0, *ends], [*ends, len(data)], strict=True)]
    if _decoded(known, pieces) != whole:
        raise AssertionError("pieces give other reports than the whole")
    _read(_written(place / "stream", data), known)
    if name in NOT_APPENDED or whole is None:
        return
    alone, more = _decoded(known, [sample]), _decoded(known, [data, b"\n", sample])
    assert alone is not None
    # A record that the end cuts off is skipped, and takes with it what follows up to its end.
    if more is None or whole[3] or more[1] > whole[1] + alone[1]:
        return
    need = Counter(alone[2])
    have = Counter(more[2]) if name in COUNTS_ONCE else Counter(more[2]) - Counter(whole[2])
    if set(need) - set(have) or (need - have and name not in COUNTS_ONCE):
        raise AssertionError(f"what follows is lost and not counted: {data!r:.60}")


def _decoded(known: str, pieces: list[bytes]) -> tuple[int, int, list[Any], bool] | None:
    """Return reports, skips, positions, and whether the end cuts a record off; None if refused."""
    form = format_named(known)
    assert form.decoder is not None
    decoder = form.decoder(**form.settings())
    try:
        frames = [decoder.feed(piece) for piece in pieces]
        before = decoder.skips.count
        frames.append(decoder.finish())
    except InvalidInputError:
        return None
    tables = [frame for frame in frames if frame is not None]
    positions = [position for each in tables for position in _positions(each)]
    skips = decoder.skips.count
    return sum(map(len, tables)), skips, positions, skips > before


def _positions(found: pl.DataFrame) -> list[Any]:
    """Return the places of all reports, null where a column is not there: of a piece some are."""
    names = ("lat", "lon", "x", "y", "range_m", "azimuth_deg")
    none = pl.repeat(None, len(found), dtype=pl.Float64, eager=True)
    columns = [
        found[name].cast(pl.Float64, strict=False) if name in found.columns else none
        for name in names
    ]
    return list(zip(*columns, strict=True))


def _try_table(
    data: bytes, path: Path, rng: np.random.Generator, found: Found, is_thorough: bool
) -> None:
    content = damaged(data, rng)
    if is_thorough and path.name.endswith(".gz"):
        content = gzip.compress(damaged(gzip.decompress(data), rng))
    table = _read(_written(path, content), None)
    if table is None:
        found.refused += 1
        return
    found.reports += len(table)
    found.skipped += bool(table.skipped)
    if is_thorough and path.suffix == ".csv" and b'"' not in content and b"\r" not in content:
        # Every line with something in it is a report, or is told.
        lines = sum(bool(line.strip()) for line in content.split(b"\n")) - 1
        told = len(table) + len(table.skipped)
        told += len(table.unavailable) if table.unavailable is not None else 0
        if told < lines:
            raise AssertionError(f"{lines} lines, {told} told: {content!r:.60}")


def _try_folder(
    name: str, place: Path, rng: np.random.Generator, found: Found, is_thorough: bool
) -> None:
    writer = format_named(name, writes=True).writer
    assert writer is not None
    files = dict(writer(Output(CELLS)))
    chosen = list(files)[int(rng.integers(len(files)))]
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


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Return data with octets put in, taken out, replaced and repeated, or an end missing."""
    content = bytearray(data * int(rng.integers(1, 4)) if rng.random() < 0.5 else data)
    for _ in range(int(rng.integers(1, 9))):
        place, how = int(rng.integers(len(content))), rng.integers(7)
        if how == 0:
            content[place] = int(rng.integers(256))
        elif how == 1:
            del content[place : place + int(rng.integers(1, 40))]
        elif how == 2:
            content[place:place] = rng.bytes(int(rng.integers(1, 40)))
        elif how == 3:
            content[place:place] = content[place : place + 200]
        elif how == 4:
            content[place] ^= 1 << int(rng.integers(8))
        elif how == 5 and rng.random() < 0.2:
            del content[place:]
        else:
            content[place:place] = WORDS[int(rng.integers(len(WORDS)))]
        if not content:
            break
    return bytes(content)


if __name__ == "__main__":
    main()
