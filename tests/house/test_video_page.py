"""What the page on detections from video shows, runs, and prints what it says."""

import re
from pathlib import Path
from typing import Any

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "my-video-detections.md"


def test_the_examples_print_what_the_page_says(capsys: pytest.CaptureFixture[str]) -> None:
    text, known = PAGE.read_text(), dict[str, Any]()
    for code in re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL):
        exec(compile(code, str(PAGE), "exec"), known)
    said = "".join(re.findall(r"```text\n(.*?)```", text, flags=re.DOTALL))
    assert capsys.readouterr().out == said
