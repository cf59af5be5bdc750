"""What the measured tables say of Huo and others' sentences: claims, report, figures."""

from collections.abc import Mapping, Sequence

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.plotting.panels_of_curves import Panel, SpreadCurve, picture_of_panels
from trackweave.plotting.strings import StringRow, picture_of_strings
from trackweave.studies import Claim, WriteUp
from trackweave.studies.judging import (
    Interval,
    Verdict,
    at_least,
    at_most,
    mean_of,
    share_of,
    verdict_of,
)
from trackweave.studies.writing import Table, claims_text, numbers, text_table

__all__ = ["write_up"]

Tables = Mapping[str, Table]
OURS = "≥ 95 % of scenes (ours)"
BEGIN = """# huo-2008, repeated

Huo L., Zhang Z., Bai P., Song Y., Xiong X., *A sort of model of multi-sensor multi-object flight
path connection based on GA*, 2008.

**The document prints no result figures**, no scene and no parameters: scenes, rates, sizes and
thresholds are ours. *document*: its genetic algorithm on its problem (every track in exactly one
tuple), sizes by the preset's rule. *relaxation*: Lagrangian prices, as the document credits to
Deb and others, on the same problem. *exact*: the proven answer of it. *pairwise*: one optimal
assignment per further sensor, the usual practice. *nearest*: each track in turn takes the nearest
group. *default*: ours. *weighted*, *modified*, *nearest neighbour*: the methods for two nodes
that it names, on the last time alone. Figures are means with 95 % intervals.

"""
SECTIONS = {
    "strings": "Figs. 1 and 2: a chromosome, and a swap in it\n\nThe tuples of objects 1, 2 and "
    "10 are the document's; it prints the others in its drawing only, and these are ours.",
    "search": "The search: J above the least one after so many evaluations [%]\n\nAt 6 σ, no stop "
    "rule; P_r = 0.2 and the rest crossed. In brackets the share of scenes at the least J. "
    "*default* and *relaxation* count steps of prices.",
    "stops": "Where the preset stops\n\nM = 3, by its own rules, with stop rule 2 (no better "
    "for so many generations) and without.",
    "spacing": "Right associations against spacing [%]\n\nM = 3, n = 10, five times: the share of "
    "tracks whose group is exactly the tracks of their object.",
    "sizes": "More sensors, more objects, objects that some sensors do not see [%]\n\nAt 6 σ. The "
    "document's problem needs every sensor to see every object; of more than 40 genes its search "
    "takes minutes, and is left out.",
    "two-nodes": "Two nodes [%]\n\nM = 2, n = 10. *shared*: the part of each error's variance "
    "that both sensors have in common, which the document takes to be none.",
    "confirmation": "What the N/M rule does to wrong declarations [%]\n\nM = 3, n = 10 at 2 σ, "
    "eight successive associations; 1/1 declares the last one's result.",
}
PICTURES = {
    "strings": ("strings",), "search": ("search", "optimum"), "spacing": ("spacing",),
}  # fmt: skip


def write_up(tables: Tables, quick: bool) -> WriteUp:
    """Return what the study's tables say: report, claims and figures."""
    claims = _claims(tables)
    shown = {name: table for name, table in tables.items() if name not in {"search", "strings"}}
    grouped = {
        "spacing": 1, "sizes": 3, "two-nodes": 2, "confirmation": 2, "stops": 3,
    }  # fmt: skip
    texts = {name: _summary(table, grouped[name]) for name, table in shown.items()}
    texts["strings"] = text_table(tables["strings"].columns, tables["strings"].rows())
    texts["search"] = _search_text(tables["search"])
    sections = []
    for name, words in SECTIONS.items():
        pictures = "".join(f"![]({picture}.png) " for picture in PICTURES.get(name, ()))
        sections.append(f"## {words}\n\n{texts[name]}\n\n{pictures}Numbers: {name}.csv")
    report = f"{BEGIN}## Claims\n\n{claims_text(claims)}\n\n" + "\n\n".join(sections) + "\n"
    return WriteUp(report, claims, _figures(tables))


def _mean(table: Table, name: str, **where: object) -> Interval:
    return mean_of(numbers(table, name, **where), "%")


def _optimal(table: Table, **where: object) -> Interval:
    excess = numbers(table, "excess", **where)
    return share_of(int(np.count_nonzero(excess == 0.0)), excess.size)


def _brief(found: Interval, most: float) -> str | None:
    """Return a figure from 0 to ``most`` with its interval as a table's cell."""
    if not found.count:
        return None
    low, high = max(found.low, 0.0), min(found.high, most)
    return f"{found.value:.4g}" + (f" ({low:.4g} to {high:.4g})" if found.count > 1 else "")


