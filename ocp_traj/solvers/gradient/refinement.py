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


@dataclass(frozen=True)
class PeakSearch:
    """How broken limits are looked for, and which points are added where there are some; lengths in segments.

    Parameters
    ----------
    samples : int
        Samples per segment when looking for broken limits.
    second_width : float
        Width of the second look at a peak, relative to the first.
    tolerance : float
        Ratios over a limit by less than this are left to the final scaling, and are far within what the audit allows.
    hidden_depth : float
        Local maxima of the samples below the limit by more than this hide no broken peak.
    first_fractions, second_fractions : tuple of float
        Fractions of a segment: where points go first, and half-way between.
    assumed_distance : float
        Distance assumed of the nearest point where there is none.
    beside : tuple of float
        Fractions of the distance to the nearest point, for the points beside a peak of an instant.
    closing : tuple of float
        The same for a wandering peak: bisecting its place would take a round for every bit.
    smallest_distance : float
        Points nearer than this to one that is there add nothing.
    """

    samples: int = 48
    second_width: float = 0.05
    tolerance: float = 1e-7
    hidden_depth: float = 0.05
    first_fractions: tuple[float, ...] = tuple(k / 8 for k in range(1, 8))
    second_fractions: tuple[float, ...] = tuple(k / 16 for k in range(1, 16, 2))
    assumed_distance: float = 0.1
    beside: tuple[float, ...] = (0.5,)
    closing: tuple[float, ...] = (0.5, 0.125)
    smallest_distance: float = 1e-5

    def around(self, point: Any, known: Any, fractions: tuple[float, ...]) -> tuple[float, ...]:
        """Return places on both sides of a point, at fractions of its distance to the nearest known one."""
        distances = (abs(other[-1] - point[-1]) for other in known if other[:-1] == point[:-1])
        nearest = min(distances, default=self.assumed_distance)
        places = [point[-1] + sign * fraction * nearest for fraction in fractions for sign in (-1, 1)]
        return tuple(min(max(place, 0.0), 1.0) for place in places)

    def is_near(self, point: Any, known: Any) -> bool:
        """Return whether a point adds nothing to the known ones."""
        return any(
            point[:-1] == other[:-1] and abs(point[-1] - other[-1]) < self.smallest_distance for other in known
        )


PEAK_SEARCH = PeakSearch()


def broken_points(
    task: TrajectoryTask,
    trajectory: Trajectory,
    moving: Any,
    search: PeakSearch = PEAK_SEARCH,
    *,
    compiled: bool = False,
) -> ExtraPoints:
    """Return the points, one per peak, where the motion is over a limit by more than the search's tolerance."""
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

        for segment, joint, fraction in _peaks(over, motion.segments, search):
            derivatives.append((limit.order, segment, joint, fraction))
    return ExtraPoints(tuple(derivatives), tuple(_broken_instants(task, motion, search, compiled)))


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
        return np.einsum("Np,Nnp->Nn", powers, coefficients)


def segment_gaps(trajectory: Trajectory) -> Any:
    """Return the gap between waypoints that every segment lies in."""
    middle = (np.asarray(trajectory.breakpoints)[:-1] + np.asarray(trajectory.breakpoints)[1:]) / 2
    last = len(trajectory.waypoint_times) - 2
    return np.clip(np.searchsorted(trajectory.waypoint_times, middle, side="right") - 1, 0, last)


def _excess(value: Array, bounds: Array, scales: Array) -> Array:
    """Return how far values (N, k) are over bounds (N, 2, k), relative to scales (N, k)."""
    return np.maximum(value - bounds[:, 1], bounds[:, 0] - value) / scales


def _peaks(over: Excess, segments: int, search: PeakSearch) -> list[tuple[int, int, float]]:
    """Return (segment, column, fraction) of local maxima above the tolerance.

    A peak may hide between two samples that keep the limit, so parabolas through three samples give its place, and
    parabolas through three points close to that place give its height.
    """
    fractions = np.linspace(0.0, 1.0, search.samples + 1)
    grid = over(np.repeat(np.arange(segments), len(fractions)), np.tile(fractions, segments))
    grid = grid.reshape(segments, len(fractions), -1)
    padded = np.pad(grid, ((0, 0), (1, 1), (0, 0)), constant_values=-np.inf)
    is_peak = (grid > -search.hidden_depth) & (grid > padded[:, :-2]) & (grid >= padded[:, 2:])
    segment, index, column = np.nonzero(is_peak)
    if not len(segment):
        return []
    fraction, top = fractions[index], grid[is_peak]
    for width in (1.0 / search.samples, search.second_width / search.samples):
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
    found = top > search.tolerance
    return [(int(k), int(c), float(f)) for k, c, f in zip(segment[found], column[found], fraction[found])]


def _broken_instants(
    task: TrajectoryTask, motion: _Motion, search: PeakSearch, compiled: bool
) -> list[tuple[int, float]]:
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

        for segment, _, fraction in _peaks(over, motion.segments, search):
            found[(segment, round(fraction, 6))] = None
    return list(found)


def new_points(known: ExtraPoints, found: ExtraPoints, search: PeakSearch = PEAK_SEARCH) -> ExtraPoints:
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
            spread = search.second_fractions + search.around(point, known.derivatives, search.closing)
        elif point[0] == 0:
            spread = search.first_fractions
        for candidate in (point, *((*point[:-1], fraction) for fraction in spread)):
            if not search.is_near(candidate, known.derivatives) and candidate not in derivatives:
                derivatives.append(candidate)
    instants: list[tuple[int, float]] = []
    for peak in found.instants:
        for place in (peak[-1], *search.around(peak, known.instants, search.beside)):
            instant = peak[0], round(place, 6)
            if not search.is_near(instant, known.instants) and instant not in instants:
                instants.append(instant)
    return ExtraPoints(tuple(derivatives), tuple(instants))
