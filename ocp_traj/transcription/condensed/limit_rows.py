"""Bounds, scales and labels of the rows of one limit, and how far values are outside them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.transcription.nlp import RowBlock

Side = tuple[Any, Any, Any]


@dataclass(frozen=True, eq=False)
class LimitRows:
    """Bounds, scale and labels of the rows of one limit, k values at N points of S segments.

    Rows run over values first and segments last.

    Attributes
    ----------
    name : str
    joints : (k,) joint of each value, -1 where none
    lower, upper : (k, S) bounds divided by `scale`
    scale : (k, S)
    fractions : (N,) of the segment; for exact extrema the two rows (largest, smallest) say 0 and 1
    per_gap : int
        Segments a gap.
    """

    name: str
    joints: Any
    lower: Array
    upper: Array
    scale: Array
    fractions: tuple[float, ...]
    per_gap: int

    @classmethod
    def of(
        cls,
        name: str,
        joints: Any,
        bounds: Array,
        scale: Array,
        fractions: tuple[float, ...],
        per_gap: int,
    ) -> LimitRows:
        """Build a block from (S, 2, k) bounds and the (S, k) scales of the values."""
        lower, upper = (bounds[:, 0] / scale).T, (bounds[:, 1] / scale).T
        return cls(name, np.asarray(joints), lower, upper, scale.T, fractions, per_gap)

    @cached_property
    def shape(self) -> tuple[int, int, int]:
        """(k, N, S)."""
        return self.scale.shape[0], len(self.fractions), self.scale.shape[1]

    @cached_property
    def size(self) -> int:
        """Number of rows."""
        return int(np.prod(self.shape))

    def row_bounds(self) -> tuple[Array, Array]:
        """Return the lower and the upper bound of every row, (rows,) each."""
        lower, upper = (np.broadcast_to(side[:, None], self.shape) for side in (self.lower, self.upper))
        return lower.ravel(), upper.ravel()

    def row_block(self) -> RowBlock:
        """Return the labels, one a row."""
        width, points, segments = self.shape
        segment = np.tile(np.arange(segments), width * points)
        fraction = np.tile(np.repeat(self.fractions, segments), width)
        inside = (segment % self.per_gap + fraction) / self.per_gap
        return RowBlock(self.name, np.repeat(self.joints, points * segments), segment // self.per_gap, inside)

    @cached_property
    def sides(self) -> list[Side]:
        """Return 1 / scale, lower and upper bound of each value: numbers, or (S, 1) where segments differ."""
        columns = (1.0 / self.scale, self.lower, self.upper)
        if all((column == column[:, :1]).all() for column in columns):
            return [tuple(float(column[k, 0]) for column in columns) for k in range(len(self.scale))]  # type: ignore[misc]
        return [tuple(column[k][:, None] for column in columns) for k in range(len(self.scale))]

    def write_over(self, k: int, values: Array, out: Array) -> None:
        """Write max(value / scale - upper, lower - value / scale, 0) of value k.

        Parameters
        ----------
        k : int
        values, out : (N, S, p)
        """
        inverse, lower, upper = self.sides[k]
        np.multiply(values, inverse, out=out)
        if isinstance(lower, float) and lower == -upper:
            np.absolute(out, out=out)
            out -= upper
        else:
            below = lower - out
            out -= upper
            np.maximum(out, below, out=out)
        np.maximum(out, 0.0, out=out)

    def ratio(self, k: int, values: Array) -> Array:
        """Return each candidate's largest value over its bound on its own side, (p,); 0/0 counts as 0."""
        inverse, lower, upper = self.sides[k]
        axes = tuple(range(values.ndim - 1))
        if isinstance(lower, float) and lower == -upper:
            largest: Array = np.absolute(values).max(axis=axes)
            return largest * (inverse / upper) if upper > 0 else np.where(largest > 0, np.inf, 0.0)
        scaled = values * inverse
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.maximum(scaled / upper, scaled / lower)
        ratio[values == 0] = 0.0
        return ratio.max(axis=axes)
