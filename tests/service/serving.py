"""The real command, run for tests: started, asked over HTTP, killed."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path
from typing import IO, Any

__all__ = ["Service", "free_port"]

PATIENCE_S = 240.0
"""Far more than a start takes, however busy the machine."""


def free_port() -> int:
    """Return a port that nobody has now."""
    with socket.socket() as sock:
        sock.bind(("127.0.0.1", 0))
        return int(sock.getsockname()[1])


class Service:
    """``trackweave serve`` in a process of its own.

    Parameters
    ----------
    folder
        Its --data.
    options
        Further words of the command line.
    stdin
        A file that it reads; None for nothing.
    """

    def __init__(self, folder: Path, *options: str, stdin: IO[bytes] | None = None) -> None:
        self.port = free_port()
        self.log = folder.with_suffix(".log")
        with self.log.open("ab") as said:
            self.process = subprocess.Popen(
                [
                    sys.executable, "-m", "trackweave", "serve", "--data", str(folder),
                    "--page", f"127.0.0.1:{self.port}", *options,
                ],
                stderr=said, stdout=said, stdin=stdin or subprocess.DEVNULL, env=dict(os.environ),
            )  # fmt: skip
        self._wait()

    def get(self, path: str) -> Any:
        """Return the JSON that is at a path."""
        with urllib.request.urlopen(f"http://127.0.0.1:{self.port}{path}", timeout=60) as answer:
            return json.load(answer)

    def post(self, lines: list[dict[str, Any]]) -> dict[str, Any]:
        """Hand reports in; return the receipt."""
        body = "".join(json.dumps(line) + "\n" for line in lines).encode()
        request = urllib.request.Request(
            f"http://127.0.0.1:{self.port}/reports",
            data=body,
            headers={"Content-Type": "application/x-ndjson"},
        )
        with urllib.request.urlopen(request, timeout=60) as answer:
            found: dict[str, Any] = json.load(answer)
            return found

    def kill(self) -> None:
        """End it as a power cut of the process would."""
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def terminate(self) -> int:
        """Ask it to end; return its status."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(timeout=PATIENCE_S)

    def wait_for(self, what: str, least: float) -> Any:
        """Return the health once one of its numbers has come to a value."""
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            health = self.get("/healthz")
            if health[what] >= least:
                return health
            time.sleep(0.2)
        raise AssertionError(f"{what}: {health}")

    def _wait(self) -> None:
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            assert self.process.poll() is None, self.log.read_text()
            try:
                is_ready = self.get("/healthz")["status"] != "starting"
            except urllib.error.HTTPError as err:
                # It asks for a token.
                is_ready = err.code == 401
            except (urllib.error.URLError, ConnectionError, TimeoutError):
                is_ready = False
            if is_ready:
                return
            time.sleep(0.2)
        raise AssertionError("it does not begin to serve")
