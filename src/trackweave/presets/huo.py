"""The search of Huo and others (2008) for tracks of one's own: what they might add today.

The document's chain of sensors, its chromosome of one permutation per sensor, rank selection, PMX,
swap mutation, both stop rules and the N-of-M rule stay; ``huo_2008`` is the document to the
letter. Each line added, and why:

- ``complete``: lists may be unequal or empty and objects seen by some sensors only, as dummies
  fill a chromosome up; the document's sum demands a track of every sensor in every tuple.
- ``statistic.memory``, ``length``: the last five times, so that a wrong join can be undone and
  memory does not grow; λ over all times never forgets.
- ``statistic.correlation``: a filter's errors are alike from time to time, so that λ varies more
  than χ²; and the chain's threshold comes from its eigenvalues, as neighbours share a sensor.
- ``statistic.false_rejection``: a tenth of the strict preset's: trackers promise more than they
  keep, and extended objects are seen at different parts.
- ``confirm``: 2/3, the quickest of the document's rules; with hysteresis more is only delay.
- ``method``: trackers of one object share its turns, so that adding their information up promises
  too much.
- ``search.by_size``: a population of one size fits no problem.
- ``search.decompose``: tracks far from one another are no one problem.
- ``search.seeded``: begun from the answer of prices, and over where they prove the best.
- ``search.improvement``: the best individual is improved locally; generations alone stall.
"""

from typing import Any

from trackweave.presets import huo_2008

__all__ = ["CONFIGURATION"]

CONFIGURATION: dict[str, Any] = {
    "method": "fast-covariance-intersection",
    "confirm": "2/3",
    "complete": False,
    "statistic": {
        "kind": "chain",
        "memory": "sliding",
        "length": 5,
        "false_rejection": 0.001,
        "correlation": "effective",
    },
    "search": {
        **huo_2008.CONFIGURATION["search"],
        "seeded": True,
        "improvement": True,
        "decompose": True,
    },
}
