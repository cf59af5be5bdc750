"""The commands, their options and their help."""

import os
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from trackweave.cli.converting import convert, formats
from trackweave.cli.edge import (
    DEBUG,
    done_by,
    last_resort,
    show_json,
    show_our_warnings,
    with_status,
)
from trackweave.cli.fusing import fuse, reproduce
from trackweave.cli.letting_in import token
from trackweave.cli.options import (
    FromOption,
    JsonOption,
    OnBadRow,
    OutOption,
    QuietOption,
    ReportsArgument,
    SeedOption,
    required,
)
from trackweave.cli.serving import replay, serve
from trackweave.cli.studying import study, tune

__all__ = ["app", "run"]

app = typer.Typer(
    name="trackweave",
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    help=(
        "Turn reports of many sensors into tracks of many objects, with a proven bound on every "
        "association.\n\n"
        "Start with `trackweave demo`, then `trackweave track reports.csv --out result`. Exit "
        "status: 0 success, 2 bad usage, bad input or an environment that refuses, 130 "
        "interrupted, 141 nobody reads the output any more, 1 a failure of ours."
    ),
)


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"trackweave {version('trackweave')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_show_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Take the options that stand before a command."""


@app.command()
@done_by("demo.run_demo")
def demo(
    out: OutOption = Path("trackweave-demo"),
    seed: SeedOption = None,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Simulate three radars, track their reports, compare with truth.

    Writes reports.csv, truth.csv, tracker.toml, tracks.csv, assignments.csv, history.csv,
    run.json and a picture, demo.png. Seed 1 unless given.
    """


@app.command()
@done_by("init.run_init")
def init(
    reports: ReportsArgument,
    out: Annotated[Path, typer.Option("--out", "-o", help="File for the configuration.")] = Path(
        "tracker.toml"
    ),
    force: Annotated[bool, typer.Option("--force", help="Replace a file that is there.")] = False,
    learn: Annotated[
        Path | None,
        typer.Option(help="Track the reports and write here what they told, and nothing else."),
    ] = None,
    on_bad_row: Annotated[
        OnBadRow, typer.Option(help="Stop at a bad row, or leave it out and go on.")
    ] = "fail",
    told: FromOption = None,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Write a commented configuration, estimated from a file of reports.

    Each key with its value, its unit and where the value came from. `track --config` with the
    file does what `track` does without a configuration, until you change it, but where tracks
    break off in turns: what was only learned gives way then. With --learn all reports are
    tracked, and what they told of sensors and objects is written, for `track --learned` and
    `serve --learned` to begin from.
    """


@app.command()
@done_by("track.run_track")
def track(
    reports: ReportsArgument,
    out: OutOption,
    config: Annotated[
        Path | None,
        typer.Option(
            "--config",
            "-c",
            help="Configuration (tracker.toml). Keys left out are estimated or default.",
        ),
    ] = None,
    learned: Annotated[
        Path | None,
        typer.Option(
            help="What `init --learn` wrote; it counts where the configuration is silent."
        ),
    ] = None,
    preset: Annotated[
        str | None, typer.Option(help="Preset to apply where the configuration is silent.")
    ] = None,
    priors: Annotated[
        Path | None,
        typer.Option(
            help="Tracks file to set out from: the last row of each track alive at its end."
        ),
    ] = None,
    seed: SeedOption = None,
    deadline_ms: Annotated[
        float | None,
        typer.Option(help="Wall clock per scan in milliseconds; makes runs not repeatable."),
    ] = None,
    on_bad_row: Annotated[
        OnBadRow, typer.Option(help="Stop at a bad row, or list it in run.json and go on.")
    ] = "fail",
    told: FromOption = None,
    also: Annotated[
        list[str] | None,
        typer.Option(help="Further formats to write, such as geojson,kml; `formats` lists them."),
    ] = None,
    engine: Annotated[
        str | None,
        typer.Option(help="Track regions on workers: local, ray, or ray://HOST for its cluster."),
    ] = None,
    workers: Annotated[int | None, typer.Option(help="Regions at a time.")] = None,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Turn reports into tracks.

    Takes any format that `formats` lists, found by its content. A table needs the columns time
    and x,y[,z] (metres), lat,lon[,alt_m], bearing_deg or
    range_m,azimuth_deg[,elevation_deg][,range_rate_mps]; optional are sensor, its place
    (sensor_x,sensor_y), noise (sigma_x and so on), identity, strength, report, scan and others,
    which pass through. Writes tracks.csv (what was known after each scan), assignments.csv
    (which report belongs to which track), history.csv (smoothed after the fact) and run.json
    (configuration as used, cost, lower bound and gap of each scan). Without a configuration
    everything is estimated from the reports, and what was assumed is said. Seed 0 unless given
    here or in the configuration.
    """


@app.command()
@done_by("simulate.run_simulate")
def simulate(
    scenario: Annotated[Path, required("SCENARIO", "Scenario (TOML): area, sensors, targets.")],
    out: OutOption,
    seed: SeedOption = None,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Make reports, and the truth behind them, from a scenario.

    Writes reports.csv (with the column target: the truth, which no tracker reads), truth.csv and
    run.json. The scenario's seed unless one is given.
    """


@app.command()
@done_by("evaluate.run_evaluate")
def evaluate(
    truth: Annotated[
        Path | None, typer.Option(help="Truth: time, target, x, y[, z], or as --from says.")
    ] = None,
    tracks: Annotated[
        Path | None, typer.Option(help="Tracks, as `track` writes them, or as --from says.")
    ] = None,
    assignments: Annotated[
        Path | None,
        typer.Option(
            help="Assignments with the column target, for report measures; these alone "
            "without --truth and --tracks."
        ),
    ] = None,
    cutoff: Annotated[
        float, typer.Option(help="Distance from which a track is not a target's, in metres.")
    ] = 50.0,
    order: Annotated[
        float, typer.Option(help="Exponent p of GOSPA, OSPA and OSPA(2), at least 1.")
    ] = 2.0,
    max_gap: Annotated[
        float | None,
        typer.Option(help="Longest time between a track's rows that is bridged, in seconds."),
    ] = None,
    window: Annotated[
        int, typer.Option(min=1, help="Number of the truth's times over which OSPA(2) is taken.")
    ] = 10,
    told: FromOption = None,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Compare tracks with the truth.

    Confirmed and coasting rows are interpolated to the truth's times; a gap longer than a period
    counts as missed. GOSPA and OSPA(2) with their parts, OSPA, MOTA, IDF1, HOTA, switches,
    fragmentations, RMSE and, with assignments, the share of reports assigned rightly; then each
    target's own record.
    """


@app.command()
@done_by("solve.run_solve")
def solve(
    file: Annotated[
        Path, required("PROBLEM", "Assignment problem: a .csv, .csv.gz, .parquet or .txt file.")
    ],
    method: Annotated[
        str | None, typer.Option(help="Solver by its name; left out, the library's default.")
    ] = None,
    time_limit: Annotated[
        float | None,
        typer.Option(
            help="Seconds for solving; makes answers not repeatable where it is reached."
        ),
    ] = None,
    seed: SeedOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", "-o", help="File for the answer (.csv, .csv.gz, .parquet); replaced if there."
        ),
    ] = None,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Solve an assignment problem: choose tuples of least total cost that share no item.

    A table has the columns i1,…,iS,cost: a row is a tuple, with the number of its item in each
    list, from 1 up, 0 for none. A row with a single item is the price of leaving that item alone,
    0 where there is none. A .txt file may hold an axial problem: a line n n n, then n³ costs,
    every item covered once. Prints cost, lower bound, gap and status: optimal, feasible,
    infeasible, or unknown where the time was over before anything was found. Seed 0 unless given.
    """


@app.command()
@done_by("plot.run_plot")
def plot(
    directory: Annotated[Path, required("DIR", "Directory of a run of `track` or `demo`.")],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            help="File for the picture (.png, .svg, .pdf, or .html for a page to move in), "
            "replaced if there; plot.png in DIR where left out.",
        ),
    ] = None,
    reports: Annotated[
        Path | None,
        typer.Option(help="The reports that were tracked, to draw them; a demo has them in DIR."),
    ] = None,
    truth: Annotated[
        Path | None, typer.Option(help="Truth to draw: time, target, x, y[, z]; as in a demo.")
    ] = None,
    history: Annotated[
        bool, typer.Option("--history", help="Draw the smoothed history of tracks.")
    ] = False,
    pixels: Annotated[
        bool, typer.Option("--pixels", help="Positions are pixels of an image, y downwards.")
    ] = False,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Draw a run from its files.

    The plan from above with tracks, sensors and, where they are given, reports and truth; the
    number of tracks by status, reports and those assigned in each scan, the gap to the bound with
    the scans told apart that were proven optimal, CPU per scan, and the speed of tracks over time.
    As .html it is one page with pan, zoom, a time slider and hover, which needs no network.
    """


app.command()(convert)
app.command()(formats)
app.command()(fuse)
app.command()(reproduce)
app.command()(study)
app.command()(token)
app.command()(tune)
app.command()(serve)
app.command()(replay)


@app.command()
@with_status
def schema() -> None:
    """Print the JSON Schema of tracker.toml.

    Editors that know it check the file and complete its keys.
    """
    from trackweave.config.schema import json_schema

    show_json(json_schema())


@app.command()
@done_by("warm.run_warm")
def warm(
    everything: Annotated[
        bool,
        typer.Option("--all", help="Every command, model and solver: many minutes to compile."),
    ] = False,
    json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Compile beforehand what `demo` and a first `track` need, and say what came compiled.

    Says how many kernels of those that it needs came with the package, were kept from earlier
    runs and were compiled now, where they lie, and, where none that came are used, why not.
    """


def run() -> None:
    """Run the command that the arguments name."""
    if not os.environ.get(DEBUG):
        show_our_warnings()
    if "MPLCONFIGDIR" not in os.environ and not os.access(Path.home(), os.W_OK):
        # Matplotlib warns at length where it finds no folder to write to.
        os.environ["MPLCONFIGDIR"] = tempfile.gettempdir()
    with last_resort():
        app()
