"""The command ``reproduce``."""

from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from trackweave.cli.edge import Voice
from trackweave.io.output import OutputDirectory
from trackweave.studies import study_of

__all__ = ["ReproduceRequest", "run_reproduce"]

QUICK = (
    "**Quick run: a fraction of the scenes, and the smallest sizes alone.** What the claims below "
    "say rests on few scenes; leave out `--quick` to judge them."
)


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


def run_reproduce(request: ReproduceRequest, voice: Voice) -> dict[str, Any]:
    """Repeat a document's study and write its report; return its claims."""
    study = study_of(request.preset)
    place = OutputDirectory(request.out, "reproduce")
    place.check()
    voice.say_if_compiling()
    begin = perf_counter()
    with voice.progress(f"repeating {request.preset}") as progress:
        found = study(np.random.default_rng(request.seed), request.quick, progress)
    time_s = perf_counter() - begin
    claims = [{"claim": claim.text, "holds": claim.holds} for claim in found.claims]
    record = {
        "trackweave": version("trackweave"),
        "seed": request.seed,
        "preset": request.preset,
        "quick": request.quick,
        "claims": claims,
        "timing": {"wall_ms": round(1e3 * time_s, 3)},
    }
    report = found.report
    if request.quick:
        title, _, rest = report.partition("\n")
        report = f"{title}\n\n{QUICK}\n{rest}"
    place.write({**found.files, "report.md": report.encode()}, record)
    marks = {True: "holds", False: "does not hold", None: "cannot be told"}
    voice.table(f"What {request.preset} says", [(c.text, marks[c.holds]) for c in found.claims])
    return {
        "preset": request.preset,
        "claims": claims,
        "report": str(request.out / "report.md"),
        "time_s": time_s,
        "seed": request.seed,
        "out": str(request.out),
    }
