"""Wiranto & Bonok (2018) to the letter: Ant System on plots, then a nearest-neighbour filter.

What the document says, and the key that says it here:

- "in each scan" the plots of N sensors at one time make tuples, with a dummy for each missed
  detection -> ``plots.fuse``
- a tuple costs what eq. 1 says, its position being "the measurement average" θ̂: the most likely
  position, which is the average where noise is equal; Ψ is a sensor's ``field_of_view``
  -> ``plots.cost``
- "a measurement declares as a target or declares as a false alarm": a tuple of one plot is a false
  alarm, priced by eq. 1 like the others
- "the ants ... are placed randomly at different points"; eqs. 3 to 7 -> ``search.method``,
  ``pheromone_weight`` (α), ``visibility_weight`` (β), ``persistence`` (ρ)
- all plots of a scan are one problem, and no bounds or local search are spoken of
  -> ``decompose``, ``seeded``
- "the number of ants determined arbitrarily": here 3 N, N being the "total points visited by each
  ant in one cycle (N) = 1 + Σ n_i", so that they grow with the scan -> ``ants`` left out
- "will stop when all the ants have the same route" -> as it is, and after N cycles, ``cycles``
  left out
- "the closest measurements between validated measurements and predicted measurements are
  chosen", for each track by itself (eq. 8) -> ``tracker.kind``, ``tracker.pairing``
- the Kalman filter of eqs. 9 and 10 with no control input -> ``motion.model``

The document gives no numbers for α, β, ρ and the gates; those here are ours. Of some fifty
settings of ants, α, β, ρ and cycles that were tried on other skies than the study's, those with
α = 1 cost most and those with α ≤ ½ and β of 2 or 3 least, too near to one another to rank. When a
track begins and ends (``lifecycle``) is ours, too. Only tuples in the gate
are points; of three sensors with a detection probability of 0.9, eq. 1 would choose no other
before its plots alone.
"""

from typing import Any

__all__ = ["CONFIGURATION", "USABLE"]

USABLE = "wiranto"
"""The preset that does the same on one's own reports, with what one would add today."""

CONFIGURATION: dict[str, Any] = {
    "sensors": {"default": {"trust": True, "tail_share": 0.0, "hidden_share": 0.0, "echoes": []}},
    "motion": {"model": "constant-velocity"},
    "tracker": {"kind": "nearest-neighbour", "pairing": "nearest"},
    "plots": {"fuse": True, "cost": "equation-1", "gate": 16.0},
    "lifecycle": {"join": False},
    "search": {
        "method": "ant-system",
        "pheromone_weight": 0.5,
        "visibility_weight": 3.0,
        "persistence": 0.8,
        "seeded": False,
        "decompose": False,
    },
}
