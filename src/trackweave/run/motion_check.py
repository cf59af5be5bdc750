"""Whether tracks break off under a run's process noise, told or learned, and what is used."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from trackweave.arrays import FloatArray, IntArray
from trackweave.chi_squared import poisson_reaches
from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.estimation.estimates import digits
from trackweave.models.motion import ConstantVelocity, Imm
from trackweave.run.diagnostics import Case, Finding
from trackweave.run.diagnostics.case import SURE_HITS

__all__ = ["MotionDoubts"]

KEY, MODEL = "motion.process_noise", "motion.model"
# Tracks are looked at when so many reports are in them, then at each doubling, and at the end.
LINKS = 800
# So many breaks, where chance hardly makes as many, are put to the trial. It must bring a process
# noise so many times larger, which mends so many, leaves half of them at most, and no more tracks;
# or, of one that was learned, so many times fewer tracks, be they as short as they may.
# What leads from an end to a beginning is that many standard deviations of a manoeuvre's noise.
FEWEST_BREAKS, BY_CHANCE, LEAST_CHANCE = 2, 0.01, 0.1
# … and of tracks, where it was learned, in which chance may make as many rather: a second model
# costs twice the time, and where few break off it gains nothing that joins do not mend.
LEAST_SHARE, CHANCE_OF_LEARNED = 0.03, 0.1
TIMES, LEFT, FEWER, DEVIATIONS = 4.0, 0.5, 0.6, 2.0
# Or it mends so many breaks and such a share of them, each of which leaves one track less, nearly.
FEWEST_JOINED, SOME, AS_MANY = 10, 0.3, 0.8
# Where a trial failed, so many times as many breaks are put to another.
MANY_MORE = 4
# Breaks that are left under a second way to move speak of faster manoeuvres if what they speak of
# is so many times as much; those are put to the trial as well, until so many proved right.
AGAIN, MOST_LEARNED = 2.0, 3
# So do those that a trial leaves which mends too little: it is stepped up so often.
MOST_STEPS = 2
# How long objects keep on and manoeuvre, in usual pauses, and what these two ways are called.
SOJOURNS, WAYS = (20.0, 5.0), ("quiet", "manoeuvring")
# A break: no later than so many of the track's usual pauses after its end, and no earlier before
# it, another track begins, as near as it can have come. What ends or begins within so many pauses
# of the ends of the recording may go on beyond it.
AFTER, BEFORE, CUT = 5.0, 3.0, 8.0
SIGMAS = 6.0
# Within one long turn tracks are short: one of the two has to be beyond doubt, the other has so
# many reports.
SHORTEST = 3
# With so many other reports in a gate tracks break for their neighbours' sake; more noise bridges
# that as well, and speaks of nothing.
CROWDED, GATE = 0.3, 4.0
LEAST = 1e-12
# As many as by chance are found where the ends are moved, so many times as far as that.
MOVED = 3.0
WEIGHT = 60.0


class _Breaks(NamedTuple):
    """Tracks that end where another begins."""

    number: int
    chance: float  # How many would by chance
    process: float  # Process noise of which they speak [m²/s³]
    pause: float  # Usual time from report to report of a track [s]


class _Trial(NamedTuple):
    """What is tried in place of a process noise under which tracks break."""

    doubted: float  # [m²/s³]
    level: float  # [m²/s³]
    broken: _Breaks
    tracks: int
    pieces: int  # Tracks of any length
    steps: int = 0  # How often it was stepped up


class MotionDoubts:
    """The process noise of a run, against where its tracks end and begin.

    Too little loses objects in turns: their tracks break off, and others begin close by. Such a
    run begins again. Where a process noise was told, it takes that of which the reports speak, or
    lets objects change between both.
    Where it was learned, tracks that broke off in turns could not tell of these: objects change
    then between that of the others and that of which the breaks speak. It goes on so if fewer
    tracks break; otherwise it begins once more as before. Tracks that broke off in the first half
    of a turn speak of half of it, so those that break still may speak again.
    """

    def __init__(self) -> None:
        self._due: float = LINKS
        self._trial: _Trial | None = None
        self._used: list[_Trial] = []  # Those that proved right
        self._tried, self._left = 0.0, 0  # The last trial's process noise, and breaks under it
        self._most = 0  # So many breaks are put to no trial again
        self._is_told, self._told = False, 0.0
        self._has_ways = False  # Whether objects change between what was told and what breaks tell

    def applied(self, configuration: Configuration) -> Configuration:
        """Return what the next attempt takes: with another process noise than is doubted."""
        ways_found = [*self._used, *([self._trial] if self._trial else [])]
        if not ways_found:
            return configuration
        motion = dict(configuration.table("motion"))
        if self._is_told:
            del motion["process_noise"]
        if self._has_ways or not self._is_told:
            first = ways_found[0]
            noises = (first.doubted, digits(ways_found[-1].level, 3))
            ways = {
                way: {"model": "constant-velocity", "process_noise": noise}
                for way, noise in zip(WAYS, noises, strict=True)
            }
            times = [digits(each * first.broken.pause, 3) for each in SOJOURNS]
            motion["model"] = "imm"
            motion["imm"] = {"models": list(WAYS), "sojourn_time": times, **ways}
        return configuration.changed(motion=motion)

    def entered(self, settings: Settings) -> Settings:
        """Return the configuration as used, in which what was learned counts as estimated."""
        if not self._used or (self._is_told and not self._has_ways):
            return settings
        own = {key for key in settings.sources if key.startswith("motion.imm.")} | {MODEL}
        return replace(settings, sources={**settings.sources, **dict.fromkeys(own, "estimated")})

    def contradict(
        self, reports: ReportTable, settings: Settings, track: IntArray, *, at_end: bool = False
    ) -> bool:
        """Look at the tracks so far; tell whether ``applied`` changed, to begin again."""
        process, trial = _process(settings), self._trial
        if trial is not None and process < max(TIMES * trial.doubted, LEAST):
            # Without what was told, tracks that broke off in turns tell of little more.
            self._has_ways = self._is_told and not self._has_ways
            return self._has_ways or self._settle(trial, is_right=False)
        n_assigned = int(np.count_nonzero(track >= 0))
        if self._due == np.inf or (not at_end and n_assigned < self._due):
            return False
        case = Case(reports, settings, track, None)
        if trial is None and not self._used and not _is_open(case):
            self._due = np.inf
            return False
        # Of what somebody told both tracks of a break are to be sure, in its trial too.
        self._is_told = settings.sources.get(KEY) == "file" or (
            trial is not None and self._is_told
        )
        found = _breaks(case, are_both_sure=self._is_told)
        if trial is not None:
            self._tried, self._left = process, found.number
            is_right = self._is_better(trial, case, found)
            return (not is_right and self._is_stepped_up(trial, found)) or self._settle(
                trial, is_right=is_right
            )
        self._due = 2 * n_assigned
        self._told = process
        if not self._is_worth_a_trial(case, found, process):
            return False
        level = max(found.process, TIMES * process) if self._used else found.process
        self._trial = _Trial(process, level, found, len(case.groups), _n_tracks(track))
        self._due = n_assigned
        return True

    def _is_better(self, trial: _Trial, case: Case, found: _Breaks) -> bool:
        """Tell whether tracks broke less in a trial than before."""
        broken, n_tracks = trial.broken.number, len(case.groups)
        most = min(broken - FEWEST_BREAKS, LEFT * broken)
        n_pieces = _n_tracks(case.track)
        if found.number <= most and (n_tracks <= trial.tracks or n_pieces < trial.pieces):
            return True
        if self._is_told:
            return False
        # Where tracks broke into pieces too short to show it, there are far fewer of them. What is
        # mended makes one track of two, be there breaks by others that come and go.
        mended = broken - found.number
        return n_pieces <= FEWER * trial.pieces or (
            mended >= max(FEWEST_JOINED, SOME * broken)
            and trial.tracks - n_tracks >= AS_MANY * mended
        )

    def _is_worth_a_trial(self, case: Case, found: _Breaks, process: float) -> bool:
        """Tell whether so many breaks are more than chance, and speak of more than is known."""
        seldom = BY_CHANCE if self._is_told else CHANCE_OF_LEARNED
        fewest = max(FEWEST_BREAKS, self._most + 1)
        if (
            found.number < fewest
            or poisson_reaches(found.number, max(found.chance, LEAST_CHANCE)) > seldom
        ):
            return False
        if self._is_told:
            return _crowd(case) <= CROWDED
        times = AGAIN if self._used else TIMES
        is_too_little = found.process >= max(times * process, LEAST)
        return is_too_little and found.number >= LEAST_SHARE * len(case.groups)

    def _is_stepped_up(self, trial: _Trial, found: _Breaks) -> bool:
        """Tell whether a trial goes on with the more of which breaks speak that it left."""
        is_more = found.number >= FEWEST_BREAKS and found.process >= AGAIN * trial.level
        if self._is_told or not is_more or trial.steps == MOST_STEPS:
            return False
        self._trial = trial._replace(level=found.process, steps=trial.steps + 1)
        return True

    def _settle(self, trial: _Trial, *, is_right: bool) -> bool:
        """End the trial; tell whether to begin again, which what proved right need not."""
        self._trial = None
        if is_right:
            self._used.append(trial)
        self._has_ways &= is_right
        # All objects may stop together later on, as a belt does: many more breaks are tried again.
        is_last = self._is_told or len(self._used) == MOST_LEARNED
        self._due = np.inf if is_last else 2 * self._due
        self._most = 0 if is_right else MANY_MORE * trial.broken.number
        return not is_right

    def findings(self) -> list[Finding]:
        """Return a sentence where another process noise is used than was told."""
        if not (self._used and self._is_told):
            return []
        told = self._used[-1]
        more = f"{self._tried:g} of which reports speak"
        instead = f"changes between that and the {more}" if self._has_ways else f"the {more}"
        return [
            Finding(
                "process_noise",
                None,
                f"{KEY} is told as {told.doubted:g} m²/s³, but with it {told.broken.number} of "
                f"{told.tracks} tracks break off where another begins, and {self._left} with "
                f"{instead}: that is used; correct it, or "
                'give trust = ["process_noise"] in [motion] to keep what is told',
                weight=WEIGHT + abs(float(np.log(self._tried / max(told.doubted, LEAST)))),
                told=told.doubted,
                seen=self._tried,
            )
        ]

    def as_record(self) -> list[dict[str, Any]]:
        """Return what was told, learned and used of a process noise that stood trial."""
        if not (self._tried and self._is_told):
            return []
        used = self._tried if self._used else self._told
        return [{"key": KEY, "told": self._told, "learned": self._tried, "used": used}]


def _process(settings: Settings) -> float:
    """Return the greatest process noise of objects that move straight, 0 of others."""
    motion = settings.motion
    ways = motion.models if isinstance(motion, Imm) else (motion,)
    return max(
        (way.process_noise for way in ways if isinstance(way, ConstantVelocity)), default=0.0
    )


def _is_open(case: Case) -> bool:
    """Tell whether the process noise was learned, or told by a file and may give way."""
    settings = case.settings
    if not isinstance(settings.motion, ConstantVelocity) or settings.divide:
        # Where objects divide, tracks end where others begin.
        return False
    if settings.sources.get(KEY) == "estimated":
        return settings.sources.get(MODEL) == "default"
    trust = settings.values["motion"].get("trust", False)
    is_trusted = trust is True or (isinstance(trust, Sequence) and "process_noise" in trust)
    return settings.sources.get(KEY) == "file" and not is_trusted


def _breaks(case: Case, *, are_both_sure: bool) -> _Breaks:
    """Return how many tracks end where another begins, and of what process noise they speak."""
    groups = [own for own in case.tracks_of(SHORTEST) if np.isfinite(case.position[own]).all()]
    if len(groups) < FEWEST_BREAKS:
        return _Breaks(0, 0.0, 0.0, 1.0)
    is_sure = np.array([own.size >= SURE_HITS for own in groups])
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
    # Behind others objects come and go in pieces.
    fits &= (is_sure[:, None] & is_sure) if are_both_sure else (is_sure[:, None] | is_sure)
    own = max((case.plane_sigma(i) for i in case.examined if case.tells_place(i)), default=0.0)
    fastest = np.maximum(speed[:, None], speed[None, :])
    reach = SIGMAS * own + fastest * (np.abs(late) + pause[:, None])
    way: FloatArray = place[begins][None, :] - place[ends][:, None]
    is_near = fits & (np.linalg.norm(way, axis=2) <= reach)
    moves = [np.array(step) for step in ((MOVED, 0.0), (-MOVED, 0.0), (0.0, MOVED), (0.0, -MOVED))]
    moved = [np.linalg.norm(way + step * reach[..., None], axis=2) <= reach for step in moves]
    chance = float(np.mean([(fits & near).any(axis=1).sum() for near in moved]))
    # A deviation d along two axes after a time T is that of a process noise of 3 d²/(2 T³).
    steps = np.concatenate([np.diff(time[own]) for own in groups])
    usual = float(np.median(steps[steps > 0.0])) if np.any(steps > 0.0) else 1.0
    late = np.maximum(late, usual)
    last = np.array([own[-2] for own in groups])
    velocity = (place[ends] - place[last]) / np.maximum(time[ends] - time[last], LEAST)[:, None]
    beside = np.linalg.norm(way - velocity[:, None] * late[..., None], axis=2) / DEVIATIONS
    process = np.where(is_near, 1.5 * beside**2 / late**3, np.inf).min(axis=1)
    broken = is_near.any(axis=1)
    spoken = float(np.median(process[broken])) if broken.any() else 0.0
    return _Breaks(int(broken.sum()), chance, spoken, usual)


def _n_tracks(track: IntArray) -> int:
    """Return how many tracks there are, the shortest as well."""
    return int(np.unique(track[track >= 0]).size)


def _crowd(case: Case) -> float:
    """Return how many other reports of a scan lie in a gate, on average over where any are."""
    known = case.position[np.isfinite(case.position).all(axis=1)]
    room = float(np.prod(np.ptp(known, axis=0))) if len(known) else 0.0
    sigma = max((case.plane_sigma(i) for i in case.examined if case.tells_place(i)), default=0.0)
    per_scan = len(known) / np.unique(case.reports.time).size
    return (per_scan - 1.0) * np.pi * (GATE * sigma) ** 2 / max(room, LEAST)


def _speed(time: FloatArray, place: FloatArray) -> float:
    """Return how fast an object usually was, over steps that noise hardly bends [m/s]."""
    step = max(1, min(5, time.size // 2))
    way = np.linalg.norm(place[step:] - place[:-step], axis=1)
    return float(np.median(way / np.maximum(time[step:] - time[:-step], 1e-9)))
