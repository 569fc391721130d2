"""Functions of an instant composed with the motion: c(u(z)), u the motion at a sample, z the knot states around it.

Derivatives are composed by hand, J_u' H J_u + sum_i w_i Hess u_i with w = J' lambda: differentiating through inverse
dynamics in all local variables at once would cost ten times more.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.transcription.lifted.chain import chain_value
from ocp_traj.transcription.lifted.elements import (
    IndexArray,
    Places,
    apply_mapped,
    gather,
    nonzeros,
    ordered_triplets,
    pattern,
    spread_triplets,
)
from ocp_traj.transcription.lifted.instant_derivatives import Outer
from ocp_traj.transcription.lifted.layout import Layout

Pattern = tuple[tuple[int, ...], tuple[int, ...]]
"""Rows and columns of nonzeros."""


@dataclass(frozen=True, eq=False)
class MotionMap:
    """The motion at a sample as a function u(z, parameters), and its composition with an outer function.

    Local variables z: scaled duration, then for every moving joint its p scaled states at the start of the segment
    and the highest one at its end; at a knot (`at_knot`) only the duration and the states q, v, a there. Parameters:
    fraction, weight of the quadrature, scale of the duration, scales of the states (p of every moving joint),
    positions of all joints (used for those that stay), scales of the values.
    """

    functions: dict[str, Any]
    jacobian_pattern: tuple[IndexArray, IndexArray]
    hessian_pattern: tuple[IndexArray, IndexArray]
    needs_first: bool
    """Whether the Hessian needs the outer function's Jacobian."""


@dataclass(frozen=True)
class MotionKind:
    """What the local variables of a `MotionMap` are, and whether its values are integrated.

    Attributes
    ----------
    degree, n : int
    moving : tuple of int
    orders : int
        3 for q, v, a; 4 with the jerk.
    at_knot : bool
    integrate : bool
        Values are multiplied by the weight of the quadrature and the duration of the segment.
    """

    degree: int
    n: int
    moving: tuple[int, ...]
    orders: int
    at_knot: bool
    integrate: bool


@lru_cache(maxsize=64)
def _motion_map(kind: MotionKind, rows: int, outer_jacobian: Pattern, outer_hessian: Pattern) -> MotionMap:
    parameters = ca.SX.sym("parameters", 3 + kind.degree * len(kind.moving) + kind.n + rows)
    local, motion = _motion(kind, parameters)
    inner = ca.jacobian(motion, local)
    values, first = ca.SX.sym("c", rows), ca.SX.sym("j", len(outer_jacobian[0]))
    second, multipliers = ca.SX.sym("h", len(outer_hessian[0])), ca.SX.sym("lambda", rows)
    derivative = _fill(rows, motion.numel(), outer_jacobian, first)
    curvature = _fill(motion.numel(), motion.numel(), outer_hessian, second)
    curvature = ca.triu2symm(curvature) if len(outer_hessian[0]) else curvature
    compose = _integrated if kind.integrate else _scaled
    slope = ca.mtimes(derivative, inner)
    value, weights, jacobian, extra = compose(local, parameters, values, multipliers, slope)
    fixed = ca.SX.sym("w", motion.numel())
    own = ca.hessian(ca.dot(fixed, motion), local)[0]
    turned = ca.substitute(own, fixed, ca.densify(ca.mtimes(derivative.T, weights)))
    hessian = ca.triu(ca.mtimes([inner.T, curvature, inner]) + turned + extra)
    arguments = [local, parameters]
    functions = {
        "motion": ca.Function("motion", arguments, [motion]),
        "weights": ca.Function("motion_weights", [*arguments, multipliers], [weights]),
        "value": ca.Function("motion_value", [*arguments, values], [value]),
        "jacobian": ca.Function("motion_jacobian", [*arguments, values, first], [nonzeros(jacobian)]),
        "hessian": ca.Function(
            "motion_hessian", [*arguments, first, second, multipliers], [nonzeros(hessian)]
        ),
    }
    return MotionMap(functions, pattern(jacobian), pattern(hessian), kind.integrate or own.nnz() > 0)


