"""ASTERIX: records decoded per second beside libasterix, and what damaged input does.

    python benchmarks/asterix_speed.py
    python benchmarks/asterix_speed.py --mutants 100000

The records are those of the recordings beside the checkout, repeated, and made-up ones with fifty
choices of items. A mutant is a stream, a capture or a recorder's file with octets
changed, taken out and put in: it is decoded whole and in pieces, which must give the same.
"""

import argparse
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl
from bench_data import BESIDE
from text_tables import command, heading, table

from trackweave.formats.asterix.decoding import AsterixDecoder, categories_of
from trackweave.formats.asterix.gathering import Gathering
from trackweave.formats.asterix.packets import datagram
from trackweave.formats.format import Skips

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))
from oracles.asterix_records import block, ethernet, final, pcap, pcapng, random_record, udp

PIECES = (1 << 20, 1 << 16)
OCTETS = 6_000_000
FILES = ("cat_034_048.pcap", "cat062cat065.raw", "single_records/cat021ed2.1.bin", "cat21_re.ast")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shared", type=Path, default=BESIDE, help="folder of recordings")
    parser.add_argument("--mutants", type=int, default=0, help="damaged inputs to decode")
    arguments = parser.parse_args()
    print(heading(command("asterix_speed.py")), end="\n\n")
    if arguments.mutants:
        mutants(arguments.mutants)
    else:
        speeds(arguments.shared)


def speeds(shared: Path) -> None:
    head = ["records", "octets each", "in pieces of 1 MiB", "of 64 KiB", "libasterix (parsing)"]
    rows = list[list[str]]()
    for number, blocks in recorded(shared).items():
        rows.append(_speed(f"category {number:03d}, recorded", blocks))
    rng = np.random.default_rng(1)
    for number in (48, 21, 62):
        layout = categories_of()[number].layouts[0]
        made = [random_record(layout, rng) for _ in range(50)] * 100
        blocks = [block(number, *made[at : at + 5]) for at in range(0, len(made), 5)]
        rows.append(_speed(f"category {number:03d}, 50 choices of items", blocks))
    print("Records a second and core, from octets to a table of reports.", end="\n\n")
    print(table(head, rows))


def recorded(shared: Path) -> dict[int, list[bytes]]:
    """Return the data blocks of recordings by their category."""
    found: dict[int, list[bytes]] = {48: [], 21: [], 62: []}
    for name in FILES:
        content = (shared / "data" / "asterix" / name).read_bytes()
        for payload in _datagrams(content) if name.endswith(".pcap") else [content]:
            place = 0
            while place < len(payload):
                size = int.from_bytes(payload[place + 1 : place + 3], "big")
                found.setdefault(payload[place], []).append(payload[place : place + size])
                place += size
    return {number: found[number] for number in (48, 21, 62)}


def _datagrams(content: bytes) -> list[bytes]:
    found, place = list[bytes](), 24
    while place < len(content):
        stop = place + 16 + int.from_bytes(content[place + 8 : place + 12], "little")
        span = datagram(content, place + 16, stop, 1)
        assert isinstance(span, tuple)
        found.append(content[slice(*span)])
        place = stop
    return found


def _speed(name: str, blocks: list[bytes]) -> list[str]:
    data = b"".join(blocks)
    gathering = Gathering(data, 0, categories_of(), Skips(), {})
    gathering.payload(0, len(data))
    count = sum(reader.count for kinds in gathering.readers.values() for reader in kinds)
    octets = f"{len(data) / count:.0f}"
    theirs = _rate(lambda: _by_libasterix(blocks), count)
    data *= max(1, OCTETS // len(data))
    rates = []
    for size in PIECES:
        decoder = AsterixDecoder()
        begin = time.process_time()
        for place in range(0, len(data), size):
            decoder.feed(data[place : place + size])
        decoder.finish()
        rates.append(f"{decoder.n_records / (time.process_time() - begin):,.0f}")
        assert decoder.skips.count == 0
    return [name, octets, *rates, theirs]


def _by_libasterix(blocks: list[bytes]) -> None:
    import asterix.base as base

    from oracles import libasterix

    for each in blocks:
        profile = libasterix.specification(each[0]).cv_uap
        assert not isinstance(profile.parse(base.Bits.from_bytes(each[3:])), ValueError)


def _rate(run: Callable[[], None], count: int) -> str:
    try:
        run()
    except ImportError:
        return "not installed"
    begin, times = time.process_time(), 0
    while time.process_time() - begin < 1.0:
        run()
        times += 1
    return f"{times * count / (time.process_time() - begin):,.0f}"


def mutants(count: int) -> None:
    rng = np.random.default_rng(2)
    worst, faults, reports, begin = 0.0, 0, 0, time.process_time()
    for number in range(count):
        if number % 500 == 0:
            good = _good(rng)
        data = _damaged(good[number % len(good)], rng)
        start = time.process_time()
        skips, rows = _decoded([data])
        worst = max(worst, time.process_time() - start)
        if number % 10 == 0:
            cuts = np.sort(rng.integers(0, len(data), 5)).tolist()
            pieces = [data[a:b] for a, b in zip([0, *cuts], [*cuts, len(data)], strict=True)]
            assert _decoded(pieces) == (skips, rows)
        faults += skips.count > 0
        reports += len(rows)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    head = ["mutants", "with faults listed", "reports", "CPU s", "the slowest", "peak MB"]
    cells = [f"{count:,}", f"{faults:,}", f"{reports:,}", f"{time.process_time() - begin:.0f}",
             f"{worst:.2f} s", str(peak)]  # fmt: skip
    print(table(head, [cells]))


def _good(rng: np.random.Generator) -> list[bytes]:
    """Return one input of each kind, of some blocks of all categories."""
    blocks = [
        block(number, *(random_record(layout, rng) for _ in range(2)))
        for number, category in categories_of().items()
        for layout in category.layouts
    ]
    order = rng.permutation(len(blocks))[:4]
    some = [blocks[place] for place in order]
    packets = [(1.7e9, ethernet(udp(each))) for each in some]
    return [b"".join(some), final(*some), pcap(*packets), pcapng(*packets)]


def _damaged(good: bytes, rng: np.random.Generator) -> bytes:
    data = bytearray(good)
    for _ in range(int(rng.integers(1, 8))):
        place, size = int(rng.integers(len(data))), int(rng.integers(1, 30))
        kind = rng.integers(3)
        if kind == 0:
            data[place] = rng.integers(256)
        elif kind == 1 and len(data) > 60:
            del data[place : place + size]
        else:
            data[place:place] = rng.bytes(size)
    return bytes(data)


def _decoded(pieces: list[bytes]) -> tuple[Skips, list[tuple[object, ...]]]:
    """Return what is skipped, and the rows."""
    decoder = AsterixDecoder()
    tables = [decoder.feed(piece) for piece in pieces] + [decoder.finish()]
    rows = [
        (row["time"], row["sensor"], row["category"])
        for each in tables
        if each is not None
        for row in each.with_columns(
            sensor=pl.col("sensor") if "sensor" in each.columns else pl.lit(None)
        ).iter_rows(named=True)
    ]
    return decoder.skips, rows


if __name__ == "__main__":
    main()
