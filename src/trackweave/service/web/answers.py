"""Answers in JSON, and what every answer says to browsers."""

from collections.abc import Mapping
from typing import Any

from starlette.responses import Response

from trackweave.service.messages import as_text

__all__ = ["DATA_HEADERS", "answer", "refusal"]

DATA_HEADERS: Mapping[str, str] = {
    "cache-control": "no-store",
    # Should a browser ever show such an answer as a page, it is one that may do nothing.
    "content-security-policy": "default-src 'none'; frame-ancestors 'none'; sandbox",
}


def answer(value: Mapping[str, Any] | list[Any], status: int = 200, **headers: str) -> Response:
    """Return an object or a list as an answer; ``headers`` with ``_`` for ``-``."""
    text = as_text(value) if isinstance(value, Mapping) else as_text({"": value})[4:-1]
    return Response(
        text.encode("utf-8", "replace"),
        status_code=status,
        media_type="application/json",
        headers={**DATA_HEADERS, **{name.replace("_", "-"): h for name, h in headers.items()}},
    )


def refusal(status: int, message: str, **headers: str) -> Response:
    """Return why something is not done; the connection ends, with whatever was still to come."""
    return answer({"error": message}, status, connection="close", **headers)
