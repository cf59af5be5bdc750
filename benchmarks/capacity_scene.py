"""A sky of aircraft seen by ten turning radars, made as it goes: nothing of the past is held."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import polars as pl

from trackweave import FieldOfView, Lifecycle, Scan, Sensor
from trackweave.domain.measurements import MeasurementKind
from trackweave.models.rotation import Rotation

Array = np.ndarray[Any, np.dtype[Any]]
SIDE = 1_000e3
"""Length of the sky's sides at 4,000 aircraft; it shrinks with them, to be as crowded [m]."""
FULL = 4_000
TURN = 4.0
SECTORS = 8
RANGE_NOISE, ANGLE_NOISE = 70.0, np.radians(0.08)
DETECTION, FALSE_SHARE = 0.97, 0.1
SPEEDS = (150.0, 270.0)
TURN_EVERY, TURN_LASTS, TURN_RATE = 300.0, 30.0, np.radians(1.0)
# Ten discs of this radius cover a square of side one from these centres, and most of it twice.
RADARS = (
    (0.14, 0.15), (0.50, 0.13), (0.86, 0.15), (0.31, 0.38), (0.69, 0.38),
    (0.13, 0.62), (0.50, 0.64), (0.87, 0.62), (0.29, 0.88), (0.71, 0.88),
)  # fmt: skip
REACH = 0.28


class Truth(NamedTuple):
    """Where the aircraft are at a time; a number that is never used again names each."""

    time: float
    name: Array
    position: Array


class Plots(NamedTuple):
    """What a radar tells of a turn, and of whom."""

    time: Array
    report: Array
    """Range [m] and azimuth, clockwise from north [rad]."""
    name: Array
    """Whose each is, -1 for false alarms."""


