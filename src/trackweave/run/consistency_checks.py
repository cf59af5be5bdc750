"""What of a configuration a run's first tracks contradict, and what is used instead."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.models.motion import ConstantVelocity
from trackweave.run.diagnostics import Case, Finding
from trackweave.run.noise_check import NoiseDoubts

__all__ = ["ConsistencyChecks", "MotionDoubts"]

KEY = "motion.process_noise"
# Tracks are looked at when so many reports are in them, then at each doubling, and at the end.
LINKS = 800
# So many breaks, and one in so many tracks, beyond chance, are put to the trial. It must bring a
# process noise so many times larger, which leaves half of the breaks at most.
FEWEST_BREAKS, BREAKING, TIMES, LEFT = 2, 0.15, 4.0, 0.5
# A break: no later than so many of the track's usual pauses after its end, and no earlier before
# it, another track begins, as near as it can have come. What ends or begins within so many pauses
# of the ends of the recording may go on beyond it.
AFTER, BEFORE, CUT = 5.0, 3.0, 8.0
SIGMAS = 6.0
LEAST = 1e-12
# As many as by chance are found where the ends are moved, so many times as far as that.
MOVED = 3.0
WEIGHT = 60.0


class MotionDoubts:
    """What was told of the process noise, against where the tracks of a run end and begin.

    Too little loses objects in turns: their tracks break off, and others begin close by. Such a
    run begins again with the process noise that the reports speak of, and goes on with it if
    fewer tracks break; otherwise it begins once more as told.
    """

    def __init__(self) -> None:
        self._due: float = LINKS
        self._told = self._learned = 0.0
        self._broken = self._tracks = self._left = 0
        self._is_on_trial = self._is_used = False

    def applied(self, configuration: Configuration) -> Configuration:
        """Return what the next attempt takes: without a process noise that is doubted."""
        if not (self._is_on_trial or self._is_used):
            return configuration
        motion = {k: v for k, v in configuration.table("motion").items() if k != "process_noise"}
        return configuration.changed(motion=motion)

    def contradict(
        self, reports: ReportTable, settings: Settings, track: IntArray, *, at_end: bool = False
    ) -> bool:
        """Look at the tracks so far; tell whether ``applied`` changed, to begin again."""
        process = _process(settings)
        if self._is_on_trial and process < max(TIMES * self._told, LEAST):
            return self._settle(is_used=False)
        n_assigned = int(np.count_nonzero(track >= 0))
        if self._due == np.inf or (not at_end and n_assigned < self._due):
            return False
        case = Case(reports, settings, track, None)
        if not self._is_on_trial and not _is_open(case):
            self._due = np.inf
            return False
        broken, chance = _breaks(case)
        if self._is_on_trial:
            self._learned, self._left = process, broken
            return self._settle(is_used=broken <= LEFT * self._broken)
        self._due = 2 * n_assigned
        if broken - chance < max(FEWEST_BREAKS, BREAKING * len(case.groups)):
            return False
        self._told, self._is_on_trial = process, True
        self._broken, self._tracks, self._due = broken, len(case.groups), n_assigned
        return True

    def _settle(self, *, is_used: bool) -> bool:
        """End the trial; tell whether to begin again, which what proved right need not."""
        self._is_on_trial, self._is_used, self._due = False, is_used, np.inf
        return not is_used

    def findings(self) -> list[Finding]:
        """Return a sentence where another process noise is used than was told."""
        if not self._is_used:
            return []
        return [
            Finding(
                "process_noise",
                None,
                f"{KEY} is told as {self._told:g} m²/s³, but with it {self._broken} of "
                f"{self._tracks} tracks break off where another begins, and {self._left} with "
                f"the {self._learned:g} of which reports speak: that is used; correct it, or "
                'give trust = ["process_noise"] in [motion] to keep what is told',
                weight=WEIGHT + abs(float(np.log(self._learned / max(self._told, LEAST)))),
                told=self._told,
                seen=self._learned,
            )
        ]

    def as_record(self) -> list[dict[str, Any]]:
        """Return what was told, learned and used of a process noise that stood trial."""
        if not self._learned:
            return []
        used = self._learned if self._is_used else self._told
        return [{"key": KEY, "told": self._told, "learned": self._learned, "used": used}]


def _process(settings: Settings) -> float:
    """Return the process noise of objects that move in one way, 0 of others."""
    motion = settings.motion
    return motion.process_noise if isinstance(motion, ConstantVelocity) else 0.0


def _is_open(case: Case) -> bool:
    """Tell whether the file tells a process noise that may give way."""
    trust = case.settings.values["motion"].get("trust", False)
    return (
        isinstance(case.settings.motion, ConstantVelocity)
        and case.settings.sources.get(KEY) == "file"
        and trust is not True
        and not (isinstance(trust, Sequence) and "process_noise" in trust)
    )


def _breaks(case: Case) -> tuple[int, float]:
    """Return how many tracks end where another begins, and how many would by chance."""
    groups = [own for own in case.groups if np.isfinite(case.position[own]).all()]
    if len(groups) < FEWEST_BREAKS:
        return 0, 0.0
    time, place = case.reports.time, case.position
    ends, begins = (np.array([own[k] for own in groups]) for k in (-1, 0))
    pause = np.array([np.median(np.diff(time[own])) for own in groups])
    speed = np.array([_speed(time[own], place[own]) for own in groups])
    known = time[case.track >= 0]
    is_end = time[ends] < known.max() - CUT * pause
    is_begin = time[begins] > known.min() + CUT * pause
    late = time[begins][None, :] - time[ends][:, None]
    fits = (late <= AFTER * pause[:, None]) & (late >= -BEFORE * pause[:, None])
    fits &= is_end[:, None] & is_begin[None, :] & ~np.eye(len(groups), dtype=bool)
    own = max((case.plane_sigma(i) for i in case.examined if case.tells_place(i)), default=0.0)
    fastest = np.maximum(speed[:, None], speed[None, :])
    reach = SIGMAS * own + fastest * (np.abs(late) + pause[:, None])
    way: FloatArray = place[begins][None, :] - place[ends][:, None]
    found = int((fits & (np.linalg.norm(way, axis=2) <= reach)).any(axis=1).sum())
    moves = [np.array(step) for step in ((MOVED, 0.0), (-MOVED, 0.0), (0.0, MOVED), (0.0, -MOVED))]
    moved = [np.linalg.norm(way + step * reach[..., None], axis=2) <= reach for step in moves]
    chance = float(np.mean([(fits & near).any(axis=1).sum() for near in moved]))
    return found, chance


def _speed(time: FloatArray, place: FloatArray) -> float:
    """Return how fast an object usually was, over steps that noise hardly bends [m/s]."""
    step = max(1, min(5, time.size // 2))
    way = np.linalg.norm(place[step:] - place[:-step], axis=1)
    return float(np.median(way / np.maximum(time[step:] - time[:-step], 1e-9)))


class ConsistencyChecks:
    """What was told of noise and of motion, against what the first tracks of a run show.

    Noise comes first: where too little is told of it, tracks break off whatever objects do.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._told = configuration
        self._noise, self._motion = NoiseDoubts(), MotionDoubts()

    @property
    def configuration(self) -> Configuration:
        """What the next attempt takes: as read, but for what is doubted."""
        return self._motion.applied(self._noise.applied(self._told))

    def contradict(
        self, reports: ReportTable, settings: Settings, track: IntArray, *, at_end: bool = False
    ) -> bool:
        """Look at the tracks so far; tell whether ``configuration`` changed, to begin again."""
        # ``track`` is that of each report as far as it is known, -1 for none; ``at_end`` no more
        # come.
        if reports.has_foreign:
            # Nothing here knows how reports of a kind from outside scatter.
            return False
        if self._noise.contradict(reports, settings, track, at_end=at_end):
            return True
        if not (self._noise.is_settled or at_end):
            return False
        return self._motion.contradict(reports, settings, track, at_end=at_end)

    def entered(self, settings: Settings) -> Settings:
        """Return the configuration as used, in which what was learned counts as estimated."""
        return self._noise.entered(settings)

    def findings(self) -> list[Finding]:
        """Return a sentence on each value that is not used as told."""
        return [*self._noise.findings(), *self._motion.findings()]

    def as_record(self) -> list[dict[str, Any]]:
        """Return what was told, learned and used of each value that was judged."""
        return [*self._noise.as_record(), *self._motion.as_record()]
