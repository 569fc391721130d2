"""An estimate of the shortest motion with bounded jerk: cubic splines with many free knots.

Any motion with piecewise constant jerk is a cubic spline, and the shortest motion under velocity, acceleration and
jerk limits has piecewise constant jerk; so a cubic spline with enough free knots contains it. The knots of all joints
are shared and their number is finite, and the solver is local: the result is a motion that exists, and an estimate of
the optimum from above, not a bound.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array, read_only
from ocp_traj.deadline import Deadline
from ocp_traj.exceptions import InputError
from ocp_traj.quantities import RATES
from ocp_traj.task.preparing import prepare

if TYPE_CHECKING:
    from ocp_traj.task import TrajectoryTask


@dataclass(frozen=True)
class JerkEstimate:
    """Estimate of the shortest time with bounded jerk.

    Attributes
    ----------
    estimate : float or None
        s; None where the solver found no feasible motion, then `message` says so.
    durations : (G,) array
        Of the gaps, s.
    knots : int
        Free knots inside every gap.
    message : str
    """

    estimate: float | None
    durations: Array = field(default_factory=lambda: np.empty(0))
    knots: int = 0
    message: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "durations", read_only(self.durations))


def jerk_estimate(task: TrajectoryTask, *, knots: int = 7, time_limit: float = np.inf) -> JerkEstimate:
    """Return an estimate of the shortest motion from rest to rest with bounded jerk.

    Velocity, acceleration and jerk limits hold at every time; end accelerations are as the task wants them.

    Parameters
    ----------
    task : TrajectoryTask
    knots : int
        Free knots inside every gap; half as many are solved first and refined.
    time_limit : float
        Seconds; a local optimum with half the knots counts where the other is not found by then.

    Raises
    ------
    InputError
        The task has no jerk limit, an end is not at rest, or `knots` is below 1.
    """
    if not task.limited("jerk"):
        raise InputError("the task has no jerk limit; use kinematic_bound")
    if np.any(task.boundary.velocity):
        raise InputError("an end is not at rest, the estimate is defined from rest to rest")
    if knots < 1:
        raise InputError(f"knots is {knots}, expected 1 or more")
    ready = prepare(task)
    task, coarse, deadline = ready.task, knots // 2, Deadline(time_limit)
    first = None
    if coarse > 1:
        first = _FreeKnotProblem(task, coarse, deadline.fraction(0.5)).solve(_first_guess(task, coarse))
    guess = _first_guess(task, knots) if first is None else _refined(task, first, knots)
    found = None if deadline.passed else _FreeKnotProblem(task, knots, deadline).solve(guess)
    if found is None and deadline.passed:
        found, knots = first, coarse
    if found is None:
        stopped = f" in its {deadline} of the time limit" if deadline.passed else ""
        return JerkEstimate(None, knots=knots, message=f"the local solver found no feasible motion{stopped}")
    durations = ready.restored_durations(found.h.reshape(task.gaps, -1).sum(axis=1))
    message = "a local optimum with finitely many knots, torque not looked at: an estimate, not a bound"
    return JerkEstimate(float(durations.sum()), durations, knots, message)


@dataclass(frozen=True)
class _States:
    """Durations h (m,) of sub-segments and knot states q, v, a (m + 1, n)."""

    h: Array
    q: Array
    v: Array
    a: Array


def _first_guess(task: TrajectoryTask, knots: int) -> _States:
    """Return the motion that stops at every waypoint, slow enough for a smooth polynomial to keep the limits."""
    distance = np.abs(np.diff(task.waypoints, axis=0))
    times = [np.zeros(task.gaps)]
    for order, (kind, peak) in enumerate(zip(RATES, (1.875, 5.774, 60.0)), start=1):
        limit = np.min(np.abs(task.limits.get(kind)), axis=1)
        times.append((peak * distance / np.maximum(limit, 1e-12)).max(axis=1) ** (1.0 / order))
    total = np.maximum(np.max(times, axis=0), 1e-6)
    steps = knots + 1
    tau = np.linspace(0, 1, steps + 1)[:-1]
    shape = (
        tau**3 * (10 - 15 * tau + 6 * tau**2),
        30 * tau**2 * (1 - tau) ** 2,
        60 * tau * (1 - tau) * (1 - 2 * tau),
    )
    parts: list[list[Array]] = [[], [], []]
    for gap, seconds in enumerate(total):
        step = task.waypoints[gap + 1] - task.waypoints[gap]
        parts[0].append(task.waypoints[gap] + shape[0][:, None] * step)
        parts[1].append(shape[1][:, None] * step / seconds)
        parts[2].append(shape[2][:, None] * step / seconds**2)
    rest = np.zeros((1, task.n))
    ends = (task.waypoints[-1:], rest, rest)
    states = [np.concatenate([*part, end]) for part, end in zip(parts, ends)]
    return _States(np.repeat(total / steps, steps), *states)


def _refined(task: TrajectoryTask, states: _States, knots: int) -> _States:
    """Return the same motion with its longest sub-segments halved until every gap has `knots` knots."""
    h, q, v, a = list(states.h), list(states.q), list(states.v), list(states.a)
    counts = [len(states.h) // task.gaps] * task.gaps
    for gap in range(task.gaps):
        while counts[gap] < knots + 1:
            first = sum(counts[:gap])
            k = first + int(np.argmax(h[first : first + counts[gap]]))
            half, jerk = 0.5 * h[k], (a[k + 1] - a[k]) / h[k]
            q.insert(k + 1, q[k] + v[k] * half + a[k] * half**2 / 2 + jerk * half**3 / 6)
            v.insert(k + 1, v[k] + a[k] * half + jerk * half**2 / 2)
            a.insert(k + 1, a[k] + jerk * half)
            h[k : k + 1] = [half, half]
            counts[gap] += 1
    return _States(np.array(h), np.array(q), np.array(v), np.array(a))


class _FreeKnotProblem:
    """Knot states and durations of a cubic spline with free knots, solved by IPOPT."""

    def __init__(self, task: TrajectoryTask, knots: int, deadline: Deadline) -> None:
        import casadi as ca

        self.task, self.steps = task, knots + 1
        self.count, n = task.gaps * self.steps, task.n
        limits = {
            kind: task.limits.get(kind)[np.arange(self.count) // self.steps] for kind in ("velocity", "jerk")
        }
        h = ca.MX.sym("h", 1, self.count)
        q, v, a = (ca.MX.sym(name, n, self.count + 1) for name in "qva")
        hours = ca.repmat(h, n, 1)
        before = [state[:, :-1] for state in (q, v, a)]
        after = [state[:, 1:] for state in (q, v, a)]
        span = np.maximum(np.ptp(task.waypoints, axis=0), 1e-6)
        rows = [
            (after[0] - before[0] - before[1] * hours - (before[2] / 3 + after[2] / 6) * hours**2) / span,
            (after[1] - before[1] - (before[2] + after[2]) * hours / 2) / span,
        ]
        change = after[2] - before[2]
        bounded: list[Any] = []
        jerk = limits["jerk"]
        finite = np.isfinite(jerk)
        for side, sign in ((0, -1.0), (1, 1.0)):
            share = np.where(
                finite[:, side], 1.0 / np.where(finite[:, side], np.abs(jerk[:, side]), 1.0), 0.0
            ).T
            bounded.append(hours - sign * change * share)
        # the velocity inside a sub-segment stays below its Bernstein middle coefficient
        middle = before[1] + before[2] * hours / 2
        g = ca.veccat(*rows, *bounded, middle)
        equal = 2 * n * self.count
        velocity = limits["velocity"]
        self.lower_g = np.concatenate([np.zeros(equal), np.zeros(equal), velocity[:, 0].ravel()])
        self.upper_g = np.concatenate([np.zeros(equal), np.full(equal, np.inf), velocity[:, 1].ravel()])
        self.lower, self.upper = self._bounds()
        options: dict[str, Any] = {
            "ipopt.print_level": 0,
            "print_time": False,
            "ipopt.sb": "yes",
            "ipopt.max_iter": 500,
            "ipopt.mu_strategy": "monotone",
        }
        if np.isfinite(deadline.seconds):
            options["ipopt.max_wall_time"] = max(deadline.left, 1e-3)
        nlp: dict[str, Any] = {"x": ca.veccat(h, q, v, a), "f": ca.sum2(h), "g": g}
        self.solver = ca.nlpsol("free_knots", "ipopt", nlp, options)

    def _bounds(self) -> tuple[Array, Array]:
        task, n = self.task, self.task.n
        knots = np.arange(self.count + 1)
        sides = (np.maximum(knots - 1, 0) // self.steps, np.minimum(knots, self.count - 1) // self.steps)
        ends = []
        for side, tighter in ((0, np.maximum), (1, np.minimum)):
            q = np.full((self.count + 1, n), (-np.inf, np.inf)[side])
            q[:: self.steps] = task.waypoints + (2 * side - 1) * np.asarray(task.tolerance)
            v, a = (
                tighter(*(task.limits.get(kind)[gap, side] for gap in sides)).copy()
                for kind in ("velocity", "acceleration")
            )
            v[[0, -1]] = 0.0
            if task.boundary.acceleration is not None:
                a[[0, -1]] = np.asarray(task.boundary.acceleration)
            ends.append(
                np.concatenate([np.full(self.count, (1e-6, np.inf)[side]), q.ravel(), v.ravel(), a.ravel()])
            )
        return ends[0], ends[1]

    def solve(self, guess: _States) -> _States | None:
        """Return the local optimum from a guess, or None where no feasible motion was found."""
        x0 = np.concatenate([guess.h, guess.q.ravel(), guess.v.ravel(), guess.a.ravel()])
        x0 = np.clip(x0, self.lower, self.upper)
        bounds = {"lbx": self.lower, "ubx": self.upper, "lbg": self.lower_g, "ubg": self.upper_g}
        answer = self.solver(x0=x0, **bounds)
        x, g = (np.asarray(answer[key], dtype=np.float64).ravel() for key in ("x", "g"))
        error = max(float((self.lower_g - g).max()), float((g - self.upper_g).max()))
        if not np.isfinite(x).all() or error > 1e-6:
            return None
        parts = np.split(x[self.count :], 3)
        return _States(x[: self.count], *(part.reshape(self.count + 1, self.task.n) for part in parts))
