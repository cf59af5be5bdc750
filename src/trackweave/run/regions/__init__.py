"""A recording on many workers: the plane in regions, each tracked by itself, one picture after."""

from trackweave.run.regions.running import Engaged, engaged, require_cuttable

__all__ = ["Engaged", "engaged", "require_cuttable"]
