"""Runtime distributions, performance profiles and data profiles, from the histories of verified runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.runs.store import StoredRun

TARGETS = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Relative distances above the best known value of a problem."""

_VIOLATION = 1e-6
CURVE_POINTS = 120


@dataclass(frozen=True)
class Curve:
    """A step function: `y` holds from `x` on."""

    x: Array
    y: Array


@dataclass(frozen=True)
class Course:
    """The verified progress of one run: best feasible cost after so many evaluations and seconds.

    A run whose answer the audit refuses has no progress, whatever its history says, but it has its costs.
    """

    evaluations: Array
    seconds: Array
    cost: Array
    spent_evaluations: float
    spent_seconds: float

    def reach(self, target: float, measure: str) -> float:
        """Return the evaluations or seconds until the cost is at most `target`; infinite when never."""
        place = int(np.searchsorted(-self.cost, -target))  # the cost never rises
        return float(getattr(self, measure)[place]) if place < self.cost.size else np.inf

    def spent(self, measure: str) -> float:
        """Return what the run cost in total."""
        return self.spent_evaluations if measure == "evaluations" else self.spent_seconds


def course_of(row: StoredRun, assumed_evaluations: float) -> Course:
    """Return the course of a stored run.

    Parameters
    ----------
    row
        The run.
    assumed_evaluations
        What a run is taken to have spent that died before it could tell.
    """
    record = row.record
    spent = float(assumed_evaluations if record.evaluations is None else record.evaluations)
    build = record.build_time or 0.0
    seconds = build + record.solve_time if record.solve_time is not None else (record.wall_time or 0.0)
    none = np.empty(0)
    if not record.feasible or record.objective is None:
        return Course(none, none, none, spent, seconds)
    points = _feasible_points(row)
    evaluations = np.append(points[0], spent)
    cost = np.minimum.accumulate(np.append(points[2], record.objective))
    return Course(evaluations, np.append(points[1] + build, seconds), cost, spent, seconds)


def _feasible_points(row: StoredRun) -> Array:
    """Return evaluations, seconds and cost (3, k) of the feasible entries of a history.

    Costs below the audited objective are lifted to it: the last bit is not what a target asks for.
    """
    history = row.record.history
    parts = [
        np.array(history.get(part, []), dtype=np.float64)
        for part in ("evaluations", "seconds", "cost", "violation")
    ]
    keep = np.isfinite(parts[2]) & (parts[3] <= _VIOLATION)
    cost = np.maximum(parts[2], row.record.objective or 0.0)
    return np.stack([parts[0], parts[1], cost])[:, keep]


def target_value(best: float, precision: float) -> float:
    """Return the cost that counts as reaching `best` to a relative precision."""
    return best + precision * abs(best)


def expected_running_time(courses: Sequence[Course], target: float, measure: str) -> float:
    """Return all evaluations or seconds spent, up to success, over the number of successes.

    Source: Hansen et al., COCO (2021), section 3: the expected time of independent restarts.
    """
    reached = np.array([course.reach(target, measure) for course in courses])
    spent = np.array([course.spent(measure) for course in courses])
    hit = np.isfinite(reached)
    if not hit.any():
        return np.inf
    return float((reached[hit].sum() + spent[~hit].sum()) / hit.sum())


def simulate_restarts(
    courses: Sequence[Course], target: float, measure: str, rng: np.random.Generator, draws: int = 200
) -> Array:
    """Return running times of simulated independent restarts until the target is reached (draws,).

    Failed runs are drawn and their whole cost added until a successful one is drawn.
    """
    reached = np.array([course.reach(target, measure) for course in courses])
    hit = np.isfinite(reached)
    if not hit.any():
        return np.full(draws, np.inf)
    totals = rng.choice(reached[hit], draws)
    if hit.all():
        return totals
    failures = rng.geometric(hit.mean(), draws) - 1
    lost = np.array([course.spent(measure) for course in courses])[~hit]
    drawn = np.concatenate([[0.0], np.cumsum(rng.choice(lost, int(failures.sum())))])
    ends = np.cumsum(failures)
    return np.asarray(totals + drawn[ends] - drawn[ends - failures])


def distribution(values: Array, points: int = CURVE_POINTS) -> Curve:
    """Return the empirical distribution of values that may be infinite, thinned to `points` steps."""
    finite = np.sort(values[np.isfinite(values)])
    if finite.size == 0:
        return Curve(np.empty(0), np.empty(0))
    fractions = np.arange(1, finite.size + 1) / values.size
    keep = np.unique(np.linspace(0, finite.size - 1, min(points, finite.size)).astype(int))
    return Curve(finite[keep], fractions[keep])


def performance_profiles(costs: Array) -> list[Curve]:
    """Return for each solver the share of instances solved within a factor of the fastest.

    Parameters
    ----------
    costs
        (instances, solvers) evaluations or seconds, infinite where not solved.

    Source: Dolan and More, Mathematical Programming 91 (2002). Instances nobody solves stay in the count.
    """
    best = costs.min(axis=1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        ratios = np.where(np.isfinite(costs), np.where(best > 0, costs / best, 1.0), np.inf)
    return [distribution(column) for column in ratios.T]


def data_profiles(costs: Array, dimensions: Array) -> list[Curve]:
    """Return for each solver the share of instances solved within so many groups of d + 1 evaluations.

    Source: More and Wild, SIAM Journal on Optimization 20 (2009), equation 2.8.
    """
    return [distribution(column) for column in (costs / (dimensions[:, None] + 1.0)).T]


def best_at(course: Course, budgets: Array, measure: str) -> Array:
    """Return the best verified cost after each budget; infinite where nothing feasible was there yet."""
    places = np.searchsorted(getattr(course, measure), budgets, side="right")
    return np.concatenate([[np.inf], course.cost])[places]
