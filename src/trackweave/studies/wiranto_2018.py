"""Wiranto & Bonok (2018), repeated: three radars, three courses, 100 scans."""

from collections.abc import Mapping

import numpy as np

from trackweave.plotting.panels_of_curves import Panel, SpreadCurve, picture_of_panels
from trackweave.studies import Claim, Progress, Study
from trackweave.studies.wiranto_claims import claims_of
from trackweave.studies.wiranto_figures import document_figures, draw_figure_sky
from trackweave.studies.wiranto_parts import NOISES, SKIES, by_noise, sorting, summary, tracking
from trackweave.studies.wiranto_tracks import IMM, LEGS, PRESET
from trackweave.studies.writing import Table, claims_text, csv_table, text_table

__all__ = ["reproduce"]

CPU = "CPU [ms/scan]"
SHOWN = (
    "classified rightly [%]", "grouped rightly [%]", "objects per scan",
    "scans with the true number [%]", "above the least cost [nats]", "scans at the least cost [%]",
)  # fmt: skip
FEWER_NOISES = (1.0, 30.0)


def reproduce(
    rng: np.random.Generator, quick: bool = False, progress: Progress | None = None
) -> Study:
    """Return the study: the document's method, exact and greedy answers, and our defaults.

    Parameters
    ----------
    rng
        Source of randomness.
    quick
        Whether a fraction of the skies will do.
    progress
        Called with the number of parts done and of all.

    Returns
    -------
    Report, claims and figures with their numbers. All but ``cpu.csv`` is the same from run to run.
    """
    n_skies = dict(zip(SKIES, (2, 1, 1) if quick else (30, 10, 10), strict=True))
    n_tracked, n_noises = (2, 1) if quick else (20, 5)
    done, total = 0, sum(n_skies.values()) + n_tracked + n_noises + 1

    def step() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, total)

    files = document_figures(draw_figure_sky(rng))
    step()
    sorted_plots = sorting(rng, n_skies, step)
    followed, courses = tracking(rng, n_tracked, step)
    noise = by_noise(rng, FEWER_NOISES if quick else NOISES, n_noises, step)
    claims = claims_of(sorted_plots, followed, courses)
    files["noise.png"] = _picture_of_noise(noise)
    files |= _numbers({
        "sorting": sorted_plots, "tracking": followed, "courses": courses, "noise": noise,
    })  # fmt: skip
    report = _report(claims, n_skies, {
        "sorting": summary(sorted_plots, ("sky", "method"), SHOWN),
        "tracking": summary(followed, ("tracker",), _without_cpu(followed).head[2:]),
        "courses": summary(courses, ("leg", "what"), courses.head[3:]),
        "noise": summary(noise, ("tracker", "noise [m²/s³]", "leg"), noise.head[4:]),
    })  # fmt: skip
    return Study(report, claims, dict(sorted(files.items())))


def _without_cpu(table: Table) -> Table:
    keep = [place for place, name in enumerate(table.head) if name != CPU]
    return Table(
        tuple(table.head[place] for place in keep),
        tuple(tuple(row[place] for place in keep) for row in table.rows),
    )


def _numbers(tables: Mapping[str, Table]) -> dict[str, bytes]:
    """Return the numbers of each draw; CPU times, which differ from run to run, by themselves."""
    files: dict[str, bytes] = {}
    times: list[tuple[object, ...]] = []
    for name, table in tables.items():
        plain = _without_cpu(table)
        files |= csv_table(plain.head, plain.rows, f"{name}.csv")
        if CPU not in table.head:
            continue
        keys = ("sky", "method") if "method" in table.head else ("tracker",)
        for row in summary(table, keys, (CPU,)).rows:
            times.append((name, " – ".join(map(str, row[:-1])), row[-1]))
    return files | csv_table(("part", "what", CPU), times, "cpu.csv")


def _picture_of_noise(table: Table) -> bytes:
    panels = []
    for title, name, leg in (
        ("Displacement in the turn", "to the right [m]", LEGS[1]),
        ("Error in the turn", "RMSE [m]", LEGS[1]),
        ("Error on straight courses", "RMSE [m]", LEGS[0]),
    ):
        curves = {}
        for tracker in (PRESET, IMM):
            noises = np.unique(table.column("noise [m²/s³]"))
            found = [
                table.column(name, tracker=tracker, leg=leg, **{"noise [m²/s³]": noise})
                for noise in noises.tolist()
            ]
            curves[tracker] = SpreadCurve(
                noises, np.array([each.mean() for each in found]),
                np.array([each.std() for each in found]),
            )  # fmt: skip
        panels.append(Panel(title, "process noise [m²/s³]", name, curves, x_logarithmic=True))
    return picture_of_panels(panels)


def _report(
    claims: tuple[Claim, ...], n_skies: Mapping[str, int], shown: Mapping[str, Table]
) -> str:
    counts = ", ".join(f"{count} {name}" for name, count in n_skies.items())
    parts = {
        "sorting": "## Plots instant by instant\n\nDraws: " + counts + ". *as chosen*: 4 false "
        "alarms per radar and scan; *dense clutter*: 20; *formations*: three aircraft abreast on "
        "each course, 283 m apart. *classified rightly*: plots of aircraft in a group, false "
        "alarms in none. *grouped rightly*: with all plots of the aircraft and no other. *above "
        "the least cost*: than the exact answer at the same cost. *default*: evidence, solved by "
        "`auto`.",
        "tracking": "## Whole trackers\n\nOne after the other on each sky as chosen, knowing "
        "radars and densities; process noise 30 m²/s³, with `imm` 1 m²/s³. *one-to-one*: the "
        "preset but for `[tracker] pairing`. *evidence, nearest neighbour*: `[plots] fuse`, one "
        "to one.",
        "courses": "## Off the course\n\nThe same runs. *plots*: of one radar each. *scatter*: "
        "about the mean offset. *to the right*: outside of the turn, which is to the left. "
        "Straight courses after their first 10 s. *history*: smoothed after the fact.",
        "noise": "## What the process noise does\n\nOne number for both a straight course and a "
        "turn is a choice between error and displacement.\n\n![](noise.png)",
    }
    sections = [
        f"{text}\n\n{text_table(shown[name].head, shown[name].rows)}\n\nNumbers: {name}.csv"
        for name, text in parts.items()
    ]
    return f"{_BEGIN}{claims_text(claims)}{_FIGURES}" + "\n\n".join(sections) + "\n"


_BEGIN = """# wiranto-2018, repeated

I. Wiranto, Z. Bonok, *Application of ant system and nearest neighbor Kalman filter for multi \
target tracking in multi sensor radar system*, ARPN, 2018.

**The document prints no numbers**, neither of its simulation nor of what came out. What is said \
there are three identical radars, three courses, one of them with a manoeuvre, and 100 scans. \
The rest is ours: 20 km × 20 km, σ 50 m along each axis, detection probability 0.9, 4 false \
alarms per radar and scan, a scan each second; two aircraft at 155 and 163 m/s that pass each \
other at 59 m, and one at 150 m/s that turns left by 90° in 30 s. Numbers are mean ± standard \
deviation (least to greatest) over draws. CPU times are in cpu.csv, which alone differs from run \
to run.

## Claims

"""
_FIGURES = """

## The document's figures

![](figure3.png) ![](figure4.png)

![](figure5.png)

![](figure6.png) Numbers: figure3.csv to figure6.csv

"""
