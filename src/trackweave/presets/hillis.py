"""Genetic multi-scan tracking as the author of US patent 6,055,523 might do it today.

From the patent: the window of five scans, individuals that are orders of its reports, their
decoding, parents by rank, crossover after one cut, the move of one report as mutation, the three
ways to stop, amendments. ``hillis-1997`` keeps to its letter; what is added here, and why:

- ``settle``: a report that joins nothing may be a false alarm, of which the patent speaks but
  which its individuals cannot say
- ``first``: an order has to be nearly one of time before its decoding is good, so half of the
  first individuals take the scans in order, and the reports of each at random
- ``decompose``: what lies far apart is searched apart; a good order of one part need not wait for
  another's
- ``elite``: the fittest two go on unchanged, so that a generation never loses what it found
- ``improvement``: each generation's best is improved by moves of single reports, as memetic
  algorithms do
- ``population``, ``generations``: by size, as in the letter, but of each part by itself, and no
  more than 2,000 ``evaluations`` of it
- ``spread``: the second rule to stop, wide enough to come before the generations do

Sequences are bounded and states told as by default, which the patent's fitness has no part in.
The bounds and prices of ``auto`` are left out: what comes out is the genetic search's own.
"""

from typing import Any

__all__ = ["CONFIGURATION"]

CONFIGURATION: dict[str, Any] = {
    "window": {"depth": 5},
    "lifecycle": {"join": False},
    "search": {
        "method": "genetic",
        "genotype": "permutation",
        "population": "by-size",
        "generations": "by-size",
        "per_item": 8,
        "evaluations": 2_000,
        "first": "in-time-order",
        "selection": "rank",
        "crossover": 0.9,
        "mutation": 0.2,
        "elite": 2,
        "spread": 1.0,
        "seeded": False,
        "improvement": True,
        "decompose": True,
        "settle": True,
    },
}
