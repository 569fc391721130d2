"""The best uniform speed of a motion from rest to rest, for a population at once.

With u = 1 / s^2 the torque at a sample is g + u c (g: gravity, c: the rest at s = 1), plus viscous friction, which
goes with sqrt(u), plus Coulomb friction, which does not change. Torque limits bound u; kinematic limits bound s.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.constraints.cartesian_speed import CartesianSpeedLimit
from ocp_traj.constraints.torque import TorqueLimit
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.batch import CurveBatch
from ocp_traj.transcription.rows import Block, CondensedRows, Samples

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
STEPS = 45
"""Golden-section steps: the bracket shrinks by 4e-10."""

WIDEST = 50.0
"""Largest slowing tried for costs other than time when no duration bound ends the search."""


@dataclass(frozen=True)
class TorqueParts:
    """Torque at scale s: still + damping / s + moving / s^2, each (S, N, p, n)."""

    still: Array
    damping: Array | None
    moving: Array

    def at(self, root: Array) -> Array:
        """Return the torques at sqrt(u) = 1 / s of every candidate, (p,)."""
        r = root[None, None, :, None]
        torque: Array = self.still + self.moving * r**2
        return torque if self.damping is None else torque + self.damping * r


class Scaling:
    """Finds, for every candidate, the smallest feasible or the cheapest feasible uniform slowing."""

    def __init__(self, task: TrajectoryTask, rows: CondensedRows) -> None:
        self.task, self.rows = task, rows
        self.position_blocks = [entry.block for entry in rows.kinematic if entry.limit.order == 0]
        self.needs_search = bool(rows.squared or rows.terms)

    def best(self, curves: CurveBatch, samples: Samples) -> tuple[Array, Array, Array]:
        """Return the scale, the cost there and the excess of gravity over the torque limits, each (p,)."""
        parts = self._torque_parts(samples) if self.task.needs_torque else None
        lowest, gravity = self._lowest(curves, samples, parts)
        low, high = np.asarray(self.task.objective.duration)
        total = curves.durations.sum(axis=1)
        lowest = np.maximum(lowest, low / total)
        for gap, (shortest, _) in enumerate(np.asarray(self.task.objective.gap_durations)):
            if shortest > 0:
                part = curves.durations[:, gap * self.rows.per_gap : (gap + 1) * self.rows.per_gap].sum(
                    axis=1
                )
                lowest = np.maximum(lowest, shortest / part)
        lowest = np.where((lowest > 0) & np.isfinite(lowest), lowest, 1.0)
        if not self.needs_search:
            return lowest, self.task.objective.time * total * lowest, gravity
        highest = np.maximum(np.minimum(high / total, WIDEST * lowest), lowest)
        scale, cost = self._search(curves, samples, parts, lowest, highest)
        return scale, cost, gravity

    def _torque_parts(self, samples: Samples) -> TorqueParts:
        still, full = samples.static_torque, samples.torque
        robot = self.task.robot
        assert robot is not None
        v = samples.motion(1)
        damping = None
        if np.any(robot.friction.viscous):
            damping = robot.friction.viscous * v
        if np.any(robot.friction.coulomb):
            still = still + robot.friction.coulomb * np.sign(v)
        moving = full - still if damping is None else full - still - damping
        return TorqueParts(still, damping, moving)

    def _lowest(self, curves: CurveBatch, samples: Samples, parts: TorqueParts | None) -> tuple[Array, Array]:
        p = curves.durations.shape[0]
        lowest, gravity = np.zeros(p), np.zeros(p)
        for entry in self.rows.kinematic:
            if entry.limit.order > 0:
                ratio = entry.block.ratio(entry.values(curves))
                lowest = np.maximum(lowest, ratio ** (1.0 / entry.limit.order))
        for rows in self.rows.instants:
            if isinstance(rows.constraint, CartesianSpeedLimit):
                squared = self.rows.instant_values(rows, samples)
                lowest = np.maximum(lowest, np.sqrt(rows.block.ratio(squared)))
            elif isinstance(rows.constraint, TorqueLimit):
                assert parts is not None
                fastest, gravity = self._fastest_root(parts, rows.block)
                with np.errstate(divide="ignore"):
                    lowest = np.maximum(lowest, 1.0 / fastest)
        return lowest, gravity

    def _fastest_root(self, parts: TorqueParts, block: Block) -> tuple[Array, Array]:
        """Return the largest sqrt(u) the torque limits allow, and by how much gravity alone exceeds them, (p,)."""
        still, moving = parts.still[..., block.joints], parts.moving[..., block.joints]
        damping = None if parts.damping is None else parts.damping[..., block.joints]
        upper = (block.upper * block.scale)[:, None, None, :]
        lower = (block.lower * block.scale)[:, None, None, :]
        scale = block.scale[:, None, None, :]
        excess = np.maximum(np.maximum(still - upper, lower - still) / scale, 0.0)
        fastest = np.full(still.shape, np.inf)
        for sign, limit in ((1.0, upper), (-1.0, -lower)):
            room = np.maximum(limit - sign * still, 0.0)
            fastest = np.minimum(
                fastest, _positive_root(sign * moving, None if damping is None else sign * damping, room)
            )
        return fastest.min(axis=(0, 1, 3)), excess.max(axis=(0, 1, 3))

    def _search(
        self, curves: CurveBatch, samples: Samples, parts: TorqueParts | None, lowest: Array, highest: Array
    ) -> tuple[Array, Array]:
        """Golden-section search in u = 1 / s^2, where time, energy and smoothness are all convex."""
        cost_at = self._cost_function(curves, samples, parts)
        left, right = highest**-2.0, lowest**-2.0
        inner = right - GOLDEN * (right - left)
        outer = left + GOLDEN * (right - left)
        at_inner, at_outer = cost_at(inner), cost_at(outer)
        for _ in range(STEPS):
            keep_left = at_inner < at_outer
            right = np.where(keep_left, outer, right)
            left = np.where(keep_left, left, inner)
            fresh = np.where(keep_left, right - GOLDEN * (right - left), left + GOLDEN * (right - left))
            value = cost_at(fresh)
            outer, at_outer, inner, at_inner = (
                np.where(keep_left, inner, fresh),
                np.where(keep_left, at_inner, value),
                np.where(keep_left, fresh, outer),
                np.where(keep_left, value, at_outer),
            )
        candidates = np.stack([lowest**-2.0, (left + right) / 2, highest**-2.0])
        costs = np.stack([cost_at(u) for u in candidates])
        chosen = costs.argmin(axis=0)
        column = np.arange(len(chosen))
        return candidates[chosen, column] ** -0.5, costs[chosen, column]

    def _cost_function(self, curves: CurveBatch, samples: Samples, parts: TorqueParts | None) -> Any:
        """Return the cost (p,) as a function of u (p,), with everything that does not depend on u computed once."""
        total = curves.durations.sum(axis=1)
        smooth = [(term.order, self.rows.squared_integral(term, curves)) for term in self.rows.squared]
        weights = self.rows.simpson[None, :, None] * curves.durations.T[:, None, :]
        v = samples.motion(1) if self.rows.terms else None

        def cost(u: Array) -> Array:
            root = np.sqrt(u)
            value = self.task.objective.time * total / root
            for order, integral in smooth:
                value = value + integral * root ** (2 * order - 1)
            if self.rows.terms:
                assert parts is not None and v is not None
                value = value + self._torque_cost(parts.at(root), v, root, weights)
            return value

        return cost

    def _torque_cost(self, tau: Array, v: Array, root: Array, weights: Array) -> Array:
        total = np.zeros(len(root))
        for entry in self.rows.terms:
            name = entry.term.name
            if name in ("energy", "energy_without_regeneration"):
                # The power goes with v / s and the time with s: the factors cancel.
                power = tau * v
                integrand = np.abs(power) if name == "energy" else np.maximum(power, 0.0)
                total = total + entry.weight * np.einsum("snpk,snp->p", integrand, weights)
            else:
                squares = tau**2 * self._square_factors(entry)
                total = total + entry.weight * np.einsum("snpk,snp->p", squares, weights) / root
        return total

    def _square_factors(self, entry: Any) -> Array:
        """Return the factors f with integrand sum f tau^2 of the terms quadratic in the torque."""
        from ocp_traj.objectives.motor_loss import loss_factors
        from ocp_traj.objectives.torque import torque_scales

        if entry.term.name == "motor_loss":
            assert self.task.objective.motor is not None
            return loss_factors(self.task.objective.motor, self.task.n)
        return torque_scales(self.task) ** -2.0


def _positive_root(quadratic: Array, linear: Array | None, room: Array) -> Array:
    """Return the largest r >= 0 with quadratic r^2 + linear r <= room everywhere below it; room >= 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        if linear is None:
            root = np.where(quadratic > 0, np.sqrt(room / quadratic), np.inf)
        else:
            discriminant = linear**2 + 4 * quadratic * room
            reached = (discriminant >= 0) & ((quadratic > 0) | (linear > 0))
            root = np.where(reached, 2 * room / (linear + np.sqrt(np.maximum(discriminant, 0.0))), np.inf)
            root = np.where(reached & (root < 0), np.inf, root)
    return np.where(np.isnan(root), 0.0, root)
