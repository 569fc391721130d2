"""What the builder of a lifted problem collects: rows with bounds and labels, slack variables, cost terms."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy.sparse as sparse

from ocp_traj.arrays import Array
from ocp_traj.transcription.lifted.assembly import WeightedPlaces
from ocp_traj.transcription.lifted.elements import Places
from ocp_traj.transcription.nlp import RowBlock


@dataclass
class Parts:
    """Rows, slacks and costs, in the order they were added.

    Attributes
    ----------
    size : int
        Number of variables, slacks included.
    places : list of Places
        Nonlinear rows.
    slack_starts : list of (k,)
        First values of the slack variables, all of them >= 0.
    costs : list of (Places with one value, weights)
    """

    size: int
    places: list[Places] = field(default_factory=list)
    slack_starts: list[Array] = field(default_factory=list)
    costs: list[WeightedPlaces] = field(default_factory=list)
    _bounds: list[tuple[Array, Array]] = field(default_factory=list)
    _labels: list[RowBlock] = field(default_factory=list)
    _linear: list[tuple[Array, Array]] = field(default_factory=list)
    _linear_bounds: list[tuple[Array, Array]] = field(default_factory=list)
    _linear_costs: list[tuple[Any, Array]] = field(default_factory=list)
    _linear_labels: list[RowBlock] = field(default_factory=list)

    def add(self, places: Places, lower: Any, upper: Any, label: RowBlock) -> None:
        """Add nonlinear rows with bounds broadcasting to (N, rows)."""
        shape = (places.count, places.rows)
        self.places.append(places)
        self._bounds.append((np.broadcast_to(lower, shape).ravel(), np.broadcast_to(upper, shape).ravel()))
        self._labels.append(label)

    def add_linear(self, columns: Any, values: Any, lower: Any, upper: Any, label: RowBlock) -> None:
        """Add linear rows: `columns` and `values` (R, k), bounds broadcasting to (R,)."""
        columns = np.asarray(columns)
        rows = len(columns)
        self._linear.append((columns, np.broadcast_to(values, columns.shape)))
        self._linear_bounds.append((np.broadcast_to(lower, (rows,)), np.broadcast_to(upper, (rows,))))
        self._linear_labels.append(label)

    def add_slacks(self, start: Array) -> Any:
        """Add slack variables >= 0 and return their indices, shaped as `start`."""
        indices = self.size + np.arange(start.size).reshape(start.shape)
        self.slack_starts.append(start.ravel())
        self.size += start.size
        return indices

    def add_linear_cost(self, columns: Any, values: Array) -> None:
        """Add values @ x[columns] to the cost."""
        self._linear_costs.append((columns, values))

    def linear_cost(self) -> Array:
        """Return the linear part of the cost, (size,)."""
        gradient = np.zeros(self.size)
        for columns, values in self._linear_costs:
            np.add.at(gradient, columns, values)
        return gradient

    def linear_matrix(self) -> sparse.csr_matrix:
        """Return the linear rows as a sparse matrix."""
        blocks = [
            sparse.csr_matrix(
                (values.ravel(), (np.repeat(np.arange(len(columns)), columns.shape[1]), columns.ravel())),
                shape=(len(columns), self.size),
            )
            for columns, values in self._linear
        ]
        return sparse.vstack(blocks, format="csr") if blocks else sparse.csr_matrix((0, self.size))

    def bounds(self) -> tuple[Array, Array]:
        """Return the bounds of all rows, nonlinear ones first."""
        pairs = [*self._bounds, *self._linear_bounds]
        if not pairs:
            return np.empty(0), np.empty(0)
        return np.concatenate([low for low, _ in pairs]), np.concatenate([high for _, high in pairs])

    def labels(self) -> list[RowBlock]:
        """Return the labels of all rows, nonlinear ones first."""
        return [*self._labels, *self._linear_labels]
