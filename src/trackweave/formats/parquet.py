"""Apache Parquet, whose columns ``trackweave.io`` reads and writes."""

from trackweave.formats.format import Format, Output
from trackweave.io.encoding import encode_table

__all__ = ["FORMAT"]


def _recognise(head: bytes, name: str) -> bool:
    return head[:4] == b"PAR1" or name.lower().endswith(".parquet")


def _write(output: Output) -> dict[str, bytes]:
    return {"tracks.parquet": encode_table(output.tracks, "tracks.parquet")}


FORMAT = Format(
    name="parquet",
    title="Apache Parquet",
    endings=(".parquet",),
    carries="every column of reports and tracks, with its type",
    loses="nothing",
    recognise=_recognise,
    is_table=True,
    writer=_write,
)
