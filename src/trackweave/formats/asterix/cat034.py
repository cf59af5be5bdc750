"""Category 034: what a radar says of itself (editions to 1.29)."""

from trackweave.formats.asterix.category import Category
from trackweave.formats.asterix.layout import parsed_layout

__all__ = ["CATEGORY"]

_LAYOUT = """
010 SAC:8 SIC:8
000 8
030 24
020 8
041 16
050 {
  COM NOGO:1 RDPC:1 RDPR:1 OVLRDP:1 OVLXMT:1 MSC:1 TSV:1 -1
  -
  -
  PSR ANT:1 CHAB:2 OVL:1 MSC:1 -3
  SSR ANT:1 CHAB:2 OVL:1 MSC:1 -3
  MDS ANT:1 CHAB:2 OVLSUR:1 MSC:1 SCF:1 DLF:1 OVLSCF:1 OVLDLF:1 -7
}
060 {
  COM -1 REDRDP:3 REDXMT:3 -1
  -
  -
  PSR POL:1 REDRAD:3 STC:2 -2
  SSR REDRAD:3 -5
  MDS REDRAD:3 CLU:1 -4
}
070 * TYP:5 COUNT:11
100 RHOST:16 RHOEND:16 THETAST:16 THETAEND:16
110 8
120 HGT:16s LAT:24s LON:24s
090 RNG:8s AZM:8s
RE =
SP =
"""

CATEGORY = Category((parsed_layout(_LAYOUT),))
