"""What the patent says, and what came out."""

from collections.abc import Mapping

import numpy as np

from trackweave.arrays import FloatArray
from trackweave.studies import Claim
from trackweave.studies.hillis_search import BY_SIZE, CLOSE, DEFAULT, LISTS, USABLE
from trackweave.studies.judging import (
    Interval,
    at_least,
    at_most,
    mean_of,
    share_of,
    share_where,
    verdict_of,
)
from trackweave.studies.sentences import Sentences
from trackweave.studies.writing import Table, numbers

__all__ = ["SAY", "claims_of", "last_of", "searches_of", "sizes_of"]

NEAR = 1.0
"""A hypothesis is good within this of the best [nats]: less than e times less likely."""
OFTEN = 95.0
"""What counts as finding the best hypothesis [% of windows]."""
LITTLE = 1.0
"""What counts as little to send [numbers per hundred that are decoded]."""
PRESET_THRESHOLD = 3.0
ALIKE_LISTS = "population 300"
ALIKE = 5.0
"""Shares within this of each other are alike [points of per cent]."""
SAY = Sentences(
    "hillis", near=NEAR, often=OFTEN, little=LITTLE, alike=ALIKE, alike_lists=ALIKE_LISTS,
    preset_threshold=PRESET_THRESHOLD,
)  # fmt: skip
Tables = Mapping[str, Table]


def sizes_of(table: Table) -> list[int]:
    """Return the numbers of objects, ascending."""
    return table["objects"].unique().sort().to_list()


def searches_of(table: Table, objects: int) -> list[str]:
    """Return the searches that were tried on windows of so many objects."""
    return table.filter(objects=objects)["search"].unique(maintain_order=True).to_list()


def last_of(table: Table, objects: int, search: str) -> tuple[FloatArray, float]:
    """Return a search's last excess in each window, and its mean number of evaluations."""
    own = table.filter(objects=objects, search=search)
    last = own.group_by("window", maintain_order=True).last()
    return numbers(last, "excess [nats]"), float(numbers(last, "evaluations").mean())


def claims_of(tables: Tables) -> tuple[Claim, ...]:
    """Return the patent's claims with what came out of each."""
    sizes = sizes_of(tables["search"])
    return (
        *_certain(tables),
        *_early_choice(tables),
        *_windows(tables["depths"]),
        *(_good(tables["search"], objects) for objects in sizes),
        _optimal(tables["search"], sizes),
        _lists(tables["search"], sizes),
        *_stops(tables),
        *_alone(tables["arrivals"]),
        *_islands(tables["islands"]),
        _usable(tables["search"], sizes),
    )


def _share(excess: FloatArray) -> Interval:
    return share_where(excess <= CLOSE)


def _certain(tables: Tables) -> list[Claim]:
    claims = []
    for row in tables["figures"].to_dicts():
        misprint = SAY.text("misprint") if str(row["figure"]) == "1" else ""
        claims.append(
            SAY.claim(
                "encoded",
                verdict_of(set(row["decoded"].split()) == set(row["drawing"].split())),
                misprint=misprint,
                cost=row["cost [nats]"],
                **row,
            )
        )
    (strings,), (children,) = tables["strings"].to_dicts(), tables["children"].to_dicts()
    return [
        *claims,
        SAY.claim(
            "many-to-one", verdict_of(strings["hypotheses"] < strings["strings"]), **strings
        ),
        SAY.claim(
            "children",
            verdict_of(tuple(children.values()) == ("1-2-3-4-6-5", "3-4-1-2-5-6")),
            **children,
        ),
    ]


def _early_choice(tables: Tables) -> tuple[Claim, ...]:
    cost = {
        (row["scans"], str(row["as in Figure"])): row["cost [nats]"]
        for row in tables["example"].to_dicts()
    }
    said = {(row["window"], row["scans"]): row for row in tables["said"].to_dicts()}
    best = next(r for r in tables["figures"].to_dicts() if str(r["figure"]) == "4")["decoded"]
    early, late = cost[2, "3"] - cost[2, "2"], cost[3, "2"] - cost[3, "3"]
    one, searched = said["one scan", 3], said["five scans, searched", 3]
    return (
        SAY.claim("early-choice", verdict_of(early > 0.0 and late > 0.0), early=early, late=late),
        SAY.claim(
            "scan-by-scan",
            verdict_of(set(one["tracks"].split()) != set(best.split())),
            tracks=one["tracks"],
        ),
        SAY.claim(
            "amended",
            verdict_of(
                bool(searched["amended"]) and set(searched["tracks"].split()) == set(best.split())
            ),
            tracks=searched["tracks"],
            amended=searched["amended"] or "nothing",
        ),
    )


def _windows(table: Table) -> tuple[Claim, ...]:
    def gain(method: str) -> Interval:
        scenes = numbers(table, "scene", method=method, depth=5).size
        right = [numbers(table, "right [%]", method=method, depth=d)[:scenes] for d in (5, 1)]
        return mean_of(right[0] - right[1], "points")

    exact, document = gain("exact"), gain("document")
    excess = mean_of(numbers(table, "excess [nats]", method="document", depth=5), "nats")
    others = "; ".join(f"{name} {gain(name)}" for name in ("its best", "hillis", "default"))
    return (
        SAY.claim("multi-scan", at_least(exact, 0.0), exact=exact, others=others),
        SAY.claim("multi-scan-searched", at_least(document, 0.0), document=document),
        SAY.claim("over-scenes", at_most(excess, NEAR), excess=excess),
    )  # fmt: skip