class Sky:
    """Aircraft that fly straight legs and turns; who leaves the sky is replaced at its border."""

    def __init__(self, aircraft: int, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        # As crowded with fewer aircraft, and seen by as many radars.
        self.side = SIDE * np.sqrt(aircraft / FULL)
        self.position = self.rng.uniform(0.0, self.side, (aircraft, 2))
        self.speed = self.rng.uniform(*SPEEDS, aircraft)
        self.course = self.rng.uniform(0.0, 2.0 * np.pi, aircraft)
        self.rate = np.zeros(aircraft)
        self.name = np.arange(aircraft)
        self.time = 0.0

    def velocity(self) -> Array:
        """Return how fast each aircraft moves, east and north [m/s]."""
        return self.speed[:, None] * np.column_stack([np.sin(self.course), np.cos(self.course)])

    def advance(self, seconds: float) -> None:
        """Let time pass: turns begin and end, aircraft leave and come."""
        count = self.speed.shape[0]
        begins = self.rng.random(count) < seconds / TURN_EVERY
        ends = self.rng.random(count) < seconds / TURN_LASTS
        self.rate = np.where(self.rate != 0.0, np.where(ends, 0.0, self.rate), 0.0)
        self.rate[begins] = self.rng.choice([-TURN_RATE, TURN_RATE], int(begins.sum()))
        self.course = self.course + self.rate * seconds / 2
        self.position = self.position + self.velocity() * seconds
        self.course = self.course + self.rate * seconds / 2
        self.time += seconds
        gone = np.flatnonzero(np.any((self.position < 0) | (self.position > self.side), axis=1))
        # From where it left it comes back as another: half a turn about the sky's middle.
        self.position[gone] = np.clip(self.side - self.position[gone], 0.0, self.side)
        self.name[gone] = self.name.max(initial=0) + 1 + np.arange(gone.size)
        self.rate[gone] = 0.0

    def truth(self) -> Truth:
        """Return where the aircraft are."""
        return Truth(self.time, self.name.copy(), self.position.copy())


class Radars:
    """Ten radars, or as many over each of the sky's blocks, a row of ``blocks`` to a side.

    Reports come sector by sector.
    """

    def __init__(self, sky: Sky, blocks: int = 1) -> None:
        self.sky = sky
        self.reach = REACH * sky.side / blocks
        corners = [(east, north) for east in range(blocks) for north in range(blocks)]
        units = np.concatenate([np.add(RADARS, corner) for corner in corners])
        self.place = units * sky.side / blocks
        self.phase = sky.rng.uniform(0.0, 2.0 * np.pi, len(units))
        seen = np.pi * REACH**2 * sky.speed.size / blocks**2 * DETECTION
        self.n_false = FALSE_SHARE / (1.0 - FALSE_SHARE) * seen
        """Mean number of false alarms of a radar in a turn."""

    def sensors(self) -> list[Sensor]:
        """Return what a tracker has to know of them."""
        return [
            Sensor(
                f"radar{number}", (RANGE_NOISE, ANGLE_NOISE), DETECTION,
                self.n_false / (self.reach * 2.0 * np.pi), scan_period=TURN,
                field_of_view=FieldOfView((x, y), max_range=self.reach),
                measurement=MeasurementKind.RANGE_AZIMUTH,
                position=(x, y),
                rotation=Rotation(TURN, float(phase)),
            )
            for number, ((x, y), phase) in enumerate(
                zip(self.place.tolist(), self.phase, strict=True)
            )
        ]  # fmt: skip

    def scans(self) -> list[Scan]:
        """Return the sectors of a turn, which begins now, in order of time."""
        found = [scan for number in range(len(self.place)) for scan in self._turn(number)]
        return sorted(found, key=lambda scan: scan.time)

    def _turn(self, number: int) -> Iterator[Scan]:
        plots, begin = self.plots(number), self.sky.time
        after = plots.time - begin
        sector = np.minimum((after / TURN * SECTORS).astype(int), SECTORS - 1)
        for part in range(SECTORS):
            own = sector == part
            end = begin + (part + 1) * TURN / SECTORS
            yield Scan(end, f"radar{number}", plots.report[own], moments=plots.time[own])

    def plots(self, number: int) -> Plots:
        """Return what a radar tells of the turn that begins now, those of aircraft first."""
        sky, rng = self.sky, self.sky.rng
        velocity = sky.velocity()
        moment = np.zeros(sky.speed.size)
        for _ in range(3):  # the beam meets an aircraft where that is by then
            apart = sky.position + velocity * moment[:, None] - self.place[number]
            azimuth = np.arctan2(apart[:, 0], apart[:, 1])
            moment = (azimuth - self.phase[number]) % (2 * np.pi) / (2 * np.pi) * TURN
        distance = np.hypot(apart[:, 0], apart[:, 1])
        seen = (distance < self.reach) & (rng.random(distance.size) < DETECTION)
        n_false = rng.poisson(self.n_false)
        false_at = rng.uniform(0.0, TURN, n_false)
        moment = np.concatenate([moment[seen], false_at])
        distance = np.concatenate(
            [distance[seen] + RANGE_NOISE * rng.standard_normal(int(seen.sum())),
             rng.uniform(0.0, self.reach, n_false)]
        )  # fmt: skip
        azimuth = np.concatenate(
            [azimuth[seen] + ANGLE_NOISE * rng.standard_normal(int(seen.sum())),
             self.phase[number] + 2 * np.pi * false_at / TURN]
        ) % (2 * np.pi)  # fmt: skip
        report = np.column_stack([np.maximum(distance, 1.0), azimuth])
        name = np.concatenate([sky.name[seen], np.full(n_false, -1)])
        return Plots(sky.time + moment, report, name)


def recorded(radars: Radars, turns: int) -> tuple[pl.DataFrame, list[Truth]]:
    """Return the radars' reports with their ``target``, "" for false ones, and who was where.

    In order of time; the truth is that at the end of each turn.
    """
    parts, truth = [], []
    for _ in range(turns):
        for number in range(len(radars.place)):
            plots = radars.plots(number)
            parts.append(pl.DataFrame({
                "time": plots.time,
                "sensor": [f"radar{number}"] * plots.time.size,
                "range_m": plots.report[:, 0],
                "azimuth_deg": np.degrees(plots.report[:, 1]),
                "target": [f"{name}" if name >= 0 else "" for name in plots.name.tolist()],
            }))  # fmt: skip
        radars.sky.advance(TURN)
        truth.append(radars.sky.truth())
    return pl.concat(parts).sort("time", maintain_order=True), truth


def lifecycle(sky: Sky) -> Lifecycle:
    """Return when tracks begin and end in such a sky."""
    crowd = sky.speed.size / sky.side**2
    return Lifecycle(
        new_target_density=1e-4 * crowd, initial_target_density=crowd, survival=0.9995
    )
