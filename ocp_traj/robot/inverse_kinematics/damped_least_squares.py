"""Inverse kinematics of any arm by damped least squares through Pinocchio, within the joint limits.

Source: Wampler, "Manipulator inverse kinematic solutions based on vector formulations and damped
least-squares methods", IEEE Trans. SMC 16 (1986) 93-101, with the damping of Levenberg and Marquardt raised
and lowered by success.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.robot.inverse_kinematics.inverse_kinematics import InverseKinematics
from ocp_traj.robot.inverse_kinematics.screws import wrap

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

CLOSED = 1e-11
"""A start has converged when the pose error (m and rad, norm) is below this."""


@dataclass(frozen=True)
class Descent:
    """Where one start ended.

    Attributes
    ----------
    q : (n,)
    error : float
        Norm of the pose error, m and rad together.
    """

    q: Array
    error: float

    @property
    def converged(self) -> bool:
        """Whether the pose is reached."""
        return self.error < CLOSED


class DampedLeastSquares(InverseKinematics):
    """Damped least squares from several starts, for arms without a closed form.

    Parameters
    ----------
    robot : Robot
    starts : int
        Random starts of `solve`, besides the middle of the range.
    iterations : int
        Steps of one start.
    seed : int
        Of the random starts: the same pose always gives the same answer.
    """

    def __init__(self, robot: Robot, starts: int = 40, iterations: int = 200, seed: int = 0) -> None:
        self.robot = robot
        self.starts = starts
        self.iterations = iterations
        self.seed = seed
        self._data = robot.bare_model.createData()
        self._joint, self._placement = robot.frame_placement()

    def descend(self, pose: Array, start: Array, weights: Array | None = None) -> Descent:
        """Go from one start to a position that reaches `pose` (4, 4), or to the best one nearby.

        Steps are damped in the norm sum of weights times squared change: joints of small weight move more.
        Positions stay within the joint limits: a joint that would leave its range stands at its end for that
        step.
        """
        import pinocchio as pin

        target = pin.SE3(self.robot.base_placement @ pose)
        inverse_weights = 1.0 / np.sqrt(np.ones(self.robot.n) if weights is None else weights)
        lower, upper = self.robot.position_limits
        q = np.clip(np.asarray(start, dtype=np.float64), lower, upper)
        damping = 1e-3
        error, jacobian = self._error(pin, q, target)
        for _ in range(self.iterations):
            size = float(error @ error)
            if size < CLOSED**2:
                break
            trial = self._step(q, error, jacobian, damping, inverse_weights)
            trial_error, trial_jacobian = self._error(pin, trial, target)
            if float(trial_error @ trial_error) < size:
                q, error, jacobian = trial, trial_error, trial_jacobian
                damping = max(0.1 * damping, 1e-15)
            elif damping > 1e8:
                break  # a local minimum, or an end of the range
            else:
                damping = 10.0 * damping
        return Descent(q, float(np.linalg.norm(error)))

    def _error(self, pin: Any, q: Array, target: Any) -> tuple[Array, Array]:
        """Return the pose error (6,) in tool axes and its Jacobian (6, n)."""
        model, data = self.robot.bare_model, self._data
        pin.computeJointJacobians(model, data, self.robot.model_positions(q))
        tool = data.oMi[self._joint] * pin.SE3(self._placement)
        twist = pin.getJointJacobian(model, data, self._joint, pin.ReferenceFrame.LOCAL)
        local = pin.SE3(self._placement).inverse().toActionMatrix() @ twist
        if self.robot.coupling is not None:
            local = local @ self.robot.coupling.matrix
        missing = target.actInv(tool)
        return pin.log6(missing).vector, pin.Jlog6(missing) @ local

    def _step(self, q: Array, error: Array, jacobian: Array, damping: float, inverse_weights: Array) -> Array:
        """Return q after one damped step; joints pushed beyond their range are held."""
        lower, upper = self.robot.position_limits
        free = np.ones(self.robot.n, dtype=bool)
        trial = q
        for _ in range(self.robot.n):
            scaled = jacobian * (inverse_weights * free)
            gram = scaled @ scaled.T + damping * np.eye(6) * max(1e-12, float(error @ error))
            change = -inverse_weights * free * (scaled.T @ np.linalg.lstsq(gram, error, rcond=1e-15)[0])
            trial = q + np.clip(change, -0.8, 0.8)
            outside = free & (((trial < lower) & (change < 0.0)) | ((trial > upper) & (change > 0.0)))
            blocked = outside & (((q <= lower) & (change < 0.0)) | ((q >= upper) & (change > 0.0)))
            if not blocked.any():
                break
            free &= ~blocked
        return np.clip(trial, lower, upper)

    def start_positions(self, count: int) -> Iterator[Array]:
        """Yield the middle of the range, then `count` random positions in it (in one turn without range)."""
        lower, upper = self.robot.position_limits
        lower = np.maximum(lower, np.where(np.isinf(upper), -np.pi, upper - 2.0 * np.pi))
        upper = np.where(np.isinf(upper), lower + 2.0 * np.pi, np.minimum(upper, lower + 2.0 * np.pi))
        rng = np.random.default_rng(self.seed)
        yield 0.5 * (lower + upper)
        for _ in range(count):
            yield rng.uniform(lower, upper)

    def solve(self, pose: Array) -> Array:
        """Return the distinct positions (B, n) within the joint limits that the starts found.

        A redundant arm has infinitely many; those returned are the ones nearest to the starts.
        """
        found: list[Array] = []
        for start in self.start_positions(self.starts):
            end = self.descend(pose, start)
            if end.converged and all(self._distance(end.q, other) > 1e-6 for other in found):
                found.append(end.q)
        return np.array(found).reshape(-1, self.robot.n)

    def _distance(self, first: Array, second: Array) -> float:
        revolute = np.array([kind != "prismatic" for kind in self.robot.joint_types])
        difference = first - second
        return float(np.max(np.abs(np.where(revolute, wrap(difference), difference))))

    def manipulability(self, q: Array) -> float:
        """Return smallest over largest singular value of the tool's Jacobian at `q` (n,)."""
        import pinocchio as pin

        here = pin.SE3(self.robot.base_placement @ self.robot.pose(q))
        _, jacobian = self._error(pin, np.asarray(q, dtype=np.float64), here)
        values = np.linalg.svd(jacobian, compute_uv=False)
        return float(values[-1] / values[0])
