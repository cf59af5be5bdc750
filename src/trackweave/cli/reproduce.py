"""The command ``reproduce``."""

from collections import Counter
from pathlib import Path
from time import perf_counter
from typing import Any

from trackweave.cli.edge import Voice
from trackweave.io.output import OutputDirectory
from trackweave.studies import study_of
from trackweave.studies.running import Order, run_study
from trackweave.summaries import counted

__all__ = ["run_reproduce"]


def run_reproduce(
    voice: Voice, preset: str, out: Path, *, seed: int | None, quick: bool
) -> dict[str, Any]:
    """Repeat a document's study and write its report; return its claims."""
    study, seed = study_of(preset), seed or 0
    place = OutputDirectory(out, "reproduce")
    place.check()
    begin = perf_counter()
    with voice.progress(f"repeating {preset}") as progress:
        found = run_study(study, Order(preset, seed, quick), place, progress)
    claims = [(claim.text, str(claim.verdict)) for claim in found.claims]
    counts = Counter(verdict for _, verdict in claims)
    told = ", ".join(f"{verdict}: {count}" for verdict, count in counts.items())
    line = f"{counted(len(claims), 'claim')}, {told}; the report is {out / 'report.md'}"
    voice.table(f"What {preset} says", claims, line)
    return {
        "preset": preset,
        "claims": [claim.told() for claim in found.claims],
        "report": str(out / "report.md"),
        "time_s": perf_counter() - begin,
        "seed": seed,
        "out": str(out),
    }
