"""Geometric paths, sampled by arc length, for the methods that time a fixed path.

A path is a piecewise polynomial in any parameter. It is sampled by its own arc length in joint space, scaled to
run from 0 to 1: micrometre motions then look like any other, and points where the parameter's speed vanishes
(the ends of a motion from rest to rest) are not singular. Tangent and curvature are kept for both ends of every
grid cell, so corners and jumps of curvature between pieces are exact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.trajectory import Trajectory

if TYPE_CHECKING:
    import numpy.typing as npt

    from ocp_traj.task import TrajectoryTask

WAYPOINT_PATHS = ("uniform", "chord")
"""Splines through the waypoints: knots at equal distances, or at distances equal to the chords."""

CELLS_A_PIECE = 8
"""Least number of cells of a polynomial piece."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True)
class GeometricPath:
    """A path to be timed.

    Attributes
    ----------
    name : str
        ``"uniform"``, ``"chord"`` or ``"spline"``.
    curve : Trajectory or None
        The path in its own parameter; None where nothing moves.
    piece_gaps : (m,) int array
        Gap between waypoints, counted from 0, of every polynomial piece.
    end_speeds : (2,) array
        Joint-space speed at start and end, rad/s: the norm of the task's boundary velocity.
    """

    name: str
    curve: Trajectory | None
    piece_gaps: npt.NDArray[np.int_]
    end_speeds: Array


@dataclass(frozen=True)
class PathGrid:
    """Samples of a path at N + 1 values of its scaled arc length s in [0, 1].

    Attributes
    ----------
    s : (N + 1,) array
    length : float
        Arc length in joint space, rad.
    q : (N + 1, n) array
        Positions, rad.
    tangent, curvature : (N, 2, n) arrays
        First and second derivative by s at the start [.., 0, ..] and the end [.., 1, ..] of every cell.
    middle_tangent : (N, n) array
        First derivative by s at the middle of every cell.
    gaps : (N,) int array
        Gap between waypoints of every cell.
    stops : (N + 1,) bool array
        Corners, where a motion with continuous velocity has to stop.
    waypoint_nodes : (K,) int array
        Grid point of every waypoint.
    """

    s: Array
    length: float
    q: Array
    tangent: Array
    curvature: Array
    middle_tangent: Array
    gaps: npt.NDArray[np.int_]
    stops: npt.NDArray[np.bool_]
    waypoint_nodes: npt.NDArray[np.int_]


def geometric_path(task: TrajectoryTask, path: str | Trajectory) -> GeometricPath:
    """Return the path named `path` through a task's waypoints, or the path of a trajectory.

    Parameters
    ----------
    task : TrajectoryTask
    path : ``"uniform"``, ``"chord"`` or a Trajectory
        The first two are the cubic "not-a-knot" splines that TOPP-RA users draw through their waypoints, with
        knots at equal distances or at distances equal to the chords (Euclidean, in joint space). Equal
        neighbouring waypoints are one knot. Where an end moves, the path leaves along the given velocity.

    Raises
    ------
    InputError
        The name is unknown, or the trajectory has another number of joints or waypoints than the task.
    """
    end_speeds = np.linalg.norm(np.asarray(task.boundary.velocity), axis=1)
    if isinstance(path, Trajectory):
        if path.n != task.n or len(path.waypoint_times) != len(task.waypoints):
            raise InputError(
                f"the trajectory has {path.n} joints and {len(path.waypoint_times)} waypoints, "
                f"expected {task.n} and {len(task.waypoints)} as in the task"
            )
        middles = 0.5 * (path.breakpoints[1:] + path.breakpoints[:-1])
        gaps = path.gap_at(middles)
        still = not (np.abs(path.derivative_coefficients(1)) > 0).any()
        return GeometricPath("spline", None if still else path, gaps, end_speeds)
    if path not in WAYPOINT_PATHS:
        raise InputError(f"path {path!r} is unknown, expected 'uniform', 'chord' or a Trajectory")
    chords = np.linalg.norm(np.diff(task.waypoints, axis=0), axis=1)
    moving = np.flatnonzero(chords > 0)
    if moving.size == 0:
        return GeometricPath(path, None, moving, end_speeds)
    points = task.waypoints[np.append(moving, moving[-1] + 1)]
    passed = np.append(0, np.cumsum(chords > 0))
    steps = np.ones(moving.size) if path == "uniform" else chords[moving]
    knots = np.append(0.0, np.cumsum(steps / steps.sum()))
    curve = _spline_through(knots, points, np.asarray(task.boundary.velocity), end_speeds, path)
    curve = replace(curve, waypoint_times=knots[passed])  # one for each of equal waypoints
    return GeometricPath(path, curve, moving, end_speeds)


