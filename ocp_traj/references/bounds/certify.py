"""The best total duration of a spline family without virtual knots, with a proof.

Piazzi and Visioli (1998) proved minimum-time cubic splines by interval analysis over all durations. Here uniform
slowing removes one dimension: for proportions p of the durations the least total is closed form,

    T(p) = max over velocity, acceleration, jerk (k = 1, 2, 3) of (largest value at total 1 / limit)^(1/k),

and branch and bound searches the simplex of proportions. In a cell the limiting quantities at the cell's centre are
enclosed over the whole cell, by interval arithmetic on the family's own formulas, in natural and in mean-value
form. Each gives a lower bound of T: instants are chosen, never trusted.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.quantities import DERIVATIVES, RATES
from ocp_traj.references.bounds.branch_and_bound import prove_total
from ocp_traj.references.bounds.enclosure import Enclosure
from ocp_traj.references.bounds.kinematic_bound import gap_bounds
from ocp_traj.references.bounds.kinematic_proof import MARGIN
from ocp_traj.task.preparing import prepare

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask

LARGEST_GAPS = 4
_INSTANTS = np.linspace(0.0, 1.0, 65)


@dataclass(frozen=True)
class Certificate:
    """Proved range of the best total duration of a task's family.

    Attributes
    ----------
    lower : float or None
        Proved: no durations with a smaller total keep the limits, s. None where no proof was possible.
    upper : float or None
        Total of `durations`, which keep the limits, s.
    durations : (G,) array
    gap : float or None
        1 - lower / upper.
    certified : bool
        True when `gap` is within what was asked for.
    nodes : int
        Cells the proof looked at.
    message : str
        One sentence on what was proved, or why nothing was.
    """

    lower: float | None
    upper: float | None
    durations: Array = field(default_factory=lambda: np.empty(0))
    gap: float | None = None
    certified: bool = False
    nodes: int = 0
    message: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "durations", read_only(self.durations))


FAR_SECONDS = 1e6
"""A bound on the duration of a gap from here on binds no motion; it makes equal waypoints two instants."""


def certify(
    task: TrajectoryTask,
    *,
    gap: float = 1e-3,
    largest_nodes: int = 400_000,
    time_limit: float = 120.0,
    rng: np.random.Generator | None = None,
) -> Certificate:
    """Return the global optimum of a task's total duration, proved to a relative `gap`.

    The task has to ask for least time from rest to rest with velocity, acceleration and jerk limits, by any family
    without virtual knots, over two to four gaps (two for one gap is trivial and included).

    Parameters
    ----------
    task : TrajectoryTask
    gap : float
    largest_nodes, time_limit
        Cells, and seconds, after which the proof stops with what it has.
    rng : numpy.random.Generator, optional
        For the search of the upper bound; seeded with 0 when left out.
    """
    ready = prepare(task)
    found = _certified(ready.task, gap, largest_nodes, time_limit, rng)
    return replace(found, durations=ready.restored_durations(found.durations)) if found.upper else found


def _certified(
    task: TrajectoryTask, gap: float, largest_nodes: int, time_limit: float, rng: np.random.Generator | None
) -> Certificate:
    """Return the certificate of a task made ready; see `certify`."""
    reason = _reason_against(task)
    if reason:
        return Certificate(None, None, message=reason)
    spline = SplineBounds(task)
    rng = np.random.default_rng(0) if rng is None else rng
    proportions, upper = _best_proportions(task, spline, rng)
    if not np.isfinite(upper):
        return Certificate(
            None, None, message="no proportions of durations that keep the position limits were found"
        )
    least = gap_bounds(task, upper)
    if (least <= 0).any():
        where = int(np.flatnonzero(least <= 0)[0]) + 1
        return Certificate(
            None, upper, proportions * upper, message=f"the duration of gap {where} has no lower bound"
        )
    target = upper * (1.0 - gap)
    outcome = prove_total(
        spline.bound,
        least / upper * (1.0 - MARGIN),
        np.ones(task.gaps),
        target,
        start=float(least.sum()) * (1.0 - MARGIN),
        largest_nodes=largest_nodes,
        time_limit=time_limit,
    )
    lower = min(outcome.lower * (1.0 - MARGIN), upper)
    found = 1.0 - lower / upper
    done = f"proved to {100 * found:.3g} % with {outcome.nodes} cells"
    message = done if outcome.complete else f"{done}, then the search was stopped"
    return Certificate(lower, upper, proportions * upper, found, outcome.complete, outcome.nodes, message)


def _reason_against(task: TrajectoryTask) -> str:
    """Return why the task has no certificate, or an empty string."""
    limits = task.limits
    checks = (
        (task.virtual_knots > 0, "the task has virtual knots, certificates are for durations alone"),
        (
            task.gaps > LARGEST_GAPS,
            f"the task has {task.gaps} gaps, certificates are for up to {LARGEST_GAPS}",
        ),
        (not task.boundary.is_rest, "the ends are not at rest"),
        (
            set(task.objective.weights) != {"time"} or bool(task.objective.custom),
            "the objective is not time alone",
        ),
        (task.limited("torque") or task.limited("torque_rate"), "torque limits are not covered"),
        (
            bool(limits.cartesian_speed or limits.others or task.constraints),
            "Cartesian and custom limits are not covered",
        ),
        (bool(np.any(task.tolerance)), "tolerances around waypoints are not covered"),
        (_bounded_durations(task), "bounds on durations are not covered"),
        (
            not any(task.limited(name) for name in RATES),
            "no velocity, acceleration or jerk limit bounds the time",
        ),
    )
    return next((sentence for holds, sentence in checks if holds), "")


def _bounded_durations(task: TrajectoryTask) -> bool:
    total, gaps = np.asarray(task.objective.duration), np.asarray(task.objective.gap_durations)
    return bool(np.isfinite(total[1]) or (gaps[:, 0] > 0).any() or (gaps[:, 1] < FAR_SECONDS).any())


class SplineBounds:
    """Bounds of T over cells of proportions, for one task."""

    def __init__(self, task: TrajectoryTask) -> None:
        from ocp_traj.spline import EndConditions

        self.family = task.family
        zero = np.zeros((1, task.n))
        given = {
            order: zero for order, name in enumerate(RATES, 1) if getattr(task.boundary, name) is not None
        }
        self.ends = EndConditions(dict(given), dict(given))
        self.positions = [row[None, :] for row in np.asarray(task.waypoints)]
        self.limits = {kind: task.limits.get(kind) for kind in RATES if task.limited(kind)}

    def pieces(self, durations: list[Any]) -> list[list[Any]]:
        """Return each piece's ascending coefficients in normalised time."""
        return [
            piece.coefficients() for piece in self.family.pieces(durations, list(self.positions), self.ends)
        ]

    def totals(self, proportions: Array) -> tuple[Array, list[dict[str, Array]]]:
        """Return T (P,) from 65 instants a piece, and by piece and kind the worst instants (P, n)."""
        durations = [proportions[:, [gap]] for gap in range(proportions.shape[1])]
        total = np.zeros(len(proportions))
        instants: list[dict[str, Array]] = []
        for gap, coefficients in enumerate(self.pieces(durations)):
            instants.append({})
            for order, (kind, limit) in self._orders():
                table = np.stack([_derivative(coefficients, order, tau) for tau in _INSTANTS])
                ratio = _ratio(table / durations[gap] ** order, limit[gap])
                worst = ratio.argmax(axis=0)
                instants[gap][kind] = _INSTANTS[worst]
                total = np.maximum(total, ratio.max(axis=(0, 2)) ** (1.0 / order))
        return total, instants

    def requirements(self, proportions: Array) -> Array:
        """Return the total (P, m) that every joint, kind and one of 257 instants a piece asks for."""
        durations = [proportions[:, [gap]] for gap in range(proportions.shape[1])]
        needed = []
        for gap, coefficients in enumerate(self.pieces(durations)):
            for order, (_, limit) in self._orders():
                for tau in np.linspace(0.0, 1.0, 257):
                    ratio = _ratio(
                        _derivative(coefficients, order, tau) / durations[gap] ** order, limit[gap]
                    )
                    needed.append(ratio ** (1.0 / order))
        return np.concatenate(needed, axis=1)

    def _orders(self) -> list[tuple[int, tuple[str, Array]]]:
        return [(DERIVATIVES.index(kind), (kind, limit)) for kind, limit in self.limits.items()]

    def bound(self, lows: Array, highs: Array, parents: Array, target: float) -> Array:
        """Return lower bounds of T over cells; see `branch_and_bound.CellBound`."""
        centres = 0.5 * (lows + highs)
        _, instants = self.totals(centres)
        variables = Enclosure.variables(lows, highs)
        points = Enclosure.variables(centres, centres)
        missing = 1.0 - centres.sum(axis=1)
        found = np.array(parents, dtype=np.float64)
        for gap, (cell, centre) in enumerate(zip(self.pieces(variables), self.pieces(points))):
            for order, (kind, limit) in self._orders():
                for tau in (0.0, 1.0, instants[gap][kind]):
                    box = _derivative(cell, order, tau) * variables[gap] ** -order
                    value = (_derivative(centre, order, tau) * points[gap] ** -order).low[0]
                    low, high = _narrowed(box, value, 0.5 * (highs - lows), missing)
                    least = _least_ratio(low, high, limit[gap]).max(axis=1)
                    found = np.maximum(found, least ** (1.0 / order))
        return np.minimum(found, np.maximum(target, parents))