def _good(table: Table, objects: int) -> Claim:
    excess, spent = last_of(table, objects, BY_SIZE)
    found = mean_of(excess, "nats")
    others = [
        f"{name}: {last_of(table, objects, name)[0].mean():.3g}"
        for name in searches_of(table, objects)
        if name.startswith("population")
    ]
    return SAY.claim(
        "good", at_most(found, NEAR), objects=objects, found=found, spent=spent,
        share=_share(excess), others="; ".join(others),
    )  # fmt: skip


def _optimal(table: Table, sizes: list[int]) -> Claim:
    found = {objects: _share(last_of(table, objects, BY_SIZE)[0]) for objects in sizes}
    whole = np.concatenate([last_of(table, objects, BY_SIZE)[0] for objects in sizes])
    each = "; ".join(f"{objects} objects {share}" for objects, share in found.items())
    return SAY.claim("optimal", at_least(_share(whole), OFTEN), each=each)  # fmt: skip


def _lists(table: Table, sizes: list[int]) -> Claim:
    """Compare both genotypes, of one population and after as many evaluations."""
    less = {
        objects: last_of(table, objects, LISTS)[0] - last_of(table, objects, ALIKE_LISTS)[0]
        for objects in sizes
    }
    found = mean_of(np.concatenate(list(less.values())), "nats")
    each = "; ".join(f"{objects} objects {mean_of(own)}" for objects, own in less.items())
    return SAY.claim("permutations", at_least(found, 0.0), found=found, each=each)  # fmt: skip


def _stops(tables: Tables) -> tuple[Claim, ...]:
    table, stops, curves = tables["thresholds"], tables["interruptions"], tables["search"]
    by_size = curves.filter(search=BY_SIZE).drop_nulls("excess [nats]")
    courses = [own for _, own in by_size.group_by("objects", "window")]
    preset, words = share_of(0, 0), []
    for (level,), own in table.group_by("threshold [nats]", maintain_order=True):
        when, of, excess = (numbers(own, name) for name in ("generation", "of", "excess [nats]"))
        is_met = np.isfinite(when)
        share = share_where(is_met)
        preset = share if level == PRESET_THRESHOLD else preset
        if is_met.any():
            at = 100.0 * float(np.mean(when[is_met] / of[is_met]))
            words.append(
                f"{level:g} nats in {share}, after {at:.0f} % of the generations, "
                f"{excess[is_met].mean():.3g} nats above the best"
            )
    late = "; ".join(
        f"{look}: {mean_of(numbers(own, 'excess [nats]'), 'nats')}"
        for (look,), own in stops.group_by("looks", maintain_order=True)
    )
    windows = [own for _, own in stops.group_by("window")]
    return (
        SAY.claim("generations", verdict_of(all(map(_falls, courses))), courses=len(courses)),
        SAY.claim("threshold", at_least(preset, 50.0), each='; '.join(words)),
        SAY.claim(
            "interrupted", verdict_of(all(map(_falls, windows)) and bool(stops["whole"].all())),
            each=late,
        ),
    )  # fmt: skip


def _falls(course: Table) -> bool:
    """Tell whether an excess never rises."""
    return bool(np.all(np.diff(numbers(course, "excess [nats]")) <= CLOSE))


def _alone(table: Table) -> tuple[Claim, ...]:
    orders = ("in time", "late")
    alone = [numbers(table, "alone right [%]", arrival=name) for name in orders]
    scans = [numbers(table, "of scans right [%]", arrival=name) for name in ("none", *orders)]
    lost, moved = mean_of(scans[0] - scans[2], "points"), mean_of(alone[0] - alone[1], "points")
    behind = mean_of(scans[1] - alone[0], "points")
    told = [mean_of(each, "%") for each in (*scans, alone[0])]
    words = SAY.text("scanned")
    return (
        SAY.claim(
            "alone", at_most(behind, 0.0, ALIKE), words=words, scans=told[1], alone=told[3],
            behind=behind, moved=moved,
        ),
        SAY.claim(
            "alone-late", at_most(lost, 0.0, ALIKE), words=words, without=told[0], scans=told[1],
            late=told[2], lost=lost,
        ),
    )  # fmt: skip


def _islands(table: Table) -> tuple[Claim, ...]:
    names = table["search"].unique(maintain_order=True).to_list()
    excess = {name: numbers(table, "excess [nats]", search=name) for name in names}
    same = table["same on threads"].drop_nulls().to_list()
    spread = names[3]
    more = mean_of(excess[spread] - excess[names[0]], "nats")
    sent = numbers(table, "sent") / numbers(table, "evaluations")
    worst = 100.0 * float(np.max(sent, initial=0.0, where=np.isfinite(sent)))
    listed = "; ".join(f"{name} {mean_of(each, 'nats')}" for name, each in excess.items())
    return (
        SAY.claim("islands", verdict_of(all(same)), searches=len(same)),
        SAY.claim("islands-close", at_most(more, 0.0, NEAR), more=more, listed=listed),
        SAY.claim("communication", verdict_of(worst <= LITTLE), worst=worst),
    )  # fmt: skip


def _usable(table: Table, sizes: list[int]) -> Claim:
    words, every = [], []
    for objects in sizes:
        excess, spent = last_of(table, objects, USABLE)
        every.append(excess)
        words.append(f"{objects} objects: {_share(excess)} after {spent:,.0f} evaluations")
    proven = np.concatenate([last_of(table, objects, DEFAULT)[0] for objects in sizes])
    return SAY.claim(
        "usable", at_least(_share(np.concatenate(every)), OFTEN), each="; ".join(words),
        proven=_share(proven),
    )  # fmt: skip