def _scaled(local: Any, parameters: Any, values: Any, multipliers: Any, slope: Any) -> tuple[Any, ...]:
    """Return c / scale, the weights of c's Hessian, the Jacobian, and what else the Hessian has: nothing.

    `slope` is the derivative of c by the local variables.
    """
    scale = parameters[-values.numel() :]
    jacobian = slope / ca.repmat(scale, 1, local.numel())
    return values / scale, multipliers / scale, jacobian, ca.SX(local.numel(), local.numel())


def _integrated(local: Any, parameters: Any, values: Any, multipliers: Any, slope: Any) -> tuple[Any, ...]:
    """Return the same as `_scaled` of weight * duration * c / scale; the duration is a local variable, too."""
    factor = parameters[1] * parameters[2] / parameters[-values.numel() :]
    unit = ca.SX(1, local.numel())
    unit[0] = 1
    jacobian = local[0] * slope + ca.mtimes(values, unit)
    jacobian = ca.repmat(factor, 1, local.numel()) * jacobian
    cross = ca.mtimes([unit.T, (factor * multipliers).T, slope])
    return factor * local[0] * values, factor * local[0] * multipliers, jacobian, cross + cross.T


def _fill(rows: int, columns: int, places: Any, values: Any) -> Any:
    sparsity = ca.Sparsity.triplet(rows, columns, list(places[0]), list(places[1]))
    return ca.SX(sparsity, values) if len(places[0]) else ca.SX(rows, columns)


def _motion(kind: MotionKind, parameters: Any) -> tuple[Any, Any]:
    """Return the local variables and (q, v, a[, jerk]) of all joints."""
    degree, moving, orders = kind.degree, kind.moving, range(kind.orders)
    h = ca.SX.sym("h")
    per_joint = [ca.SX.sym(f"states{joint}", len(orders) if kind.at_knot else degree + 1) for joint in moving]
    positions = parameters[3 + degree * len(moving) :]
    columns = [[positions[i] if order == 0 else ca.SX(0) for i in range(kind.n)] for order in orders]
    for index, joint in enumerate(moving):
        scales = parameters[3 + degree * index : 3 + degree * (index + 1)]
        states = per_joint[index]
        if kind.at_knot:
            for order in orders:
                columns[order][joint] = states[order] * scales[order]
            continue
        known = [states[order] * scales[order] for order in range(degree)]
        top = (states[degree] - states[degree - 1]) * scales[degree - 1]
        for order in orders:
            columns[order][joint] = chain_value(
                degree, order, parameters[0], h * parameters[2], known[order:], top
            )
    motion = ca.vertcat(*[entry for column in columns for entry in column])
    return ca.vertcat(h, *per_joint), motion


