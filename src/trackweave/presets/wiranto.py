"""Wiranto & Bonok (2018) as one would have it today: their ants and filter, made to serve.

What stays is the document's: plots of several sensors are joined by an Ant System on the tuples
of plots (eqs. 3 to 7), and what is joined is followed by the nearest-neighbour Kalman filter (eqs.
8 to 10). What its authors would add today, each with its reason:

- evidence in place of eq. 1, with dummies priced by clutter and object density: eq. 1 takes one
  false alarm in the whole field of view for granted and finds too many objects in clutter
  -> ``plots.cost``
- radars that look at different moments: all scans of a scan period are one instant, and their
  plots are brought to its end along the tracks; otherwise nothing is fused -> ``plots.within``
- a plot where no other radar looks at that instant is a report as it is, for the filter to judge:
  by eq. 1 it would be a false alarm, always -> ``plots.keep_lone``
- components apart: plots that no tuple joins have nothing to do with one another -> ``decompose``
- ants begin from the answer of prices, and see reduced costs: to the letter they end above the
  best -> ``seeded``
- each plot to one track, the best pairing of all: of tracks that each take their nearest plot
  many follow one object -> ``tracker.pairing``

Ants, cycles, α, β and ρ are those of ``wiranto-2018``; N counts the plots of a component.
"""

from typing import Any

__all__ = ["CONFIGURATION"]

CONFIGURATION: dict[str, Any] = {
    "motion": {"model": "constant-velocity"},
    "tracker": {"kind": "nearest-neighbour", "pairing": "one-to-one"},
    "plots": {"fuse": True, "cost": "evidence", "within": "period", "keep_lone": True},
    "lifecycle": {"join": False},
    "search": {
        "method": "ant-system",
        "pheromone_weight": 0.5,
        "visibility_weight": 3.0,
        "persistence": 0.8,
        "seeded": True,
        "decompose": True,
    },
}
