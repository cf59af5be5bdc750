"""What users read each format with today, as a function of a file's bytes or path."""

import contextlib
import io
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

__all__ = ["PEERS", "Peer"]

Peer = tuple[str, Callable[[bytes, Path], int]]
"""What it is, and how many records it makes of a file's bytes; the path is the same file."""


def _pandas(**options: Any) -> Callable[[bytes, Path], int]:
    def read(data: bytes, path: Path) -> int:
        import pandas

        return len(pandas.read_csv(io.BytesIO(data), **options))

    return read


def _pyais(data: bytes, path: Path) -> int:
    from pyais.stream import FileReaderStream

    count = 0
    for message in FileReaderStream(str(path)):
        with contextlib.suppress(Exception):  # what it cannot decode counts as read, as ours does
            message.decode()
        count += 1
    return count


def _snapshots(data: bytes, path: Path) -> int:
    import pandas

    rows = []
    for value in _values(data):
        now = value.get("now")
        rows += [{**each, "now": now} for each in value.get("aircraft", [value])]
    return len(pandas.DataFrame(rows))


def _states(data: bytes, path: Path) -> int:
    import pandas

    return len(pandas.DataFrame([row for value in _values(data) for row in value["states"]]))


def _values(data: bytes) -> Iterator[Any]:
    """Yield JSON values that stand one after the other."""
    text, place, decoder = data.decode().strip(), 0, json.JSONDecoder()
    while place < len(text):
        value, place = decoder.raw_decode(text, place)
        yield value
        while place < len(text) and text[place].isspace():
            place += 1


def _parquet(data: bytes, path: Path) -> int:
    import pandas

    return len(pandas.read_parquet(path))


def _json_lines(data: bytes, path: Path) -> int:
    import pandas

    return len(pandas.read_json(io.BytesIO(data), lines=True))


def _coco(data: bytes, path: Path) -> int:
    from pycocotools.coco import COCO

    with contextlib.redirect_stdout(None):
        return len(COCO(str(path)).anns)


def _ctc(data: bytes, path: Path) -> int:
    import tifffile
    from skimage.measure import regionprops_table

    return sum(
        len(regionprops_table(tifffile.imread(image), properties=("label", "centroid"))["label"])
        for image in sorted(path.glob("mask*.tif"))
    )


def _geff(data: bytes, path: Path) -> int:
    import geff

    return len(geff.read(path)[0].nodes)


_NO_HEADER = {"header": None, "names": range(22)}
PEERS: dict[str, Peer] = {
    "nmea": ("pyais", _pyais),
    "sbs": ("pandas.read_csv", _pandas(**_NO_HEADER)),
    "aircraft": ("json and pandas", _snapshots),
    "aircraft lines": ("json and pandas", _snapshots),
    "states": ("json and pandas", _states),
    "state table": ("pandas.read_csv", _pandas()),
    "mot": ("pandas.read_csv, as py-motmetrics", _pandas(header=None)),
    "kitti detections": ("pandas.read_csv", _pandas(header=None)),
    "kitti labels": ("pandas.read_csv", _pandas(header=None, sep=" ")),
    "json lines": ("pandas.read_json", _json_lines),
    "csv": ("pandas.read_csv", _pandas()),
    "parquet": ("pandas and pyarrow", _parquet),
    "coco": ("pycocotools", _coco),
    "ctc": ("tifffile and scikit-image", _ctc),
    "geff": ("geff", _geff),
}
"""By the names of samples; for what is not here there is none that is kept up."""
