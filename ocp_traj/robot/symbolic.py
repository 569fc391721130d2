"""A robot's dynamics and kinematics as CasADi functions: what problems are built from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from ocp_traj.arrays import Array
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.additions import Coupling, Friction
from ocp_traj.robot.links import Link

if TYPE_CHECKING:
    import casadi as ca


@dataclass(frozen=True, eq=False)
class SymbolicRobot:
    """CasADi functions of a robot, each built once; `Robot.symbolic` makes it.

    Attributes
    ----------
    name : str
        The robot's, for messages.
    links : tuple of Link
        Payload included.
    gravity : (3,)
        In root axes, m/s^2.
    friction : Friction or None
        None for a robot without link masses.
    base : (4, 4)
        The base frame in the root.
    frame_placement : callable
        As `Robot.frame_placement`.
    coupling : Coupling or None
        As `Robot.coupling`.
    """

    name: str
    links: tuple[Link, ...]
    gravity: Array
    friction: Friction | None
    base: Array
    frame_placement: Callable[[str | None], tuple[int, Array]]
    coupling: Coupling | None = None

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.links) if self.coupling is None else self.coupling.n

    @cached_property
    def inverse_dynamics(self) -> ca.Function:
        """Function (q, v, a) -> tau, each (n,), N m: payload, armature and friction included.

        Raises
        ------
        RobotError
            The robot has no link masses.
        """
        from ocp_traj.robot.inverse_dynamics import inverse_dynamics_function

        if self.friction is None:
            raise without_masses(self.name)
        return inverse_dynamics_function(self.links, self.gravity, self.friction, self.coupling)

    def pose(self, frame: str | None = None) -> ca.Function:
        """Return the function q (n,) -> T (4, 4) from the base to a frame (default: the tool).

        Raises
        ------
        RobotError
            The frame does not exist.
        """
        from ocp_traj.robot.kinematics import pose_function

        return self._frame_function(pose_function, frame)

    def velocity(self, frame: str | None = None) -> ca.Function:
        """Return the function (q, v) -> linear velocity (3,) of a frame's origin in base axes, m/s.

        Raises
        ------
        RobotError
            The frame does not exist.
        """
        from ocp_traj.robot.kinematics import velocity_function

        return self._frame_function(velocity_function, frame)

    def _frame_function(self, build: Callable[..., ca.Function], frame: str | None) -> ca.Function:
        """Return what `build` makes of a frame, made once."""
        if (build, frame) not in self._frame_functions:
            joint, placement = self.frame_placement(frame)
            self._frame_functions[build, frame] = build(
                self.links, joint - 1, placement, self.base, self.coupling
            )
        return self._frame_functions[build, frame]

    @cached_property
    def _frame_functions(self) -> dict[tuple[Callable[..., ca.Function], str | None], ca.Function]:
        return {}


def without_masses(name: str) -> RobotError:
    """Return the error of a robot that has no torques; the caller raises it."""
    return RobotError(f"robot {name!r} has no link masses, torque and energy are not defined for it")
