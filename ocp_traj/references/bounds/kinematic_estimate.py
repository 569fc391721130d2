"""The kinematic bound as a smooth problem, solved locally by IPOPT from several starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.deadline import NO_DEADLINE, Deadline
from ocp_traj.references.bounds.double_integrator import JointLimits

SMALLEST_SHARE = 1e-3
"""Share of the total that a gap without travel gets in a first guess: without any, its mean velocity has no value."""


@dataclass(frozen=True)
class LocalOptimum:
    """Durations (G,) s and velocities at the waypoints (G + 1, n) rad/s of a local optimum."""

    durations: Array
    velocities: Array

    @property
    def total(self) -> float:
        """Total duration, s."""
        return float(self.durations.sum())


@dataclass(frozen=True)
class LocalSearch:
    """How many starts there are, where they come from, and when to stop."""

    starts: int
    rng: np.random.Generator
    deadline: Deadline = NO_DEADLINE


def local_optimum(
    limits: JointLimits,
    search: LocalSearch,
    boxes: tuple[Array, Array] | None = None,
    known: LocalOptimum | None = None,
) -> LocalOptimum | None:
    """Return the best of several local optima over durations and waypoint velocities, or None.

    The first start is the motion `known`, if there is one; a start that is not expected to end in time is not made.

    A distance d can be travelled if and only if some plateau velocities w, z within the limits satisfy

        w h - (w - v0)^2 / 2A - (w - v1)^2 / 2B >= d,   z h + (z - v0)^2 / 2B + (z - v1)^2 / 2A <= d,

    and -B h <= v1 - v0 <= A h (acceleration A, deceleration B; see `double_integrator`): smooth, without cases.
    With a tolerance the distances are variables too, and the positions they add up to stay within `boxes`, the
    lowest and the highest position (G + 1, n) at every waypoint.
    """
    deadline = search.deadline
    problem = EstimateProblem(limits, boxes, deadline.left)
    best: LocalOptimum | None = None
    longest = 0.0
    for index in range(0 if known is None else -1, search.starts):
        if longest > deadline.left or deadline.passed:
            break
        begun = deadline.spent
        guess = problem.guess_from(known) if known is not None and index < 0 else None
        found = problem.solve(problem.first_guess(search.rng if index else None) if guess is None else guess)
        longest = max(longest, deadline.spent - begun)
        if found is not None and (best is None or found.total < best.total):
            best = found
    return best


class EstimateProblem:
    """The smooth problem in durations, velocities and plateau velocities, scaled to order one."""

    def __init__(self, limits: JointLimits, boxes: tuple[Array, Array] | None, seconds: float) -> None:
        import casadi as ca

        self.limits, self.boxes = limits, boxes
        gaps, n = limits.fastest.shape
        self.stops = stop_durations(limits)
        self.unit = float(self.stops.sum())
        h = ca.MX.sym("h", gaps)
        inner = ca.MX.sym("v", n, gaps - 1)
        high, low = ca.MX.sym("w", n, gaps), ca.MX.sym("z", n, gaps)
        distance = ca.MX.sym("d", n, gaps)
        velocities = ca.horzcat(ca.DM.zeros(n, 1), inner, ca.DM.zeros(n, 1))
        v0, v1 = velocities[:, :-1], velocities[:, 1:]
        hours = ca.repmat(h.T, n, 1)
        up, down = 0.5 / limits.speeding.T, 0.5 / limits.braking.T
        rows = [
            (high * hours - up * (high - v0) ** 2 - down * (high - v1) ** 2 - distance)
            / self._distance_scale(),
            (distance - low * hours - down * (low - v0) ** 2 - up * (low - v1) ** 2) / self._distance_scale(),
            hours - 2 * up * (v1 - v0),
            hours - 2 * down * (v0 - v1),
        ]
        variables = [h, inner, high, low, distance]
        if boxes is not None:
            position = ca.MX.sym("q", n)
            variables.append(position)
            lowest, highest = boxes
            for knot in range(gaps + 1):
                rows += [position - lowest[knot], highest[knot] - position]
                position = position + distance[:, knot] if knot < gaps else position
        x = ca.veccat(*variables)
        g = ca.veccat(*rows)
        options: dict[str, Any] = {
            "ipopt.print_level": 0,
            "print_time": False,
            "ipopt.sb": "yes",
            "ipopt.max_iter": 500,
            "ipopt.tol": 1e-10,
            "ipopt.mu_strategy": "monotone",
        }
        if np.isfinite(seconds):
            options["ipopt.max_wall_time"] = max(seconds, 1e-3)
        nlp: dict[str, Any] = {"x": x, "f": ca.sum1(h) / self.unit, "g": g}
        self.solver = ca.nlpsol("bound", "ipopt", nlp, options)
        self.lower, self.upper = self._bounds()

    def _distance_scale(self) -> Array:
        size = np.maximum(np.abs(self.limits.nearest), np.abs(self.limits.farthest)).T
        return np.asarray(np.maximum(size, 1e-3 * max(float(size.max()), 1e-300)))

    def _bounds(self) -> tuple[Array, Array]:
        limits = self.limits
        inner_low = -np.minimum(limits.slowest[:-1], limits.slowest[1:])
        inner_high = np.minimum(limits.fastest[:-1], limits.fastest[1:])
        gaps, n = limits.fastest.shape
        free = np.full(gaps * n, np.inf)
        lower = [np.zeros(gaps), inner_low.ravel(), -free, -limits.slowest.ravel(), limits.nearest.ravel()]
        upper = [free[:gaps], inner_high.ravel(), limits.fastest.ravel(), free, limits.farthest.ravel()]
        if self.boxes is not None:
            lower.append(self.boxes[0][0])
            upper.append(self.boxes[1][0])
        return np.concatenate(lower), np.concatenate(upper)

    def first_guess(self, rng: np.random.Generator | None) -> Array:
        """Return the motion that stops at every waypoint, or a random one about twice as fast."""
        limits = self.limits
        gaps, n = limits.fastest.shape
        distance = 0.5 * (limits.nearest + limits.farthest)
        h, inner = np.maximum(self.stops, SMALLEST_SHARE * self.unit), np.zeros((gaps - 1, n))
        if rng is not None:
            h = h * rng.uniform(0.4, 1.0, gaps)
            mean = distance / h[:, None]
            inner = rng.uniform(0.0, 1.0, inner.shape) * 0.5 * (mean[1:] + mean[:-1])
        return self._guess(h, inner)

    def guess_from(self, motion: LocalOptimum) -> Array:
        """Return the durations and velocities of a motion."""
        return self._guess(motion.durations, motion.velocities[1:-1])

    def _guess(self, h: Array, inner: Array) -> Array:
        distance = 0.5 * (self.limits.nearest + self.limits.farthest)
        middle = distance / h[:, None]
        start = [] if self.boxes is None else [0.5 * (self.boxes[0][0] + self.boxes[1][0])]
        return np.concatenate([h, inner.ravel(), middle.ravel(), middle.ravel(), distance.ravel(), *start])

    def solve(self, guess: Array) -> LocalOptimum | None:
        """Return the local optimum IPOPT finds from a guess, or None where it finds no feasible point."""
        guess = np.clip(guess, self.lower, self.upper)
        answer: dict[str, Any] = self.solver(x0=guess, lbx=self.lower, ubx=self.upper, lbg=0.0, ubg=np.inf)
        x = np.asarray(answer["x"], dtype=np.float64).ravel()
        worst = float(-np.asarray(answer["g"]).min())
        if not np.isfinite(x).all() or worst > 1e-6:
            return None
        gaps, n = self.limits.fastest.shape
        velocities = np.zeros((gaps + 1, n))
        velocities[1:-1] = x[gaps : gaps + (gaps - 1) * n].reshape(gaps - 1, n)
        return LocalOptimum(x[:gaps], velocities)


def stop_durations(limits: JointLimits) -> Array:
    """Return the durations (G,) of the motion that stops at every waypoint, the slowest joint deciding."""
    distance = 0.5 * (limits.nearest + limits.farthest)
    forwards = distance >= 0
    size = np.abs(distance)
    speed = np.where(forwards, limits.fastest, limits.slowest)
    up = np.where(forwards, limits.speeding, limits.braking)
    down = np.where(forwards, limits.braking, limits.speeding)
    ramps = 1.0 / up + 1.0 / down  # a peak velocity w needs w ramps seconds and covers w^2 ramps / 2
    peak = np.where(ramps > 0, np.sqrt(2.0 * size / np.where(ramps > 0, ramps, 1.0)), np.inf)
    reached = np.minimum(peak, speed)
    cruise = size / np.where(reached > 0, reached, 1.0)
    times = np.where(size > 0, np.where(np.isfinite(reached), cruise + 0.5 * reached * ramps, 0.0), 0.0)
    return np.asarray(np.where(np.isnan(times), 0.0, times).max(axis=1))