def _summary(table: Table, n_keys: int) -> str:
    keys, names = table.columns[:n_keys], table.columns[n_keys:]
    most, rows = np.inf if "excess" in names else 100.0, []
    for key, own in table.group_by(keys, maintain_order=True):
        cells = [_brief(_mean(own, name), most) for name in names]
        if "excess" in names:
            cells.append(str(_optimal(own)))
        rows.append((*key, *cells))
    more = ("at the least J",) if "excess" in names else ()
    return text_table((*keys, *names, *more), rows)


def _search_text(table: Table) -> str:
    """Return one line for each size and search: excess and share at the optimum by evaluations."""
    marks = sorted({row[3] for row in table.rows() if "P_m" in row[2]})
    rows: list[tuple[object, ...]] = []
    for (size, search), own in table.group_by("M × n", "search", maintain_order=True):
        if "P_m" not in str(search):
            used = numbers(own, "evaluations").mean()
            cell = f"{_mean(own, 'excess').value:.3g} after {used:.0f}"
            rows.append((size, search, *[None] * (len(marks) - 1), cell))
            continue
        cells = []
        for mark in marks:
            found = _mean(own, "excess", evaluations=mark)
            share = _optimal(own, evaluations=mark)
            cells.append(f"{found.value:.3g} [{share.value:.0f}]" if found.count else None)
        rows.append((size, search, *cells))
    return text_table(("M × n", "search", *(f"{mark:,}" for mark in marks)), rows)


def _figures(tables: Tables) -> dict[str, bytes]:
    strings, spacing = tables["strings"], tables["spacing"]
    fig_1 = [StringRow(f"sensor {k + 1}", _cells(strings, name)) for k, name in enumerate("abc")]
    before, after = _cells(strings, "c"), _cells(strings, "c after the swap")
    moved = tuple(
        k for k, pair in enumerate(zip(before, after, strict=True)) if pair[0] != pair[1]
    )
    fig_2 = [StringRow("before", before, moved), StringRow("after", after, moved)]
    titles = {"Fig. 1: a chromosome of three substrings": fig_1, "Fig. 2: swap mutation": fig_2}
    curves = {
        name: _spread([(key, _mean(own, name)) for (key,), own in
                       spacing.group_by("spacing", maintain_order=True)])
        for name in spacing.columns[1:] if name != "relaxation"
    }  # fmt: skip
    panel = Panel("Right associations, M = 3, n = 10", "spacing [σ]", "tracks [%]", curves)
    return {
        "strings.png": picture_of_strings(titles),
        "spacing.png": picture_of_panels([panel]),
        "search.png": picture_of_panels(_search_panels(tables["search"], "J above the least [%]")),
        "optimum.png": picture_of_panels(_search_panels(tables["search"], "at the least J [%]")),
    }


def _cells(table: Table, name: str) -> tuple[str, ...]:
    return tuple(str(int(value)) for value in numbers(table, name))


def _spread(points: Sequence[tuple[object, Interval]]) -> SpreadCurve:
    x = np.array([float(str(place)) for place, _ in points])
    y, *ends = np.array([(f.value, f.value - f.low, f.high - f.value) for _, f in points]).T
    return SpreadCurve(x, y, np.where(np.isfinite(ends), ends, 0.0))


def _search_panels(table: Table, what: str) -> list[Panel]:
    is_excess = "above" in what
    panels = []
    for (size,), scenes in table.group_by("M × n", maintain_order=True):
        curves = {}
        for (search,), own in scenes.group_by("search", maintain_order=True):
            # What is proven least is 0 by itself.
            if search in {"exact", "relaxation"}:
                continue
            marks, each = numbers(own, "evaluations").mean(keepdims=True), [own]
            if "P_m" in str(search):
                marks = np.unique(numbers(own, "evaluations"))
                each = [own.filter(evaluations=mark) for mark in marks]
            found = [_mean(one, "excess") if is_excess else _optimal(one) for one in each]
            y = np.array([one.value for one in found])
            curves[str(search)] = SpreadCurve(marks, y)
        panels.append(Panel(f"M × n = {size}", "evaluations", what, curves, True, is_excess))
    return panels


def _least_j(stops: Table) -> list[Claim]:
    texts = {
        (10, 6.0, "with"): "The genetic algorithm finds the least J of M = 3, n = 10",
        (10, 6.0, "without"): "… without stop rule 2, for its G generations",
        (20, 6.0, "with"): "… of n = 20, its sizes grown by the preset's rule",
        (20, 2.0, "with"): "… of n = 20 where objects are 2 σ apart",
    }
    claims = []
    for (objects, spacing, rule), text in texts.items():
        own = {"objects": objects, "spacing": spacing, "rule 2": rule}
        share, excess = _optimal(stops, **own), _mean(stops, "excess", **own)
        found = f"It ends there in {share} of the scenes, and above it by {excess} on average."
        if not share.count:
            found = "Not measured by a quick run."
        claims.append(Claim(text, at_least(share, 95.0), found, OURS))
    return claims


