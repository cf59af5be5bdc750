"""Comma-separated values: files are tables of ``trackweave.io``, streams come line by line."""

from trackweave.formats.csv_stream import CsvDecoder
from trackweave.formats.format import Format, Output
from trackweave.io.encoding import encode_table

__all__ = ["FORMAT"]

_TIMES = {b"time", b"t", b"frame", b"timestamp", b"datetime"}


def _recognise(head: bytes, name: str) -> bool:
    if name.lower().endswith((".csv", ".csv.gz", ".tsv", ".tsv.gz")):
        return True
    first = head.removeprefix(b"\xef\xbb\xbf").partition(b"\n")[0]
    names = {cell.strip().strip(b'"').lower() for cell in first.replace(b"\t", b",").split(b",")}
    return len(names) > 1 and bool(names & _TIMES)


def _write(output: Output) -> dict[str, bytes]:
    return {"tracks.csv": encode_table(output.tracks, "tracks.csv")}


FORMAT = Format(
    name="csv",
    title="Comma-separated values",
    endings=(".csv", ".csv.gz"),
    carries="every column of reports and tracks",
    loses="nothing",
    recognise=_recognise,
    is_table=True,
    decoder=CsvDecoder,
    writer=_write,
)
