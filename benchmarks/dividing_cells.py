"""Sequences of cells that creep and divide, simulated: where each was, and what was detected."""

from dataclasses import dataclass

import numpy as np
import polars as pl

SIZE = 500.0  # Side of the image [pixels]
MARGIN = 10.0
N_FRAMES = 80
N_FIRST = 10
STEP = 1.5  # Change of velocity a frame along each axis [pixels]
DRAG = 0.6  # Share of velocity that is kept
CYCLE, LEAST_CYCLE = 40.0, 12.0  # Mean time between divisions and the least [frames]
APART = 7.0  # Daughters are born so far from where their mother was [pixels]
ROOM = 13.0  # Cells push each other apart within this [pixels]
DETECTED = 0.97
NOISE = 0.8  # Of a detected position along each axis [pixels]
FALSE_ALARMS = 1.0  # A frame
INCOMING = 0.05  # Cells that come into the image a frame


@dataclass(slots=True)
class _Cell:
    number: int
    parent: int | None
    place: np.ndarray
    speed: np.ndarray
    divides: int


def simulated(seed: int) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return true states ``time,track,parent,x,y`` and detections ``time,x,y,target``."""
    rng = np.random.default_rng(seed)
    cells: list[_Cell] = []
    count = 0

    def born(parent: int | None, place: np.ndarray, divides: int) -> _Cell:
        nonlocal count
        count += 1
        return _Cell(count, parent, place, rng.normal(0.0, STEP, 2), divides)

    def cycle(frame: int) -> int:
        return frame + round(LEAST_CYCLE + rng.gamma(4.0, (CYCLE - LEAST_CYCLE) / 4.0))

    states = []
    for frame in range(N_FRAMES):
        if frame == 0:
            for _ in range(N_FIRST):
                place = rng.uniform(2 * MARGIN, SIZE - 2 * MARGIN, 2)
                cells.append(born(None, place, cycle(0) - int(rng.uniform(0.0, LEAST_CYCLE))))
        else:
            cells = _moved(cells, rng)
            if rng.random() < INCOMING:
                place = rng.uniform(MARGIN, SIZE - MARGIN, 2)
                place[rng.integers(2)] = rng.choice([MARGIN, SIZE - MARGIN])
                cells.append(born(None, place, cycle(frame)))
        following = []
        for cell in cells:
            if cell.divides > frame:
                following.append(cell)
                continue
            angle = rng.uniform(0.0, 2.0 * np.pi)
            offset = APART * np.array([np.cos(angle), np.sin(angle)])
            following += [
                born(cell.number, cell.place + side * offset, cycle(frame)) for side in (1, -1)
            ]
        cells = following
        for cell in cells:
            cell.place = np.clip(cell.place, MARGIN, SIZE - MARGIN)
            states.append((float(frame), cell.number, cell.parent, *cell.place.tolist()))
    names = {"time": float, "track": int, "parent": int, "x": float, "y": float}
    truth = pl.DataFrame(states, names, orient="row")
    return truth, _detected(truth, rng)


def _moved(cells: list[_Cell], rng: np.random.Generator) -> list[_Cell]:
    place = np.array([cell.place for cell in cells])
    apart = place[:, None] - place[None]
    distance = np.maximum(np.linalg.norm(apart, axis=2), 1e-6)
    push = np.where((distance < ROOM) & (distance > 1e-6), ROOM - distance, 0.0) / 3.0
    pushed = np.sum(apart / distance[..., None] * push[..., None], axis=1)
    for cell, by in zip(cells, pushed, strict=True):
        cell.speed = DRAG * cell.speed + rng.normal(0.0, STEP, 2)
        cell.place = cell.place + cell.speed + by
    return cells


def _detected(truth: pl.DataFrame, rng: np.random.Generator) -> pl.DataFrame:
    """Return positions with noise, without those that were missed, with false ones."""
    place = truth.select("x", "y").to_numpy() + rng.normal(0.0, NOISE, (len(truth), 2))
    found = truth.select(
        "time", pl.Series("x", place[:, 0]), pl.Series("y", place[:, 1]), target="track"
    ).filter(pl.Series(rng.random(len(truth)) < DETECTED))
    n_false = rng.poisson(FALSE_ALARMS * N_FRAMES)
    places = rng.uniform(MARGIN, SIZE - MARGIN, (n_false, 2))
    times = rng.integers(0, N_FRAMES, n_false).astype(float)
    alarms = pl.DataFrame({"time": times, "x": places[:, 0], "y": places[:, 1], "target": None})
    alarms = alarms.cast({"target": pl.Int64})
    return pl.concat([found, alarms]).sample(fraction=1.0, shuffle=True, seed=1).sort("time")
