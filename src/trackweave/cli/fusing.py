"""The commands that turn tracks into common objects, and repeat studies of that."""

from pathlib import Path
from typing import Annotated

import typer

from trackweave.cli.edge import done_by
from trackweave.cli.options import JsonOption, OutOption, QuietOption, SeedOption, required

__all__ = ["fuse", "reproduce"]


@done_by("fuse.run_fuse")
def fuse(
    tracks: Annotated[
        list[Path] | None,
        required(
            "TRACKS TRACKS …",
            "Tracks of one sensor each, as `track` writes them; the reference first.",
        ),
    ] = None,
    *,
    out: OutOption,
    name: Annotated[
        list[str] | None,
        typer.Option(help="NAME=FILE: the sensor's name; left out, that of its file."),
    ] = None,
    config: Annotated[
        Path | None,
        typer.Option(
            "--config", "-c", help="Configuration (tracker.toml), whose table [fusion] is read."
        ),
    ] = None,
    register: Annotated[
        bool,
        typer.Option(
            "--register", help="Find each sensor's shift, turn and clock beside the first."
        ),
    ] = False,
    bias: Annotated[
        str | None,
        typer.Option(
            help="What --register looks for: some of translation, rotation, range, azimuth and "
            "clock, with commas; translation,rotation,clock by default."
        ),
    ] = None,
    method: Annotated[
        str | None,
        typer.Option(
            help="How estimates are combined: fast-covariance-intersection (the default), convex, "
            "covariance-intersection or information-matrix."
        ),
    ] = None,
    preset: Annotated[
        str | None, typer.Option(help="Preset: huo, or huo-2008, the document to the letter.")
    ] = None,
    search: Annotated[
        str | None, typer.Option(help="Solver of the association, by its name.")
    ] = None,
    confirm: Annotated[
        str | None, typer.Option(help="N/M: declare what came out N of the last M times.")
    ] = None,
    false_rejection: Annotated[
        float | None,
        typer.Option(help="Probability of rejecting tracks of one object; 0.01 by default."),
    ] = None,
    correlation: Annotated[
        str | None,
        typer.Option(
            help="What to do about correlated errors: effective (the default), both, none, "
            "cross-covariance or inflated."
        ),
    ] = None,
    process_noise: Annotated[
        float | None,
        typer.Option(help="How fast estimates age, in m²/s³; left out, told from covariances."),
    ] = None,
    seed: SeedOption = None,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Fuse the tracks of several sensors.

    Each file holds what one sensor's tracker wrote: time, track, x, y[, z], velocities and the
    upper triangle of covariances. Confirmed and coasting rows take part. Writes associations.csv
    (which local track was of which object, from when to when, and why that ended), tracks.csv
    (one row per object and time) and run.json. Options come before the configuration, that
    before the preset, key by key. Seed 0 unless given here or there.
    """


@done_by("reproduce.run_reproduce")
def reproduce(
    preset: Annotated[str, required("PRESET", "Preset whose document is repeated.")],
    out: OutOption,
    quick: Annotated[
        bool, typer.Option("--quick", help="A fraction of the scenes: seconds, not minutes.")
    ] = False,
    seed: SeedOption = None,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Repeat a source document's study.

    Writes report.md, claim by claim, with its figures (.png) and their numbers (.csv), and
    run.json. Seed 0 unless given.
    """
