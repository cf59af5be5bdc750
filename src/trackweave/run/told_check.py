"""What was told of sensors and objects, taken back where a whole run contradicts it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from trackweave.config import Configuration
from trackweave.config.fill import ANY_SENSOR, Settings
from trackweave.keys import show_value
from trackweave.run.diagnostics import Finding

__all__ = ["ToldDoubts"]

# What a finding's cause takes back of its sensor, or of all objects.
OF_SENSOR = {
    "field of view": ("field_of_view",),
    "detection_probability": ("detection_probability",),
    "clutter": ("clutter_per_scan", "clutter_density"),
}
OF_MOTION = {"max_speed": "max_speed"}
# What is said of the fastest is a limit, which only what is faster contradicts; and more false
# alarms and misses than there are cost little, so that whoever tells them may be careful.
ONLY_MORE, ONLY_LESS = {"max_speed", "clutter"}, {"detection_probability"}
USED = {"clutter_per_scan": "clutter_density"}
"""Under which key what is used instead stands, where it is another."""
# Where reports come from outside what a sensor is said to see, the rest may follow from that.
FIRST = "field of view"
MOST_RUNS = 3


class _Doubted(NamedTuple):
    """A key that is no longer believed."""

    path: tuple[str, ...]
    told: Any
    finding: Finding

    def used(self, settings: Settings) -> Any:
        """Return what a run has in its place."""
        *table, key = self.path
        return _at(settings.values, (*table, USED.get(key, key)))

    def sentence(self, used: Any) -> str:
        """Return what the finding says, and what is used instead."""
        *table, key = self.path
        instead = f"{show_value(used)} is used" if used is not None else "none is used"
        return (
            f'{self.finding.sentence}; {instead}, and trust = ["{key}"] in [{".".join(table)}] '
            "keeps what is told"
        )


class ToldDoubts:
    """What a run's tracks contradict when all is tracked, to begin again as if nobody told it.

    Noise, process noise, biases and turns give way before; these show only in the end: how often
    a sensor reports what it sees, from where, how many reports are nobody's, how fast objects are.
    """

    def __init__(self) -> None:
        self._doubted: list[_Doubted] = []
        self._used: list[Any] = []
        self._sensors: list[str] = []
        self._n_runs = 1

    def take_back(self, findings: Sequence[Finding], settings: Settings) -> bool:
        """Look at what contradicts a run; tell whether ``applied`` changed, to begin again."""
        self._sensors = [sensor.name for sensor in settings.sensors]
        if self._n_runs == MOST_RUNS:
            return False
        found = [new for finding in findings for new in _taken_back(finding, settings)]
        found = [each for each in found if each.finding.cause == FIRST] or found
        self._doubted += found
        self._n_runs += bool(found)
        return bool(found)

    def applied(self, configuration: Configuration) -> Configuration:
        """Return what the next run takes: as read, without what is doubted."""
        if not self._doubted:
            return configuration
        motion, usual = configuration.table("motion"), configuration.table("sensors", ANY_SENSOR)
        # Each sensor gets what it has of every sensor's keys for its own.
        sensors = configuration.table("sensors")
        sensors |= {name: configuration.sensor(name) for name in self._sensors}
        for table, *rest in (each.path for each in self._doubted):
            if table == "motion":
                motion.pop(rest[0], None)
                continue
            name, key = rest
            for word in {key, USED.get(key, key)}:
                sensors[name].pop(word, None)
                usual.pop(word, None)
        if ANY_SENSOR not in self._sensors:
            sensors[ANY_SENSOR] = usual
        return configuration.changed(motion=motion, sensors=sensors)

    def entered(self, settings: Settings) -> Settings:
        """Return a run's configuration, of which what is used instead is remembered."""
        self._used = [each.used(settings) for each in self._doubted]
        return settings

    def findings(self) -> list[Finding]:
        """Return a sentence on each value that is not used as told, of several sensors on one."""
        of = {each.finding.sentence: (each, used) for each, used in reversed(self._both())}
        return [replace(each.finding, sentence=each.sentence(used)) for each, used in of.values()]

    def _both(self) -> list[tuple[_Doubted, Any]]:
        return list(zip(self._doubted, self._used, strict=True))

    def as_record(self) -> list[dict[str, Any]]:
        """Return what was told, learned and used of each value that was taken back."""
        return [
            {"key": ".".join(each.path), "told": each.told, "learned": used, "used": used}
            for each, used in self._both()
        ]


def _taken_back(finding: Finding, settings: Settings) -> Iterator[_Doubted]:
    """Yield what a finding contradicts that a file told without asking for trust."""
    is_more = (finding.seen or 0.0) > (finding.told or 0.0)
    if not finding.is_clear or finding.cause in (ONLY_LESS if is_more else ONLY_MORE):
        return
    trusting = {sensor.name: sensor for sensor in settings.sensors}
    names = [] if finding.sensor is None else [finding.sensor, *finding.likewise]
    for name in names:
        for key in OF_SENSOR.get(finding.cause, ()):
            path = ("sensors", name, key)
            told = _at(settings.values, path)
            if told is not None and _is_of_file(settings, path) and not trusting[name].trusts(key):
                yield _Doubted(path, told, finding)
                break
    key = OF_MOTION.get(finding.cause, "")
    of_all = ("motion", key)
    if key and _is_of_file(settings, of_all) and not _is_trusted(settings, key):
        yield _Doubted(of_all, _at(settings.values, of_all), finding)


def _is_of_file(settings: Settings, path: tuple[str, ...]) -> bool:
    return settings.sources.get(".".join(path)) == "file"


def _is_trusted(settings: Settings, key: str) -> bool:
    trust = settings.values["motion"].get("trust", False)
    return trust if isinstance(trust, bool) else key in trust


def _at(values: Mapping[str, Any], path: tuple[str, ...]) -> Any:
    """Return the value of a path of keys, None where there is none."""
    *table, key = path
    for name in table:
        values = values.get(name) or {}
    return values.get(key)
