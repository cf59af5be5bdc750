"""The command reproduce."""

import json
from pathlib import Path

import numpy as np
import pytest

from cli.conftest import Run
from trackweave import studies
from trackweave.studies import Claim, Study


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put a study in place of the document's that takes no time."""

    def reproduce(rng: np.random.Generator, quick: bool, progress: object) -> Study:
        number = rng.integers(1000)
        claims = (Claim("It holds", True, "It does."), Claim("Who knows", None, "Nobody."))
        return Study(f"# Report {number} {quick}\n", claims, {"spacing.csv": b"a\n1\n"})

    monkeypatch.setattr(
        studies, "import_module", lambda _: type("M", (), {"reproduce": reproduce})
    )


@pytest.mark.usefixtures("quick")
def test_writes_the_report_and_says_what_holds(run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run("reproduce", "huo-2008", "--out", out, "--seed", 4, "--json")
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["claims"] == [
        {"claim": "It holds", "holds": True}, {"claim": "Who knows", "holds": None}
    ]  # fmt: skip
    assert (found["preset"], found["seed"], found["out"]) == ("huo-2008", 4, str(out))
    assert (out / "report.md").read_text().startswith("# Report")
    record = json.loads((out / "run.json").read_text())
    assert record["files"] == ["report.md", "run.json", "spacing.csv"]
    first = (out / "report.md").read_bytes()
    done = run("reproduce", "huo-2008", "--out", out, "--seed", 4)
    assert done.exit_code == 0, done.stderr
    assert "It holds: holds" in done.stderr
    assert (out / "report.md").read_bytes() == first


def test_says_which_presets_have_a_study(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(studies.STUDIES, "hillis-1997")
    done = run("reproduce", "hillis-1997", "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "a preset without a study so far; expected huo-2008" in done.stderr
    done = run("reproduce", "huo", "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "huo-2008" in done.stderr
    assert not (tmp_path / "out").exists()
