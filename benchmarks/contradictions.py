"""Whether a wrong input is called by its name: many in turn, over seeds; and false alarms."""

import argparse
import sys
import time
from collections import Counter
from typing import Any

import numpy as np
from contradictions_scenes import CONTRADICTIONS, Scene, scene
from text_tables import command, heading, table

from trackweave import track

CAUSES, NONE = {"clock_offset": "clock", "translation": "offset"}, {"used": 0.0}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--seeds", type=int, nargs=2, default=[101, 112], help="first, and last + 1"
    )
    parser.add_argument("--only", nargs="*", default=list(CONTRADICTIONS))
    parser.add_argument("--show", action="store_true", help="print each first sentence")
    parser.add_argument("--no-clean", action="store_true", help="leave out what is right")
    arguments = parser.parse_args()
    seeds = range(*arguments.seeds)
    print(heading(command("contradictions.py")), end="\n\n")
    rows = []
    for name in arguments.only:
        rows.append(_row(name, seeds, show=arguments.show))
        print(*rows[-1], sep=" | ", file=sys.stderr, flush=True)
    head = ["what is wrong", "runs", "named first", "named", "missed", "others named first"]
    print(table(head, rows), end="\n\n")
    if not arguments.no_clean:
        print(table(["nothing is wrong", "runs", "false alarms", "which"], _clean(seeds)))


def _row(name: str, seeds: range, *, show: bool) -> list[Any]:
    one, first, named, runs = CONTRADICTIONS[name], 0, 0, 0
    others: Counter[str] = Counter()
    for seed in seeds:
        # Two radars in each third scene; nothing told in each second where nothing has to be.
        n_sensors, is_told = (2 if seed % 3 == 0 else 3), one.told or seed % 2 == 0
        made = one.spoil(scene(seed, polar=one.polar, n_sensors=n_sensors))
        found = causes_of(made, is_told=is_told, show=show and seed == seeds[0])
        runs += 1
        first += bool(found) and found[0] in one.causes
        named += any(cause in one.causes for cause in found)
        if found and found[0] not in one.causes:
            others[found[0]] += 1
    listed = ", ".join(f"{cause} {count}" for cause, count in others.most_common(3))
    return [name, runs, first, named, runs - named, listed or "–"]


def _clean(seeds: range) -> list[list[Any]]:
    rows = []
    for polar in (False, True):
        for n_sensors in (2, 3):
            for is_told in (True, False):
                false: Counter[str] = Counter()
                for seed in seeds:
                    made = scene(seed, polar=polar, n_sensors=n_sensors)
                    false.update(causes_of(made, is_told=is_told))
                kind = "ranges and azimuths" if polar else "positions"
                what = f"{n_sensors} radars, {kind}, {'all' if is_told else 'nothing'} told"
                listed = ", ".join(f"{cause} {count}" for cause, count in false.items())
                rows.append([what, len(seeds), sum(false.values()), listed or "–"])
                print(*rows[-1], sep=" | ", file=sys.stderr, flush=True)
    return rows


def causes_of(made: Scene, *, is_told: bool, show: bool = False) -> list[str]:
    """Return the causes that a run names, in order."""
    places = {name: {"position": s["position"]} for name, s in made.told["sensors"].items()}
    told = made.told if is_told else {"sensors": places}
    begin = time.process_time()
    result = track(made.reports.drop("target"), told, rng=np.random.default_rng(1))
    if show:
        totals = result.run["totals"]
        print(f"    {totals['assigned_reports']}/{totals['reports']} "
              f"{time.process_time() - begin:.1f} s")  # fmt: skip
        for each in result.run["diagnostics"][:4]:
            print("       ", each["cause"], "|", each["sentence"])
    # What was found of a sensor before the run, and taken out, is said before anything else.
    known = (result.run["registration"] or {}).get("sensors", {}).values()
    taken = [CAUSES[key] for own in known for key in CAUSES if np.any(own.get(key, NONE)["used"])]
    return [*taken, *(each["cause"] for each in result.run["diagnostics"])]


if __name__ == "__main__":
    main()
