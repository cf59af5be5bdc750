"""The command ``reproduce``."""

from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from trackweave.cli.edge import Voice, telling_compiling
from trackweave.io.output import OutputDirectory
from trackweave.studies import study_of
from trackweave.studies.running import Order, run_study

__all__ = ["ReproduceRequest", "run_reproduce"]


@dataclass(frozen=True, slots=True)
class ReproduceRequest:
    """What the command was asked for.

    Parameters
    ----------
    preset
        Name of the preset whose document is to be repeated.
    out
        Directory for the files.
    seed
        Seed of the random numbers.
    quick
        Whether a fraction of the scenes will do.
    """

    preset: str
    out: Path
    seed: int = 0
    quick: bool = False


@telling_compiling
def run_reproduce(request: ReproduceRequest, voice: Voice) -> dict[str, Any]:
    """Repeat a document's study and write its report; return its claims."""
    study = study_of(request.preset)
    place = OutputDirectory(request.out, "reproduce")
    place.check()
    begin = perf_counter()
    order = Order(request.preset, request.seed, request.quick)
    try:
        with voice.progress(f"repeating {request.preset}") as progress:
            found = run_study(study, order, place, progress)
    except KeyboardInterrupt:
        if (place.record() or {}).get("complete") is False:
            voice.say(f"what is measured so far is in {request.out}; the same command goes on")
        raise
    voice.table(
        f"What {request.preset} says", [(claim.text, claim.verdict) for claim in found.claims]
    )
    return {
        "preset": request.preset,
        "claims": [
            {"claim": claim.text, "verdict": claim.verdict, "found": claim.found}
            for claim in found.claims
        ],
        "report": str(request.out / "report.md"),
        "time_s": perf_counter() - begin,
        "seed": request.seed,
        "out": str(request.out),
    }
