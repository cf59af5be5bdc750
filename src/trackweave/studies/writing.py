"""Tables and claims of a study's report, as Markdown and as files."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray
from trackweave.io.encoding import encode_table

if TYPE_CHECKING:
    from trackweave.studies import Claim

__all__ = ["Table", "claims_text", "csv_table", "text_table"]


@dataclass(frozen=True, slots=True)
class Table:
    """Names of columns, and rows of cells."""

    head: tuple[str, ...]
    rows: tuple[tuple[object, ...], ...]

    def column(self, name: str, **where: object) -> FloatArray:
        """Return a column's numbers, NaN for none, of the rows in which others are as given."""
        place = self.head.index(name)
        wanted = {self.head.index(key): value for key, value in where.items()}
        rows = [row for row in self.rows if all(row[at] == value for at, value in wanted.items())]
        cells: list[Any] = [row[place] for row in rows]
        return np.array([np.nan if cell is None else cell for cell in cells], dtype=float)

    def records(self) -> list[dict[str, Any]]:
        """Return the rows, each as its cells by the columns' names."""
        return [dict(zip(self.head, row, strict=True)) for row in self.rows]


def text_table(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """Return a table as Markdown; numbers with three digits that count, None as a dash."""
    lines = [header, ["---"] * len(header), *([_shown(cell) for cell in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def csv_table(header: Sequence[str], rows: Sequence[Sequence[Any]], name: str) -> dict[str, bytes]:
    """Return a table as a file: its name and content."""
    columns = {column: [row[place] for row in rows] for place, column in enumerate(header)}
    return {name: encode_table(pl.DataFrame(columns, strict=False), name)}


def claims_text(claims: Sequence["Claim"]) -> str:
    """Return claims with what came out of each, as Markdown."""
    return "\n".join(
        f"{number}. {claim.text} – **{claim.verdict}**"
        + (f", judged by {claim.judged_by}" if claim.judged_by else "")
        + f". {claim.found}"
        for number, claim in enumerate(claims, start=1)
    )


def _shown(cell: Any) -> str:
    if cell is None:
        return "–"
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)
