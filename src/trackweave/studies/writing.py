"""Tables of a study, and its claims, as a report has them."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import polars as pl

from trackweave.arrays import FloatArray

if TYPE_CHECKING:
    from trackweave.studies import Claim

__all__ = ["Table", "claims_text", "frame", "numbers", "text_by", "text_table"]

Table: TypeAlias = pl.DataFrame


def frame(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> Table:
    """Return rows of cells, None for none, as a table."""
    columns = {name: [row[place] for row in rows] for place, name in enumerate(head)}
    return pl.DataFrame(columns, strict=False)


def numbers(table: Table, name: str, **where: object) -> FloatArray:
    """Return a column's numbers, NaN for none, of the rows in which others are as given."""
    own = table.filter(**where) if where else table
    return own[name].cast(pl.Float64).fill_null(np.nan).to_numpy()


def text_table(header: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """Return a table as Markdown; numbers with three digits that count, None as a dash."""
    head = [_shown(cell) for cell in header]
    lines = [head, ["---"] * len(head), *([_shown(cell) for cell in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def text_by(
    table: Table, by: Sequence[str], names: Sequence[str], cell: Callable[[Table, str], Any]
) -> str:
    """Return a line of Markdown for each combination of some columns, with a cell by each name."""
    rows = [
        (*key, *(cell(own, name) for name in names))
        for key, own in table.group_by(by, maintain_order=True)
    ]
    return text_table((*by, *names), rows)


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
    # A bar would end the cell, and a line the row.
    text = f"{cell:.4g}" if isinstance(cell, float) else " ".join(str(cell).split("\n"))
    return text.replace("|", r"\|")
