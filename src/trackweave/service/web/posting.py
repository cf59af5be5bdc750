"""``POST /reports``: 200 once every accepted report is in the journal on the disk."""

import asyncio
import logging
from typing import Any

from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response

from trackweave.errors import InvalidInputError, OutputError
from trackweave.service.desk import Desk, OverloadedError, Receipt, Rejected, Rows
from trackweave.service.log import say
from trackweave.service.web.answers import answer, refusal
from trackweave.service.web.bodies import MOST_REJECTED, Decoded, told_by
from trackweave.service.web.decoding import DecodingProcess
from trackweave.service.web.settings import Limits
from trackweave.service.web.tally import Tally

__all__ = ["Posting", "read_body"]

_LOG = logging.getLogger("trackweave.service.web")


class Posting:
    """Takes reports in.

    Parameters
    ----------
    desk
        Where they are handed in.
    decoding
        What decodes them.
    limits
        How long a body may be, and take to come.
    tally
        Where to count.
    """

    def __init__(
        self, desk: Desk, decoding: DecodingProcess, limits: Limits, tally: Tally
    ) -> None:
        self._desk, self._decoding, self._limits, self._tally = desk, decoding, limits, tally
        self._held = 0

    async def __call__(self, request: Request) -> Response:
        """Answer ``POST /reports``."""
        if request.headers.get("content-encoding", "identity") != "identity":
            return refusal(415, "a body that is packed; expected one that is not")
        try:
            told = told_by(request.headers.get("content-type", ""), _query(request))
        except InvalidInputError as err:
            return refusal(400, str(err))
        length = min(_length(request), self._limits.body_bytes)
        if self._held + length > self._limits.bodies_bytes:
            return _later("too many reports at once; expected them again in a while")
        self._held += length
        try:
            body = await read_body(request, self._limits)
            return body if isinstance(body, Response) else await self._take(request, body, told)
        finally:
            self._held -= length

    async def _take(self, request: Request, body: bytes, told: str | None) -> Response:
        try:
            found = await self._decoding.decode(body, told)
            receipt = await self._hand_in(found, request.scope["trackweave.address"])
        except InvalidInputError as err:
            return refusal(400, str(err))
        except OverloadedError as err:
            return _later(str(err))
        except OutputError as err:
            say(_LOG, logging.ERROR, "reports not stored", error=str(err))
            return _later(f"not stored: {err}")
        self._tally.add("posted_reports_total", receipt.accepted, outcome="accepted")
        rejected = [*found.rejected, *receipt.rejected]
        count = found.rejected_count + len(receipt.rejected)
        self._tally.add("posted_reports_total", count, outcome="rejected")
        told_of: dict[str, Any] = {
            "accepted": receipt.accepted,
            "rejected": [_as_json(each) for each in _in_order(rejected)],
            "sequence": receipt.sequence,
        }
        if count > len(told_of["rejected"]):
            told_of["rejected_count"] = count
        return answer(told_of)

    async def _hand_in(self, found: Decoded, address: str) -> Receipt:
        if found.table.is_empty():
            return Receipt(0, (), int(self._desk.health().get("sequence") or 0))
        rows = Rows(found.table, found.row, f"http {address}", found.facts)
        return await self._desk.accept(rows)


async def read_body(request: Request, limits: Limits) -> bytes | Response:
    """Return a request's body, or what to answer where it is too long or too slow."""
    most = limits.body_bytes
    too_long = f"a body of more than {most:,} bytes; expected less at a time"
    if _length(request) > most and "content-length" in request.headers:
        return refusal(413, too_long)
    pieces: list[bytes] = []
    size = 0
    try:
        async with asyncio.timeout(limits.body_s):
            async for piece in request.stream():
                size += len(piece)
                if size > most:
                    return refusal(413, too_long)
                pieces.append(piece)
    except TimeoutError:
        return refusal(408, f"a body that takes more than {limits.body_s:g} s; expected it sooner")
    except ClientDisconnect:
        return refusal(400, "a body that ends too early")
    return b"".join(pieces)


def _length(request: Request) -> int:
    """Return how long the body says it is; as long as any where it does not say."""
    told = request.headers.get("content-length", "")
    return int(told) if told.isascii() and told.isdigit() and len(told) < 20 else 1 << 62


def _query(request: Request) -> list[tuple[str, str]]:
    return request.query_params.multi_items()


def _in_order(rejected: list[Rejected]) -> list[Rejected]:
    known = [each for each in rejected if each.row is not None]
    unknown = [each for each in rejected if each.row is None]
    return [*sorted(known, key=lambda each: each.row or 0), *unknown][:MOST_REJECTED]


def _as_json(rejected: Rejected) -> dict[str, Any]:
    return {"row": rejected.row, "message": rejected.message}


def _later(message: str) -> Response:
    return refusal(503, message, retry_after="1")
