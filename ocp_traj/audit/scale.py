"""The smallest uniform slowing that makes a motion feasible."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.conditions import scale_bounds
from ocp_traj.audit.curves import constraint_peaks
from ocp_traj.audit.measures import further_peaks
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.numerics import chebyshev
from ocp_traj.audit.numerics.polynomials import evaluate, roots_in_unit_interval
from ocp_traj.audit.torque import TorqueCurve, torque_curve
from ocp_traj.audit.verdict import Extremum
from ocp_traj.quantities import KINEMATIC_POWERS
from ocp_traj.task import TrajectoryTask

_MAX_EXCHANGES = 30
_FAR = 10.0
_TOLERANCE = 1e-10
_NODE_BASIS = np.cos(
    np.pi / chebyshev.DEGREE * np.outer(np.arange(chebyshev.DEGREE + 1), np.arange(chebyshev.DEGREE + 1))
)
_ROOTS_AT_ONCE = 64
_SEGMENTS_ASKED = 1000
_SLOWEST_START = 1e-6
_SLOWEST = 1e6


def smallest_scale(
    task: TrajectoryTask,
    motion: Motion,
    peaks: list[Extremum],
    torques: TorqueCurve | None,
    feasible: bool,
    smallest: float = 0.0,
) -> float | None:
    """Return the smallest s for which the motion run s times slower keeps every limit, or None.

    Velocity, acceleration and jerk fall with s, s^2 and s^3, so their part is closed form. Torques are
    gravity + viscous / s + inertial / s^2 + Coulomb friction: at given times the forbidden s are intervals
    between roots of polynomials; times are added where the torque is largest until none is above its limit
    (an exchange method: each round solves for a growing set of times and looks for the worst time left). A
    user's own constraints are asked again on the slowed motion; where they need it, the smallest slowing
    above the one found is sought by bracketing. Limits are met without the judge's 1e-6.

    Parameters
    ----------
    peaks : list of Extremum
        The largest ratios at s = 1.
    torques : TorqueCurve or None
        None when neither torque nor torque rate is limited.
    feasible : bool
        The verdict at s = 1: it decides for motions that do not start and end at rest.
    smallest : float
        Slowing below which jumps of rounding's size are too large.
    """
    if not task.boundary.is_rest:
        return 1.0 if feasible else None
    fixed = [peak for peak in peaks if peak.limit == "position"]
    if any(peak.broken for peak in fixed) or not all(np.isfinite(peak.ratio) for peak in peaks):
        return None
    least, most = scale_bounds(task, motion)
    needed = [
        peak.ratio ** (1.0 / KINEMATIC_POWERS[peak.limit]) for peak in peaks if peak.limit in KINEMATIC_POWERS
    ]
    least = max([least, smallest, *needed])
    scale: float | None = least
    if torques is not None:
        scale = _with_torques(task, torques, least, most)
        if scale is not None and scale > 0.0 and not 1.0 / _FAR <= scale <= _FAR:
            scale = _refined(task, motion, scale, (least, most))
    if scale is None or scale > most:
        return None
    if not (task.constraints or task.limits.others):
        return scale
    slower = _with_constraints(task, motion, scale, most)
    if feasible and (slower is None or slower > 1.0):
        return 1.0
    if slower is None or torques is None or slower == scale:
        return slower
    return slower if _with_torques(task, torques, slower, slower * (1.0 + _TOLERANCE)) is not None else None


def _with_constraints(task: TrajectoryTask, motion: Motion, smallest: float, largest: float) -> float | None:
    """Return a slowing in [smallest, largest] that keeps the user's own constraints, too; the first found.

    One at which they vary too fast to be resolved is passed over.
    """
    from scipy.optimize import brentq  # its package takes longer to load than many a solve

    def excess(log_scale: float) -> float:
        slowed = Motion.of(motion.trajectory.scaled(float(np.exp(log_scale))))
        found, unresolved = constraint_peaks(task, slowed, _SEGMENTS_ASKED)
        further, more_unresolved = further_peaks(task, slowed)
        unresolved = unresolved + more_unresolved
        over = max((peak.ratio for peak in found + further), default=0.0) - 1.0
        return max(over, 1.0) if unresolved else over

    low = float(np.log(max(smallest, _SLOWEST_START)))
    if excess(low) <= 0.0:
        return float(np.exp(low))
    high = float(np.log(min(largest, _SLOWEST)))
    steps = np.unique(np.clip(low + np.array([0.05, 0.2, 0.7, 2.0, 5.0, np.inf]), low, high))
    for high in steps[steps > low]:
        if (value := excess(float(high))) <= 0.0:
            root = high if value == 0.0 else brentq(excess, low, high, xtol=_TOLERANCE)
            return float(np.exp(min(root + 2.0 * _TOLERANCE, high)))
        low = float(high)
    return None


def _refined(task: TrajectoryTask, motion: Motion, scale: float, bounds: tuple[float, float]) -> float | None:
    """Return the smallest slowing, sought again from a motion slowed by about that much.

    Far from it rounding hides the smaller of gravity and inertial torques.
    """
    slowed = Motion.of(motion.trajectory.scaled(scale))
    smallest, largest = bounds[0] / scale, bounds[1] / scale
    again = _with_torques(task, torque_curve(task, slowed), smallest, largest)
    return None if again is None else scale * again


def _with_torques(
    task: TrajectoryTask, torques: TorqueCurve, smallest: float, largest: float
) -> float | None:
    """Return the smallest slowing in [smallest, largest] that keeps torques and torque rates, too."""
    curves = [_Curve(task, torques, name) for name in ("torque", "torque_rate") if task.limited(name)]
    with np.errstate(divide="ignore"):
        fastest, slowest = float(1.0 / np.float64(smallest)), float(1.0 / np.float64(largest))
    polynomials = [curve.first_violations() for curve in curves]
    if np.isinf(fastest):
        fastest = min(_always_violated_beyond(block) for block in polynomials)
        if np.isinf(fastest):
            return smallest
    scale = smallest
    for _ in range(_MAX_EXCHANGES):
        x = largest_allowed(polynomials, fastest, slowest)
        if x is None:
            return None
        scale = 1.0 / x
        worst = [curve.violated(x) for curve in curves]
        if not any(row.size for row, _ in worst):
            break
        polynomials += [
            curve.violations(*points) for curve, points in zip(curves, worst, strict=True) if points[0].size
        ]
    return scale


class _Curve:
    """Torques or torque rates as polynomials in x = 1/s at every time, with their limits.

    Attributes
    ----------
    parts : (d + 1, S n, .) array
        Chebyshev coefficients of each power of x; row r belongs to joint r mod n.
    limits : (S n, 2) array
    """

    def __init__(self, task: TrajectoryTask, torques: TorqueCurve, name: str) -> None:
        gravity, viscous, inertial = (part.copy() for part in np.split(torques.curve.coefficients, 3, axis=1))
        gravity[:, :, 0] += torques.coulomb
        parts = np.stack([gravity, viscous, inertial])
        if name == "torque_rate":
            rates = chebyshev.differentiate(parts) * (2.0 / torques.seconds)[:, None, None]
            parts = np.concatenate([np.zeros_like(rates[:1]), rates])
        self.parts = parts.reshape(len(parts), -1, parts.shape[3])
        self.limits = task.limits.get(name)[torques.gaps].transpose(0, 2, 1).reshape(-1, 2)

    def first_violations(self) -> Array:
        """Return polynomials in x, above 0 where a limit is broken, at the nodes of every row, (R, d + 1)."""
        values = (self.parts @ _NODE_BASIS).transpose(1, 2, 0)
        rows = np.repeat(np.arange(values.shape[0]), values.shape[1])
        return self._beyond_limits(values.reshape(-1, values.shape[2]), rows)

    def violations(self, row: chebyshev.Pieces, theta: Array) -> Array:
        """Return the same at chosen rows and angles."""
        values = np.stack([chebyshev.evaluate(part[row], theta) for part in self.parts], axis=1)
        return self._beyond_limits(values, row)

    def _beyond_limits(self, values: Array, row: chebyshev.Pieces) -> Array:
        above, below = values.copy(), -values
        above[:, 0] -= self.limits[row, 1]
        below[:, 0] += self.limits[row, 0]
        both: Array = np.concatenate([above, below])
        return both[np.isfinite(both[:, 0])]

    def violated(self, x: float) -> tuple[chebyshev.Pieces, Array]:
        """Return rows and angles of the extrema above the limits at slowing 1/x."""
        series = np.tensordot(x ** np.arange(len(self.parts)), self.parts, axes=1)
        lower, upper = self.limits.T
        low, high, lower_bound, upper_bound = chebyshev.enclosures(series)
        width = np.where(np.isfinite(upper - lower), upper - lower, np.maximum(-low, high).max())
        chosen = np.flatnonzero((lower_bound < lower) | (upper_bound > upper))
        row, theta = chebyshev.critical_points(series[chosen])
        row = chosen[row]
        values = chebyshev.evaluate(series[row], theta)
        allowed, lower, upper = _TOLERANCE * width[row], lower[row], upper[row]
        over = (values > upper + allowed) | (values < lower - allowed)
        return row[over], theta[over]


def _always_violated_beyond(polynomials: Array) -> float:
    """Return an x beyond which one polynomial stays above 0 (Cauchy's bound of its roots), or infinity."""
    leading, others = polynomials[:, -1], np.abs(polynomials[:, :-1]).sum(axis=1)
    growing = leading > 0
    if not growing.any():
        return np.inf
    return float(np.maximum(1.0, others[growing] / leading[growing]).min())


def largest_allowed(polynomials: list[Array], fastest: float, slowest: float) -> float | None:
    """Return the largest x in [slowest, fastest] where no polynomial is above 0, or None.

    Going down from the fastest, only polynomials that are above 0 there are asked for their roots, the largest
    ones first.
    """
    width = max(block.shape[1] for block in polynomials)
    powers = np.arange(width)
    padded = [np.pad(block, ((0, 0), (0, width - block.shape[1]))) for block in polynomials]
    scaled = np.concatenate(padded) * fastest**powers
    size = np.abs(scaled).sum(axis=1)
    x, settled = 1.0, np.zeros(len(scaled), dtype=bool)
    while True:
        values = np.where(settled, 0.0, scaled @ x**powers)
        above = np.flatnonzero(values > 0)
        if not above.size:
            break
        chosen = above[np.argsort(-values[above] / size[above], kind="stable")[:_ROOTS_AT_ONCE]]
        start, end = _broken_intervals(scaled[chosen])
        inside = (start < x) & (x <= end)
        if inside.any():
            x = float(start[inside].min())
            settled[:] = False
        else:  # x is a root of these: what they have above 0 is rounding
            settled[chosen] = True
    x *= fastest
    return x if x > 0 and x >= slowest else None


def _broken_intervals(polynomials: Array) -> tuple[Array, Array]:
    """Return starts and ends of the intervals inside [0, 1] where some polynomial is above 0."""
    reach = polynomials[:, 0] + np.maximum(polynomials[:, 1:], 0.0).sum(axis=1)
    polynomials = polynomials[reach > 0]
    points = roots_in_unit_interval(polynomials)
    above = evaluate(polynomials, 0.5 * (points[:, 1:] + points[:, :-1])) > 0
    above &= points[:, 1:] > points[:, :-1]
    return points[:, :-1][above], points[:, 1:][above]
