"""BoxTracker beside SORT, ByteTrack and norfair on the same boxes, by TrackEval's own numbers.

The peers need not live beside trackweave; norfair asks for an older ``rich``, which it can do
without:

    python3 -m venv peers
    peers/bin/pip install . "trackeval>=1.3" "trackers>=2.6" "supervision<0.28" filterpy
    peers/bin/pip install --no-deps norfair
    peers/bin/python benchmarks/boxes.py

Parameters: ours are the defaults, but for the frame's period and what scores are, which the files
tell; the peers' are theirs, norfair's those of its documentation's MOTChallenge demo. Peers take
each class by itself, in the image; ours takes both classes of a KITTI sequence at once.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from boxes_data import Found, Sequence, figures, judged, sequences, together
from boxes_peers import peers
from boxes_streets import KINDS, judged_street, street
from recordings_data import add_arguments
from text_tables import command, heading, table

import trackweave as tw

HEAD = [
    "sequences",
    "method",
    "HOTA",
    "IDF1",
    "MOTA",
    "DetA",
    "AssA",
    "switches",
    "missed",
    "false",
]


def ours(several: list[Sequence], *, solid: bool = False, **options: Any) -> list[list[Found]]:
    """Follow the boxes of sequences that are of the same frames, each of a class."""
    tracker = tw.BoxTracker(
        period=several[0].period,
        scores="log-odds" if several[0].dataset == "KITTI" else "probability",
        **options,
    )
    told, owners = [], []
    for seen in zip(*(one.frames for one in several), strict=True):
        owners.append(
            [(place, row) for place, one in enumerate(seen) for row in range(len(one.box))]
        )
        told.append(
            tracker.update(
                np.vstack([one.solid if solid else one.box for one in seen]),
                np.concatenate([one.score for one in seen]),
                [several[place].kind for place, _ in owners[-1]],
            )
        )
    found: list[list[Found]] = [[] for _ in several]
    for frame in [*told, *tracker.rest()]:
        for (place, row), who in zip(owners[frame.number], frame.identifiers, strict=False):
            if who >= 0:
                box = several[place].frames[frame.number].box[row]
                found[place].append(Found(frame.number, int(who), box))
    return found


def by_frames(data: list[Sequence]) -> list[list[Sequence]]:
    """Return sequences with those together that are of the same frames."""
    names = dict.fromkeys((one.dataset, one.name) for one in data)
    return [[one for one in data if (one.dataset, one.name) == name] for name in names]


def results(data: list[Sequence], **options: Any) -> list[dict[str, Any]]:
    """Return what TrackEval says of ours, sequence by sequence."""
    return [
        judged(one, found)
        for several in by_frames(data)
        for one, found in zip(several, ours(several, **options), strict=True)
    ]


def compared(data: list[Sequence], methods: dict[str, list[dict[str, Any]]]) -> str:
    """Return a table: a row a method, a column each sequence and all of them together."""
    head = [one.words for one in data]
    rows = []
    for name, each in methods.items():
        cells = [*each, together(each)] if len(data) > 1 else each
        rows.append([name, *(" / ".join(f"{x:.1f}" for x in figures(one)) for one in cells)])
    return table(["HOTA / IDF1 / MOTA", *head, "together"][: 1 + len(rows[0][1:])], rows)


def streets(seeds: list[int]) -> str:
    """Return a table of simulated streets, several of a kind together."""
    made = {kind: [street(kind, seed) for seed in seeds] for kind in KINDS}
    methods: dict[str, Callable[[Sequence], list[Found]]] = {
        "BoxTracker": lambda one: ours([one])[0],
        "BoxTracker, window=3": lambda one: ours([one], window=3)[0],
        "BoxTracker, delay=3": lambda one: ours([one], delay=3)[0],
        **peers(),
    }
    rows = []
    for name, follow in methods.items():
        each = [
            figures(together([judged_street(truth, follow(one)) for one, truth in several]))
            for several in made.values()
        ]
        cells = [*each, list(np.mean(each, axis=0))]
        rows.append([name, *(" / ".join(f"{x:.1f}" for x in cell) for cell in cells)])
    return table(["HOTA / IDF1 / MOTA", *made, "mean"], rows)


def milliseconds(n_boxes: int, **options: Any) -> float:
    """Return the median CPU time of a frame of so many boxes, once warm."""
    rng = np.random.default_rng(1)
    place, speed = rng.uniform(0, [1920, 1080], (n_boxes, 2)), rng.normal(0, 60, (n_boxes, 2))
    size = rng.uniform(30, 120, (n_boxes, 2))
    tracker, spent = tw.BoxTracker(**options), []
    for _ in range(150):
        place += 0.04 * speed
        middle = place + rng.normal(0, 2, place.shape)
        boxes = np.hstack([middle - size / 2, middle + size / 2])
        scores = rng.beta(8, 2, n_boxes)
        begun = time.process_time()
        tracker.update(boxes, scores)
        spent.append(time.process_time() - begun)
    return 1e3 * float(np.median(spent[30:]))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    add_arguments(parser)
    parser.add_argument("--seeds", type=int, nargs="+", default=[11, 12], help="of the streets")
    arguments = parser.parse_args()
    data = sequences(arguments.recordings)
    try:
        import trackeval  # noqa: F401 a peer, which is not there everywhere
    except ImportError:
        print("Skipped: needs trackeval (see the top of this file for it and the peers).")
        return
    print(heading(command("boxes.py").partition(" --recordings")[0]), end="\n\n")
    for dataset in ("TUD", "KITTI"):
        part = [one for one in data if one.dataset == dataset]
        methods = {"BoxTracker": results(part)}
        if dataset == "KITTI":
            methods["BoxTracker, 3-D boxes"] = results(part, solid=True)
        methods["BoxTracker, delay=3"] = results(part, delay=3)
        named: dict[str, Callable[[Sequence], list[Found]]] = peers()
        for name, follow in named.items():
            methods[name] = [judged(one, follow(one)) for one in part]
        print(f"{dataset}:\n\n{compared(part, methods)}", end="\n\n")
    print(f"Simulated streets, seeds {' '.join(map(str, arguments.seeds))}:\n")
    print(streets(arguments.seeds), end="\n\n")
    print("CPU of a frame, median, warm:\n")
    times = [[str(n), milliseconds(n), milliseconds(n, window=3)] for n in (10, 50, 100, 200)]
    print(table(["boxes a frame", "ms", "ms with window=3"], times))


if __name__ == "__main__":
    main()
