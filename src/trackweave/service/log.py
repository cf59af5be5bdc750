"""What the service says of itself: one line of JSON for each event, which nobody can forge."""

import json
import logging
from datetime import UTC, datetime
from typing import Any

__all__ = ["LogLine", "say"]

_LONGEST = 400
"""Characters of a value that are kept: what others send ends up here."""
_FIELDS = "trackweave_fields"


class LogLine(logging.Formatter):
    """Makes of a record one line: ``time`` (UTC), ``level``, ``from``, ``event`` and what it says.

    Everything beyond printable ASCII is escaped, as JSON does: no line end, no terminal's control
    sequence and no letter that looks like another gets through.
    """

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        when = datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")
        line: dict[str, Any] = {
            "time": when.replace("+00:00", "Z"),
            "level": record.levelname.lower(),
            "from": record.name,
            "event": _short(record.getMessage()),
        }
        for key, value in getattr(record, _FIELDS, {}).items():
            line.setdefault(key, _short(value))
        if record.exc_info and record.exc_info[0] is not None:
            line["error"] = _short(f"{record.exc_info[0].__name__}: {record.exc_info[1]}")
            line["traceback"] = self.formatException(record.exc_info)[-4000:]
        return json.dumps(line, ensure_ascii=True, default=repr).replace("\x7f", "\\u007f")


def say(logger: logging.Logger, level: int, event: str, /, **fields: Any) -> None:
    """Log an event with what belongs to it.

    Parameters
    ----------
    logger
        Whose event it is.
    level
        One of logging's.
    event
        What happened, in fixed words: what came from outside belongs into ``fields``.
    fields
        Texts, numbers, truths or None.
    """
    logger.log(level, "%s", event, extra={_FIELDS: fields})


def _short(value: Any) -> Any:
    if value is None or isinstance(value, bool | int | float):
        return value
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
