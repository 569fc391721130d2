"""The best uniform speed of a motion from rest to rest, for a population at once.

At scale s of the durations, with r = 1 / s, the torque at a sample is still + damping r + moving r^2 (still: gravity
and Coulomb friction; damping: viscous friction). Torque limits bound r; so do kinematic limits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.costs import InstantCost
from ocp_traj.exceptions import InputError
from ocp_traj.quantities import SpeedLaw
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.batch import CurveBatch
from ocp_traj.transcription.condensed.best_speed import POWERS, Kinks, SpeedCost, cheapest_root, row_of
from ocp_traj.transcription.condensed.limit_rows import LimitRows
from ocp_traj.transcription.condensed.rows import CondensedRows, InstantTerm
from ocp_traj.transcription.condensed.samples import Samples

WIDEST = 50.0
"""Largest slowing tried for costs other than time when no duration bound ends the search."""


UNKNOWN = SpeedLaw(torque=-1)
"""Law of what does not state one."""


@dataclass(frozen=True)
class TorqueParts:
    """Torque at scale s: still + damping / s + moving / s^2, each (n, N, S, p)."""

    still: Array
    damping: Array | None
    moving: Array


class Scaling:
    """Finds, for every candidate, the smallest feasible or the cheapest feasible uniform slowing.

    Raises
    ------
    InputError
        A limit or a cost does not say how it goes with the speed, or in a way that has no closed form here.
    """

    def __init__(self, task: TrajectoryTask, rows: CondensedRows) -> None:
        self.task, self.rows = task, rows
        self.limit_laws = [entry.limit.scaling(task) or UNKNOWN for entry in rows.instants]
        self.cost_laws = [entry.term.scaling(task) or UNKNOWN for entry in rows.terms]
        unknown = [
            *(e.limit.name for e, law in zip(rows.instants, self.limit_laws) if not _bounds_speed(law)),
            *(
                f"cost {e.term.name}"
                for e, law in zip(rows.terms, self.cost_laws)
                if not _has_closed_form(e.term, law)
            ),
        ]
        if unknown:
            raise InputError(
                f"the scaled encoding does not know how {unknown[0]} scales, expected encoding 'durations'"
            )
        self.needs_search = bool(rows.squared or rows.terms)

    def best(self, curves: CurveBatch, samples: Samples) -> tuple[Array, Array, Array]:
        """Return the scale, the cost there, and by how much limits are exceeded at any speed, each (p,)."""
        parts = self._torque_parts(samples) if self.task.needs_torque else None
        lowest, stuck = self._lowest(samples, parts)
        total = curves.h.sum(axis=0)
        shortest, longest = self._duration_scales(curves, total)
        lowest = np.maximum(lowest, shortest)
        hopeless = ~np.isfinite(lowest)
        stuck = np.where(hopeless, np.maximum(stuck, 1.0), stuck)
        lowest = np.where((lowest > 0) & ~hopeless, lowest, 1.0)
        if not self.needs_search:
            return lowest, self.task.objective.time * total * lowest, stuck
        highest = np.maximum(np.minimum(longest, WIDEST * lowest), lowest)
        cost = self._cost(curves, samples, parts, total)
        root = cheapest_root(cost, 1.0 / highest, 1.0 / lowest)
        return 1.0 / root, cost.at(root), stuck

    def _duration_scales(self, curves: CurveBatch, total: Array) -> tuple[Array, Array]:
        """Return the smallest and the largest scale the bounds of durations allow, (p,) each."""
        low, high = np.asarray(self.task.objective.duration)
        shortest, longest = low / total, high / total
        bounded = np.asarray(self.task.objective.gap_durations)
        for gap, (least, most) in enumerate(bounded):
            part = curves.h[gap * self.rows.per_gap : (gap + 1) * self.rows.per_gap].sum(axis=0)
            shortest, longest = np.maximum(shortest, least / part), np.minimum(longest, most / part)
        return shortest, longest

    def _torque_parts(self, samples: Samples) -> TorqueParts:
        still, full = samples.static_torque, samples.torque
        robot = self.task.robot
        assert robot is not None
        v = samples.motion(1)
        viscous, coulomb = (
            np.asarray(part)[:, None, None, None] for part in (robot.friction.viscous, robot.friction.coulomb)
        )
        if coulomb.any():
            still = still + coulomb * np.sign(v)
        if not viscous.any():
            return TorqueParts(still, None, full - still)
        damping = viscous * v
        return TorqueParts(still, damping, full - still - damping)

    def _lowest(self, samples: Samples, parts: TorqueParts | None) -> tuple[Array, Array]:
        """Return the smallest scale all limits allow and by how much gravity alone exceeds them, (p,) each."""
        p = samples.curves.h.shape[1]
        lowest, stuck = np.zeros(p), np.zeros(p)
        # From the highest derivative down: what is known then spares most of the velocities' extrema.
        for entry in reversed(self.rows.kinematic):
            order = entry.limit.order
            if order > 0:
                lowest = np.maximum(lowest, entry.ratio(samples, lowest**order) ** (1.0 / order))
        for rows, law in zip(self.rows.instants, self.limit_laws):
            if not law.torque:
                for k, values in enumerate(rows.values(samples)):
                    lowest = np.maximum(lowest, rows.block.ratio(k, values) ** (1.0 / law.speed))
            else:
                assert parts is not None
                fastest, stuck = fastest_root(parts, rows.block)
                with np.errstate(divide="ignore"):
                    lowest = np.maximum(lowest, 1.0 / fastest)
        return lowest, stuck

    def _cost(
        self, curves: CurveBatch, samples: Samples, parts: TorqueParts | None, total: Array
    ) -> SpeedCost:
        smooth = np.zeros((len(POWERS), len(total)))
        smooth[row_of(-1)] = self.task.objective.time * total
        for term in self.rows.squared:
            smooth[row_of(2 * term.order - 1)] += self.rows.squared_integral(term, curves)
        kinks: list[Kinks] = []
        for entry, law in zip(self.rows.terms, self.cost_laws):
            if not law.torque:
                integrand = self.rows.term_integrand(entry, samples)
                smooth[row_of(law.speed - 1)] += self.rows.integrate(integrand, curves.h)
                continue
            assert parts is not None
            weights = entry.weight * self.rows.simpson[:, None, None] * curves.h
            if law.speed:
                kinks.append(_power_kinks(entry, samples.motion(1), parts, weights, smooth))
            else:
                _add_squared_torque(law.factors, parts, weights, smooth)
        return SpeedCost(smooth, tuple(kinks))


def _bounds_speed(law: SpeedLaw) -> bool:
    """Return whether a limit on such a value has a largest speed in closed form."""
    return law.speed > 0 if not law.torque else (law.torque, law.speed) == (1, 0)


def _has_closed_form(cost: InstantCost, law: SpeedLaw) -> bool:
    """Return whether a cost is a power of the speed, a kinked sum of powers or a sum of squared torques."""
    if not law.torque:
        return law.speed in POWERS + 1
    if (law.torque, law.speed) == (1, 1):
        return cost.shape != "sum"
    return (law.torque, law.speed) == (2, 0) and cost.shape == "sum"


def fastest_root(parts: TorqueParts, block: LimitRows) -> tuple[Array, Array]:
    """Return the largest r the torque limits allow from standstill on, and the excess at r = 0, (p,) each.

    The excess is that of gravity and Coulomb friction over a limit, in units of the block's scale.
    """
    p = parts.still.shape[3]
    fastest, excess = np.full(p, np.inf), np.zeros(p)
    upper, lower = (side * block.scale for side in (block.upper, block.lower))
    for k, joint in enumerate(block.joints):
        still, moving = parts.still[joint], parts.moving[joint]
        scale, high, low = (side[k][:, None] for side in (block.scale, upper, lower))
        excess = np.maximum(excess, (np.maximum(still - high, low - still) / scale).max(axis=(0, 1)))
        above, below = np.maximum(high - still, 0.0), np.maximum(still - low, 0.0)
        if parts.damping is None:
            roots = _first_root(moving, np.where(moving > 0, above, below))
            fastest = np.minimum(fastest, roots.min(axis=(0, 1)))
            continue
        for sign, room in ((1.0, above), (-1.0, below)):
            roots = _first_damped_root(sign * moving, sign * parts.damping[joint], room)
            fastest = np.minimum(fastest, roots.min(axis=(0, 1)))
    return fastest, excess


def _first_root(moving: Array, room: Array) -> Array:
    """Return the r where |moving| r^2 reaches `room` >= 0; never where nothing moves."""
    with np.errstate(divide="ignore", invalid="ignore"):
        square = room / np.absolute(moving)
    return np.sqrt(np.where(moving == 0, np.inf, square))


def _first_damped_root(moving: Array, damping: Array, room: Array) -> Array:
    """Return the smallest r > 0 beyond which moving r^2 + damping r exceeds `room` >= 0."""
    discriminant = damping**2 + 4 * moving * room
    reached = (discriminant >= 0) & ((moving > 0) | (damping > 0))
    bottom = damping + np.sqrt(np.maximum(discriminant, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        # Without room a force that first falls is back at its start at r = -damping / moving.
        root = np.where(bottom > 0, 2 * room / bottom, -damping / moving)
    return np.where(reached, root, np.inf)


def _power_kinks(entry: InstantTerm, v: Array, parts: TorqueParts, weights: Array, smooth: Array) -> Kinks:
    """Return the kinks of an energy; the power goes with v r and the time with 1 / r, so the factors cancel."""
    p = v.shape[3]
    weighted = weights * v
    share = 1.0
    if entry.term.shape == "positive":
        # max(x, 0) = (x + |x|) / 2, and the sum of x is a polynomial.
        share = 0.5
        for power, part in ((0, parts.still), (1, parts.damping), (2, parts.moving)):
            if part is not None:
                smooth[row_of(power)] += share * np.einsum("insp,insp->p", weighted, part)
    flat = [
        None if part is None else part.reshape(-1, p) for part in (parts.still, parts.damping, parts.moving)
    ]
    magnitude = share * np.absolute(weighted).reshape(-1, p)
    assert flat[0] is not None and flat[2] is not None
    return Kinks(magnitude, flat[0], flat[1], flat[2])


def _add_squared_torque(factors: Array, parts: TorqueParts, weights: Array, smooth: Array) -> None:
    """Add sum weight f (still + damping r + moving r^2)^2 / r to the polynomial."""
    present = [(0, parts.still), (1, parts.damping), (2, parts.moving)]
    for power, part in present:
        for other, second in present:
            if part is not None and second is not None:
                product = np.einsum("insp,insp,i,nsp->p", part, second, factors, weights)
                smooth[row_of(power + other - 1)] += product


__all__ = ["Scaling", "TorqueParts", "fastest_root"]
