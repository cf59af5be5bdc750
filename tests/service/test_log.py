"""Lines that nobody can forge."""

import json
import logging

from trackweave.service.log import LogLine, say


def test_a_line_is_one_object_whatever_it_says() -> None:
    lines: list[str] = []

    class Keeping(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            lines.append(LogLine().format(record))

    logger = logging.Logger("test")
    logger.addHandler(Keeping())
    nasty = '"}\n{"event": "forged"}\r\x1b[31m\u2028\u202e\x7f' + "x" * 5000
    say(logger, logging.WARNING, "refused", path=nasty, count=3, level="forged", why=None)
    logger.error(nasty)
    error = OSError(nasty)
    logger.error("failed", exc_info=(OSError, error, None))
    assert all(line.isascii() and line.isprintable() for line in lines)
    found = [json.loads(line) for line in lines]
    assert [each["level"] for each in found] == ["warning", "error", "error"]
    assert (found[0]["event"], found[0]["count"], found[0]["why"]) == ("refused", 3, None)
    assert found[0]["path"].startswith('"}\n{"event": "forged"}')
    assert len(found[0]["path"]) < 500
    assert found[2]["error"].startswith("OSError: ")
    assert found[0]["time"].endswith("Z")
