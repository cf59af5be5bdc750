"""The source documents' own studies, repeated: what each says, and what comes out here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module

import numpy as np

from trackweave.config.messages import suggest
from trackweave.config.presets import FUSION_PRESETS, PRESETS
from trackweave.errors import InvalidInputError

__all__ = ["STUDIES", "Claim", "Progress", "Study", "study_of"]

Progress = Callable[[int, int], None]

# The module of each preset's study; its ``reproduce`` makes a Study.
STUDIES: dict[str, str] = {
    "hillis-1997": "trackweave.studies.hillis_1997",
    "huo-2008": "trackweave.studies.huo_2008",
    "wiranto-2018": "trackweave.studies.wiranto_2018",
}


@dataclass(frozen=True, slots=True)
class Claim:
    """What a document says, or what one would expect of it.

    Parameters
    ----------
    text
        The claim, as a sentence.
    holds
        Whether it came out here; None where the document claims nothing that can be measured.
    found
        What came out, in words and numbers.
    """

    text: str
    holds: bool | None
    found: str


@dataclass(frozen=True, slots=True)
class Study:
    """A study's result.

    Parameters
    ----------
    report
        The report, as Markdown.
    claims
        The claims, in the report's order.
    files
        Figures and their numbers: each file's name and content.
    """

    report: str
    claims: tuple[Claim, ...]
    files: Mapping[str, bytes]


Reproduce = Callable[[np.random.Generator, bool, Progress | None], Study]


def study_of(preset: str) -> Reproduce:
    """Return what repeats the study of a preset's document.

    Parameters
    ----------
    preset
        Name of the preset.

    Returns
    -------
    A function of the source of randomness, of whether a fraction of the scenes will do, and of
    what to call with the number of parts done and of all.

    Raises
    ------
    InvalidInputError
        If there is no such preset, or its document has no study yet.
    """
    if preset not in STUDIES:
        there_are = f"expected {' or '.join(sorted(STUDIES))}, the presets that have a study"
        if preset in {*PRESETS, *FUSION_PRESETS}:
            raise InvalidInputError(f"{preset}: a preset without a study so far; {there_are}")
        hint = suggest(preset, sorted(STUDIES))
        raise InvalidInputError(
            f'preset: "{preset}" is not known; {hint if hint.startswith("did") else there_are}'
        )
    made: Reproduce = import_module(STUDIES[preset]).reproduce
    return made
