"""Sentences of studies are data: each is used, and says what it is given."""

import re
from pathlib import Path

import pytest

import trackweave.studies
from trackweave.studies.judging import Verdict
from trackweave.studies.sentences import Sentences

FOLDER = Path(trackweave.studies.__file__).parent


@pytest.mark.parametrize("study", ["hillis", "huo", "wiranto"])
def test_every_sentence_is_said_somewhere(study: str) -> None:
    code = "".join(path.read_text() for path in FOLDER.glob(f"{study}_*.py"))
    said = Sentences(study)
    names = [*said._texts.get("claims", ()), *(n for n in said._texts if n not in KINDS)]
    assert len(names) > 10
    assert [
        name for name in names if name not in re.findall(r"[\"']([a-z0-9-]+)[\"']", code)
    ] == []


KINDS = ("claims", "sections")


def test_a_claim_has_its_own_figures_and_those_of_all() -> None:
    said = Sentences("hillis", near=1.0, often=95.0)
    claim = said.claim("over-scenes", Verdict.HOLDS, excess="0.5 nats")
    assert claim.found == "Above the best of each window, mean of a scene: 0.5 nats."
    assert claim.judged_by.startswith("at most 1 nat ")
    assert said.claim("generations", Verdict.HOLDS, courses=3).judged_by == ""
