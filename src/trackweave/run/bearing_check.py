"""Whether bearings contradict the noise that was told of them, and what is used instead."""

from dataclasses import replace
from typing import Any

from trackweave.config import Configuration
from trackweave.config.fill import Settings
from trackweave.domain.reports import ReportTable
from trackweave.keys import show_value
from trackweave.run.diagnostics import Finding
from trackweave.run.noise_check import number, scaled
from trackweave.run.observing import observe, positions_in
from trackweave.run.views import are_bearings

__all__ = ["BearingDoubts"]

WEIGHT = 50.0


class BearingDoubts:
    """What was told of the noise of bearings, against what makes their tracks likelier.

    Where no report says where its object is, none scatters about a place: tracks under one noise
    are compared with those under another. All sensors are judged together, once.
    """

    def __init__(self) -> None:
        self._is_judged = False
        self._told: dict[str, Any] = {}
        self._used: dict[str, Any] = {}

    def applied(self, configuration: Configuration) -> Configuration:
        """Return what the next attempt takes: as read, but for the noise that is doubted."""
        if not self._used:
            return configuration
        sensors = configuration.table("sensors")
        for name, sigma in self._used.items():
            sensors[name] = {**sensors.get(name, {}), "sigma": sigma}
        return configuration.changed(sensors=sensors)

    def contradict(
        self, reports: ReportTable, settings: Settings, configuration: Configuration
    ) -> bool:
        """Judge what is told, if that was not done; tell whether ``applied`` changed."""
        # The configuration is as read; ``settings`` are those of the attempt.
        if self._is_judged:
            return False
        self._is_judged = True
        told = {name: configuration.sensor(name).get("sigma") for name in reports.sensors}
        is_trusted = any(sensor.trusts("sigma") for sensor in settings.sensors)
        observed = observe(reports, configuration)
        motion = settings.values["motion"]
        is_known = {"max_speed", "process_noise"} <= set(motion)
        if None in told.values() or is_trusted or not is_known or not are_bearings(observed):
            return False
        from trackweave.run.bearings_alone import likelier_noise

        factor = likelier_noise(
            reports,
            configuration,
            observed,
            positions_in(reports, configuration),
            (motion["max_speed"], motion["process_noise"]),
        )
        if factor is None:
            return False
        self._told, self._used = told, {n: scaled(s, {"": factor}) for n, s in told.items()}
        return True

    def entered(self, settings: Settings) -> Settings:
        """Return the configuration as used, in which what was learned counts as estimated."""
        learned = {f"sensors.{name}.sigma": "estimated" for name in self._used}
        return replace(settings, sources={**settings.sources, **learned})

    def findings(self) -> list[Finding]:
        """Return a sentence on each sensor whose noise is contradicted."""
        return [
            Finding(
                "sigma",
                name,
                f"sensor {name}: sigma is told as {show_value(self._told[name])}, but tracks are "
                f"far likelier under {show_value(used)}: that is used; correct it, or give "
                f'trust = ["sigma"] in [sensors.{name}] to keep what is told',
                weight=WEIGHT,
                told=number(self._told[name]),
                seen=number(used),
            )
            for name, used in self._used.items()
        ]

    def as_record(self) -> list[dict[str, Any]]:
        """Return what was told, learned and used of each sensor that was contradicted."""
        return [
            {
                "key": f"sensors.{name}.sigma",
                "told": self._told[name],
                "learned": used,
                "used": used,
            }
            for name, used in self._used.items()
        ]
