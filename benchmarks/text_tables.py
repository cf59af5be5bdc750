"""Results as Markdown, with the machine and the command that made them."""

import datetime
import os
import platform
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

Rows = Sequence[Sequence[Any]]


def table(head: Sequence[str], rows: Rows) -> str:
    """Return a Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(_cell(value) for value in row) + " |" for row in rows]
    return "\n".join(lines)


def heading(line: str) -> str:
    """Return the line that says how, when and on what a table was measured."""
    day = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
    return f"`{line}` · {machine()} · {day}"


def command(script: str) -> str:
    """Return the command that runs a script with the options that this process was given."""
    return " ".join(["python", f"benchmarks/{script}", *sys.argv[1:]])


def machine() -> str:
    """Return the machine in a line, without names."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists():
        for line in information.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                model = line.partition(":")[2].strip()
                break
    return f"one of {os.cpu_count()} cores of {model}, Python {platform.python_version()}"


def _cell(value: Any) -> str:
    if isinstance(value, float):
        size = abs(value)
        return f"{value:.0f}" if size >= 1000 else f"{value:.1f}" if size >= 10 else f"{value:.2f}"
    return "–" if value is None else str(value)
