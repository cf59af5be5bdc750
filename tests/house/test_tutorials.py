"""Tutorials and the page of messages run as they stand, and print what they say."""

import contextlib
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import trackweave

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "docs" / "tutorials"
# Its commands are the README's, whose picture other tests make.
PAGES = sorted({*FOLDER.glob("*.md")} - {FOLDER / "index.md", FOLDER / "first-tracks.md"})
MESSAGES = ROOT / "docs" / "reference" / "messages.md"
BLOCK = re.compile(r"^```(python|sh|toml|text)\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)
SHELL = f"trackweave() {{ '{sys.executable}' -m trackweave \"$@\"; }}\nset -e\n"


def run_in_shell(commands: str) -> None:
    # The same package as here, be it of this checkout or one that was installed.
    paths = [str(Path(trackweave.__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}
    done = subprocess.run(
        ["bash", "-c", SHELL + commands], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, f"{commands}\n{done.stderr}"


def follow(page: Path) -> int:
    """Run a page's blocks in the directory in which one is; return how many there were."""
    known: dict[str, object] = {}
    told = ""
    blocks = BLOCK.findall(page.read_text())
    for language, text in blocks:
        if language == "python":
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compile(text, str(page), "exec"), known)
            told = out.getvalue()
        elif language == "sh":
            run_in_shell(text)
        elif language == "toml":
            Path(text.splitlines()[0].removeprefix("# ")).write_text(text)
        else:
            assert told == text
    return len(blocks)


@pytest.mark.slow
@pytest.mark.tutorial
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_tutorial_runs_as_it_stands(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow(page) >= 3


def test_messages_are_as_their_page_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert follow(MESSAGES) >= 8


def test_every_tutorial_is_listed() -> None:
    listed = (FOLDER / "index.md").read_text()
    assert len(PAGES) >= 6
    assert [page.stem for page in PAGES if f"\n{page.stem}\n" not in listed] == []
