"""Scenes invented by somebody who had not seen the tracker: nothing told but where radars stand.

IDF1 of the reports against who sent them, beside the nearest-neighbour tracker with the same
estimates; switches, false reports in tracks, objects' reports on none, and joins that are right.
"""

import argparse
import time

import numpy as np
from invented_changes import CHANGES
from invented_few import FEW
from invented_ground import GROUND
from invented_named import NAMED
from invented_scenes import NOBODY
from invented_scenes import SCENES as FIRST_SCENES
from invented_sea import SEA
from invented_together import TOGETHER
from invented_waits import WAITS
from joins import judged
from text_tables import command, heading, table

from trackweave import track
from trackweave.metrics import assignment_quality

SCENES = FIRST_SCENES | SEA | GROUND | NAMED | TOGETHER | WAITS | FEW | CHANGES
HEAD = [
    "scene",
    "seed",
    "IDF1",
    "nearest",
    "switches",
    "false in tracks",
    "on none",
    "joins right",
]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--only", nargs="+", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--at-rest", choices=["objects", "echoes"], default="objects")
    parser.add_argument("--notes", action="store_true", help="print what each run says")
    told = parser.parse_args()
    lines = []
    for name in told.only:
        make, sensors = SCENES[name]
        for seed in range(told.first, told.first + told.seeds):
            reports = make(np.random.default_rng(seed))
            whose, seen, begun = reports["target"].to_list(), reports.drop("target"), _now()
            given = {"sensors": sensors, "lifecycle": {"at_rest": told.at_rest}}
            result = track(seen, given)
            spent = _now() - begun
            simple = track(seen, {**given, "tracker": {"kind": "nearest-neighbour"}})
            found, near = (
                each.assignments["track"].fill_null(-1).to_numpy() for each in (result, simple)
            )
            scored, false = assignment_quality(whose, found), np.array(whose) == NOBODY
            joins, right, *_ = judged(result.run, found, reports)
            lines.append([
                name, seed, f"{scored.idf1:.3f}", f"{assignment_quality(whose, near).idf1:.3f}",
                scored.switches, f"{np.count_nonzero(found[false] >= 0)} of {false.sum()}",
                f"{np.count_nonzero(found[~false] < 0)} of {np.count_nonzero(~false)}",
                f"{right} of {joins}", f"{spent:.0f}",
            ])  # fmt: skip
            print(*lines[-1], sep="  ", flush=True)
            if told.notes:
                print(*result.run["notes"], sep="\n  - ", flush=True)
    print(heading(command("invented.py")), end="\n\n")
    print(table([*HEAD, "CPU s"], lines))


def _now() -> float:
    return time.process_time()


if __name__ == "__main__":
    main()
