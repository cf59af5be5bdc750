"""The command reproduce, run as it is: quick, each document's study."""

import json
import re
from pathlib import Path

import matplotlib.image
import pytest

from cli.conftest import Run
from trackweave.cli import reproduce
from trackweave.studies import STUDIES, Claim, WriteUp, study_of
from trackweave.studies.judging import Verdict


@pytest.mark.slow
@pytest.mark.parametrize("preset", sorted(STUDIES))
def test_repeats_a_study_claim_by_claim(preset: str, run: Run, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = run("reproduce", preset, "--quick", "--seed", 4, "--out", out, "--json")
    assert done.exit_code == 0, done.stderr
    found = json.loads(done.stdout)
    assert (found["preset"], found["seed"], found["out"]) == (preset, 4, str(out))
    assert len(found["claims"]) >= 7
    assert {claim["verdict"] for claim in found["claims"]} <= set(Verdict)
    report = (out / "report.md").read_text()
    assert "**Quick run" in report
    for claim in found["claims"]:
        assert claim["claim"] in report
        assert claim["found"]
    record = json.loads((out / "run.json").read_text())
    assert record["complete"] is True
    assert record["files"] == sorted(path.name for path in out.iterdir())
    assert set(record["parts"]) == {part.name for part in study_of(preset).parts}
    for name in re.findall(r"!\[[^]]*\]\(([^)]*)\)", report):
        assert matplotlib.image.imread(out / name).std() > 0.0
    assert not [name for name in record["files"] if name.endswith(".png") and name not in report]


def test_says_in_a_line_what_became_of_the_claims(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    verdicts = [Verdict.HOLDS, Verdict.DOES_NOT_HOLD, Verdict.HOLDS]
    written = WriteUp("", tuple(Claim("it is so", each, "it is") for each in verdicts), {})
    monkeypatch.setattr(reproduce, "run_study", lambda *told: written)
    done = run("reproduce", "huo-2008", "--quick", "--out", tmp_path / "out")
    assert done.exit_code == 0, done.stderr
    report = tmp_path / "out" / "report.md"
    assert done.stderr == (f"3 claims, holds: 2, does not hold: 1; the report is {report}\n")


def test_says_which_presets_have_a_study(run: Run, tmp_path: Path) -> None:
    done = run("reproduce", "huo-2009", "--out", tmp_path / "out")
    assert done.exit_code == 2
    assert "huo-2008" in done.stderr
    assert not (tmp_path / "out").exists()


def test_leaves_a_directory_that_is_not_its_own_as_it_is(run: Run, tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    done = run("reproduce", "huo-2008", "--quick", "--out", tmp_path)
    assert done.exit_code == 2
    assert "not empty and not a run of trackweave" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]
