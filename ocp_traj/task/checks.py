"""What is refused of numbers, intervals, waypoints and families, before anything is computed."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array, ArrayLike, read_only
from ocp_traj.exceptions import TaskError
from ocp_traj.spline import Family


def numbers(key: str, value: ArrayLike) -> Array:
    """Return a value as an array of numbers, refused by its key where it is none."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TaskError(key, f"{value!r} given, expected numbers") from None


def expand_interval(key: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return lower and upper bounds of durations (..., 2), s, checked."""
    array = numbers(key, value)
    if array.shape != shape or np.isnan(array).any():
        raise TaskError(key, f"has shape {array.shape}, expected {shape}: lower and upper seconds")
    if (array[..., 0] < 0).any() or (array[..., 0] > array[..., 1]).any() or (array[..., 1] <= 0).any():
        raise TaskError(key, "expected 0 <= lower <= upper with upper above 0")
    return read_only(array)


def check_waypoints(waypoints: ArrayLike) -> Array:
    """Return the (K, n) waypoints of a task, K >= 2, all finite."""
    try:
        array = np.asarray(waypoints, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TaskError("waypoints", "rows differ in length or hold something else than numbers") from None
    if array.ndim != 2 or array.shape[1] < 1:
        raise TaskError("waypoints", f"have shape {array.shape}, expected (K, n): one row a waypoint")
    if len(array) < 2:
        raise TaskError("waypoints", f"{len(array)} given, expected at least 2")
    if not np.isfinite(array).all():
        row, joint = np.argwhere(~np.isfinite(array))[0]
        raise TaskError(
            "waypoints",
            f"waypoint {row + 1}, joint {joint + 1} is {array[row, joint]}, expected a finite number",
        )
    return read_only(array)


def check_family(family: Family, virtual_knots: int, count: int) -> None:
    """Refuse a family that is not made for so many virtual knots or waypoints."""
    if not isinstance(virtual_knots, int) or isinstance(virtual_knots, bool) or virtual_knots < 0:
        raise TaskError(
            "spline.virtual_knots", f"{virtual_knots!r} given, expected a whole number of 0 or more"
        )
    if virtual_knots and not family.takes_virtual_knots:
        raise TaskError("spline.virtual_knots", f"{virtual_knots} given, but {family} takes none")
    if count < family.least_waypoints:
        raise TaskError(
            "spline.family", f"{family} needs at least {family.least_waypoints} waypoints, {count} given"
        )