def _claims(tables: Tables) -> tuple[Claim, ...]:
    spacing, search, strings = tables["spacing"], tables["search"], tables["strings"]
    drawn = {(1, 9, 4), (2, 10, 7), (10, 5, 2)}
    listed = {str(row[4]) for row in strings.rows()}
    exact = numbers(search, "excess", search="exact")
    relaxed = _optimal(search, search="relaxation")
    return (
        Claim(
            "“Simulation experiments testify the correctness and validity” (abstract)",
            Verdict.CANNOT_BE_TOLD,
            "The document prints no result, figure or number of an experiment to compare with.",
        ),
        Claim(
            "Fig. 1's chromosome is the tuples {1, 9, 4}, {2, 10, 7}, …, {10, 5, 2}; Fig. 2 swaps "
            "two genes",
            verdict_of({str(one) for one in drawn} <= listed),
            f"The search reads {len(listed)} tuples out of it, these three among them.",
        ),
        *_least_j(tables["stops"]),
        Claim(
            "For s ≥ 3 traditional searches such as integer programming are “powerless” "
            "(introduction)",
            verdict_of(bool(np.any(exact > 0.0))),
            f"Branch and bound proves the least J of {np.count_nonzero(exact == 0.0)} of "
            f"{exact.size} scenes, M × n as below.",
        ),
        Claim(
            "“The more effective method at present is the relaxation” of Deb and others "
            "(introduction), which the genetic algorithm is to better",
            at_least(relaxed, 95.0),
            f"Prices alone end at the least J in {relaxed} of the scenes; no search can do better "
            "there.",
            OURS,
        ),
        *_against_practice(tables),
        *_confirming(tables["confirmation"]),
        _better(
            "Our default associates more tracks rightly than pairwise assignment",
            numbers(spacing, "default") - numbers(spacing, "pairwise"),
        ),
    )  # fmt: skip


def _better(text: str, difference: FloatArray) -> Claim:
    found = mean_of(difference, "points")
    if found.count > 1 and found.high < 0.0:
        verdict = Verdict.DOES_NOT_HOLD
    else:
        verdict = Verdict.HOLDS if found.low > 0.0 else Verdict.CANNOT_BE_TOLD
    return Claim(text, verdict, f"By {found}.", "above 0 points of right associations (ours)")


def _against_practice(tables: Tables) -> list[Claim]:
    spacing, two = tables["spacing"], tables["two-nodes"]
    return [
        _better(
            "M-dimensional assignment, solved exactly, beats the usual practice of two lists at a "
            "time",
            numbers(spacing, "exact") - numbers(spacing, "pairwise"),
        ),
        _better(
            "… and so it does as the genetic algorithm solves it",
            numbers(spacing, "document") - numbers(spacing, "pairwise"),
        ),
        _better(
            "λ summed over all times (eq. 6) beats the weighted method for two nodes at one time",
            numbers(two, "document", shared=0.0) - numbers(two, "weighted", shared=0.0),
        ),
        _better(
            "The modified method beats the weighted one where errors have half their variance in "
            "common",
            numbers(two, "modified", shared=0.5) - numbers(two, "weighted", shared=0.5),
        ),
    ]


def _confirming(table: Table) -> list[Claim]:
    claims = []
    for memory, words in (("one time", "each time judged alone"), ("all times", "λ over all")):
        wrong = {
            str(rule): numbers(own, "wrong among declared", memory=memory)
            for (rule,), own in table.group_by("N/M", maintain_order=True)
        }
        # What declares nothing declares nothing wrong.
        less = np.nan_to_num(wrong["3/4"]) - np.nan_to_num(wrong["1/1"])
        found = mean_of(less, "points")
        means = {rule: mean_of(own) for rule, own in wrong.items()}
        shares = ", ".join(
            f"{rule} {mean.value:.0f} %" if mean.count else f"{rule} declares nothing"
            for rule, mean in means.items()
        )
        claims.append(
            Claim(
                f"The N/M rule is “to reduce errors” (section 2.5): 3/4 at 2 σ, {words}",
                at_most(found, 0.0) if found.value else Verdict.CANNOT_BE_TOLD,
                f"Wrong among what is declared: {found}; by rule: {shares}.",
                "below 0 points of what is declared (ours)",
            )
        )
    return claims