def _derivative(coefficients: list[Any], order: int, tau: Any) -> Any:
    """Return a derivative by normalised time at `tau`; zero where the degree is too low."""
    total: Any = coefficients[0] * 0.0
    for power in range(order, len(coefficients)):
        factor = float(np.prod(np.arange(power - order + 1, power + 1)))
        total = total + coefficients[power] * (factor * tau ** (power - order))
    return total


def _ratio(values: Array, limit: Array) -> Array:
    """Return value over limit, each on its own side; 0 for 0 over 0."""
    bound = np.where(values < 0, limit[0], limit[1])
    ratio = np.zeros_like(values)
    with np.errstate(divide="ignore"):
        np.divide(values, bound, out=ratio, where=values != 0)
    return ratio


def _narrowed(box: Enclosure, value: Array, radius: Array, missing: Array) -> tuple[Array, Array]:
    """Return the intersection of natural and mean-value form, (P, n) twice.

    f(p) lies in f(centre) + sum_g slope_g (p_g - centre_g). Proportions sum to one, so a common number may be
    taken off all slopes; the mean of their middles makes the sum small. A centre need not lie on the simplex: the
    common number times what its proportions lack to one, `missing` (P,), comes in its place.
    """
    slope_low, slope_high = box.low[1:], box.high[1:]
    with np.errstate(invalid="ignore"):
        common = 0.5 * (slope_low + slope_high).mean(axis=0)
        size = np.maximum(np.abs(slope_low - common), np.abs(slope_high - common))
        spread = (size * radius.T[:, :, None]).sum(axis=0)
        value = value + common * missing[:, None]
        low, high = value - spread, value + spread
    low = np.where(np.isnan(low), -np.inf, low)
    high = np.where(np.isnan(high), np.inf, high)
    return np.maximum(low, box.low[0]), np.minimum(high, box.high[0])


