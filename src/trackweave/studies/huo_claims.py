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
    share_where,
    verdict_of,
)
from trackweave.studies.sentences import Sentences
from trackweave.studies.writing import Table, claims_text, numbers, text_by, text_table

__all__ = ["write_up"]

Tables = Mapping[str, Table]
SAY = Sentences("huo")
LEAST = "at the least J"
PICTURES = {
    "strings": ("strings",), "search": ("search", "optimum"), "spacing": ("spacing",),
}  # fmt: skip


def write_up(tables: Tables, quick: bool) -> WriteUp:
    """Return what the study's tables say: report, claims and figures."""
    claims = _claims(tables)
    grouped = {"spacing": 1, "sizes": 3, "two-nodes": 2, "confirmation": 2, "stops": 3}
    texts = {name: _summary(tables[name], n_keys) for name, n_keys in grouped.items()}
    texts["strings"] = text_table(tables["strings"].columns, tables["strings"].rows())
    texts["search"] = _search_text(tables["search"])
    sections = []
    for name, words in SAY.sections().items():
        pictures = "".join(f"![]({picture}.png) " for picture in PICTURES.get(name, ()))
        sections.append(f"## {words}\n\n{texts[name]}\n\n{pictures}Numbers: {name}.csv")
    report = (
        f"{SAY.text('begin')}## Claims\n\n{claims_text(claims)}\n\n" + "\n\n".join(sections) + "\n"
    )
    return WriteUp(report, claims, _figures(tables))


def _mean(table: Table, name: str, **where: object) -> Interval:
    return mean_of(numbers(table, name, **where), "%")


def _optimal(table: Table, **where: object) -> Interval:
    return share_where(numbers(table, "excess", **where) == 0.0)


def _brief(found: Interval, most: float) -> str | None:
    """Return a figure from 0 to ``most`` with its interval as a table's cell."""
    if not found.count:
        return None
    low, high = max(found.low, 0.0), min(found.high, most)
    return f"{found.value:.4g}" + (f" ({low:.4g} to {high:.4g})" if found.count > 1 else "")


def _summary(table: Table, n_keys: int) -> str:
    keys, names = table.columns[:n_keys], table.columns[n_keys:]
    if "excess" not in names:
        return text_by(table, keys, names, lambda own, name: _brief(_mean(own, name), 100.0))
    return text_by(table, keys, [*names, LEAST], lambda own, name: (
        str(_optimal(own)) if name == LEAST else _brief(_mean(own, name), np.inf)
    ))  # fmt: skip


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
    cases = {
        "least": (10, 6.0, "with"), "least-without": (10, 6.0, "without"),
        "least-of-20": (20, 6.0, "with"), "least-near": (20, 2.0, "with"),
    }  # fmt: skip
    claims = []
    for name, (objects, spacing, rule) in cases.items():
        own = {"objects": objects, "spacing": spacing, "rule 2": rule}
        share, excess = _optimal(stops, **own), _mean(stops, "excess", **own)
        found = SAY.text("ends" if share.count else "unmeasured")
        found = found.format(share=share, excess=excess)
        claims.append(SAY.claim(name, at_least(share, 95.0), found=found))
    return claims


def _claims(tables: Tables) -> tuple[Claim, ...]:
    spacing, search, strings = tables["spacing"], tables["search"], tables["strings"]
    drawn = {(1, 9, 4), (2, 10, 7), (10, 5, 2)}
    listed = {str(row[4]) for row in strings.rows()}
    exact = numbers(search, "excess", search="exact")
    relaxed = _optimal(search, search="relaxation")
    return (
        SAY.claim("experiments", Verdict.CANNOT_BE_TOLD),
        SAY.claim(
            "chromosome", verdict_of({str(one) for one in drawn} <= listed), listed=len(listed),
        ),
        *_least_j(tables["stops"]),
        SAY.claim(
            "powerless", verdict_of(bool(np.any(exact > 0.0))),
            proven=np.count_nonzero(exact == 0.0), scenes=exact.size,
        ),
        SAY.claim("relaxation", at_least(relaxed, 95.0), relaxed=relaxed),
        *_against_practice(tables),
        *_confirming(tables["confirmation"]),
        _better("default", numbers(spacing, "default") - numbers(spacing, "pairwise")),
    )  # fmt: skip


def _better(name: str, difference: FloatArray) -> Claim:
    found = mean_of(difference, "points")
    if found.count > 1 and found.high < 0.0:
        verdict = Verdict.DOES_NOT_HOLD
    else:
        verdict = Verdict.HOLDS if found.low > 0.0 else Verdict.CANNOT_BE_TOLD
    return SAY.claim(name, verdict, found=found)


def _against_practice(tables: Tables) -> list[Claim]:
    spacing, two = tables["spacing"], tables["two-nodes"]
    return [
        _better("exact", numbers(spacing, "exact") - numbers(spacing, "pairwise")),
        _better("document", numbers(spacing, "document") - numbers(spacing, "pairwise")),
        _better(
            "all-times",
            numbers(two, "document", shared=0.0) - numbers(two, "weighted", shared=0.0),
        ),
        _better(
            "modified", numbers(two, "modified", shared=0.5) - numbers(two, "weighted", shared=0.5)
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
            SAY.claim(
                "confirming",
                at_most(found, 0.0) if found.value else Verdict.CANNOT_BE_TOLD,
                words=words,
                found=found,
                shares=shares,
            )
        )
    return claims
