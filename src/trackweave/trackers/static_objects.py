"""Which plots of one instant are one object's, and where objects are, as well as can be told.

The most probable answer is rarely the best one. Among close objects it is one of thousands
that are nearly as probable. What most of them agree on is right more often, and a place
amid what they say is nearer to the truth.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment

from trackweave.arrays import FloatArray, IntArray, require_instance
from trackweave.association.plots_rule import ScoredTuples
from trackweave.association.problem import AssignmentProblem, Certificate
from trackweave.association.sampling import Draws, Sampling
from trackweave.errors import InvalidInputError
from trackweave.fields import settle
from trackweave.randomness import RandomSource, generator_of
from trackweave.solvers.auto import Auto
from trackweave.solvers.protocol import Solver, Stop, require_solver
from trackweave.solvers.solving import solve
from trackweave.summaries import summary

__all__ = ["FoundObjects", "ObjectFinder"]

PLACING_DRAWS = 100
"""Answers that places are fitted to; more of them moved no place by a tenth of its error."""
ROUNDS = 12


@dataclass(frozen=True, slots=True, eq=False)
class FoundObjects:
    """What is known of the objects that made the plots of one instant.

    Parameters
    ----------
    groups
        Rows of disjoint tuples: of all choices that with the greatest expected number of right
        ones, a tuple being right if its plots are all that one object made.
    group_probability
        That each group is right.
    positions
        Where objects are told to be [m], shape (objects, dimensions), such that the expected
        square of GOSPA is least. An object is told if it is more likely there than not.
    covariances
        How certain it is [m²], shape (objects, dimensions, dimensions).
    existence
        How likely there is an object within the cut-off, shape (objects,).
    likeliest
        Rows of the most probable answer that the solver found.
    certificate
        Its cost, and a proven bound.
    draws
        Answers drawn by their probability, from which all but the last two come.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> plots = [
    ...     tw.SensorPlots([[x, 0.0], [x + 500.0, 0.0]], sigma=10.0, volume=1e8, false_alarms=0.1)
    ...     for x in (0.0, 6.0)
    ... ]
    >>> found = tw.PlotsRule(object_density=1e-6)(plots)  # objects per m²
    >>> objects = tw.ObjectFinder(cutoff=50.0)(found, rng=np.random.default_rng(1))
    >>> objects.positions.round()  # m
    array([[  3.,   0.],
           [503.,   0.]])
    >>> objects.existence.round(2)
    array([1., 1.])
    """

    groups: IntArray
    group_probability: FloatArray
    positions: FloatArray
    covariances: FloatArray
    existence: FloatArray
    likeliest: IntArray
    certificate: Certificate
    draws: Draws

    __repr__ = summary


@dataclass(frozen=True, slots=True)
class ObjectFinder:
    """Finds objects in scored tuples of plots.

    First the most probable answer, by any solver; from there answers are drawn by their
    probability; then the groups that are right most often among them, again by the solver, and
    the places of least expected GOSPA [1]_.

    Parameters
    ----------
    cutoff
        How far from an object a place may be and still count as that object's [m]; above 0.
    least_probability
        Groups less probable than this are not told, nor those that others are better without:
        each told one counts its probability less this. At least 0 and below 1.
    solver
        Finds the most probable answer, and the groups.
    sampling
        Draws answers.

    Raises
    ------
    InvalidInputError
        If a parameter is out of range.

    References
    ----------
    .. [1] Guerriero, Svensson, Svensson, Willett, *Shooting two birds with two bullets: how to
       find minimum mean OSPA estimates*, FUSION 2010.

    Examples
    --------
    >>> import numpy as np
    >>> import trackweave as tw
    >>> plots = [
    ...     tw.SensorPlots([[x, 0.0], [x + 500.0, 0.0]], sigma=10.0, volume=1e8, false_alarms=0.1)
    ...     for x in (0.0, 6.0)
    ... ]
    >>> found = tw.PlotsRule(object_density=1e-6)(plots)  # objects per m²
    >>> objects = tw.ObjectFinder(cutoff=50.0)(found, rng=np.random.default_rng(1))
    >>> objects.positions.round()  # m
    array([[  3.,   0.],
           [503.,   0.]])
    """

    cutoff: float
    least_probability: float = 0.0
    solver: Solver = field(default_factory=Auto)
    sampling: Sampling = field(default_factory=Sampling)

    def __post_init__(self) -> None:
        settle(self)
        if not self.cutoff > 0:
            raise InvalidInputError(f"cutoff: {self.cutoff!r:.80}; expected a finite number > 0")
        least = self.least_probability
        if not 0 <= least < 1:
            raise InvalidInputError(
                f"least_probability: {least!r:.80}; expected at least 0 and below 1"
            )
        require_solver(self.solver, "solver")

    def __call__(
        self, scored: ScoredTuples, *, rng: RandomSource = 0, stop: Stop | None = None
    ) -> FoundObjects:
        """Return the objects.

        Parameters
        ----------
        scored
            Tuples at the cost of their evidence, best without ``negative_only``.
        rng
            The only source of randomness: a generator, or a seed.
        stop
            Asked every few milliseconds whether to stop with what is known so far.

        Returns
        -------
        Groups and places; fewer draws stand behind them after an early stop.
        """
        require_instance(scored, ScoredTuples, "scored")
        rng = generator_of(rng)
        # No best answer needs a tuple that costs nothing or more.
        likeliest, certificate = self._choose(scored, scored.costs, rng, stop)
        draws = self.sampling(scored, likeliest, rng=rng, stop=stop)
        is_several = np.count_nonzero(scored.tuples, axis=1) > 1
        worth = np.where(is_several, draws.probability - self.least_probability, 0.0)
        groups, _ = self._choose(scored, -worth, rng, stop)
        mixture = _Mixture.of(scored, draws.answers, float(self.cutoff))
        best = min(
            (mixture.descend(scored.positions[rows], stop) for rows in (likeliest, groups)),
            key=lambda told: told.loss,
        )
        return FoundObjects(
            groups=groups,
            group_probability=draws.probability[groups],
            positions=best.positions,
            covariances=mixture.covariances(best),
            existence=best.share,
            likeliest=likeliest,
            certificate=certificate,
            draws=draws,
        )

    def _choose(
        self,
        scored: ScoredTuples,
        costs: FloatArray,
        rng: np.random.Generator,
        stop: Stop | None,
    ) -> tuple[IntArray, Certificate]:
        """Return the rows of the disjoint tuples of least cost, and what is proven of them."""
        rows = np.flatnonzero(costs < 0.0)
        problem = AssignmentProblem.from_tuples(scored.tuples[rows], costs[rows])
        answer = solve(problem, self.solver, rng=rng, stop=stop)
        assert problem.row is not None
        chosen: IntArray = np.sort(rows[problem.row[answer.nodes]])
        return chosen, answer.certificate


@dataclass(frozen=True, slots=True, eq=False)
class _Told:
    """Places told, how often a drawn object is paired with each, and the expected GOSPA²."""

    positions: FloatArray
    share: FloatArray
    loss: float


@dataclass(frozen=True, slots=True, eq=False)
class _Mixture:
    """Drawn sets of objects, each with a place and its covariance, and how far is too far."""

    places: tuple[FloatArray, ...]
    covariance: tuple[FloatArray, ...]
    cutoff: float

    @classmethod
    def of(cls, scored: ScoredTuples, answers: Sequence[IntArray], cutoff: float) -> "_Mixture":
        """Return what some of the answers say, evenly spread."""
        n_kept = min(PLACING_DRAWS, len(answers))
        kept = np.linspace(0, len(answers) - 1, n_kept).astype(np.int64)
        return cls(
            tuple(scored.positions[answers[number]] for number in kept),
            tuple(scored.covariances[answers[number]] for number in kept),
            cutoff,
        )

    def descend(self, start: FloatArray, stop: Stop | None) -> _Told:
        """Return places from which pairing and averaging by turns leads to no better ones."""
        positions, best = start, None
        for _ in range(ROUNDS):
            told, mean, worth = self._judge(positions)
            if best is not None and told.loss >= best.loss * (1.0 - 1e-4):
                break
            best = told
            if stop is not None and stop():
                break
            # A place is worth telling if it saves more than a false object costs.
            positions = mean[worth > 0.5 * self.cutoff**2]
        assert best is not None
        return best

    def covariances(self, told: _Told) -> FloatArray:
        """Return the second moments about places told of what is paired with them."""
        n, dim = told.positions.shape
        total, count = np.zeros((n, dim, dim)), np.zeros(n)
        for places, covariance in zip(self.places, self.covariance, strict=True):
            row, column, _ = self._pair(told.positions, places, covariance)
            aside = places[column] - told.positions[row]
            total[row] += covariance[column] + aside[:, :, None] * aside[:, None, :]
            count[row] += 1.0
        return total / np.maximum(count, 1.0)[:, None, None]

    def _judge(self, positions: FloatArray) -> tuple[_Told, FloatArray, FloatArray]:
        """Return what places are worth together; the mean of what is paired; each one's worth."""
        n_draws, limit = len(self.places), self.cutoff**2
        total, count = np.zeros_like(positions), np.zeros(len(positions))
        saved, n_drawn = np.zeros(len(positions)), 0
        for places, covariance in zip(self.places, self.covariance, strict=True):
            row, column, squared = self._pair(positions, places, covariance)
            total[row] += places[column]
            count[row] += 1.0
            saved[row] += limit - squared
            n_drawn += len(places)
        mean = np.where(count[:, None] > 0, total / np.maximum(count, 1.0)[:, None], positions)
        loss = 0.5 * limit * (len(positions) + n_drawn / n_draws) - saved.sum() / n_draws
        told = _Told(positions, count / n_draws, float(loss))
        return told, mean, saved / n_draws

    def _pair(
        self, positions: FloatArray, places: FloatArray, covariance: FloatArray
    ) -> tuple[IntArray, IntArray, FloatArray]:
        """Return the pairs of places told and drawn, and their expected squared distances."""
        aside = positions[:, None, :] - places[None, :, :]
        spread = np.trace(covariance, axis1=1, axis2=2)
        limit = self.cutoff**2
        squared = np.minimum(np.sum(aside**2, axis=2) + spread[None, :], limit)
        row, column = linear_sum_assignment(squared)
        reached = squared[row, column]
        is_pair = reached < limit
        return row[is_pair], column[is_pair], reached[is_pair]
