"""Where a motion breaks a limit between the points its problem knew: the solver's own look, not the audit."""

from __future__ import annotations

from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.constraints import DERIVATIVE_LIMITS
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.lifted import ExtraPoints
from ocp_traj.transcription.outer import outer_of
from ocp_traj.transcription.samples import instant_function, instant_of

DENSE = 48
"""Samples a segment when looking for broken limits."""

TOLERANCE = 1e-7
"""Ratios over a limit by less than this are left to the final scaling, and are far within what the audit allows."""

HIDDEN = 0.05
"""Local maxima of the samples below the limit by more than this hide no broken peak."""

EIGHTHS = tuple(k / 8 for k in range(1, 8))
HALVING = tuple(k / 16 for k in range(1, 16, 2))
"""Fractions of a segment: where to look first, and half-way between."""

CLOSE = 1e-5
"""Points nearer than this to one that is there, in segments, add nothing."""


def broken_points(
    task: TrajectoryTask, trajectory: Trajectory, moving: Any, *, compiled: bool = False
) -> ExtraPoints:
    """Return the points, one a peak, where the motion is over a limit by more than `TOLERANCE`."""
    fractions = np.linspace(0.0, 1.0, DENSE + 1)
    breakpoints = np.asarray(trajectory.breakpoints)
    spans = np.diff(breakpoints)
    t = (breakpoints[:-1, None] + fractions * spans[:, None]).ravel()
    gaps = np.repeat(segment_gaps(trajectory), DENSE + 1)
    derivatives: list[tuple[int, int, int, float]] = []
    for limit in DERIVATIVE_LIMITS:
        if limit.order >= trajectory.degree - 1 or not limit.applies(task):
            continue
        value = _one_sided(trajectory, t, spans, limit.order)
        over = _excess(value, limit.bounds(task)[gaps])[:, moving]
        for segment, joint, fraction in _peaks(over, len(spans), fractions):
            derivatives.append((limit.order, segment, joint, fraction))
    return ExtraPoints(
        tuple(derivatives), tuple(_broken_instants(task, trajectory, t, gaps, fractions, compiled))
    )


def segment_gaps(trajectory: Trajectory) -> Any:
    """Return the gap between waypoints that every segment lies in."""
    middle = (np.asarray(trajectory.breakpoints)[:-1] + np.asarray(trajectory.breakpoints)[1:]) / 2
    last = len(trajectory.waypoint_times) - 2
    return np.clip(np.searchsorted(trajectory.waypoint_times, middle, side="right") - 1, 0, last)


def _one_sided(trajectory: Trajectory, t: Array, spans: Array, order: int) -> Array:
    """Evaluate each segment's own polynomial, at its end too, (segments * (DENSE + 1), n)."""
    coefficients = trajectory.derivative_coefficients(order)
    local = np.linspace(0.0, 1.0, DENSE + 1) * spans[:, None]
    powers = local[:, :, None] ** np.arange(coefficients.shape[2])
    values: Array = np.einsum("skp,snp->skn", powers, coefficients).reshape(len(t), -1)
    return values


def _excess(value: Array, bounds: Array) -> Array:
    """Return how far values (N, k) are over bounds (N, 2, k), relative to the larger finite bound."""
    scale = np.where(np.isfinite(bounds), np.abs(bounds), 0.0).max(axis=1)
    scale = np.where(scale > 0, scale, 1.0)
    over: Array = np.maximum(value - bounds[:, 1], bounds[:, 0] - value) / scale
    return over


def _peaks(over: Array, segments: int, fractions: Array) -> list[tuple[int, int, float]]:
    """Return (segment, column, fraction) of local maxima above the tolerance, by a parabola through the samples.

    A peak may hide between two samples that keep the limit, so the parabola's top decides.
    """
    grid = over.reshape(segments, len(fractions), -1)
    padded = np.pad(grid, ((0, 0), (1, 1), (0, 0)), constant_values=-np.inf)
    is_peak = (grid > -HIDDEN) & (grid >= padded[:, :-2]) & (grid >= padded[:, 2:])
    found = []
    for segment, index, column in np.argwhere(is_peak):
        top, fraction = float(grid[segment, index, column]), float(fractions[index])
        if 0 < index < len(fractions) - 1:
            left, middle, right = grid[segment, index - 1 : index + 2, column]
            curvature = left - 2 * middle + right
            if curvature < 0:
                fraction += float(0.5 * (left - right) / curvature * fractions[1])
                top -= float((left - right) ** 2 / (8.0 * curvature))
        if top > TOLERANCE:
            found.append((int(segment), int(column), fraction))
    return found


def _broken_instants(
    task: TrajectoryTask, trajectory: Trajectory, t: Array, gaps: Any, fractions: Array, compiled: bool
) -> list[tuple[int, float]]:
    found: dict[tuple[int, float], None] = {}
    constraints = instant_of(task).constraints
    if not constraints:
        return []
    spans = np.diff(trajectory.breakpoints)
    columns = [_one_sided(trajectory, t, spans, order) for order in range(4)]
    for constraint in constraints:
        orders = 4 if constraint.needs_jerk else 3
        outer = outer_of(
            instant_function(task, constraint),
            needs_jerk=constraint.needs_jerk,
            total=False,
            compiled=compiled,
        )
        u = np.concatenate(columns[:orders], axis=1).T
        value = np.array(outer.functions["value"].map(len(t))(u)).T
        over = _excess(value, constraint.bounds(task)[gaps])
        for segment, _, fraction in _peaks(over, len(spans), fractions):
            found[(segment, round(fraction, 6))] = None
    return list(found)


def new_points(known: ExtraPoints, found: ExtraPoints) -> ExtraPoints:
    """Return the found points that are not all but known already.

    Where a joint breaks a limit in a segment for the second time (a position: for the first time, because nothing
    inside its segments is limited at first), its peaks wander, and points spread over the segment hold them.
    """
    wandering = {point[:-1] for point in known.derivatives}
    derivatives = []
    for point in found.derivatives:
        spread: tuple[float, ...] = ()
        if point[0] == 0 or point[:-1] in wandering:
            spread = HALVING if point[:-1] in wandering else EIGHTHS
        for candidate in (point, *((*point[:-1], fraction) for fraction in spread)):
            if not _is_near(candidate, known.derivatives) and candidate not in derivatives:
                derivatives.append(candidate)
    instants = [point for point in found.instants if not _is_near(point, known.instants)]
    return ExtraPoints(tuple(derivatives), tuple(instants))


def _is_near(point: Any, known: Any) -> bool:
    return any(point[:-1] == other[:-1] and abs(point[-1] - other[-1]) < CLOSE for other in known)
