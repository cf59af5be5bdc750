"""US patent 6,055,523 (filed 1997) to the letter: genetic multi-scan tracking.

What the document says, and the key that says it here:

- "a sliding window of time that is, for example, five scans deep" -> ``window.depth``
- "each individual is ... a permutation of length N, where N is the number of points in the
  window"; all reports of the window are one problem -> ``genotype``, ``decompose``
- "a population is formed from random permutations" at every scan, "non overlapping
  generations" -> ``seeded``, ``elite``
- "individuals with high scores ... are selected to be parents with a higher probability"
  -> ``selection``, by linear rank
- "a random cross point"; "taking a single random point in the string and moving it to a random
  location" -> ``crossover``, ``mutation``
- "until a fixed number of generations have been completed, or the difference in fitness between
  the fittest individual and the average for the population falls below a threshold, or ... the
  arrival of a new scan" -> ``generations``, ``spread``, and the deadline of a scan
- "the preferred embodiment spreads the GA across several parallel processors using the 'island'
  model" -> ``islands = 4`` beside these keys; left out: one population
- each detection starts a track or joins one, and so a lone one is a track of one report
  -> ``settle``
- "the hypothesis of the fittest individual is reported" -> ``output.estimate``

The document gives no numbers for the population, the generations, the rates and the threshold;
those here are ours. By size, a window of N reports has 16 N individuals for at most 2 N
generations; most searches end before, where the mean comes within 3 nats of the fittest and
crossing finds nothing new. From some 100 reports on, 200,000 evaluations come first.

It filters every track anew for each individual; here a sequence is filtered once and remembered,
with bounds on their number (``growth``) wide enough to bind in dense scenes only.
"""

from typing import Any

__all__ = ["CONFIGURATION", "USABLE"]

USABLE = "hillis"

CONFIGURATION: dict[str, Any] = {
    "sensors": {"default": {"trust": True, "tail_share": 0.0, "hidden_share": 0.0, "echoes": []}},
    "window": {"depth": 5},
    "lifecycle": {"join": False},
    "search": {
        "method": "genetic",
        "genotype": "permutation",
        "population": "by-size",
        "generations": "by-size",
        "per_item": 16,
        "evaluations": 200_000,
        "first": "random",
        "selection": "rank",
        "crossover": 0.9,
        "mutation": 0.2,
        "elite": 0,
        "spread": 3.0,
        "seeded": False,
        "improvement": False,
        "decompose": False,
        "settle": False,
    },
    "growth": {
        "margin": 25.0,
        "keep": 500,
        "new_margin": 25.0,
        "new_keep": 60,
        "new_ceiling": 25.0,
    },
    "output": {"estimate": "best"},
}
