"""Where a motion breaks a limit between the points its problem knew: the solver's own look, not the audit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.limits import DERIVATIVE_LIMITS, instant_limits
from ocp_traj.limits.limit import bound_scales
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.lifted.elements import IndexArray
from ocp_traj.transcription.lifted.instant_derivatives import outer_of
from ocp_traj.transcription.lifted.lifted import ExtraPoints

Excess = Callable[[IndexArray, Array], Array]
"""From segments (N,) and fractions of them (N,) to how far each of k values is over its limit, (N, k)."""

DENSE = 48
"""Samples a segment when looking for broken limits."""

CLOSER = 0.05
"""The second look at a peak is so many times as wide as the first."""

TOLERANCE = 1e-7
"""Ratios over a limit by less than this are left to the final scaling, and are far within what the audit allows."""

HIDDEN = 0.05
"""Local maxima of the samples below the limit by more than this hide no broken peak."""

EIGHTHS = tuple(k / 8 for k in range(1, 8))
HALVING = tuple(k / 16 for k in range(1, 16, 2))
"""Fractions of a segment: where to look first, and half-way between."""

ASIDE, BESIDE = 0.1, (0.5,)
"""Distance assumed of the nearest point where there is none, in segments; parts of it for the points beside a peak."""

CLOSING = (0.5, 0.125)
"""The same for a wandering peak: bisecting its place would take a round for every bit."""

CLOSE = 1e-5
"""Points nearer than this to one that is there, in segments, add nothing."""


def broken_points(
    task: TrajectoryTask, trajectory: Trajectory, moving: Any, *, compiled: bool = False
) -> ExtraPoints:
    """Return the points, one a peak, where the motion is over a limit by more than `TOLERANCE`."""
    motion = _Motion(trajectory, segment_gaps(trajectory))
    derivatives: list[tuple[int, int, int, float]] = []
    for limit in DERIVATIVE_LIMITS:
        if limit.order >= trajectory.degree - 1 or not limit.applies(task):
            continue
        bounds = limit.bounds(task)
        scales = bound_scales(bounds)

        def over(
            segment: IndexArray,
            fraction: Array,
            order: int = limit.order,
            bounds: Array = bounds,
            scales: Array = scales,
        ) -> Array:
            gap, value = motion.gaps[segment], motion.derivative(order, segment, fraction)
            return _excess(value, bounds[gap], scales[gap])[:, moving]

        for segment, joint, fraction in _peaks(over, motion.segments):
            derivatives.append((limit.order, segment, joint, fraction))
    return ExtraPoints(tuple(derivatives), tuple(_broken_instants(task, motion, compiled)))


@dataclass(frozen=True)
class _Motion:
    """A trajectory, looked at by segments and fractions of them."""

    trajectory: Trajectory
    gaps: IndexArray

    @property
    def segments(self) -> int:
        return len(self.gaps)

    def derivative(self, order: int, segment: IndexArray, fraction: Array) -> Array:
        """Evaluate each segment's own polynomial, at its end too, (N, n)."""
        coefficients = self.trajectory.derivative_coefficients(order)[segment]
        local = fraction * np.diff(self.trajectory.breakpoints)[segment]
        powers = local[:, None] ** np.arange(coefficients.shape[2])
        values: Array = np.einsum("Np,Nnp->Nn", powers, coefficients)
        return values


def segment_gaps(trajectory: Trajectory) -> Any:
    """Return the gap between waypoints that every segment lies in."""
    middle = (np.asarray(trajectory.breakpoints)[:-1] + np.asarray(trajectory.breakpoints)[1:]) / 2
    last = len(trajectory.waypoint_times) - 2
    return np.clip(np.searchsorted(trajectory.waypoint_times, middle, side="right") - 1, 0, last)


def _excess(value: Array, bounds: Array, scales: Array) -> Array:
    """Return how far values (N, k) are over bounds (N, 2, k), relative to scales (N, k)."""
    over: Array = np.maximum(value - bounds[:, 1], bounds[:, 0] - value) / scales
    return over


