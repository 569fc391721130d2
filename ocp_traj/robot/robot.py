"""The robot: limits, and its kinematics and dynamics as named functions."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array, ArrayLike, read_only
from ocp_traj.exceptions import RobotError
from ocp_traj.robot.additions import STANDARD_GRAVITY, Coupling, Friction, Payload, vector

if TYPE_CHECKING:
    from ocp_traj.robot.batch import BatchRobot
    from ocp_traj.robot.links import Link
    from ocp_traj.robot.symbolic import SymbolicRobot

_OPTIONAL_LIMITS = ("acceleration_limits", "jerk_limits")
_LIMITS = ("position_limits", "velocity_limits", "torque_limits", *_OPTIONAL_LIMITS)


@dataclass(frozen=True, eq=False)
class RobotSource:
    """What a robot was made from: a name, a URDF, or a table of Denavit-Hartenberg parameters.

    Attributes
    ----------
    name : str
        One of `robot_names`, else empty.
    urdf : pathlib.Path or None
        The file it was read from, a named robot's too.
    lock : mapping of str to float
        Joints of that file that do not move, and where they stand, rad or m.
    srdf : pathlib.Path or None
        The SRDF that belongs to it.
    dh : mapping or None
        Arguments of `robot_from_dh`, in rad, as lists.
    """

    name: str = ""
    urdf: Path | None = None
    lock: Mapping[str, float] = field(default_factory=dict)
    srdf: Path | None = None
    dh: Mapping[str, Any] | None = None


@dataclass(frozen=True, eq=False)
class Robot:
    """A fixed-base robot with n one-degree-of-freedom joints, as it stands in its cell.

    Made by `load_robot`, `robot_from_urdf` and `robot_from_dh`, changed by `with_changes`. Two robots are
    equal when their digests are.

    Attributes
    ----------
    name : str
    joint_names : tuple of n str
    joint_types : tuple of n str
        "revolute", "continuous" or "prismatic".
    position_limits, velocity_limits, torque_limits : (2, n)
        Lower and upper, in rad, rad/s, N m (m, m/s, N for prismatic joints); infinite where there is none.
    bare_model : pin.Model
        Links and frames without payload, nq = nv = n. Read it, do not change it.
    tool : str
        Frame that poses and payload refer to.
    base : str
        Frame that poses and gravity are given in; fixed to the root.
    gravity : (3,)
        In base axes, m/s^2.
    payload : Payload or None
    friction : Friction
        Zero unless given: the friction tags of a URDF are simulator settings, see `robot_from_urdf`.
    source : RobotSource or None
        What the robot was made from; None for one that was put together by hand.
    acceleration_limits, jerk_limits : (2, n)
        As the others; infinite unless the description has them.
    coupling : Coupling or None
        How further joints of the model follow those of the robot (mimic joints); None where none does. With it
        `bare_model`, `model`, `links` and `link_placements` have all joints, everything else the robot's n.
    """

    name: str
    joint_names: tuple[str, ...]
    joint_types: tuple[str, ...]
    position_limits: Array
    velocity_limits: Array
    torque_limits: Array
    bare_model: Any = field(repr=False)
    tool: str
    base: str
    gravity: Array = field(default_factory=lambda: np.array(STANDARD_GRAVITY))
    payload: Payload | None = None
    friction: Friction = field(default_factory=lambda: Friction.none(0))  # none(0) stands for none(n)
    source: RobotSource | None = field(default=None, repr=False)
    acceleration_limits: Array = field(default_factory=lambda: np.empty((2, 0)))  # none stands for infinite
    jerk_limits: Array = field(default_factory=lambda: np.empty((2, 0)))
    coupling: Coupling | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        from ocp_traj.robot.model import frame_index, root_placement

        for name in _LIMITS:
            limits = read_only(getattr(self, name))
            if name in _OPTIONAL_LIMITS and not limits.size:
                limits = read_only([[-np.inf] * self.n, [np.inf] * self.n])
            if limits.shape != (2, self.n):
                raise RobotError(f"{name} has shape {limits.shape}, expected (2, {self.n})")
            if np.any(np.isnan(limits)) or np.any(limits[0] > limits[1]):
                raise RobotError(f"{name} is {limits.tolist()}, expected lower <= upper for every joint")
            object.__setattr__(self, name, limits)
        object.__setattr__(self, "gravity", vector(self.gravity, 3, "gravity"))
        friction = self.friction if self.friction.viscous.size else Friction.none(self.n)
        if friction.viscous.shape != (self.n,):
            raise RobotError(f"friction has {friction.viscous.size} entries, expected {self.n}, one a joint")
        object.__setattr__(self, "friction", friction)
        frame_index(self.bare_model, self.tool)
        root_placement(self.bare_model, self.base)

    def __reduce__(self) -> tuple[type[Robot], tuple[Any, ...]]:
        return Robot, tuple(getattr(self, item.name) for item in fields(self))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Robot) and self.digest() == other.digest()

    def __hash__(self) -> int:
        return hash(self.digest())

    @property
    def description(self) -> Path | None:
        """The URDF the robot was read from, for its meshes."""
        return None if self.source is None else self.source.urdf

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joint_names)

    @property
    def followers(self) -> dict[str, tuple[str, float, float]]:
        """For every joint of the model that follows one of the robot: that joint's name, multiplier and offset."""
        if self.coupling is None:
            return {}
        rows = zip(self.coupling.joints, self.coupling.matrix, self.coupling.offset, strict=True)
        return {
            name: (self.joint_names[driver := int(np.argmax(row != 0.0))], float(row[driver]), float(offset))
            for name, row, offset in rows
            if name not in self.joint_names
        }

    def row_problem(self, width: int) -> str:
        """Return what is wrong with a waypoint of `width` numbers: the joints there are, and how to hold some."""
        names = ", ".join(self.joint_names)
        problem = f"rows have {width} numbers, expected {self.n}, the joints of {self.name}: {names}"
        if self.source is None or self.source.urdf is None:
            return problem
        if width < self.n:
            some = ", ".join(f'"{name}"' for name in self.joint_names[width:])
            return (
                f"{problem}; hold those that do not belong to the task with robot.lock, for instance [{some}], or "
                "name those that do in robot.keep"
            )
        still = ", ".join([*self.source.lock, *self.followers])
        return f"{problem}; {still} are held still or follow another joint" if still else problem

    @cached_property
    def has_inertia(self) -> bool:
        """Whether the links have masses: without them there is neither torque nor energy."""
        return not self.massless_joints

    @cached_property
    def massless_joints(self) -> tuple[str, ...]:
        """Names of the joints that move no mass."""
        from ocp_traj.robot.model import moves_mass

        heavy = moves_mass(self.bare_model, self.coupling)
        return tuple(name for name, moves in zip(self.joint_names, heavy, strict=True) if not moves)

    @cached_property
    def model(self) -> Any:
        """The pin.Model with payload and gravity (friction is not part of it)."""
        from ocp_traj.robot.model import completed_model

        return completed_model(self.bare_model, self.payload, self.tool, self.base, self.gravity)

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """The model as plain numbers."""
        from ocp_traj.robot.links import links_of

        return links_of(self.model)

    @cached_property
    def base_placement(self) -> Array:
        """Placement (4, 4) of the base frame in the model's root."""
        from ocp_traj.robot.model import root_placement

        return root_placement(self.bare_model, self.base)

    def frame_placement(self, name: str | None = None) -> tuple[int, Array]:
        """Return the joint (0: the root) that carries a frame (default: the tool), and where there (4, 4)."""
        from ocp_traj.robot.model import frame_index

        frame = self.bare_model.frames[frame_index(self.bare_model, self.tool if name is None else name)]
        return int(frame.parentJoint), np.array(frame.placement.homogeneous)

    def digest(self) -> str:
        """Return a hash of all that decides a motion: model, limits, frames, gravity, payload, friction.

        Numbers enter with 12 significant digits, so the rounding of another platform does not change it.
        """
        return self._digest

    @cached_property
    def _digest(self) -> str:
        joint, tool = self.frame_placement(None)
        numbers = [self.position_limits, self.velocity_limits, self.torque_limits, self.base_placement]
        numbers += [self.model.gravity.linear, np.append(joint, tool)]
        numbers += [self.friction.viscous, self.friction.coulomb]
        for link in self.links:
            numbers += [np.array([link.parent, link.prismatic, link.mass, link.armature])]
            numbers += [
                link.rotation,
                link.translation,
                link.alignment,
                link.first_moment,
                link.second_moment,
            ]
        numbers += [limits for name in _OPTIONAL_LIMITS if np.isfinite(limits := getattr(self, name)).any()]
        if self.coupling is not None:
            numbers += [self.coupling.matrix, self.coupling.offset]
        text = [*self.joint_names, *self.joint_types]
        for block in numbers:
            text += [f"{value:.11e}" for value in np.ravel(np.where(np.abs(block) < 1e-11, 0.0, block))]
        return hashlib.sha256("\n".join(text).encode()).hexdigest()

    @cached_property
    def symbolic(self) -> SymbolicRobot:
        """The robot's dynamics and kinematics as CasADi functions."""
        from ocp_traj.robot.symbolic import SymbolicRobot

        return SymbolicRobot(
            self.name,
            self.links,
            np.array(self.model.gravity.linear),
            self.friction if self.has_inertia else None,
            self.base_placement,
            self.frame_placement,
            self.coupling,
        )

    @cached_property
    def batch(self) -> BatchRobot:
        """The robot's torques at many states at once, fast."""
        from ocp_traj.robot.batch import BatchRobot

        return BatchRobot(self.symbolic)

    @cached_property
    def _data(self) -> Any:
        return self.model.createData()

    def torque(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Return the torques (N, n) in N m of rows of `q`, `v`, `a` (N, n), by Pinocchio and without CasADi.

        This is the reference the audit uses; `batch.torque` is the fast way.

        Raises
        ------
        RobotError
            The robot has no link masses, or a shape is wrong.
        """
        import pinocchio as pin

        from ocp_traj.robot.batch import state_rows
        from ocp_traj.robot.symbolic import without_masses

        if not self.has_inertia:
            raise without_masses(self.name)
        rows = state_rows(self.n, q, v, a)
        states, coupling = rows, self.coupling
        if coupling is not None:
            states = (coupling.positions(rows[0]), *map(coupling.rates, rows[1:]))
        torques = np.empty_like(states[0])
        for index, (position, velocity, acceleration) in enumerate(zip(*states, strict=True)):
            torques[index] = pin.rnea(self.model, self._data, position, velocity, acceleration)
        if coupling is not None:
            torques = coupling.torques(torques)
        return torques + self.friction.viscous * rows[1] + self.friction.coulomb * np.sign(rows[1])

    def pose(self, q: ArrayLike, frame: str | None = None) -> Array:
        """Return the transform (4, 4) from the base to a frame (default: the tool) at `q` (n,), by Pinocchio.

        Raises
        ------
        RobotError
            The frame does not exist, or `q` has not n values.
        """
        import pinocchio as pin

        joint, placement = self.frame_placement(frame)
        pin.forwardKinematics(self.bare_model, self._data, self.model_positions(q))
        base = pin.SE3(self.base_placement).inverse().homogeneous
        return base @ self._data.oMi[joint].homogeneous @ placement

    def model_positions(self, q: ArrayLike) -> Array:
        """Return the positions of all joints of the model, those that follow others too, at `q` (n,).

        Raises
        ------
        RobotError
            `q` has not n values.
        """
        position = vector(q, self.n, "q")
        return position if self.coupling is None else self.coupling.positions(position)

    def link_placements(self, q: ArrayLike) -> Array:
        """Return the transforms (N + 1, 4, 4) from the base to the root and what each of N joints moves, at `q` (n,).

        Raises
        ------
        RobotError
            `q` has not n values.
        """
        import pinocchio as pin

        pin.forwardKinematics(self.bare_model, self._data, self.model_positions(q))
        base = np.linalg.inv(self.base_placement)
        return np.array([base @ placement.homogeneous for placement in self._data.oMi])

    def with_changes(
        self,
        *,
        payload: Payload | None = None,
        gravity: ArrayLike | None = None,
        friction: Friction | None = None,
        tool: str | None = None,
        base: str | None = None,
    ) -> Robot:
        """Return a robot that differs in what is given; what is left out stays.

        The payload sits at the (new) tool frame; gravity is given in the (new) base frame.

        Raises
        ------
        RobotError
            A shape is wrong, a frame does not exist, or the base is moved by a joint.
        """
        given: dict[str, Any] = {
            "payload": payload,
            "gravity": gravity,
            "friction": friction,
            "tool": tool,
            "base": base,
        }
        return replace(self, **{name: value for name, value in given.items() if value is not None})