def _least_ratio(low: Array, high: Array, limit: Array) -> Array:
    """Return the least value over limit that an interval allows, (P, n)."""
    nearest = np.where(low > 0, low, np.where(high < 0, high, 0.0))
    return _ratio(nearest, limit)


def _best_proportions(
    task: TrajectoryTask, spline: SplineBounds, rng: np.random.Generator
) -> tuple[Array, float]:
    """Return good proportions and their exact least total, infinite where positions leave their range."""
    gaps = task.gaps
    proportions = rng.dirichlet(np.ones(gaps), 400) if gaps > 1 else np.ones((1, 1))
    totals, _ = spline.totals(proportions)
    for _ in range(120 if gaps > 1 else 0):
        order = np.argsort(totals)[:40]
        proportions, totals = proportions[order], totals[order]
        if totals[-1] <= totals[0] * (1 + 1e-9):
            break
        spread = 1.5 * np.cov(proportions[:20].T)
        moved = np.abs(rng.multivariate_normal(proportions[:10].mean(axis=0), spread, 120, method="eigh"))
        moved /= moved.sum(axis=1, keepdims=True)
        proportions = np.concatenate([proportions, moved])
        totals = np.concatenate([totals, spline.totals(moved)[0]])
    for index in np.argsort(totals)[:8]:
        if np.isfinite(exact_total(task, spline, proportions[index])):
            return _polished(task, spline, proportions[index])
    return proportions[0], np.inf


