"""Symbolic functions of one instant of a motion: torques, powers, speeds and a user's own."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.constraints import SAMPLED_CONSTRAINTS, SampledConstraint, SymbolicSample
from ocp_traj.objectives import SAMPLED_TERMS, SampledTerm
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.chain import chain_value
from ocp_traj.transcription.elements import Formula
from ocp_traj.transcription.layout import Layout


@dataclass(frozen=True)
class Instant:
    """What a task asks of every instant.

    Attributes
    ----------
    constraints : constraints that apply
    terms : cost terms with weight
    needs_jerk : whether any of them needs the jerk
    """

    constraints: tuple[SampledConstraint, ...]
    terms: tuple[SampledTerm, ...]

    @property
    def needs_jerk(self) -> bool:
        """Whether any constraint needs the jerk."""
        return any(constraint.needs_jerk for constraint in self.constraints)

    def __bool__(self) -> bool:
        """Whether there is anything."""
        return bool(self.constraints or self.terms)


def instant_of(task: TrajectoryTask) -> Instant:
    """Return the sampled constraints and terms that apply to a task."""
    return Instant(
        tuple(constraint for constraint in SAMPLED_CONSTRAINTS if constraint.applies(task)),
        tuple(term for term in SAMPLED_TERMS if term.weight(task) > 0),
    )


def instant_function(task: TrajectoryTask, part: SampledConstraint | SampledTerm) -> Any:
    """Return the CasADi function (q, v, a, j) -> values of one constraint or term."""
    symbols = [ca.SX.sym(name, task.n) for name in "qvaj"]
    return ca.Function(part.name, symbols, [part.expression(SymbolicSample(task, *symbols))])


def state_formula(layout: Layout, function: Any, scale: Array, *, integrate: bool, needs_jerk: bool) -> Formula:
    """Compose a function of (q, v, a, j) with the motion at a fraction of a segment.

    Local variables: scaled duration, then for every moving joint its p scaled states at the start and the highest
    one at the end. Parameters: fraction, weight of the quadrature. The Hessian is composed by hand,
    J_u' H J_u + sum_i w_i Hess u_i with u = (q, v, a, j): differentiating through inverse dynamics in all local
    variables at once would cost ten times more.

    Parameters
    ----------
    scale : (rows,)
        Divides the values.
    integrate : bool
        Multiply the sum of the values by weight times duration: a term of a quadrature.
    """
    parameters = ca.SX.sym("parameters", 2)
    local, motion = _motion(layout, parameters[0], 4 if needs_jerk else 3)
    inner = ca.SX.sym("u", motion.numel())
    blocks = [inner[k * layout.task.n : (k + 1) * layout.task.n] for k in range(4 if needs_jerk else 3)]
    if not needs_jerk:
        blocks.append(ca.SX.zeros(layout.task.n))
    value = function(*blocks) / ca.DM(scale)
    if integrate:
        return _integrated(layout, local, parameters, motion, inner, ca.sum1(value))
    multipliers = ca.SX.sym("lambda", value.numel())
    derivative, curvature = _outer_derivatives(inner, value, multipliers)
    at = ca.Function("outer", [inner, multipliers], [value, derivative, curvature])
    outer_value, outer_derivative, outer_curvature = at(motion, multipliers)
    inner_jacobian = ca.jacobian(motion, local)
    weights = ca.mtimes(outer_derivative.T, multipliers)
    hessian = _composed_hessian(local, motion, inner_jacobian, outer_curvature, weights)
    jacobian = ca.mtimes(outer_derivative, inner_jacobian)
    return Formula(function.name(), local, parameters, outer_value, jacobian, (multipliers, hessian))


def _integrated(layout: Layout, local: Any, parameters: Any, motion: Any, inner: Any, value: Any) -> Formula:
    """Return weight * duration * value as a formula with one row."""
    multiplier = ca.SX.sym("lambda")
    derivative, curvature = _outer_derivatives(inner, value, ca.SX(1))
    at = ca.Function("outer", [inner], [value, derivative, curvature])
    outer_value, outer_derivative, outer_curvature = at(motion)
    inner_jacobian = ca.jacobian(motion, local)
    gradient = ca.mtimes(outer_derivative, inner_jacobian)
    hessian = _composed_hessian(local, motion, inner_jacobian, outer_curvature, outer_derivative.T)
    factor = parameters[1] * layout.duration_scale
    duration = local[0]
    unit = ca.SX(1, local.numel())
    unit[0] = 1
    jacobian = factor * (duration * gradient + outer_value * unit)
    cross = ca.mtimes(unit.T, gradient)
    full = factor * (duration * hessian + cross + cross.T)
    return Formula(
        "integrated", local, parameters, factor * duration * outer_value, jacobian, (multiplier, multiplier * full)
    )


def _outer_derivatives(inner: Any, value: Any, multipliers: Any) -> tuple[Any, Any]:
    return ca.jacobian(value, inner), ca.hessian(ca.dot(multipliers, value), inner)[0]


def _composed_hessian(local: Any, motion: Any, inner_jacobian: Any, curvature: Any, weights: Any) -> Any:
    fixed = ca.SX.sym("w", motion.numel())
    own = ca.hessian(ca.dot(fixed, motion), local)[0]
    second = ca.substitute(own, fixed, ca.densify(weights))
    return ca.mtimes([inner_jacobian.T, curvature, inner_jacobian]) + second


def _motion(layout: Layout, fraction: Any, orders: int) -> tuple[Any, Any]:
    """Return the local variables and (q, v, a[, j]) of all joints at `fraction`, as SX."""
    degree, task = layout.degree, layout.task
    h = ca.SX.sym("h")
    per_joint = [ca.SX.sym(f"states{joint}", degree + 1) for joint in layout.moving]
    duration = h * layout.duration_scale
    columns = [[ca.SX(float(value)) if order == 0 else ca.SX(0) for value in task.waypoints[0]] for order in range(orders)]
    for index, joint in enumerate(layout.moving):
        scales = layout.state_scales[:, index]
        states = [per_joint[index][j] * float(scales[j]) for j in range(degree)]
        top = (per_joint[index][degree] - per_joint[index][degree - 1]) * float(scales[degree - 1])
        for order in range(orders):
            columns[order][int(joint)] = chain_value(degree, order, fraction, duration, states[order:], top)
    motion = ca.vertcat(*[entry for column in columns for entry in column])
    return ca.vertcat(h, *per_joint), motion


def state_variables(layout: Layout, segments: Any) -> Any:
    """Return the (N, nz) variable indices of `state_formula` at N segments."""
    segments = np.asarray(segments)[:, None]
    parts = [segments]
    for joint in range(len(layout.moving)):
        parts.append(layout.state(segments, joint, np.arange(layout.degree)[None, :]))
        parts.append(layout.state(segments + 1, joint, layout.degree - 1))
    return np.concatenate(parts, axis=1)
