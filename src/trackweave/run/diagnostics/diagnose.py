"""All checks, in one list."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

from trackweave.run.diagnostics.across import disagreeing_sensors, other_senses
from trackweave.run.diagnostics.at_rest import tracks_at_rest
from trackweave.run.diagnostics.biased import biased_sensors
from trackweave.run.diagnostics.case import Case, Check, Finding
from trackweave.run.diagnostics.jumps import common_jumps
from trackweave.run.diagnostics.repeats import repeated_reports
from trackweave.run.diagnostics.scans import (
    copied_sensors,
    lone_reports,
    reporting_objects,
    single_times,
    sparse_scans,
    unseen_turns,
)
from trackweave.run.diagnostics.share import (
    few_assigned,
    lies_together,
    noise_of_rows,
    single_reports,
    what_reports_tell,
)
from trackweave.run.diagnostics.told import (
    clutter,
    detection,
    is_random,
    motion,
    noise,
    out_of_view,
)
from trackweave.run.diagnostics.units import azimuths_in_radians, degrees_as_metres

__all__ = ["CHECKS", "diagnose"]

CHECKS: tuple[Check, ...] = (
    single_times,
    unseen_turns,
    reporting_objects,
    copied_sensors,
    lone_reports,
    sparse_scans,
    repeated_reports,
    azimuths_in_radians,
    degrees_as_metres,
    other_senses,
    disagreeing_sensors,
    biased_sensors,
    common_jumps,
    out_of_view,
    noise,
    motion,
    detection,
    clutter,
    tracks_at_rest,
    noise_of_rows,
    single_reports,
    few_assigned,
)
# What weighs so much explains what tracks show beside it.
A_CAUSE = 85.0
CONSEQUENCES = {"bias", "sigma", "max_speed", "process_noise", "detection_probability", "clutter"}
WORTH_A_SECOND_LOOK = {"detection_probability", "clutter", "few assigned", "sigma"}


def diagnose(case: Case, overruled: Sequence[Finding] = ()) -> list[Finding]:
    """Return what contradicts something, most telling first; what was overruled always counts."""
    found = [finding for check in CHECKS for finding in check(case)]
    is_explained = any(finding.weight >= A_CAUSE for finding in found)
    causes = {finding.cause for finding in found}
    if not is_explained and (WORTH_A_SECOND_LOOK & causes or lies_together(case)):
        found += what_reports_tell(case)
    if any(finding.weight >= A_CAUSE for finding in found):
        found = [finding for finding in found if finding.cause not in CONSEQUENCES]
        if causes & {"turn", "scans"}:
            found = [each for each in found if each.cause not in {"lone reports", "scan period"}]
    elif causes & {"field of view", "scan period"}:
        found = [finding for finding in found if finding.cause != "detection_probability"]
    found += overruled
    # Reports outside too narrow a gate seem not to have come, or to be of nobody.
    narrow = {f.sensor for f in found if f.cause == "sigma" and (f.seen or 0) > (f.told or 0)}
    spoilt = {"detection_probability", "clutter"}
    found = [f for f in found if f.cause not in spoilt or f.sensor not in narrow]
    # What lies beside tracks may be just what it is taken for.
    if {finding.cause for finding in found} == {"few assigned"} and is_random(case):
        return []
    # How few reports are in tracks tells nothing of why: any cause beside it is told before.
    return _together(sorted(found, key=lambda f: (f.cause == "few assigned", -f.weight)))


def _together(found: Iterable[Finding]) -> list[Finding]:
    """Return findings with one for each cause; where other sensors share it, it names them."""
    first: dict[tuple[str, str | None], Finding] = {}
    others: dict[tuple[str, str | None], list[str]] = {}
    for finding in found:
        # Beams that turn elsewhere do so each about its own place.
        key = (finding.cause, finding.sensor if finding.cause == "turn" else None)
        if key not in first:
            first[key] = finding
        elif finding.sensor is not None:
            others.setdefault(key, []).append(finding.sensor)
    told = []
    for key, finding in first.items():
        names = [name for name in dict.fromkeys(others.get(key, [])) if name != finding.sensor]
        if names:
            listed = ", ".join(names[:3]) + (f" and {len(names) - 3} more" if names[3:] else "")
            sentence = f"{finding.sentence} (likewise {listed})"
            finding = replace(finding, sentence=sentence, likewise=tuple(names))
        told.append(finding)
    return told
