"""Cells that meet, are one spot for a while and go on: names kept, and reports that are shared.

python benchmarks/dividing_merges.py
"""

import argparse

import numpy as np
import polars as pl
from text_tables import command, heading, table

import trackweave as tw

RESOLUTION, NOISE, FALSE_ALARMS, DETECTED = 8.0, 0.8, 1.0, 0.97  # pixels, and a frame
N_FRAMES, N_PAIRS, SIZE = 60, 8, 600.0


def simulated(seed: int) -> pl.DataFrame:
    """Return detections ``time,x,y,first,second``: true cells, null where there is none.

    Cells come in pairs, each with a place of its own; they meet, lie near each other for some
    frames and go on. Two nearer than ``RESOLUTION`` are one spot in their middle.
    """
    rng = np.random.default_rng(seed)
    rows: list[tuple[float, float, float, int | None, int | None]] = []

    def seen(frame: int, place: np.ndarray, *cells: int) -> None:
        if rng.random() < DETECTED:
            x, y = place + rng.normal(0.0, NOISE, 2)
            rows.append((float(frame), x, y, cells[0], cells[1] if len(cells) > 1 else None))

    for pair in range(N_PAIRS):
        centre = np.array([(pair % 4 + 0.5) * SIZE / 4, (pair // 4 + 0.5) * SIZE / 2])
        across = rng.normal(size=2)
        across /= np.hypot(*across)
        along = np.array([-across[1], across[0]])
        middle, stay = rng.uniform(25, 35), rng.uniform(1.0, 4.0)
        drift, speed, nearest = rng.uniform(0.5, 1.5), rng.uniform(1.5, 2.5), rng.uniform(1.0, 5.0)
        for frame in range(N_FRAMES):
            past = frame - middle
            gap = speed * np.sign(past) * max(0.0, abs(past) - stay)
            offset = gap * across + nearest / 2 * along
            both = [centre + drift * (frame - 30) * along + sign * offset for sign in (1, -1)]
            if 2 * np.hypot(*offset) < RESOLUTION:
                seen(frame, (both[0] + both[1]) / 2, 2 * pair, 2 * pair + 1)
            else:
                seen(frame, both[0], 2 * pair)
                seen(frame, both[1], 2 * pair + 1)
    for frame in range(N_FRAMES):
        for _ in range(rng.poisson(FALSE_ALARMS)):
            rows.append((float(frame), *rng.uniform(0.0, SIZE, 2), None, None))
    names = ["time", "x", "y", "first", "second"]
    return pl.DataFrame(rows, schema=names, orient="row").sort("time", maintain_order=True)


def judged(detections: pl.DataFrame) -> dict[str, int]:
    """Return what became of merged spots and of names."""
    found = tw.track(detections, {"lifecycle": {"merge": RESOLUTION}}).assignments
    alone = found.filter(pl.col("first").is_not_null() & pl.col("second").is_null())
    kept, owner = 0, dict[int, int]()
    for (cell,), rows in alone.group_by("first"):
        tracks = rows.sort("time")["track"].drop_nulls().to_list()
        counts = {track: tracks.count(track) for track in tracks}
        owner[cell] = max(counts, key=lambda track: counts[track])
        kept += tracks[:5].count(owner[cell]) >= 3 and tracks[-5:].count(owner[cell]) >= 3
    spots = found.filter(pl.col("second").is_not_null())
    both = one = 0
    for first, second, track, other in spots.select(
        "first", "second", "track", "shared_with"
    ).iter_rows():
        given = {track, other} - {None}
        right = len(given & {owner[first], owner[second]})
        both += right == 2
        one += right == 1
    shared = found["shared_with"].is_not_null()
    return {
        "cells": len(owner), "kept": kept, "spots": len(spots), "both": both, "one": one,
        "wrong": int((shared & found["second"].is_null()).sum()),
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, nargs="+", default=[11, 12, 13])
    told = parser.parse_args()
    print(heading(command("dividing_merges.py")), end="\n\n")
    rows = []
    for seed in told.seeds:
        found = judged(simulated(seed))
        rows.append(
            [
                f"seed {seed}", f"{found['kept']} of {found['cells']}", str(found["spots"]),
                str(found["both"]), str(found["one"]), str(found["wrong"]),
            ]
        )  # fmt: skip
    head = ["sequence", "names kept", "merged spots", "of both tracks", "of one", "shared wrongly"]
    print(table(head, rows))


if __name__ == "__main__":
    main()
