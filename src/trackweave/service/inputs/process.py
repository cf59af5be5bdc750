"""The service's side of an input: its process, and what comes from it."""

import asyncio
import json
import logging
import sys
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

from trackweave.service.inputs.outbox import FRAME, MARKS, REPORTS
from trackweave.service.inputs.source import Source
from trackweave.service.log import say

__all__ = ["Handed", "Input", "Marked"]

Handed = Callable[[bytes, int, dict[str, list[float]]], Awaitable[None]]
"""Takes a record's payload, how many reports it has, and what each sensor told of times in it.
What is not awaited for is not read: so the process sees that it has to drop."""
Marked = Callable[[dict[str, float]], None]
"""Takes when sensors' beams came by somewhere, as they say themselves, by name [s]."""
_log = logging.getLogger("trackweave.service")
_STDIN = {"stdin": None, "replay": asyncio.subprocess.PIPE}
"""What an input reads; a recording waits there until it may begin."""


class Input:
    """One input: decodes in a process of its own, which ends with the service.

    Parameters
    ----------
    source
        What it listens to.
    handed, marked
        Take what it hands on.
    begin
        Set once recordings may begin; who sends live is heard from the start.
    """

    def __init__(
        self, source: Source, handed: Handed, marked: Marked, begin: asyncio.Event
    ) -> None:
        self.source = source
        self.state: dict[str, Any] = {
            "dropped": 0, "skipped": 0, "clients": 0, "message": "", "listening": False,
        }  # fmt: skip
        self.reports = 0
        self._dropped = 0
        self.has_ended = False
        self.has_told = asyncio.Event()
        """Set once it listens, or has said why it does not."""
        self._handed, self._marked, self._begin = handed, marked, begin
        self._process: asyncio.subprocess.Process | None = None
        if self.is_ready:
            self.has_told.set()

    @property
    def is_ready(self) -> bool:
        """Whether nothing that is sent is lost: it listens, or fetches what waits for it."""
        waits = self.source.scheme in ("stdin", "replay") or self.source.connect
        return waits or bool(self.state["listening"])

    def newly_dropped(self) -> int:
        """Return how many reports were dropped since this was last asked."""
        before, self._dropped = self._dropped, int(self.state["dropped"])
        # A process that was begun anew counts anew.
        return self._dropped - before if self._dropped >= before else self._dropped

    async def run(self) -> None:
        """Read what comes until the input ends; a process that dies is begun anew."""
        while not self.has_ended:
            stdin = _STDIN.get(self.source.scheme, asyncio.subprocess.DEVNULL)
            self._process = await asyncio.create_subprocess_exec(
                sys.executable, "-m", "trackweave.service.inputs", json.dumps(self.source.url),
                stdin=stdin, stdout=asyncio.subprocess.PIPE,
            )  # fmt: skip
            if self._process.stdin is not None:
                await self._begin.wait()
                self._process.stdin.close()
            with suppress(asyncio.IncompleteReadError):
                await self._read(self._process)
            await self._process.wait()
            self.state["listening"] = False
            self._note_end(self._process.returncode)
            if self.source.scheme in ("stdin", "replay"):
                # What was read of it cannot be read again.
                self.has_ended = True
            elif not self.has_ended:
                await asyncio.sleep(1.0)
                self.has_ended = False

    async def close(self) -> None:
        """End its process."""
        self.has_ended = True
        if self._process is not None and self._process.returncode is None:
            with suppress(ProcessLookupError):
                self._process.kill()
            await self._process.wait()

    async def _read(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdout is not None
        while True:
            kind, n_words, n_body = FRAME.unpack(await process.stdout.readexactly(FRAME.size))
            words = json.loads(await process.stdout.readexactly(n_words))
            body = await process.stdout.readexactly(n_body)
            if kind == REPORTS:
                self.reports += words["reports"]
                await self._handed(body, words["reports"], words["told"])
            elif kind == MARKS:
                self._marked(words["marks"])
            else:
                self._note(words)

    def _note_end(self, status: int | None) -> None:
        """Log that the process ended without a word, as one that was killed."""
        if not self.state.pop("ended", False) and not self.has_ended:
            is_over = self.source.scheme in ("stdin", "replay")
            self.state["message"] = "its process ended" + ("" if is_over else "; begun anew")
            say(_log, logging.WARNING, "input ended", url=self.source.url, status=status)

    def _note(self, words: dict[str, Any]) -> None:
        """Take in how it is; a message is logged once, when it is new."""
        message = words["message"]
        if message and message != self.state["message"]:
            say(_log, logging.WARNING, "input", url=self.source.url, message=message)
        self.state.update(words)
        if message or self.is_ready:
            self.has_told.set()
