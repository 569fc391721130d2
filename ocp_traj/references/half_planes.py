"""Removing the half-planes that do not touch a polygon, for many small polygons at once."""

from __future__ import annotations

import numpy as np

from ocp_traj.arrays import Array

BOX = 1e4
"""Bound on the coordinates that makes every polygon bounded; coordinates of interest are of order one."""


def touching(normals: Array, offsets: Array, slack: float = 1e-9) -> tuple[Array, Array]:
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
    start, end = _clip_lines(rows, bounds)
    edges = (end >= start - slack) & ~nothing
    return edges[:, :-4], ~edges.any(axis=1) | (nothing & (bounds < 0)).any(axis=1)


def _clip_lines(rows: Array, bounds: Array) -> tuple[Array, Array]:
    """Return the interval [start, end], (N, r) each, of every row's line that the other rows leave over.

    Row i's line is bounds_i rows_i + t along_i; row j cuts it at t with t (rows_j . along_i) = room_ij.
    """
    along = np.stack([-rows[:, :, 1], rows[:, :, 0]], axis=2)
    slope = np.einsum("nix,njx->nij", along, rows)
    room = bounds[:, None, :] - np.einsum("nix,njx->nij", rows, rows) * bounds[:, :, None]
    parallel = np.abs(slope) <= 1e-12
    cut = room / np.where(parallel, 1.0, slope)
    end = np.where(~parallel & (slope > 0), cut, np.inf).min(axis=2)
    start = np.where(~parallel & (slope < 0), cut, -np.inf).max(axis=2)
    outside = (parallel & (room < -1e-12 * (1.0 + np.abs(bounds[:, None, :])))).any(axis=2)
    return np.where(outside, np.inf, start), np.where(outside, -np.inf, end)
