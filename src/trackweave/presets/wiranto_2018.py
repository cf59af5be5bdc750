"""Wiranto & Bonok (2018) to the letter: Ant System on plots, then a nearest-neighbour filter.

What the document says, and the key that says it here:

- "in each scan" the plots of N sensors at one time make tuples, with a dummy for each missed
  detection -> ``plots.fuse``
- a tuple costs what eq. 1 says, its position being "the measurement average" θ̂: the most likely
  position, which is the average where noise is equal; Ψ is a sensor's ``field_of_view``
  -> ``plots.cost``
- "a measurement declares as a target or declares as a false alarm": a tuple of one plot is a false
  alarm, priced by eq. 1 like the others
- "the ants (the number ... determined arbitrarily) are placed randomly at different points"; eqs.
  3 to 7 -> ``search.method``, ``ants``, ``pheromone_weight`` (α), ``visibility_weight`` (β),
  ``persistence`` (ρ)
- all plots of a scan are one problem, and no bounds or local search are spoken of
  -> ``decompose``, ``seeded``
- "will stop when all the ants have the same route" -> as it is; ``cycles`` and ``evaluations``
  are wide enough not to bind before
- "the closest measurements between validated measurements and predicted measurements are
  chosen", for each track by itself (eq. 8) -> ``tracker.kind``, ``tracker.pairing``
- the Kalman filter of eqs. 9 and 10 with no control input -> ``motion.model``

The document gives no numbers for ants, α, β, ρ and the gates; those here are ours, and so is when
a track begins and ends (``lifecycle``), which the document does not tell. Only tuples in the gate
are points; of three sensors with a detection probability of 0.9, eq. 1 would choose no other
before its plots alone.
"""

from typing import Any

__all__ = ["CONFIGURATION"]

CONFIGURATION: dict[str, Any] = {
    "motion": {"model": "constant-velocity"},
    "tracker": {"kind": "nearest-neighbour", "pairing": "nearest"},
    "plots": {"fuse": True, "cost": "equation-1", "gate": 16.0},
    "search": {
        "method": "ant-system",
        "ants": 30,
        "pheromone_weight": 1.0,
        "visibility_weight": 5.0,
        "persistence": 0.8,
        "cycles": 200,
        "evaluations": 6_000,
        "seeded": False,
        "decompose": False,
    },
}
