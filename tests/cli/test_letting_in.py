"""The command ``token``: the real one."""

import json
import stat
import subprocess
import sys
from pathlib import Path

from trackweave.service.web.tokens import read_tokens


def token(*given: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "trackweave", "token", *map(str, given)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_tokens_are_printed_once_and_their_digests_kept(tmp_path: Path) -> None:
    file = tmp_path / "tokens"
    first = token(file, "--name", "radar north")
    assert first.returncode == 0, first.stderr
    second = json.loads(token(file, "--json").stdout)
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    text = file.read_text()
    assert len(text.splitlines()) == 2
    assert "radar north" in text
    found = read_tokens(file)
    for each in (first.stdout.strip(), second["token"]):
        assert len(each) > 40
        assert found.matches(each)
        assert each not in text
    assert found.notes == ()


def test_a_line_that_does_not_end_is_kept_apart(tmp_path: Path) -> None:
    file = tmp_path / "tokens"
    file.write_text("a token in clear, long enough")
    done = token(file)
    found = read_tokens(file)
    assert found.matches("a token in clear, long enough")
    assert found.matches(done.stdout.strip())


def test_what_is_no_file_is_refused_in_one_line(tmp_path: Path) -> None:
    for given in ([tmp_path], [tmp_path / "a" / "b"], [tmp_path / "t", "--name", "a\nb"]):
        done = token(*given)
        assert done.returncode == 2
        assert len(done.stderr.strip().splitlines()) == 1
        assert done.stdout == ""
