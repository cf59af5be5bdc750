"""Who may come in: tokens, of which only digests are kept, and files of them."""

import hashlib
import hmac
import re
import secrets
import stat
from dataclasses import dataclass
from pathlib import Path

from trackweave.errors import InvalidInputError

__all__ = ["Tokens", "line_of", "new_token", "read_tokens"]

_HASHED = re.compile(r"sha256:([0-9a-f]{64})(?:\s.*)?")
_PREFIX = "sha256:"
_LONGEST_FILE = 1 << 16
SHORT = 16
"""Characters below which a token can be guessed by whoever has the time."""


@dataclass(frozen=True, slots=True)
class Tokens:
    """The tokens that open the service, as SHA-256 digests.

    Parameters
    ----------
    digests
        One for each token; at least one.
    notes
        What a user should know of the file that they came from.
    has_short
        Whether one in clear has less than ``SHORT`` characters.
    """

    digests: tuple[bytes, ...]
    notes: tuple[str, ...] = ()
    has_short: bool = False

    def matches(self, told: str) -> bool:
        """Tell whether a text is one of the tokens, in a time that tells nothing of them."""
        digest = _digest(told)
        # All are compared, whichever it is.
        return any([hmac.compare_digest(digest, each) for each in self.digests])


def new_token() -> str:
    """Return a token that nobody guesses: 256 bits of the system's randomness."""
    return secrets.token_urlsafe(32)


def line_of(token: str, name: str = "") -> str:
    """Return the line of a token file that lets a token in without holding it."""
    return f"{_PREFIX}{_digest(token).hex()} {name}".rstrip()


def read_tokens(path: Path) -> Tokens:
    """Return the tokens of a file.

    Parameters
    ----------
    path
        A text file with a token a line: as ``line_of`` writes it, or in clear. Empty lines and
        those that begin with ``#`` say nothing.

    Returns
    -------
    Their digests, and notes where the file itself gives tokens away.

    Raises
    ------
    InvalidInputError
        If it cannot be read or holds no token; no message shows what it holds.
    """
    lines = [line.strip() for line in _text(path).splitlines()]
    lines = [line for line in lines if line and not line.startswith("#")]
    if not lines:
        raise InvalidInputError(f"{path}: no token; expected one a line")
    digests, clear = [], []
    for number, line in enumerate(lines, start=1):
        hashed = _HASHED.fullmatch(line)
        if hashed is None and line.startswith(_PREFIX):
            raise InvalidInputError(
                f"{path}, token {number}: no SHA-256; expected 64 digits in hexadecimal"
            )
        if hashed is None and not line.isascii():
            raise InvalidInputError(
                f"{path}, token {number}: letters beyond ASCII; expected what a header can carry"
            )
        digests.append(bytes.fromhex(hashed[1]) if hashed else _digest(line))
        clear += [] if hashed else [line]
    return Tokens(tuple(digests), _notes(path, clear), any(len(t) < SHORT for t in clear))


def _notes(path: Path, clear: list[str]) -> tuple[str, ...]:
    if not clear:
        return ()
    notes = [f"{path}: holds a token in clear; `trackweave token` writes a file without any"]
    if path.stat().st_mode & (stat.S_IRGRP | stat.S_IROTH):
        notes.append(f"{path}: others on this machine can read it; expected mode 600")
    if any(len(token) < SHORT for token in clear):
        notes.append(f"{path}: a token of less than {SHORT} characters can be guessed")
    return tuple(notes)


def _text(path: Path) -> str:
    try:
        # A pipe is read as well: that is how a shell hands over a secret.
        with path.open("rb") as file:
            data = file.read(_LONGEST_FILE + 1)
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidInputError(f"{path}: not UTF-8; expected a token a line") from None
    except OSError as err:
        raise InvalidInputError(f"{path}: {err.strerror}; expected a file of tokens") from None
    except ValueError:  # a NUL
        raise InvalidInputError(f"{str(path)!r}: not a file name; expected a token file") from None
    if len(data) > _LONGEST_FILE:
        raise InvalidInputError(f"{path}: more than 64 KiB; expected a token a line")
    return text


def _digest(token: str) -> bytes:
    return hashlib.sha256(token.encode("utf-8", "surrogateescape")).digest()
