"""Files of keys and values, read in one way: whatever is wrong is said in one line."""

import re
import tomllib
from pathlib import Path
from typing import Any

from trackweave.errors import InvalidInputError

__all__ = ["read_toml"]

DEEPEST = 20
"""As many tables and lists lie in one another at most; nobody writes more by hand."""
LARGEST = 2**63
"""TOML's whole numbers have 64 bits."""
_DEEP = r"(\[\s*){21}|(\{[^{}]*){21}"
_LONG = r"\d{1000}"


def read_toml(path: Path, expected: str) -> dict[str, Any]:
    """Return what a TOML file holds, which should be as ``expected`` says."""
    # What cannot be read, is no TOML, or holds what no table of keys does is refused, with file
    # and place.
    text = _text(path, expected)
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as err:
        place = re.search(r"\(at (.*)\)$", str(err))
        where = f", {place.group(1)}" if place else ""
        what = re.sub(r" \(at .*\)$", "", str(err))
        raise InvalidInputError(f"{path}{where}: {what}; expected TOML") from None
    except RecursionError:
        where = _line_of(text, _DEEP)
        raise InvalidInputError(
            f"{path}{where}: nested too deeply; expected at most {DEEPEST} tables and lists in "
            "one another"
        ) from None
    except ValueError:  # thousands of digits, of which Python makes no number
        where = _line_of(text, _LONG)
        raise InvalidInputError(
            f"{path}{where}: a whole number too large; expected 64 bits"
        ) from None
    _check(path, values, "", 0)
    return values


def _text(path: Path, expected: str) -> str:
    try:
        is_other = path.exists() and not path.is_file()  # opening a pipe would wait for ever
        text = "" if is_other else path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as err:
        raise InvalidInputError(
            f"{path}, byte {err.start}: not UTF-8; expected TOML as UTF-8 text"
        ) from None
    except FileNotFoundError:
        raise InvalidInputError(f"{path}: no such file; expected {expected}") from None
    except OSError as err:
        raise InvalidInputError(f"{path}: {err.strerror}; expected {expected} file") from None
    except ValueError:  # a NUL
        raise InvalidInputError(f"{str(path)!r}: not a file name; expected {expected}") from None
    if is_other:
        what = "a directory" if path.is_dir() else "not a regular file"
        raise InvalidInputError(f"{path}: {what}; expected {expected}")
    return text


def _line_of(text: str, pattern: str) -> str:
    """Return the line and the key at which a pattern begins, as a message names them."""
    found = re.search(pattern, text)
    if found is None:
        return ""
    before = text[: found.start()]
    key = before.rpartition("\n")[2].partition("=")[0].strip()
    return f", line {before.count(chr(10)) + 1}" + (f", {key}" if key else "")


def _check(path: Path, value: Any, key: str, depth: int) -> None:
    """Refuse what is nested too deeply, and numbers that TOML does not have."""
    if depth > DEEPEST:
        raise InvalidInputError(
            f"{path}, {key:.60}: nested too deeply; expected at most {DEEPEST} tables and lists "
            "in one another"
        )
    if isinstance(value, dict):
        for name, entry in value.items():
            _check(path, entry, f"{key}.{name}" if key else name, depth + 1)
    elif isinstance(value, list):
        for place, entry in enumerate(value):
            _check(path, entry, f"{key}[{place}]", depth + 1)
    elif isinstance(value, int) and not -LARGEST <= value < LARGEST:
        shown = str(value) if abs(value) < 10**40 else f"{str(value)[:20]}…"
        raise InvalidInputError(f"{path}, {key}: {shown}; expected at most 64 bits")
