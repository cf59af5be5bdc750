"""Studies part by part: what is measured stays, and the next run goes on from there."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from time import process_time
from typing import Any

import polars as pl

from trackweave.errors import InvalidInputError
from trackweave.io.encoding import encode_table
from trackweave.io.output import OutputDirectory
from trackweave.randomness import generator_for
from trackweave.studies import Part, Study, WriteUp
from trackweave.studies.writing import Table

__all__ = ["Order", "run_study"]

QUICK = (
    "**Quick run: a fraction of the scenes, and the smallest sizes alone.** What the claims below "
    "say rests on few scenes; leave out `--quick` to judge them."
)
PARTS_OF_PROGRESS = 1000


@dataclass(frozen=True, slots=True)
class Order:
    """Which preset's study is run, from which seed, and whether a few of its scenes will do."""

    preset: str
    seed: int = 0
    quick: bool = False

    def record(self) -> dict[str, Any]:
        """Return what tells this study's run from others."""
        return {
            "trackweave": version("trackweave"), "seed": self.seed, "preset": self.preset,
            "quick": self.quick,
        }  # fmt: skip


def run_study(
    study: Study,
    order: Order,
    place: OutputDirectory,
    progress: Callable[[int, int], None] | None = None,
) -> WriteUp:
    """Measure a study's parts, write each as it comes, and at last the report."""
    # An earlier run of the same order that was interrupted is gone on with: its parts are read,
    # not measured again. The outcome is the same to the byte.
    done, timing = _earlier(order, place)
    files = {name: content for part in done.values() for name, content in part.items()}
    for number, part in enumerate(study.parts):
        if part.name in done:
            continue

        def tick(now: int, of: int, number: int = number) -> None:
            if progress is not None:
                whole = PARTS_OF_PROGRESS * (number + now / max(of, 1)) / len(study.parts)
                progress(int(whole), PARTS_OF_PROGRESS)

        begin = process_time()
        done[part.name] = _measured(part, order, tick)
        timing[part.name] = round(process_time() - begin, 3)
        files |= done[part.name]
        record = {**order.record(), "complete": False, "parts": _named(done)}
        place.write(files, {**record, "timing": {"cpu_s": timing}})
    found = study.write_up(_tables(files), order.quick)
    claims = [claim.told() for claim in found.claims]
    record = {**order.record(), "complete": True, "parts": _named(done), "claims": claims}
    report = _marked(found.report) if order.quick else found.report
    place.write(
        {**files, **found.figures, "report.md": report.encode()},
        {**record, "timing": {"cpu_s": timing}},
    )
    return found


def _named(done: Mapping[str, Mapping[str, bytes]]) -> dict[str, list[str]]:
    return {name: sorted(files) for name, files in done.items()}


def _measured(part: Part, order: Order, tick: Callable[[int, int], None]) -> dict[str, bytes]:
    """Return a part's files; its random numbers are its own, whatever ran before."""
    tables = part.measure(generator_for(order.seed, part.name), order.quick, tick)
    return {f"{name}.csv": encode_table(table, "x.csv") for name, table in tables.items()}


def _tables(files: Mapping[str, bytes]) -> dict[str, Table]:
    """Return tables as their files have them, so that read and measured ones are the same."""
    return {
        name.removesuffix(".csv"): pl.read_csv(content, infer_schema_length=None)
        for name, content in files.items()
    }


def _earlier(
    order: Order, place: OutputDirectory
) -> tuple[dict[str, dict[str, bytes]], dict[str, float]]:
    """Return the files of an interrupted run's parts, and how long each took [s]."""
    record = place.record()
    known = {key: record.get(key) for key in order.record()} if record else None
    if record is None or known != order.record() or record.get("complete") is not False:
        return {}, {}
    try:
        parts = {
            name: {file: (place.path / file).read_bytes() for file in files}
            for name, files in record["parts"].items()
        }
        timing = {name: float(record["timing"]["cpu_s"][name]) for name in parts}
        for files in parts.values():
            _tables(files)
    except (OSError, ValueError, TypeError, KeyError, AttributeError, pl.exceptions.PolarsError):
        raise InvalidInputError(
            f"{place.path}: the files of an interrupted run have changed since; expected them as "
            "they were, or another directory"
        ) from None
    return parts, timing


def _marked(report: str) -> str:
    title, _, rest = report.partition("\n")
    return f"{title}\n\n{QUICK}\n{rest}"
