"""The source documents' own studies, repeated: what each says, and what comes out here.

A study is a list of parts. Each part measures tables of numbers by itself, from random numbers of
its own, so that a study that was interrupted goes on where it stopped and ends with the same
bytes. Report, claims and figures are made from the tables alone.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module

import numpy as np

from trackweave.config.presets import FUSION_PRESETS, PRESETS
from trackweave.errors import InvalidInputError
from trackweave.keys import suggest
from trackweave.studies.judging import Verdict
from trackweave.studies.writing import Table

__all__ = ["STUDIES", "Claim", "Part", "Study", "Tick", "WriteUp", "draws", "study_of"]

# Called with how much of a part is done and how much it is in all.
Tick = Callable[[int, int], None]

# The module of each preset's study, which has a ``STUDY``.
STUDIES: dict[str, str] = {
    "hillis-1997": "trackweave.studies.hillis_1997",
    "huo-2008": "trackweave.studies.huo_2008",
    "wiranto-2018": "trackweave.studies.wiranto_2018",
}


@dataclass(frozen=True, slots=True)
class Claim:
    """What a document says, or what one would expect of it, and what came out.

    The text has the document's own words in quotation marks; ``found`` are words and numbers, each
    figure with its 95 % interval. ``judged_by`` is the threshold and whose it is, such as "≥ 95 %
    of windows (ours)"; empty where the claim needs none.
    """

    text: str
    verdict: Verdict
    found: str
    judged_by: str = ""

    def told(self) -> dict[str, str]:
        """Return it as run.json and ``--json`` have it."""
        return {"claim": self.text, "verdict": str(self.verdict), "found": self.found}


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a study, measured by itself.

    From its own source of randomness, whether a fraction of the scenes will do, and whom to tell
    of progress, ``measure`` returns its tables by name; each becomes a file, NAME.csv. What
    differs from run to run, as CPU times do, has no place in them: run.json tells each part's CPU
    time.
    """

    name: str
    measure: Callable[[np.random.Generator, bool, Tick], Mapping[str, Table]]


@dataclass(frozen=True, slots=True)
class WriteUp:
    """What a study's tables say: a Markdown report, claims in its order, figures by file name."""

    report: str
    claims: tuple[Claim, ...]
    figures: Mapping[str, bytes]


@dataclass(frozen=True, slots=True)
class Study:
    """A document's study: what is measured, and what writes all tables up, quick or not.

    No two parts have a name or a table's name in common.
    """

    parts: tuple[Part, ...]
    write_up: Callable[[Mapping[str, Table], bool], WriteUp]


def draws(
    rng: np.random.Generator, count: int, tick: Tick
) -> Iterator[tuple[int, np.random.Generator]]:
    """Yield the numbers of draws with a generator of each; tell how many are done after each."""
    for number, own in enumerate(rng.spawn(count)):
        yield number, own
        tick(number + 1, count)


def study_of(preset: str) -> Study:
    """Return the study of a preset's document, and refuse a preset that has none."""
    if preset not in STUDIES:
        there_are = f"expected {' or '.join(sorted(STUDIES))}, the presets that have a study"
        if preset in {*PRESETS, *FUSION_PRESETS}:
            raise InvalidInputError(f"{preset}: a preset without a study; {there_are}")
        hint = suggest(preset, sorted(STUDIES))
        raise InvalidInputError(
            f'preset: "{preset}" is not known; {hint if hint.startswith("did") else there_are}'
        )
    study: Study = import_module(STUDIES[preset]).STUDY
    return study