def _peaks(over: Excess, segments: int) -> list[tuple[int, int, float]]:
    """Return (segment, column, fraction) of local maxima above the tolerance.

    A peak may hide between two samples that keep the limit, so parabolas through three samples give its place, and
    parabolas through three points close to that place give its height.
    """
    fractions = np.linspace(0.0, 1.0, DENSE + 1)
    grid = over(np.repeat(np.arange(segments), DENSE + 1), np.tile(fractions, segments))
    grid = grid.reshape(segments, DENSE + 1, -1)
    padded = np.pad(grid, ((0, 0), (1, 1), (0, 0)), constant_values=-np.inf)
    is_peak = (grid > -HIDDEN) & (grid > padded[:, :-2]) & (grid >= padded[:, 2:])
    segment, index, column = np.nonzero(is_peak)
    if not len(segment):
        return []
    fraction, top = fractions[index], grid[is_peak]
    for width in (1.0 / DENSE, CLOSER / DENSE):
        middle = np.clip(fraction, width, 1.0 - width)
        places = middle + width * np.array([[-1.0], [0.0], [1.0]])
        near = over(np.tile(segment, 3), places.ravel()).reshape(3, len(segment), -1)
        left, centre, right = near[:, np.arange(len(segment)), column]
        curvature = left - 2 * centre + right
        bent = curvature < 0
        shift = np.divide(left - right, 2 * curvature, out=np.zeros_like(top), where=bent)
        inside = bent & (np.abs(shift) <= 1.0)
        height = centre - np.divide((left - right) ** 2, 8 * curvature, out=np.zeros_like(top), where=bent)
        fraction = np.where(inside, middle + width * shift, fraction)
        top = np.where(inside, height, np.maximum(np.maximum(left, centre), right))
    found = top > TOLERANCE
    return [(int(k), int(c), float(f)) for k, c, f in zip(segment[found], column[found], fraction[found])]


def _broken_instants(task: TrajectoryTask, motion: _Motion, compiled: bool) -> list[tuple[int, float]]:
    found: dict[tuple[int, float], None] = {}
    for constraint in instant_limits(task):
        orders = 4 if constraint.needs_jerk else 3
        function = outer_of(
            constraint.function(task),
            needs_jerk=constraint.needs_jerk,
            total=False,
            compiled=compiled,
        ).functions["value"]
        bounds, scales = constraint.bounds(task), constraint.scales(task)

        def over(
            segment: IndexArray,
            fraction: Array,
            orders: int = orders,
            function: Any = function,
            bounds: Array = bounds,
            scales: Array = scales,
        ) -> Array:
            gap = motion.gaps[segment]
            u = [motion.derivative(order, segment, fraction) for order in range(orders)]
            value = np.array(function.map(len(segment))(np.concatenate(u, axis=1).T)).T
            return _excess(value, bounds[gap], scales[gap])

        for segment, _, fraction in _peaks(over, motion.segments):
            found[(segment, round(fraction, 6))] = None
    return list(found)


def new_points(known: ExtraPoints, found: ExtraPoints) -> ExtraPoints:
    """Return the found points that are not all but known already.

    Where a joint breaks a limit in a segment for the second time (a position: for the first time, because nothing
    inside its segments is limited at first), its peaks wander, and points spread over the segment hold them. A
    limit of an instant gets points on both sides of the peak, too: motions run along such limits for a while.
    """
    wandering = {point[:-1] for point in known.derivatives}
    derivatives = []
    for point in found.derivatives:
        spread: tuple[float, ...] = ()
        if point[:-1] in wandering:
            spread = HALVING + _around(point, known.derivatives, CLOSING)
        elif point[0] == 0:
            spread = EIGHTHS
        for candidate in (point, *((*point[:-1], fraction) for fraction in spread)):
            if not _is_near(candidate, known.derivatives) and candidate not in derivatives:
                derivatives.append(candidate)
    instants: list[tuple[int, float]] = []
    for peak in found.instants:
        for place in (peak[-1], *_around(peak, known.instants, BESIDE)):
            instant = peak[0], round(place, 6)
            if not _is_near(instant, known.instants) and instant not in instants:
                instants.append(instant)
    return ExtraPoints(tuple(derivatives), tuple(instants))


def _around(point: Any, known: Any, parts: tuple[float, ...]) -> tuple[float, ...]:
    """Return fractions on both sides of a point, at parts of its distance to the nearest known one."""
    nearest = min((abs(other[-1] - point[-1]) for other in known if other[:-1] == point[:-1]), default=ASIDE)
    places = [point[-1] + sign * part * nearest for part in parts for sign in (-1, 1)]
    return tuple(min(max(place, 0.0), 1.0) for place in places)


def _is_near(point: Any, known: Any) -> bool:
    return any(point[:-1] == other[:-1] and abs(point[-1] - other[-1]) < CLOSE for other in known)