class Composed(Places):
    """An outer function at N samples of the motion.

    Parameters
    ----------
    layout : Layout
    outer : Outer
    at : (N, 2) array of (segment, fraction); with `at_knot` the fraction is 0, or 1 in the last segment
    scale : (rows,)
        Divides the values.
    weights : (N,), optional
        Makes the value weight * duration of the segment (s) * c(u): a term of a quadrature.
    at_knot : bool
        All samples are knots: the states there are variables themselves.
    needs_jerk : bool
    """

    def __init__(
        self,
        layout: Layout,
        outer: Outer,
        at: Array,
        scale: Array,
        *,
        weights: Array | None = None,
        at_knot: bool = False,
        needs_jerk: bool = False,
    ) -> None:
        self.outer = outer
        self.count, self.rows = len(at), outer.rows
        segment = at[:, 0].astype(np.int64)
        self.variables = _variables(layout, segment, at[:, 1], at_knot)
        constants = np.concatenate(
            [[layout.duration_scale], layout.state_scales.T.ravel(), layout.task.waypoints[0], scale]
        )
        quadrature = np.zeros(self.count) if weights is None else weights
        self.parameters = np.column_stack([at[:, 1], quadrature, np.tile(constants, (self.count, 1))])
        moving = tuple(int(joint) for joint in layout.moving)
        orders, integrate = 4 if needs_jerk else 3, weights is not None
        self.map = _motion_map(
            MotionKind(layout.degree, layout.task.n, moving, orders, at_knot, integrate),
            outer.rows,
            _hashable(outer.jacobian_pattern),
            _hashable(outer.hessian_pattern),
        )

    def call(self, what: str, x: Any, multipliers: Any = None) -> Any:
        """Return mapped values; see `Places.call`."""
        arguments = [gather(x, self.variables), ca.DM(self.parameters.T)]
        own, outer = self.map.functions, self.outer.functions
        u = self._mapped(own["motion"], *arguments)
        if what == "hessian":
            shaped = ca.reshape(multipliers, self.rows, self.count)
            weights = self._mapped(own["weights"], *arguments, shaped)
            first = ca.DM.zeros(len(self.outer.jacobian_pattern[0]), self.count)
            if self.map.needs_first:
                first = self._mapped(outer["jacobian"], u)
            second = self._mapped(outer["hessian"], u, weights)
            return ca.vec(self._mapped(own["hessian"], *arguments, first, second, shaped))
        values = self._mapped(outer["value"], u)
        if what == "value":
            return ca.vec(self._mapped(own["value"], *arguments, values))
        first = self._mapped(outer["jacobian"], u)
        return ca.vec(self._mapped(own["jacobian"], *arguments, values, first))

    def _mapped(self, function: Any, *arguments: Any) -> Any:
        return apply_mapped(function, self.count, *arguments)

    def jacobian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """See `Places.jacobian_triplets`."""
        return spread_triplets(self.variables, self.rows, self.map.jacobian_pattern)

    def hessian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """See `Places.hessian_triplets`."""
        return ordered_triplets(self.variables, self.map.hessian_pattern)


def _variables(layout: Layout, segment: IndexArray, fraction: Array, at_knot: bool) -> IndexArray:
    """Return the (N, nz) indices of the local variables of `MotionMap`."""
    column = segment[:, None]
    parts = [column]
    knot = column + (fraction[:, None] == 1.0) if at_knot else column
    for joint in range(len(layout.moving)):
        if at_knot:
            parts.append(layout.state(knot, joint, np.arange(3)[None, :]))
        else:
            parts.append(layout.state(column, joint, np.arange(layout.degree)[None, :]))
            parts.append(layout.state(column + 1, joint, layout.degree - 1))
    return np.concatenate(parts, axis=1)


def _hashable(places: tuple[IndexArray, IndexArray]) -> Pattern:
    rows, columns = (tuple(int(index) for index in part) for part in places)
    return rows, columns


class Split(Places):
    """Rows value - plus + minus = 0 at every place: with plus, minus >= 0 the kinks of |value| and max(value, 0).

    Where plus + minus has a cost, the smaller of the two vanishes at an optimum, so |value| = plus + minus.

    Parameters
    ----------
    values : Composed
    plus, minus : (N, rows) indices of the variables
    """

    def __init__(self, values: Composed, plus: IndexArray, minus: IndexArray) -> None:
        self.values, self.plus, self.minus = values, plus, minus
        self.count, self.rows = values.count, values.rows

    def call(self, what: str, x: Any, multipliers: Any = None) -> Any:
        """Return mapped values; see `Places.call`."""
        inner = self.values.call(what, x, multipliers)
        if what == "value":
            return inner - ca.vec(gather(x, self.plus)) + ca.vec(gather(x, self.minus))
        if what == "jacobian":
            shaped = ca.reshape(inner, -1, self.count)
            ones = ca.DM.ones(self.rows, self.count)
            return ca.vec(ca.vertcat(shaped, -ones, ones))
        return inner

    def jacobian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """See `Places.jacobian_triplets`."""
        row, column = self.values.map.jacobian_pattern
        width = self.values.variables.shape[1]
        own = np.arange(self.rows)
        local = (
            np.concatenate([row, own, own]),
            np.concatenate([column, width + own, width + self.rows + own]),
        )
        variables = np.concatenate([self.values.variables, self.plus, self.minus], axis=1)
        return spread_triplets(variables, self.rows, local)

    def hessian_triplets(self) -> tuple[IndexArray, IndexArray]:
        """See `Places.hessian_triplets`."""
        return self.values.hessian_triplets()
