"""Huo, Zhang, Bai, Song, Xiong (2008) to the letter: tracks of sensors become common objects.

What the document says, and the key that says it here:

- "local nodes' estimation errors are independent"; C = P_i + P_j -> ``statistic.correlation``
- λ(k) = λ(k − 1) + tᵀ C⁻¹ t, over all times (eqs. 6 and 7) -> ``statistic.memory``
- b, the sum of λ over consecutive sensors (eq. 9) -> ``statistic.kind``
- minimise J = Σ τ b, every track in exactly one tuple with one of each sensor (eqs. 11 and 12):
  all sensors see all objects -> ``complete``
- a chromosome of M substrings, that of sensor 1 in order -> ``search.method``
- "elitist" and rank selection, the next population P_r kept, P_c crossed by PMX and P_m mutated by
  a swap of two genes -> ``reproduction``, ``mutation``, ``mutate``
- a random first population of all tuples as one problem, no bounds and no local search
  -> ``seeded``, ``improvement``, ``decompose``
- one size fits no problem: the numbers are those of M = 3, n = 10, and grow with the genes, the
  population with their square, generations in proportion -> ``by_size``
- stop after G generations, or when the best fitness changed by at most ε for G′ generations
  running -> ``generations``, ``tolerance``, ``patience``
- "2/3, 3/4, 4/5 or 6/8": a result is declared that came out N times of M -> ``confirm``

The document gives no numbers for the population, the rates, G, G′, ε and α; those here are ours:
of six settings that were tried they find the least J of M = 3, n = 10 most often.
It reports which tracks belong together and combines no estimates; those of independent errors
are combined convexly -> ``method``
"""

from typing import Any

__all__ = ["CONFIGURATION", "USABLE"]

USABLE = "huo"
"""The preset of the same search for tracks of one's own."""

CONFIGURATION: dict[str, Any] = {
    "method": "convex",
    "confirm": "3/4",
    "complete": True,
    "statistic": {
        "kind": "chain",
        "memory": "full",
        "false_rejection": 0.01,
        "correlation": "none",
    },
    "search": {
        "method": "list-genetic",
        "population": 200,
        "generations": 300,
        "evaluations": 100_000,
        "reproduction": 0.2,
        "mutation": 0.6,
        "mutate": "swap",
        "tolerance": 0.0,
        "patience": 100,
        "seeded": False,
        "improvement": False,
        "decompose": False,
        "by_size": True,
    },
}
