"""Category 002: what a radar says of itself beside category 001 (editions to 1.2)."""

from trackweave.formats.asterix.category import Category
from trackweave.formats.asterix.layout import parsed_layout

__all__ = ["CATEGORY"]

_LAYOUT = """
010 SAC:8 SIC:8
000 8
020 8
030 24
041 16
050 ~ 7
060 ~ 7
070 * A:1 IDENT:5 COUNTER:10
100 RS:16 RE:16 TS:16 TE:16
090 RE:8s AE:8s
080 ~ 7
-
SP =
-
"""

CATEGORY = Category((parsed_layout(_LAYOUT),))
