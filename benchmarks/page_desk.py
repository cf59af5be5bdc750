"""A desk with aircraft of its own, for the page to be tried on without a tracker behind it."""

import asyncio
from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl

from trackweave.domain.frames import LocalFrame
from trackweave.service.desk import Picture, Receipt, Rows
from trackweave.service.fanout import Fanout, Listener
from trackweave.service.web.application import Application
from trackweave.service.web.server import WebServer
from trackweave.service.web.settings import WebSettings

TURN_S, SECTORS, TRAIL = 4.0, 16, 60
PLACES = {"Bern": (-8e4, -12e4), "Ulm": (9e4, 8e4)}


class AircraftDesk:
    """Aircraft that fly straight and turn now and then, each told of once a turn of the radar."""

    def __init__(
        self, n: int, *, seed: int = 0, reach_m: float = 4e5, geographic: bool = True
    ) -> None:
        rng = np.random.default_rng(seed)
        self.rng, self.n, self.reach = rng, n, reach_m
        self.frame = LocalFrame(47.5, 8.5) if geographic else None
        angle, speed = rng.uniform(0, 2 * np.pi, n), rng.uniform(90, 250, n)
        self.speed, self.angle = speed, angle
        self.place = rng.uniform(-reach_m, reach_m, (n, 2))
        self.height = rng.choice([900.0, 3000.0, 6000.0, 9500.0, 11000.0, 11900.0], n)
        self.status = rng.choice(["confirmed", "coasting", "tentative"], n, p=[0.9, 0.06, 0.04])
        self.rate = np.zeros(n)
        self.time, self.sector, self.sequence = 1.7e9, 0, 0
        self.names = [f"{name:06X}" for name in rng.integers(0, 1 << 24, n).tolist()]
        self.trails: list[list[list[float]]] = [[] for _ in range(n)]
        self.fanout = Fanout(self.picture)

    def advance(self, seconds: float) -> pl.DataFrame:
        """Let time pass, and return the rows of who is in the sector that the beam swept."""
        turning = self.rng.random(self.n) < 0.01 * seconds
        self.rate[turning] = self.rng.choice([0.0, 0.0, 0.02, -0.02], int(turning.sum()))
        self.angle += self.rate * seconds
        self.place += self.speed[:, None] * self.heading() * seconds
        outside = np.abs(self.place).max(axis=1) > self.reach
        homeward = np.arctan2(*-self.place.T) + self.rng.normal(0, 0.6, self.n)
        self.angle = np.where(outside, homeward, self.angle)
        self.time += seconds
        self.sector = (self.sector + 1) % SECTORS
        azimuth = np.arctan2(*self.place.T) % (2 * np.pi)
        return self.rows(
            np.flatnonzero((azimuth / (2 * np.pi) * SECTORS).astype(int) == self.sector)
        )

    def heading(self) -> np.ndarray:
        """Return where each aircraft goes, east and north."""
        return np.stack([np.sin(self.angle), np.cos(self.angle)], axis=1)

    def rows(self, which: np.ndarray) -> pl.DataFrame:
        """Return rows of a tracks table for some of them."""
        place, velocity = self.place[which], (self.speed[:, None] * self.heading())[which]
        columns: dict[str, Any] = {
            "time": np.full(which.size, self.time), "track": which + 1,
            "status": self.status[which], "x": place[:, 0], "y": place[:, 1],
        }  # fmt: skip
        if self.frame is not None:
            columns["lat"], columns["lon"], _ = self.frame.to_geodetic(place)
            columns["alt_m"] = self.height[which]
        columns |= {
            "vx": velocity[:, 0], "vy": velocity[:, 1], "p_x_x": np.full(which.size, 8e3),
            "p_x_y": np.full(which.size, 3e3), "p_y_y": np.full(which.size, 5e3),
            "existence": np.full(which.size, 0.998), "hits": np.full(which.size, 60),
            "identity": [self.names[k] for k in which.tolist()],
            "sensors": [["Bern", "Ulm"] if k % 3 else ["Bern"] for k in which.tolist()],
        }  # fmt: skip
        return pl.DataFrame(columns)

    def picture(self) -> Picture:
        """Return all aircraft."""
        return Picture(self.time, self.rows(np.arange(self.n)), self.frame)

    def track(self, identifier: str) -> dict[str, Any] | None:
        """Return an aircraft with innovations drawn by chance."""
        if not identifier.isdecimal() or not 0 < int(identifier) <= self.n:
            return None
        times = self.time - TURN_S * np.arange(TRAIL)[::-1]
        nis = self.rng.chisquare(2, TRAIL)
        pairs = zip(times.tolist(), nis.tolist(), strict=True)
        return {
            "track": identifier,
            "innovations": [[time, "Bern", value] for time, value in pairs],
        }

    def sensors(self) -> list[dict[str, Any]]:
        """Return two radars, one of them silent."""
        angle = np.linspace(0, 2 * np.pi, 60)
        found = []
        for k, (name, (x, y)) in enumerate(PLACES.items()):
            reach = 1.8e5 + 4e4 * np.sin(3 * angle + k)
            border = np.stack([x + reach * np.sin(angle), y + reach * np.cos(angle)], axis=1)
            sensor = {
                "name": name, "kind": "range-azimuth", "last_heard": self.time - 30 * k,
                "reports_per_s": self.n / TURN_S * (0.7 - 0.4 * k), "silent": k > 0,
            }  # fmt: skip
            if self.frame is None:
                found.append(sensor | {"x": x, "y": y, "coverage": border.tolist()})
                continue
            latitude, longitude, _ = self.frame.to_geodetic(np.array([[x, y], *border]))
            pairs = np.stack([longitude, latitude], axis=1).tolist()
            found.append(sensor | {"place": pairs[0], "coverage": pairs[1:]})
        return found

    def health(self) -> dict[str, Any]:
        """Return that all is well."""
        return {"status": "ok", "sequence": self.sequence}

    def counters(self) -> Mapping[str, float]:
        """Return how many rows were told."""
        return {"reports_total": float(self.sequence)}

    async def accept(self, rows: Rows) -> Receipt:
        """Take nothing."""
        del rows
        return Receipt(0, (), self.sequence)

    def subscribe(self, *, reports: bool = False) -> Listener:
        """Return messages from now on."""
        return self.fanout.subscribe(reports=reports)

    async def fly(self, fast: float = 1.0) -> None:
        """Send what the sectors hold as time passes, for ever."""
        step = TURN_S / SECTORS
        while True:
            changed = self.advance(step)
            self.sequence += changed.height
            self.fanout.tracks(self.time, changed, [], self.frame)
            if self.sector % SECTORS == 0:
                self.fanout.send({"type": "sensors", "sensors": self.sensors()})
            if self.sector % 4 == 0:
                self.fanout.send(self.said())
                self.fanout.reports(self.time, self.echoes(changed))
            await asyncio.sleep(step / fast)

    def said(self) -> dict[str, Any]:
        """Return what a service would say of itself."""
        return {
            "type": "status", "time": self.time, "load": float(self.rng.uniform(0.3, 0.4)),
            "latency_s": float(self.rng.uniform(0.08, 0.15)), "gap": 0.0, "set_aside": 3,
            "reports_per_s": self.n / TURN_S, "sequence": self.sequence,
        }  # fmt: skip

    def echoes(self, changed: pl.DataFrame) -> list[list[Any]]:
        """Return reports: of those that changed, and some of nothing."""
        false = self.rng.uniform(-self.reach, self.reach, (20, 2))
        names = [str(track) for track in changed["track"].to_list()]
        if self.frame is None:
            places = np.concatenate([changed.select("x", "y").to_numpy(), false])
        else:
            latitude, longitude, _ = self.frame.to_geodetic(false)
            own = changed.select("lon", "lat").to_numpy()
            places = np.concatenate([own, np.stack([longitude, latitude], axis=1)])
        tracks: list[str | None] = [*names, *[None] * len(false)]
        return [
            [x, y, "Bern", track] for (x, y), track in zip(places.tolist(), tracks, strict=True)
        ]


async def served(desk: AircraftDesk) -> WebServer:
    """Return a server of the page that listens already; whoever asked stops it."""
    server = WebServer(Application(desk, WebSettings()), "127.0.0.1", 0)
    await server.start()
    return server