def _spline_through(knots: Array, points: Array, velocity: Array, speeds: Array, name: str) -> Trajectory:
    """Return the cubic spline; a moving end gets the direction of its velocity at the free spline's pace."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(knots, points, bc_type="not-a-knot")
    if speeds.any():
        conditions: list[object] = ["not-a-knot", "not-a-knot"]
        for end in range(2):
            if speeds[end] > 0:
                pace = np.linalg.norm(spline(knots[-end], 1))
                conditions[end] = (1, velocity[end] / speeds[end] * pace)
        if len(knots) == 2:  # "not-a-knot" needs a third point: an end at rest leaves without curvature
            conditions = [
                (2, np.zeros(points.shape[1])) if item == "not-a-knot" else item for item in conditions
            ]
        spline = CubicSpline(knots, points, bc_type=tuple(conditions))
    coefficients = np.moveaxis(spline.c[::-1], 0, 2)
    return Trajectory(knots, coefficients, knots, "cubic", name)


def sample_path(path: GeometricPath, points: int, *, dense_ends: bool = False) -> PathGrid:
    """Sample a path with about `points` cells, at least eight a polynomial piece.

    Cells are equal in the path's own parameter; reversals of single joints, waypoints and corners are grid points.
    With `dense_ends` they shrink towards both ends as the cube of the distance, as a motion with bounded jerk does.

    Raises
    ------
    InputError
        Nothing moves along the path.
    """
    if path.curve is None:
        raise InputError("nothing moves along the path, so it cannot be sampled by its length")
    curve = path.curve
    breaks, pieces = _grid_parameters(curve, points, dense_ends)
    velocities, lengths = _cell_lengths(curve, breaks, pieces)
    keep = lengths > 1e-15 * lengths.sum()  # pieces in which nothing moves have no length
    if not keep.all():
        breaks = np.stack([breaks[:-1][keep], breaks[1:][keep]])
        pieces, lengths, velocities = pieces[keep], lengths[keep], velocities[keep]
    else:
        breaks = np.stack([breaks[:-1], breaks[1:]])
    length = float(lengths.sum())
    tangent = np.empty((len(pieces), 2, curve.n))
    curvature = np.empty_like(tangent)
    for end in range(2):
        tangent[:, end], curvature[:, end] = _arc_derivatives(curve, pieces, breaks, end)
    s = np.append(0.0, np.cumsum(lengths / length))
    s[-1] = 1.0
    corners = np.linalg.norm(tangent[1:, 0] - tangent[:-1, 1], axis=1) > 1e-6
    middle = velocities / np.linalg.norm(velocities, axis=1, keepdims=True)
    times = np.append(breaks[0], breaks[1, -1])
    first_piece = np.searchsorted(times, curve.waypoint_times - 1e-12 * curve.duration)
    return PathGrid(
        s=s,
        length=length,
        q=curve(times),
        tangent=tangent * length,
        curvature=curvature * length**2,
        middle_tangent=middle * length,
        gaps=np.asarray(path.piece_gaps)[pieces],
        stops=np.concatenate([[False], corners, [False]]),
        waypoint_nodes=np.clip(first_piece, 0, len(times) - 1),
    )


def _grid_parameters(curve: Trajectory, points: int, dense_ends: bool) -> tuple[Array, npt.NDArray[np.int_]]:
    """Return grid parameters (N + 1,) and the piece of every cell (N,)."""
    breakpoints, duration = curve.breakpoints, curve.duration
    cells = np.maximum(CELLS_A_PIECE, np.ceil(points * np.diff(breakpoints) / duration)).astype(int)
    values = [np.linspace(breakpoints[k], breakpoints[k + 1], cells[k] + 1)[:-1] for k in range(len(cells))]
    if dense_ends:
        z = np.linspace(0.0, 1.0, points + 1)
        values = [breakpoints[0] + duration * z**3 * (10.0 - 15.0 * z + 6.0 * z**2), breakpoints]
    grid = np.concatenate([*values, _reversals(curve), breakpoints[-1:]])
    grid = np.unique(grid)
    keep = np.append(np.diff(grid) > 1e-9 * duration, True)
    exact = np.isin(grid, breakpoints)
    keep |= exact
    keep[:-1] &= ~(~exact[:-1] & exact[1:] & (np.diff(grid) <= 1e-9 * duration))
    keep[1:] &= ~(~exact[1:] & exact[:-1] & (np.diff(grid) <= 1e-9 * duration))
    grid = grid[keep]
    middles = 0.5 * (grid[1:] + grid[:-1])
    return grid, np.searchsorted(breakpoints, middles, side="right") - 1


def _reversals(curve: Trajectory) -> Array:
    """Return the parameters at which a joint that moves changes its direction."""
    velocity = curve.derivative_coefficients(1)
    found = []
    for piece in range(velocity.shape[0]):
        span = curve.breakpoints[piece + 1] - curve.breakpoints[piece]
        scaled = velocity[piece] * span ** np.arange(velocity.shape[2])
        moving = np.abs(scaled).max(axis=1) > 1e-12 * max(np.abs(scaled).max(), 1e-300)
        rows = scaled[moving & ~_keep_their_sign(scaled)]
        roots = [_quadratic_roots(rows)] if rows.shape[1] == 3 else [_roots_inside(row) for row in rows]
        found += [curve.breakpoints[piece] + span * real for real in roots]
    return np.concatenate(found) if found else np.empty(0)


def _keep_their_sign(polynomials: Array) -> npt.NDArray[np.bool_]:
    """Return which polynomials (n, degree + 1) surely have no root in [0, 1], (n,): by Bernstein coefficients."""
    degree = polynomials.shape[1] - 1
    matrix = np.array([[comb(j, i) / comb(degree, i) for i in range(degree + 1)] for j in range(degree + 1)])
    bernstein = polynomials @ matrix.T
    least, most = bernstein.min(axis=1), bernstein.max(axis=1)
    clear = 1e-9 * np.abs(bernstein).max(axis=1)
    return np.asarray((least > clear) | (most < -clear))


def _quadratic_roots(rows: Array) -> Array:
    """Return all real roots in (0, 1) of quadratics (n, 3) with ascending coefficients, without cancellation."""
    c, b, a = rows.T
    square = b**2 - 4.0 * a * c
    with np.errstate(divide="ignore", invalid="ignore"):
        far = -0.5 * (b + np.copysign(np.sqrt(square), b))
        roots = np.concatenate([far / a, c / far])
    return np.asarray(roots[(roots > 1e-9) & (roots < 1 - 1e-9)])


def _roots_inside(row: Array) -> Array:
    """Return the real roots in (0, 1) of a polynomial with ascending coefficients.

    Leading coefficients that are rounding errors would spoil the companion matrix and are left out there; Newton
    steps on the full polynomial make up for what that changes.
    """
    polynomial = np.polynomial.polynomial
    kept = np.trim_zeros(np.where(np.abs(row) > 1e-11 * np.abs(row).max(), row, 0.0), "b")
    roots = polynomial.polyroots(kept)
    real = roots[np.abs(roots.imag) < 1e-7].real
    slope = polynomial.polyder(row)
    for _ in range(3):
        steep = polynomial.polyval(real, slope)
        step = polynomial.polyval(real, row) / np.where(steep == 0, np.inf, steep)
        real = real - np.clip(step, -1e-3, 1e-3)
    return np.asarray(real[(real > 1e-9) & (real < 1 - 1e-9)])


def _evaluate(coefficients: Array, local: Array) -> Array:
    """Evaluate (N, n, degree + 1) ascending coefficients at (N,) local parameters."""
    values = coefficients[:, :, -1]
    for power in range(coefficients.shape[2] - 2, -1, -1):
        values = values * local[:, None] + coefficients[:, :, power]
    return values


def _cell_lengths(curve: Trajectory, breaks: Array, pieces: npt.NDArray[np.int_]) -> tuple[Array, Array]:
    """Return the velocity (N, n) by the parameter at the cells' middles and the cells' arc lengths (N,)."""
    velocity = curve.derivative_coefficients(1)[pieces]
    start = breaks[:-1] - curve.breakpoints[pieces]
    width = np.diff(breaks)
    lengths = np.zeros(len(pieces))
    for node, weight in zip(_NODES, _WEIGHTS):
        speed = np.linalg.norm(_evaluate(velocity, start + 0.5 * (1 + node) * width), axis=1)
        lengths += 0.5 * weight * width * speed
    return _evaluate(velocity, start + 0.5 * width), lengths


def _arc_derivatives(
    curve: Trajectory, pieces: npt.NDArray[np.int_], breaks: Array, end: int
) -> tuple[Array, Array]:
    """Return unit tangent and curvature by arc length, each (N, n), at one end of every cell.

    Where the parameter's speed vanishes the tangent is its limit from inside the cell, along the first derivative
    that does not vanish; the curvature there is unbounded, but multiplies a path speed of zero, and is set to 0.
    """
    local = breaks[end] - curve.breakpoints[pieces]
    inward = 1.0 if end == 0 else -1.0
    derivatives = [
        _evaluate(curve.derivative_coefficients(order)[pieces], local)
        for order in range(1, max(curve.degree, 2) + 1)
    ]
    width = breaks[1] - breaks[0]
    sizes = np.stack(
        [np.linalg.norm(value, axis=1) * width**order for order, value in enumerate(derivatives)], axis=1
    )
    first = np.argmax(sizes > 1e-7 * sizes.max(axis=1, keepdims=True), axis=1)
    direction = np.take_along_axis(np.stack(derivatives, axis=1), first[:, None, None], axis=1)[:, 0]
    direction = direction * (inward**first)[:, None]
    tangent = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    along = np.sum(derivatives[1] * tangent, axis=1, keepdims=True) * tangent
    speed = np.where(first == 0, np.linalg.norm(derivatives[0], axis=1), np.inf)
    return tangent, (derivatives[1] - along) / speed[:, None] ** 2
