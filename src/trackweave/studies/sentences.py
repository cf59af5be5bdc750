"""What studies say, kept beside them as data: texts, with places for the figures in them."""

import tomllib
from importlib.resources import files
from typing import Any

from trackweave.studies import Claim
from trackweave.studies.judging import Verdict

__all__ = ["Sentences"]


class Sentences:
    """The texts of one study's report, by name; some figures are the same in all of them."""

    def __init__(self, study: str, **figures: Any) -> None:
        text = files("trackweave.studies").joinpath(f"{study}.toml").read_text("utf-8")
        self._texts, self._figures = tomllib.loads(text), figures

    def text(self, name: str) -> str:
        """Return a text as it is."""
        return str(self._texts[name])

    def sections(self) -> dict[str, str]:
        """Return the texts of the report's sections, in order."""
        return dict(self._texts["sections"])

    def claim(self, name: str, verdict: Verdict, **figures: Any) -> Claim:
        """Return a claim with its figures."""
        known = {**self._figures, **figures}
        said = {key: words.format(**known) for key, words in self._texts["claims"][name].items()}
        return Claim(said["text"], verdict, said["found"], said.get("judged_by", ""))
