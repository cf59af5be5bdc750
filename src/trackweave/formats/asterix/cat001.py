"""Category 001: plots and local tracks of a radar, before 048 (editions to 1.4)."""

from trackweave.formats.asterix.category import Category
from trackweave.formats.asterix.layout import parsed_layout
from trackweave.formats.asterix.records import Records
from trackweave.formats.asterix.values import (
    DEGREES_16,
    NAUTICAL_MILE_M,
    TIME_S,
    Columns,
    level,
    mode_a,
    sensor_names,
    words,
)

__all__ = ["CATEGORY"]

_DESCRIPTOR = """
010 SAC:8 SIC:8
020 + TYP:1 SIM:1 SSRPSR:2 ANT:1 SPI:1 RAB:1 | TST:1 DS1DS2:2 ME:1 MI:1 -2
"""
_MODE_2 = "050 V:1 G:1 L:1 -1 MODE2:12\n"
_PULSES = """\
080 -4 QA4:1 QA2:1 QA1:1 QB4:1 QB2:1 QB1:1 QC4:1 QC2:1 QC1:1 QD4:1 QD2:1 QD1:1
100 V:1 G:1 -2 MODEC:12 \
-4 QC1:1 QA1:1 QC2:1 QA2:1 QC4:1 QA4:1 QB1:1 QD1:1 QB2:1 QD2:1 QB4:1 QD4:1
060 -4 QA4:1 QA2:1 QA1:1 QB4:1 QB2:1 QB1:1 QC4:1 QC2:1 QC1:1 QD4:1 QD2:1 QD1:1
030 ~ 7
"""
_PRESENCE = "150 XA:1 -1 XC:1 -2 X2:1 -2\n"
_PLOT = (
    _DESCRIPTOR
    + """\
040 RHO:16 THETA:16
070 V:1 G:1 L:1 -1 MODE3A:12
090 V:1 G:1 HGT:14s
130 ~ 7
141 16
"""
    + _MODE_2
    + "120 8s\n131 8s\n"
    + _PULSES
    + _PRESENCE
    + "-\n-\n-\n-\nSP =\n-"
)
_TRACK = (
    _DESCRIPTOR
    + """\
161 16
040 RHO:16 THETA:16
042 X:16s Y:16s
200 GSP:16 HDG:16
070 V:1 G:1 L:1 -1 MODE3A:12
090 V:1 G:1 HGT:14s
141 16
130 ~ 7
131 8s
120 8s
170 + CON:1 RAD:1 MAN:1 DOU:1 RDPC:1 -1 GHO:1 | TRE:1 -6
210 ~ 7
"""
    + _MODE_2
    + _PULSES
    + "SP =\n-\n"
    + _PRESENCE
)
_DETECTIONS = ("none", "psr", "ssr", "psr+ssr")


def _columns(records: Records) -> Columns:
    columns: Columns = {
        "time_within_512_s": records.number("141", scale=TIME_S),
        "sensor": sensor_names(records),
        "range_m": records.number("040", "RHO", NAUTICAL_MILE_M / 128),
        "azimuth_deg": records.number("040", "THETA", DEGREES_16),
        "range_rate_mps": records.number("120", scale=NAUTICAL_MILE_M / 256),
        **level(records, field="HGT"),
        "strength": records.number("131"),
        **mode_a(records),
        "detection": words(records, "020", "SSRPSR", _DETECTIONS),
        "simulated": records.flag("020", "SIM") | records.flag("020", "TST"),
        "field_monitor": records.flag("020", "RAB"),
    }
    if records.knows("161"):
        columns["track_number"] = records.number("161")
    return columns


def _kind(block: bytes, place: int) -> int:
    """Return 0 for a plot, 1 for a track, which the descriptor's first bit says."""
    first = block[place]
    if not first & 0x40:
        return 0
    while block[place] & 1:
        place += 1
    return block[place + (3 if first & 0x80 else 1)] >> 7


CATEGORY = Category((parsed_layout(_PLOT), parsed_layout(_TRACK)), _columns, _kind)