def _polished(task: TrajectoryTask, spline: SplineBounds, proportions: Array) -> tuple[Array, float]:
    """Return proportions improved by sequential linear programming, and their exact total.

    T is the largest of many smooth values: each step minimises the largest of their linear models in a trust box.
    """
    from scipy.optimize import linprog

    point, value = proportions, exact_total(task, spline, proportions)
    gaps, box = len(point), 0.02
    for _ in range(40 if gaps > 1 else 0):
        moved = np.concatenate([point[None, :], point + 1e-6 * np.eye(gaps) * point])
        table = spline.requirements(moved)
        near = table[0] >= 0.8 * table[0].max()
        slopes = ((table[1:] - table[0]) / (1e-6 * point)[:, None]).T[near]
        model = np.column_stack([slopes, -np.ones(near.sum())])
        sum_to_zero = np.append(np.ones(gaps), 0.0)[None, :]
        limits = [(-box * share, box * share) for share in point] + [(None, None)]
        cost = np.append(np.zeros(gaps), 1.0)
        step = linprog(cost, A_ub=model, b_ub=-table[0][near], A_eq=sum_to_zero, b_eq=[0.0], bounds=limits)
        if step.status != 0:
            break
        trial = point + step.x[:gaps]
        trial /= trial.sum()
        total = exact_total(task, spline, trial)
        if total < value:
            point, value, box = trial, total, min(2 * box, 0.1)
        else:
            box *= 0.25
        if box < 1e-8:
            break
    return point, value


def exact_total(task: TrajectoryTask, spline: SplineBounds, proportions: Array) -> float:
    """Return T(p) from the exact extrema of the curve, s; infinite where it leaves the position limits."""
    curve = [np.stack(piece) for piece in spline.pieces([np.full((1, 1), share) for share in proportions])]
    total = 0.0
    for order, kind in enumerate(DERIVATIVES):
        if not task.limited(kind):
            continue
        limits = task.limits.get(kind)
        for piece in range(task.gaps):
            extremes = _extremes(curve[piece][:, 0], order) / proportions[piece] ** order
            if kind == "position":
                span = 1e-9 * (1.0 + np.abs(extremes))
                if (extremes[0] < limits[piece, 0] - span[0]).any() or (
                    extremes[1] > limits[piece, 1] + span[1]
                ).any():
                    return np.inf
            else:
                total = max(total, float(_ratio(extremes, limits[piece]).max()) ** (1.0 / order))
    return total


def _extremes(coefficients: Array, order: int) -> Array:
    """Return least and largest value (2, n) of a derivative by normalised time, from the roots of the next one.

    `coefficients` (degree + 1, n) are ascending.
    """
    values = np.empty((2, coefficients.shape[1]))
    for joint, column in enumerate(coefficients.T):
        derivative = np.polynomial.polynomial.polyder(column, order)
        size = np.abs(derivative).max()
        slope = np.polynomial.polynomial.polyder(derivative)
        slope = np.where(np.abs(slope) > 1e-10 * size, slope, 0.0)
        roots = np.polynomial.polynomial.polyroots(np.trim_zeros(slope, "b")) if slope.any() else np.empty(0)
        real = np.real(roots[np.abs(np.imag(roots)) < 1e-6])
        places = np.concatenate([[0.0, 1.0], real[(real > 0) & (real < 1)]])
        found = np.polynomial.polynomial.polyval(places, derivative)
        values[:, joint] = found.min(), found.max()
    return values
