"""What the page on live tracking shows, runs."""

import gc
import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PAGE = Path(__file__).resolve().parents[2] / "docs" / "how-to" / "live.md"


@pytest.fixture
def thawed():
    yield
    # The page freezes what lives, which tests after this one need not.
    gc.unfreeze()


def test_the_examples_run_one_after_the_other(thawed, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    known = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text(), flags=re.DOTALL):
        exec(compile(code, str(PAGE), "exec"), known)
    assert known["hypothesis"].late == ()
    told = capsys.readouterr().out.splitlines()
    assert len(told) == 4
    assert "HeldScan(time=86404.0" in told[2]
    assert told[3].startswith("4.0 () (HeldScan(time=86404.0")
