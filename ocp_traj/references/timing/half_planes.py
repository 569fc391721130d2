"""Removing the half-planes that do not touch a polygon, for many small polygons at once."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from ocp_traj.arrays import Array

BoolArray: TypeAlias = npt.NDArray[np.bool_]

BOX = 1e4
"""Bound on the coordinates that makes every polygon bounded; coordinates of interest are of order one."""

_BLOCK = 16
"""Polygons handled at a time: their tables of pairs of rows then fit into the cache."""


def touching(normals: Array, offsets: Array, slack: float = 1e-9) -> tuple[BoolArray, BoolArray]:
    """Return which rows of {z >= 0: normals z <= offsets} touch their polygon.

    Parameters
    ----------
    normals : (N, r, 2) array
        Rows of N polygons in the plane; a row of zeros is never kept.
    offsets : (N, r) array
    slack : float
        Length by which an edge may miss the polygon and still be kept.

    Returns
    -------
    edges : (N, r) bool array
        Rows with an edge on the polygon. Of equal rows all are kept.
    empty : (N,) bool array
        Polygons without any point.
    """
    count = len(normals)
    sides = np.array([[-1.0, 0.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0]])
    rows = np.concatenate([normals, np.broadcast_to(sides, (count, 4, 2))], axis=1)
    bounds = np.concatenate([offsets, np.broadcast_to([0.0, 0.0, BOX, BOX], (count, 4))], axis=1)
    size = np.linalg.norm(rows, axis=2)
    nothing = size <= 1e-14
    rows = rows / np.where(nothing, 1.0, size)[:, :, None]
    bounds = np.where(nothing, np.where(bounds < 0, -1.0, 1.0), bounds / np.where(nothing, 1.0, size))
    near = _may_touch(rows, bounds, slack)
    edges = np.zeros(bounds.shape, dtype=bool)
    for first in range(0, count, _BLOCK):
        block = slice(first, first + _BLOCK)
        columns = np.flatnonzero(near[block].any(axis=0))
        start, end = clip_lines(rows[block][:, columns], bounds[block][:, columns])
        edges[block, columns] = end >= start - slack
    edges &= ~nothing
    empty: BoolArray = ~edges.any(axis=1) | (nothing & (bounds < 0)).any(axis=1)
    return edges[:, :-4], empty


def _may_touch(rows: Array, bounds: Array, slack: float) -> BoolArray:
    """Return which rows touch a box around the polygon in m = (z0 + z1) / 2 and d = z1 - z0, or define it, (N, r).

    The box follows from few rows; those are kept, so what does not touch it is redundant. It is thin where z0 and z1
    can hardly differ, as the squared speeds at both ends of a cell.
    """
    across, up = rows[:, :, 0], rows[:, :, 1]
    by_mean, by_difference = across + up, 0.5 * (up - across)
    places = np.arange(len(rows))
    near = np.zeros(bounds.shape, dtype=bool)

    def least(useful: BoolArray, factor: Array, room: Array) -> Array:
        value = np.where(useful, room / np.where(useful, factor, 1.0), np.inf)
        row = value.argmin(axis=1)
        near[places, row] = True
        return np.asarray(value[places, row])

    # with both factors at least 0 a row bounds either coordinate alone, as z >= 0
    first = least((across > 1e-12) & (up >= 0), across, bounds)
    mean = 0.5 * (first + least((up > 1e-12) & (across >= 0), up, bounds))
    room = bounds - np.minimum(by_mean * mean[:, None], 0.0)
    rise = least(by_difference > 1e-12, by_difference, room)
    fall = least(by_difference < -1e-12, -by_difference, room)
    farthest = np.maximum(by_mean * mean[:, None], 0.0)
    farthest = farthest + np.maximum(by_difference * rise[:, None], -by_difference * fall[:, None])
    near |= farthest >= bounds - 1e-6 - slack
    return near


def clip_lines(rows: Array, bounds: Array) -> tuple[Array, Array]:
    """Return the interval [start, end], (N, r) each, of every row's line that the other rows leave over.

    Row i's line is bounds_i rows_i + t along_i; row j cuts it at t with t (rows_j . along_i) = room_ij.
    """
    across, up = rows[:, :, 0], rows[:, :, 1]
    slope = across[:, :, None] * up[:, None, :] - up[:, :, None] * across[:, None, :]
    cosine = across[:, :, None] * across[:, None, :] + up[:, :, None] * up[:, None, :]
    room = bounds[:, None, :] - cosine * bounds[:, :, None]
    rising, falling = slope > 1e-12, slope < -1e-12
    parallel = ~(rising | falling)
    cut = room / np.where(parallel, 1.0, slope)
    end = np.where(rising, cut, np.inf).min(axis=2)
    start = np.where(falling, cut, -np.inf).max(axis=2)
    outside = (parallel & (room < -1e-12 * (1.0 + np.abs(bounds[:, None, :])))).any(axis=2)
    return np.where(outside, np.inf, start), np.where(outside, -np.inf, end)
