"""Bars and tables on a terminal, plain lines elsewhere, silence when asked."""

import io

import pytest

from trackweave.cli.edge import Voice


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    # Called by each test and no fixture: pytest puts its own stream back after the fixtures.
    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    return screen


def test_a_terminal_gets_a_bar_and_a_table(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = terminal(monkeypatch)
    voice = Voice(quiet=False)
    with voice.progress("tracking") as advance:
        assert advance is not None
        advance(5, 10)
    voice.table("Result", [("switches", "0")])
    said = screen.getvalue()
    assert "5/10" in said
    assert "Result" in said
    assert "switches" in said


def test_a_quiet_terminal_gets_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = terminal(monkeypatch)
    voice = Voice(quiet=True)
    with voice.progress("tracking") as advance:
        assert advance is None
    voice.table("Result", [("switches", "0")])
    voice.say("hello")
    assert screen.getvalue() == ""


def test_a_file_gets_lines_and_no_table(capsys: pytest.CaptureFixture[str]) -> None:
    voice = Voice(quiet=False)
    with voice.progress("tracking") as advance:
        assert advance is None
    voice.table("Result", [("switches", "0")])
    voice.say("hello")
    assert capsys.readouterr().err == "hello\n"
