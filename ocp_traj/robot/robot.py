"""The robot: limits, and its kinematics and dynamics as named functions."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array, ArrayLike, read_only
from ocp_traj.exceptions import RobotError, UnavailableError
from ocp_traj.robot.additions import STANDARD_GRAVITY, Friction, Payload, vector

if TYPE_CHECKING:
    import casadi as ca

    from ocp_traj.codegen.batch_program import BatchProgram
    from ocp_traj.robot.links import Link
    from ocp_traj.robot.meshes import VisualMesh

logger = logging.getLogger(__name__)


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
    description : pathlib.Path or None
        The URDF the robot was read from, for its meshes.
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
    description: Path | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        from ocp_traj.robot.model import frame_index, root_placement

        for name in ("position_limits", "velocity_limits", "torque_limits"):
            limits = read_only(getattr(self, name))
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
    def n(self) -> int:
        """Number of joints."""
        return len(self.joint_names)

    @cached_property
    def has_inertia(self) -> bool:
        """Whether the links have masses: without them there is neither torque nor energy."""
        from ocp_traj.robot.model import has_link_inertia

        return has_link_inertia(self.bare_model)

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

    def _require_inertia(self) -> None:
        if not self.has_inertia:
            raise RobotError(
                f"robot {self.name!r} has no link masses, torque and energy are not defined for it"
            )

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
        text = [*self.joint_names, *self.joint_types]
        for block in numbers:
            text += [f"{value:.11e}" for value in np.ravel(np.where(np.abs(block) < 1e-11, 0.0, block))]
        return hashlib.sha256("\n".join(text).encode()).hexdigest()

    @cached_property
    def inverse_dynamics(self) -> ca.Function:
        """CasADi function (q, v, a) -> tau, each (n,): payload, armature and friction included.

        Raises
        ------
        RobotError
            The robot has no link masses.
        """
        from ocp_traj.robot.inverse_dynamics import inverse_dynamics_function

        self._require_inertia()
        return inverse_dynamics_function(self.links, np.array(self.model.gravity.linear), self.friction)

    def inverse_dynamics_from_pinocchio(self) -> ca.Function:
        """Return the same function as `inverse_dynamics`, built by Pinocchio's own CasADi binding.

        Raises
        ------
        UnavailableError
            `pinocchio.casadi` cannot be imported (no wheel on PyPI holds it; conda-forge's package does).
        RobotError
            The robot has no link masses.
        """
        import casadi as ca

        self._require_inertia()
        try:
            import pinocchio.casadi as cpin
        except ImportError as error:
            raise UnavailableError(
                f"pinocchio.casadi cannot be imported ({error}); it comes with conda-forge's pinocchio, "
                "not with the wheels of PyPI"
            ) from error
        model = cpin.Model(self.model)
        q, v, a = (ca.SX.sym(name, self.n) for name in "qva")
        tau = cpin.rnea(model, model.createData(), q, v, a)
        tau = tau + ca.DM(self.friction.viscous) * v + ca.DM(self.friction.coulomb) * ca.sign(v)
        return ca.Function("inverse_dynamics", [q, v, a], [tau], ["q", "v", "a"], ["tau"])

    def forward_kinematics(self, frame: str | None = None) -> ca.Function:
        """Return the CasADi function q (n,) -> T (4, 4) from the base to a frame (default: the tool).

        Raises
        ------
        RobotError
            The frame does not exist.
        """
        from ocp_traj.robot.kinematics import pose_function

        return self._frame_function(pose_function, frame)

    def frame_velocity(self, frame: str | None = None) -> ca.Function:
        """Return the CasADi function (q, v) -> linear velocity (3,) of a frame's origin in base axes, m/s.

        Raises
        ------
        RobotError
            The frame does not exist.
        """
        from ocp_traj.robot.kinematics import velocity_function

        return self._frame_function(velocity_function, frame)

    def _frame_function(self, build: Callable[..., ca.Function], frame: str | None) -> ca.Function:
        """Return what `build` makes of a frame, made once."""
        key = (build.__name__, self.tool if frame is None else frame)
        if key not in self._frame_functions:
            joint, placement = self.frame_placement(frame)
            self._frame_functions[key] = build(self.links, joint - 1, placement, self.base_placement)
        return self._frame_functions[key]

    @cached_property
    def _frame_functions(self) -> dict[tuple[str, str], ca.Function]:
        return {}

    @cached_property
    def _data(self) -> Any:
        return self.model.createData()

    def torque(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Return the torques (N, n) in N m of rows of `q`, `v`, `a` (N, n), by Pinocchio and without CasADi.

        This is the reference the audit uses; `torque_batch` is the fast way.

        Raises
        ------
        RobotError
            The robot has no link masses, or a shape is wrong.
        """
        import pinocchio as pin

        self._require_inertia()
        rows = self._rows(q, v, a)
        torques = np.empty_like(rows[0])
        for index, (position, velocity, acceleration) in enumerate(zip(*rows, strict=True)):
            torques[index] = pin.rnea(self.model, self._data, position, velocity, acceleration)
        return torques + self.friction.viscous * rows[1] + self.friction.coulomb * np.sign(rows[1])

    def torque_batch(self, q: ArrayLike, v: ArrayLike, a: ArrayLike) -> Array:
        """Return the torques (N, n) of many states at once, in N m; fast.

        `inverse_dynamics` as machine code where there is a C compiler, else its operations over NumPy arrays.
        Both equal the interpreter to the last bit where NumPy's sine and cosine do.

        Raises
        ------
        RobotError
            The robot has no link masses, or a shape is wrong.
        """
        q, v, a = self._rows(q, v, a)
        return self._program(q, v, a)[0]

    def torque_columns(self, q: Array, v: Array, a: Array, out: Array) -> None:
        """Write the torques of many states, one a column: `torque_batch` without transposing, for populations.

        Parameters
        ----------
        q, v, a, out : (n, N)
            Arrays of doubles whose rows are contiguous.

        Raises
        ------
        RobotError
            The robot has no link masses.
        """
        self._require_inertia()
        self._program.run_columns((q, v, a), (out,))

    @cached_property
    def _program(self) -> BatchProgram:
        from ocp_traj.codegen.array_program import ArrayProgram
        from ocp_traj.codegen.compiled import find_compiler
        from ocp_traj.codegen.compiled_program import CompiledProgram

        if find_compiler() is None:
            return ArrayProgram(self.inverse_dynamics)
        try:
            return CompiledProgram(self.inverse_dynamics)
        except UnavailableError as error:
            logger.warning("inverse dynamics of %s run in NumPy, not compiled: %s", self.name, error)
            return ArrayProgram(self.inverse_dynamics)

    def _rows(self, *arrays: ArrayLike) -> tuple[Array, ...]:
        rows = tuple(np.atleast_2d(np.asarray(array, dtype=np.float64)) for array in arrays)
        for array in rows:
            if array.shape != rows[0].shape or array.ndim != 2 or array.shape[1] != self.n:
                shapes = ", ".join(str(item.shape) for item in rows)
                raise RobotError(f"q, v, a have shapes {shapes}, expected (N, {self.n}) each")
        return rows

    def pose(self, q: ArrayLike, frame: str | None = None) -> Array:
        """Return the transform (4, 4) from the base to a frame (default: the tool) at `q` (n,), by Pinocchio.

        Raises
        ------
        RobotError
            The frame does not exist, or `q` has not n values.
        """
        import pinocchio as pin

        joint, placement = self.frame_placement(frame)
        position = vector(q, self.n, "q")
        pin.forwardKinematics(self.bare_model, self._data, position)
        base = pin.SE3(self.base_placement).inverse().homogeneous
        pose: Array = base @ self._data.oMi[joint].homogeneous @ placement
        return pose

    def link_placements(self, q: ArrayLike) -> Array:
        """Return the transforms (n + 1, 4, 4) from the base to the root and to what each joint moves, at `q` (n,).

        Raises
        ------
        RobotError
            `q` has not n values.
        """
        import pinocchio as pin

        pin.forwardKinematics(self.bare_model, self._data, vector(q, self.n, "q"))
        base = np.linalg.inv(self.base_placement)
        return np.array([base @ placement.homogeneous for placement in self._data.oMi])

    def visual_meshes(self) -> list[VisualMesh]:
        """Return the robot's meshes with the link that carries each; empty for a robot without a URDF.

        Raises
        ------
        RobotError
            The URDF or one of its meshes is not where it should be.
        """
        from ocp_traj.robot.meshes import visual_meshes

        return visual_meshes(self)

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
