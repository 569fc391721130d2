"""Random but solvable tasks, robots and motions, each reproducible from one integer."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
from scipy.interpolate import make_interp_spline

from ocp_traj.robot import Friction, Robot
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory

FAMILIES = ("cubic", "quintic", "septic")


def random_task(seed: int, *, moving_ends: bool = False, jerk: bool | None = None) -> TrajectoryTask:
    """A task with 2 to 6 waypoints, 1 to 8 joints, any family, and limits over several decades."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    family = str(rng.choice(FAMILIES))
    knots = int(rng.integers(0, 3)) if family == "cubic" else 0
    count = int(rng.integers(2, 7))
    scale = 10.0 ** rng.uniform(-3, 2, n)
    waypoints = rng.uniform(-1, 1, (count, n)) * scale
    velocity = scale * 10.0 ** rng.uniform(-0.5, 0.5, n)
    acceleration = scale * 10.0 ** rng.uniform(-0.5, 0.5, n)
    limits = {"velocity": velocity, "acceleration": acceleration}
    if jerk if jerk is not None else rng.random() < 0.5:
        limits["jerk"] = scale * 10.0 ** rng.uniform(0.0, 1.0, n)
    boundary = Boundary()
    if moving_ends:
        boundary = Boundary(velocity=0.1 * velocity * rng.uniform(-1, 1, (2, n)))
    return TrajectoryTask(
        waypoints,
        Limits(**limits),
        family=family,
        virtual_knots=knots,
        boundary=boundary,
        name=f"random-{seed}",
    )


def random_robot(seed: int, *, signs: np.ndarray | None = None, friction: float = 0.0) -> Robot:
    """A serial chain of 1 to 8 revolute and prismatic joints with physically possible links, no limits.

    Parameters
    ----------
    signs
        (n,) of 1 and -1: joints with -1 count the other way round, everything else stays.
    friction
        Size of viscous (N m s/rad) and Coulomb (N m) friction.
    """
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    model = pin.Model()
    model.name = f"chain-{seed}"
    kinds = []
    for index in range(n):
        axis = np.eye(3)[rng.integers(3)] if rng.random() < 0.5 else rng.standard_normal(3)
        axis = axis / np.linalg.norm(axis) * (1 if signs is None else signs[index])
        kinds.append("revolute" if rng.random() < 0.7 else "prismatic")
        joint = (
            pin.JointModelRevoluteUnaligned if kinds[-1] == "revolute" else pin.JointModelPrismaticUnaligned
        )
        model.addJoint(index, joint(axis), random_placement(rng), f"j{index}")
        inertia = pin.Inertia.FromEllipsoid(rng.uniform(0.1, 5.0), *rng.uniform(0.02, 0.3, 3))
        model.appendBodyToJoint(index + 1, inertia, random_placement(rng))
    model.armature = rng.uniform(0.0, 0.1, n)
    model.addFrame(pin.Frame("tip", n, 0, random_placement(rng), pin.FrameType.BODY))
    free = np.array([[-np.inf] * n, [np.inf] * n])
    rubbing = Friction(*(friction * rng.uniform(0.0, 1.0, (2, n))))
    names = tuple(f"j{index}" for index in range(n))
    return Robot(
        model.name,
        names,
        tuple(kinds),
        free,
        free,
        free,
        model,
        tool="tip",
        base="universe",
        friction=rubbing,
    )


def random_placement(rng: np.random.Generator) -> pin.SE3:
    """Any rotation, and a translation of up to 0.5 m."""
    parts = rng.standard_normal(4)
    quaternion = pin.Quaternion(*(parts / np.linalg.norm(parts)))
    return pin.SE3(quaternion.matrix(), rng.uniform(-0.5, 0.5, 3))


def random_motion(seed: int, n: int) -> Trajectory:
    """A quintic spline from rest to rest through 2 to 5 random points, over a time of order one."""
    rng = np.random.default_rng(seed)
    gaps = int(rng.integers(1, 5))
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.2, 1.0, gaps))])
    ends = [(1, np.zeros(n)), (2, np.zeros(n))]
    spline = make_interp_spline(times, rng.uniform(-1, 1, (gaps + 1, n)), k=5, bc_type=(ends, ends))
    pieces = [spline(times[:-1], nu=order) / math.factorial(order) for order in range(6)]
    return Trajectory(times, np.stack(pieces, axis=2), times, "quintic")


def reversed_motion(motion: Trajectory) -> Trajectory:
    """The same path from its end to its start."""
    lengths = np.diff(motion.breakpoints)[:, None]
    taylor = [motion.derivative_coefficients(order) for order in range(motion.degree + 1)]
    ends = []
    for order, coefficients in enumerate(taylor):
        powers = lengths ** np.arange(coefficients.shape[2])
        ends.append((-1) ** order * (coefficients * powers[:, None, :]).sum(axis=2) / math.factorial(order))
    backwards = np.stack(ends, axis=2)[::-1]
    last = motion.breakpoints[-1]
    return Trajectory(
        last - motion.breakpoints[::-1],
        backwards,
        last - motion.waypoint_times[::-1],
        motion.family,
    )


def torque_limits(robot: Robot, motion: Trajectory, share: float) -> np.ndarray:
    """(n,) limits that hold the arm at rest all along the motion, and leave `share` of the rest of its torque."""
    t = np.linspace(0.0, motion.duration, 300)
    q, v, a = (motion(t, order) for order in range(3))
    holding = np.abs(robot.torque(q, 0 * v, 0 * a)).max(axis=0)
    moving = np.abs(robot.torque(q, v, a)).max(axis=0)
    return 1.1 * holding + share * moving + robot.friction.coulomb
