"""Simulated streets: people who hide one another, halves of them, false boxes and what lasts."""

import contextlib
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from boxes_data import Array, Found, Seen, Sequence, metrics_of
from recordings_boxes import overlap

WIDTH = 1280.0
SHARE_FOUND = 0.97


class Street(NamedTuple):
    """What a kind of street is like."""

    rate: float  # frames a second
    people: int
    frames: int
    speed: float  # metres a second at most
    pan: float = 0.0  # pixels a second
    ghosts: int = 1  # things that are taken for people again and again
    false: float = 1.0  # other false boxes a frame
    found: float = SHARE_FOUND  # of those who are in plain sight


KINDS = {
    "walk": Street(25, 10, 200, 1.2),
    "crowd": Street(25, 30, 150, 1.0, ghosts=2, false=2.0),
    "drive": Street(10, 10, 150, 3.0, pan=120.0, ghosts=3),
    "slow": Street(5, 8, 100, 1.0),
    "weak": Street(15, 15, 150, 1.2, found=0.75),
}


@dataclass
class Person:
    """Somebody in the image, about a middle; score as log-odds in plain sight."""

    who: int
    middle: Array
    size: Array
    speed: Array
    score: float

    def box(self, shift: float) -> Array:
        """Return the box as a camera sees it that has panned."""
        middle = self.middle + np.array([shift, 0.0])
        return np.concatenate([middle - self.size / 2, middle + self.size / 2])


def street(kind: str, seed: int) -> tuple[Sequence, list[list[tuple[int, Array]]]]:
    """Return the boxes of a street, and who was where in each frame."""
    one, rng = KINDS[kind], np.random.default_rng(seed)
    people = [_person(k, one, rng, coming=False) for k in range(one.people)]
    ghosts = np.column_stack([
        rng.uniform(0, WIDTH, one.ghosts), rng.uniform(300, 500, one.ghosts),
        rng.uniform(80, 200, one.ghosts),
    ])  # fmt: skip
    frames, truth, shift, next_who, wait = [], [], 0.0, one.people, 1.0 / one.rate
    for k in range(one.frames):
        shift += one.pan * wait * np.sin(1.5 * k * wait)
        if rng.random() < 0.12 * one.people * wait:
            people.append(_person(next_who, one, rng, coming=True))
            next_who += 1
        for person in people:
            _walk(person, one, rng)
        people = [p for p in people if -p.size[0] < p.middle[0] < WIDTH + p.size[0]]
        seen, there = _people_seen(people, one, shift, rng)
        frames.append(_frame(seen + _false(one, ghosts, shift, rng)))
        truth.append(there)
    return Sequence("streets", kind, "Pedestrian", frames, wait, Path()), truth


def _person(who: int, one: Street, rng: np.random.Generator, *, coming: bool) -> Person:
    high = np.exp(rng.uniform(np.log(70), np.log(320)))
    size = high * np.array([rng.uniform(0.35, 0.5), 1.0])
    side = float(rng.choice([-1, 1]))
    x = (WIDTH / 2 - side * (WIDTH + size[0]) / 2) if coming else rng.uniform(0, WIDTH)
    speed = side * rng.uniform(0.3, 1.0) * one.speed * high / 1.7
    middle = np.array([x, 350 + 0.35 * high + rng.normal(0, 20)])
    sideways = np.array([speed, rng.normal(0, 0.05) * high])
    return Person(who, middle, size, sideways, float(rng.normal(2.5, 1.0)))


def _walk(person: Person, one: Street, rng: np.random.Generator) -> None:
    wait = 1.0 / one.rate
    person.speed[0] += rng.normal(0, 0.125) * person.size[1] * np.sqrt(wait)
    person.speed[1] *= 0.98
    person.middle = person.middle + wait * person.speed
    if one.pan:
        person.size = person.size * (1.0 + 0.05 * wait)


def _people_seen(
    people: list[Person], one: Street, shift: float, rng: np.random.Generator
) -> tuple[list[tuple[Array, float]], list[tuple[int, Array]]]:
    """Return boxes with scores, and who is to be found; the lower edge tells who is nearer."""
    seen, there, nearer = [], [], np.empty((0, 4))
    for person in sorted(people, key=lambda p: -float(p.box(0.0)[3])):
        box = person.box(shift)
        hidden = overlap(nearer, box[None], of_second=True).max(initial=0.0)
        nearer = np.vstack([nearer, box])
        if hidden < 0.9:
            there.append((person.who, box))
        if rng.random() >= one.found * np.clip((0.8 - hidden) / 0.5, 0.0, 1.0):
            continue
        error = 0.03 * person.size[1] * (1.0 + 1.5 * hidden)
        seen.append((box + rng.normal(0, error, 4), person.score + rng.normal() - 2.5 * hidden))
        if rng.random() < 0.02:
            half = np.array([*box[:3], box[1] + person.size[1] / 2])
            seen.append((half + rng.normal(0, error, 4), rng.normal()))
    return seen, there


def _false(
    one: Street, ghosts: Array, shift: float, rng: np.random.Generator
) -> list[tuple[Array, float]]:
    found = []
    for _ in range(rng.poisson(one.false)):
        high = np.exp(rng.uniform(np.log(50), np.log(250)))
        found.append((rng.uniform(0, WIDTH), rng.uniform(250, 550), high, rng.normal(-0.5, 1.2)))
    for x, y, high in ghosts[rng.random(one.ghosts) < 0.5]:
        place = np.array([x + shift, y]) + rng.normal(0, 0.03 * high, 2)
        found.append((*place, high, rng.normal(-0.3, 1.0)))
    half = np.array([0.2, 0.5])
    return [
        (np.concatenate([[x, y] - half * high, [x, y] + half * high]), score)
        for x, y, high, score in found
    ]


def _frame(seen: list[tuple[Array, float]]) -> Seen:
    box = np.array([box for box, _ in seen]).reshape(-1, 4)
    box[:, 2:] = np.maximum(box[:, 2:], box[:, :2] + 2.0)
    odds = np.array([score for _, score in seen])
    return Seen(box, 1.0 / (1.0 + np.exp(-odds)), np.empty((0, 7)))


def judged_street(truth: list[list[tuple[int, Array]]], found: list[Found]) -> dict[str, Any]:
    """Return TrackEval's results of one street, by metric."""
    named = {who: k for k, who in enumerate(sorted({who for at in truth for who, _ in at}))}
    tracks = {who: k for k, who in enumerate(sorted({row.who for row in found}))}
    data: dict[str, Any] = {
        "num_timesteps": len(truth), "num_gt_ids": len(named), "num_tracker_ids": len(tracks),
        "num_gt_dets": sum(map(len, truth)), "num_tracker_dets": len(found),
        "gt_ids": [], "tracker_ids": [], "similarity_scores": [],
    }  # fmt: skip
    by_frame: list[list[Found]] = [[] for _ in truth]
    for row in found:
        by_frame[row.frame].append(row)
    for there, rows in zip(truth, by_frame, strict=True):
        data["gt_ids"].append(np.array([named[who] for who, _ in there], dtype=int))
        data["tracker_ids"].append(np.array([tracks[row.who] for row in rows], dtype=int))
        true = np.array([box for _, box in there]).reshape(-1, 4)
        data["similarity_scores"].append(
            overlap(true, np.array([row.box for row in rows]).reshape(-1, 4))
        )
    with contextlib.redirect_stdout(io.StringIO()):
        return {key: metric.eval_sequence(data) for key, metric in metrics_of().items()}
