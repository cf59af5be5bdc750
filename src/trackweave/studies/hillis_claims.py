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
    verdict_of,
)
from trackweave.studies.writing import Table, numbers

__all__ = ["claims_of", "last_of", "searches_of", "sizes_of"]

NEAR = 1.0
"""A hypothesis is good within this of the best [nats]: less than e times less likely."""
OFTEN = 95.0
"""What counts as finding the best hypothesis [% of windows]."""
LITTLE = 1.0
"""What counts as little to send [numbers per hundred that are decoded]."""
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
    return share_of(int(np.count_nonzero(excess <= CLOSE)), excess.size)


def _certain(tables: Tables) -> list[Claim]:
    claims = []
    for row in tables["figures"].to_dicts():
        misprint = " (as printed it names D1,0 twice)" if str(row["figure"]) == "1" else ""
        claims.append(
            Claim(
                f'"The hypothesis in FIG. {row["figure"]} could be encoded by the string '
                f'{row["string"]}"{misprint}',
                verdict_of(set(row["decoded"].split()) == set(row["drawing"].split())),
                f"The string decodes to {row['decoded']}, at {row['cost [nats]']:.2f} nats.",
            )
        )
    (strings,), (children,) = tables["strings"].to_dicts(), tables["children"].to_dicts()
    return [
        *claims,
        Claim(
            '"The mapping of strings to hypotheses is not one to one"',
            verdict_of(strings["hypotheses"] < strings["strings"]),
            f"The {strings['strings']} strings of the five detections decode to "
            f"{strings['hypotheses']} hypotheses, {strings['best']} of them to the best.",
        ),
        Claim(
            'Of 1-2-3-4-5-6 and 3-4-1-2-6-5, cut after the third point, "the first child = '
            '1-2-3-4-6-5 and the second child = 3-4-1-2-5-6"',
            verdict_of(tuple(children.values()) == ("1-2-3-4-6-5", "3-4-1-2-5-6")),
            f"They are {children['first']} and {children['second']}.",
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
        Claim(
            '"Selecting a hypothesis with a relatively poor score at an early scan may lead to a '
            'hypothesis with an optimum … score at a later scan"',
            verdict_of(early > 0.0 and late > 0.0),
            f"After two scans Figure 3 costs {early:.2f} nats more than Figure 2; after three "
            f"what goes on from it, Figure 4, costs {late:.2f} less.",
        ),
        Claim(
            '"Finding the local optimal assignment … for each scan does not guarantee that the '
            'global optimal assignment across many scans is achieved"',
            verdict_of(set(one["tracks"].split()) != set(best.split())),
            f"With a window of one scan the tracks are {one['tracks']}.",
        ),
        Claim(
            '"Later hypotheses may amend it based on additional data"',
            verdict_of(
                bool(searched["amended"]) and set(searched["tracks"].split()) == set(best.split())
            ),
            f"With five scans the search ends with {searched['tracks']}; amended after the third "
            f"scan: {searched['amended'] or 'nothing'}.",
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
        Claim(
            '"The reason for performing multi-scan optimization": the best hypothesis of five '
            "scans assigns more reports rightly than that of each scan",
            at_least(exact, 0.0),
            f"Gain, proven best where lone reports may be false alarms: {exact}. "
            f"Others: {others}.",
            "a gain above 0 (ours)",
        ),
        Claim(
            "So it does with the patent's own search, at sizes of ours", at_least(document, 0.0),
            f"Gain: {document}.", "a gain above 0 (ours)",
        ),
        Claim(
            '"The GA is employed … for the purpose of finding a good (though quite possibly '
            'sub-optimal) hypothesis": over whole scenes of two sensors', at_most(excess, NEAR),
            f"Above the best of each window, mean of a scene: {excess}.",
            f"at most {NEAR:g} nat (ours; the patent: \"some acceptable range\")",
        ),
    )  # fmt: skip


def _good(table: Table, objects: int) -> Claim:
    excess, spent = last_of(table, objects, BY_SIZE)
    found = mean_of(excess, "nats")
    others = [
        f"{name}: {last_of(table, objects, name)[0].mean():.3g}"
        for name in searches_of(table, objects)
        if name.startswith("population")
    ]
    return Claim(
        f'"A population is formed from random permutations", and the search finds a good '
        f"hypothesis of {objects} objects' windows", at_most(found, NEAR),
        f"Sizes by size: {found} above the best after {spent:,.0f} evaluations, the best itself "
        f"in {_share(excess)}. Fixed sizes, at the end of their curves [nats] – "
        f"{'; '.join(others)}.", f"at most {NEAR:g} nat on average (ours)",
    )  # fmt: skip


def _optimal(table: Table, sizes: list[int]) -> Claim:
    found = {objects: _share(last_of(table, objects, BY_SIZE)[0]) for objects in sizes}
    whole = np.concatenate([last_of(table, objects, BY_SIZE)[0] for objects in sizes])
    each = "; ".join(f"{objects} objects {share}" for objects, share in found.items())
    return Claim(
        'Claim 2: "the good hypothesis is an optimal hypothesis across the window"',
        at_least(_share(whole), OFTEN), f"Best found, in windows of {each}.",
        f"≥ {OFTEN:g} % of windows (ours)",
    )  # fmt: skip


def _lists(table: Table, sizes: list[int]) -> Claim:
    """Compare both genotypes, of one population and after as many evaluations."""
    less = {
        objects: last_of(table, objects, LISTS)[0] - last_of(table, objects, ALIKE_LISTS)[0]
        for objects in sizes
    }
    found = mean_of(np.concatenate(list(less.values())), "nats")
    each = "; ".join(f"{objects} objects {mean_of(own)}" for objects, own in less.items())
    return Claim(
        'Permutations serve better than "lists of associations between sensor reports", the '
        "'931 patent's genotype, after as many evaluations", at_least(found, 0.0),
        f"Of {ALIKE_LISTS} each, lists end above permutations by {found}: {each}.",
        "a difference above 0 (ours)",
    )  # fmt: skip


def _stops(tables: Tables) -> tuple[Claim, ...]:
    table, stops, curves = tables["thresholds"], tables["interruptions"], tables["search"]
    courses: dict[tuple[int, int], list[float]] = {}
    for row in curves.to_dicts():
        if row["search"] == BY_SIZE and row["excess [nats]"] is not None:
            courses.setdefault((row["objects"], row["window"]), []).append(row["excess [nats]"])
    falling = all(bool(np.all(np.diff(course) <= CLOSE)) for course in courses.values())
    preset, words = share_of(0, 0), []
    for level in sorted(set(numbers(table, "threshold [nats]").tolist())):
        when, of, excess = (
            numbers(table, name, **{"threshold [nats]": level})
            for name in ("generation", "of", "excess [nats]")
        )
        is_met = np.isfinite(when)
        share = share_of(int(is_met.sum()), when.size)
        preset = share if level == PRESET_THRESHOLD else preset
        if is_met.any():
            at = 100.0 * float(np.mean(when[is_met] / of[is_met]))
            words.append(
                f"{level:g} nats in {share}, after {at:.0f} % of the generations, "
                f"{excess[is_met].mean():.3g} nats above the best"
            )
    looks = sorted(set(numbers(stops, "looks").tolist()))
    late = [mean_of(numbers(stops, "excess [nats]", looks=look), "nats") for look in looks]
    ordered = all(
        bool(np.all(np.diff(numbers(stops, "excess [nats]", window=window)) <= CLOSE))
        for window in set(numbers(stops, "window").tolist())
    )
    return (
        Claim(
            'The search goes on "until a fixed number of generations have been completed": the '
            "fittest so far never gets worse", verdict_of(falling),
            f"So it is in all {len(courses)} windows.",
        ),
        Claim(
            '"or the difference in fitness between the fittest individual and the average … falls '
            f'below a threshold": the preset\'s, {PRESET_THRESHOLD:g} nats, is reached before the '
            "generations are over", at_least(preset, 50.0),
            f"Thresholds reached: {'; '.join(words)}.", "≥ 50 % of windows (ours)",
        ),
        Claim(
            '"or the process is interrupted by the arrival of a new scan", and the fittest so far '
            "is a whole hypothesis, no worse than what an earlier scan would have stopped at",
            verdict_of(ordered and all(row["whole"] for row in stops.to_dicts())),
            "Above the best after so many looks at the clock: "
            + "; ".join(f"{int(k)}: {each}" for k, each in zip(looks, late, strict=True)) + ".",
        ),
    )  # fmt: skip


PRESET_THRESHOLD = 3.0
ALIKE_LISTS = "population 300"
ALIKE = 5.0
"""Shares within this of each other are alike [points of per cent]."""


def _alone(table: Table) -> tuple[Claim, ...]:
    orders = ("in time", "late")
    alone = [numbers(table, "alone right [%]", arrival=name) for name in orders]
    scans = [numbers(table, "of scans right [%]", arrival=name) for name in ("none", *orders)]
    lost, moved = mean_of(scans[0] - scans[2], "points"), mean_of(alone[0] - alone[1], "points")
    behind = mean_of(scans[1] - alone[0], "points")
    told = [mean_of(each, "%") for each in (*scans, alone[0])]
    words = (
        '"The inventive technique is equally applicable for different numbers of sensors which '
        'need not be scanned systems": reports that come alone '
    )
    return (
        Claim(
            f"{words}are assigned as rightly as those of scans", at_most(behind, 0.0, ALIKE),
            f"Rightly assigned of the scans {told[1]}, of those that come alone, two a scene, "
            f"{told[3]}: {behind} fewer; late, {moved} fewer still.",
            f"none fewer, tolerance {ALIKE:g} points (ours)",
        ),
        Claim(
            f"{words}and late spoil nothing for those of scans", at_most(lost, 0.0, ALIKE),
            f"Rightly assigned of the scans without them {told[0]}, with them {told[1]}, with "
            f"them late {told[2]}: {lost} lost.",
            f"no loss, tolerance {ALIKE:g} points (ours, asked after the claim above had failed)",
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
        Claim(
            '"The preferred embodiment spreads the GA across several parallel processors using '
            'the \'island\' model": the same answer on one, two and four threads',
            verdict_of(all(same)), f"{len(same)} searches, each on all three.",
        ),
        Claim(
            "Spread over four islands, a quarter of the population on each, the search comes as "
            "close to the best as one population does", at_most(more, 0.0, NEAR),
            f"Above one population: {more}. Above the best – {listed}.",
            f"a difference of 0, tolerance {NEAR:g} nat (ours)",
        ),
        Claim(
            '"The communications requirements between parallel processors can be very low"',
            verdict_of(worst <= LITTLE),
            f"At most {worst:.2g} individuals are sent for a hundred decoded.",
            f"≤ {LITTLE:g} for a hundred (ours)",
        ),
    )  # fmt: skip


def _usable(table: Table, sizes: list[int]) -> Claim:
    words, every = [], []
    for objects in sizes:
        excess, spent = last_of(table, objects, USABLE)
        every.append(excess)
        words.append(f"{objects} objects: {_share(excess)} after {spent:,.0f} evaluations")
    proven = np.concatenate([last_of(table, objects, DEFAULT)[0] for objects in sizes])
    return Claim(
        "With what its author might add today, the preset hillis, the search finds the best "
        "hypothesis, where lone reports may be false alarms",
        at_least(_share(np.concatenate(every)), OFTEN),
        f"{'; '.join(words)}. The default proves it in {_share(proven)}.",
        f"≥ {OFTEN:g} % of windows (ours)",
    )  # fmt: skip
