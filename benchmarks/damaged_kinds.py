"""Kinds of damage: octets, what a text is made of, lines, encodings, and tables."""

import re
from collections.abc import Callable
from io import BytesIO

import numpy as np
import polars as pl

__all__ = ["damaged", "odd_table"]

WORDS = (b"nan", b"1e999", b"-0", b'"', b"\n", b"9" * 400, b"{", b"[[", b"\xff\xfe", b",")
NUMBERS = (
    b"nan", b"inf", b"-Infinity", b"1e999", b"-1e308", b"1e300", b"9" * 30, b"9" * 400, b"-0",
    b"-1", b"0", b"181", b"91", b"360.0", b"1e-320", b"0x10", b"1_000", b"1,5", b"", b"null",
    b"true", b'"7"', b"9223372036854775808", b"18446744073709551616", b"4294967296", b"1e15",
    b"2024-02-30T00:00:00Z", b"9999-12-31T23:59:59.999999Z", b"0001-01-01", b"\xef\xbc\x97",
    b"[1]", b"{}", b"\xd9\xa3",
)  # fmt: skip
"""What may stand where a number stood."""
TOKEN = re.compile(rb'-?\d[\d.]*(?:[eE][+-]?\d+)?|"[^"\n]*"|[{}\[\],:<>/=*!]|[A-Za-z_]+')
NUMBER = re.compile(rb"-?\d")
VALUE = re.compile(rb'(?<=")[^"\n<>=]*(?=")|(?<=[:,\[ ])-?\d[\d.]*(?=[\],} \r\n])')
ELEMENT = re.compile(rb'<\w[^<>]*/>|\{[^{}]*\}|\[[^\[\]]*\]|"[^"\n]*"|(?<=: )-?\d[\d.]*')
Damage = Callable[[bytearray, np.random.Generator], None]


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """Return data with one to eight damages, of a kind chosen once or of all kinds."""
    content = bytearray(data * int(rng.integers(1, 4)) if rng.random() < 0.3 else data)
    kinds = (_octets, _tokens, _lines, _values, _encoding)
    shares = (0.3, 0.25, 0.15, 0.25, 0.05)
    chosen = kinds[:4] if rng.random() < 0.3 else (kinds[rng.choice(5, p=shares)],)
    for _ in range(min(int(rng.geometric(0.35)), 8)):
        chosen[int(rng.integers(len(chosen)))](content, rng)
        if not content:
            break
    return bytes(content)


def _octets(content: bytearray, rng: np.random.Generator) -> None:
    """Put octets in, take them out, replace or repeat them, or cut the end off."""
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


def _tokens(content: bytearray, rng: np.random.Generator) -> None:
    """Put another number for a number; take out, double or swap what the text is made of."""
    found = [match.span() for match in TOKEN.finditer(content)]
    if not found:
        return
    begin, end = found[int(rng.integers(len(found)))]
    how = rng.integers(6)
    if how < 3 and NUMBER.match(content, begin):
        content[begin:end] = NUMBERS[int(rng.integers(len(NUMBERS)))]
    elif how == 3:
        del content[begin:end]
    elif how == 4:
        content[begin:begin] = content[begin:end] * int(rng.choice([1, 2, 300]))
    else:
        other, last = found[int(rng.integers(len(found)))]
        content[begin:end] = content[other:last]


def _values(content: bytearray, rng: np.random.Generator) -> None:
    """Put another value for a value, or an element for another: brackets and marks stay whole."""
    is_value = rng.random() < 0.7
    found = [match.span() for match in (VALUE if is_value else ELEMENT).finditer(content)]
    if not found:
        return
    begin, end = found[int(rng.integers(len(found)))]
    other, last = found[int(rng.integers(len(found)))]
    number = NUMBERS[int(rng.integers(len(NUMBERS)))].replace(b'"', b"")
    use_other = not is_value or rng.random() < 0.3
    content[begin:end] = content[other:last] if use_other else number


def _lines(content: bytearray, rng: np.random.Generator) -> None:
    """Take out, double, move, join, cut or empty a line."""
    lines = bytes(content).splitlines(keepends=True)
    place, how = int(rng.integers(len(lines))), rng.integers(6)
    if how == 0:
        del lines[place]
    elif how == 1:
        lines.insert(int(rng.integers(len(lines) + 1)), lines[place])
    elif how == 2:
        lines.insert(int(rng.integers(len(lines))), lines.pop(place))
    elif how == 3:
        lines[place] = lines[place].rstrip(b"\r\n")
    elif how == 4:
        lines[place] = lines[place][: int(rng.integers(len(lines[place]) + 1))] + b"\n"
    else:
        lines[place] = (b"\n", b"\r\n", b" \n", b"\r", b"\0\n")[int(rng.integers(5))]
    content[:] = b"".join(lines)


def _encoding(content: bytearray, rng: np.random.Generator) -> None:
    """Write the text otherwise: another encoding, a mark before it, other ends of lines."""
    text = bytes(content).decode("utf-8", "replace")
    ways = (
        text.encode("utf-16"), text.encode("utf-16-le"), b"\xef\xbb\xbf" + content,
        text.replace("\n", "\r\n").encode(), text.replace("\n", "\r").encode(),
        text.replace("e", "é").encode("latin-1", "replace"), text.replace(",", ";").encode(),
        text.replace(" ", "\u00a0").encode(), text.replace(",", "\t").encode(),
    )  # fmt: skip
    content[:] = ways[int(rng.integers(len(ways)))][: 4 * len(content)]


def odd_table(table: pl.DataFrame, rng: np.random.Generator) -> bytes:
    """Return a file of Parquet in which columns and cells are what they should not be."""
    for _ in range(int(rng.integers(1, 5))):
        name = table.columns[int(rng.integers(table.width))]
        column, how = table[name], rng.integers(7)
        if how == 0 and table.width > 1:
            table = table.drop(name)
        elif how == 1:
            kinds = (pl.Int8, pl.UInt64, pl.Boolean, pl.String, pl.Date, pl.Datetime("ns"),
                     pl.Decimal(9, 2), pl.Duration("us"), pl.Binary, pl.Categorical)  # fmt: skip
            table = _cast(table, name, kinds[int(rng.integers(len(kinds)))])
        elif how == 2 and column.dtype.is_float():
            odd = (np.nan, np.inf, -np.inf, 1e308, -1e300, 1e-320, None)[int(rng.integers(7))]
            cells = [odd if rng.random() < 0.5 else cell for cell in column.to_list()]
            table = table.with_columns(pl.Series(name, cells, dtype=column.dtype))
        elif how == 3:
            table = table.with_columns(pl.lit(None).alias(name))
        elif how == 4:
            table = table.with_columns(pl.concat_list(name).alias(name))
        elif how == 5:
            names = ("Time", "lat", "", "y ", "scan", "é", name.upper())
            other = names[int(rng.integers(len(names)))]
            table = table if other in table.columns else table.rename({name: other})
        else:
            table = table.sample(fraction=1.0, shuffle=True, seed=int(rng.integers(99)))
            table = table.head(int(rng.integers(table.height + 1)))
        if not table.height or table.width == 1:
            break
    buffer = BytesIO()
    table.write_parquet(buffer)
    return buffer.getvalue()


def _cast(table: pl.DataFrame, name: str, kind: pl.DataType) -> pl.DataFrame:
    try:
        return table.with_columns(pl.col(name).cast(kind, strict=False))
    except pl.exceptions.PolarsError:  # no way from one to the other
        return table
