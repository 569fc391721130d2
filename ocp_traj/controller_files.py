"""Motions for controllers: ROS 2 JointTrajectory and URScript, with limits kept after sampling."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.exceptions import InputError
from ocp_traj.quantities import limited_quantity
from ocp_traj.spline.hermite import hermite_pieces
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

NANOSECOND = 1e-9
_MAXIMUM_SAMPLES = 1_000_000
_SHORTEST_STEP = 1e-6


END_SPEED = 1e-6
"""Speed of a joint, rad/s or m/s, up to which a motion ends at rest."""


def objections(
    trajectory: Trajectory, task: TrajectoryTask | None, *, starts_at_rest: bool = False
) -> list[str]:
    """Return what speaks against sending a motion to a controller, a phrase each; empty where nothing does.

    Parameters
    ----------
    trajectory : Trajectory
    task : TrajectoryTask or None
        Whose limits it has to keep.
    starts_at_rest : bool
        Whether the program brings the robot to the start first, so that it begins at rest.
    """
    from ocp_traj.audit import audit

    found = []
    if task is None:
        found.append("the motion carries no task, so that its limits are not known")
    else:
        verdict = audit(task, trajectory)
        if not verdict.feasible:
            found.append(f"the motion is not feasible ({verdict.findings[0] if verdict.findings else verdict.worst})")
    ends = [("ends", -1)] + ([("starts", 0)] if starts_at_rest else [])
    for word, place in ends:
        speeds = np.abs(trajectory(trajectory.breakpoints[place], 1)).ravel()
        if speeds.max() > END_SPEED:
            joint = int(speeds.argmax())
            found.append(f"the motion {word} moving, joint {joint + 1} at {speeds[joint]:.6g} rad/s (m/s)")
    return found


@dataclass(frozen=True)
class ControllerSamples:
    """What a controller gets: strictly increasing times from 0 and the states there.

    Parameters
    ----------
    nanoseconds
        (N,) whole nanoseconds.
    q, v, a
        (N, n) rad, rad/s, rad/s^2.
    scale
        How much slower than the motion given, so that limits are kept; 1 for not at all.
    """

    nanoseconds: Array
    q: Array
    v: Array
    a: Array
    scale: float


def sample_for_controller(
    trajectory: Trajectory, rate: float, task: TrajectoryTask | None = None
) -> ControllerSamples:
    """Sample a motion so that the quintic a controller draws through the samples keeps the limits.

    Every breakpoint is a sample, in addition to an even grid: between samples the quintic through q, v, a
    then is the motion itself for families up to degree five. With a task, the quintic is audited, and the whole
    motion slowed where it exceeds a limit.

    Raises
    ------
    InputError
        The rate is not positive, gives too many samples, or the motion cannot keep the limits at any speed.
    """
    scale = 1.0
    for _ in range(8):
        samples = _sample(trajectory.scaled(scale), rate, scale)
        if task is None:
            return samples
        needed = _needed_scale(task, trajectory.scaled(scale), samples)
        if needed is None:
            raise InputError("the motion breaks limits of the case that slowing it down does not restore")
        if needed <= 1.0:
            return samples
        scale *= needed * (1.0 + 1e-9)
    raise InputError("no slowing was found that keeps the limits between samples, expected a higher --rate")


def _sample(trajectory: Trajectory, rate: float, scale: float) -> ControllerSamples:
    times = np.round(sampling_times(trajectory, rate) / NANOSECOND)
    start = trajectory.breakpoints[0]
    at = start + times * NANOSECOND
    return ControllerSamples(times, trajectory(at), trajectory(at, 1), trajectory(at, 2), scale)


def sampling_times(trajectory: Trajectory, rate: float) -> Array:
    """Return times from 0 on an even grid and at every breakpoint, no two closer than a microsecond."""
    if not (math.isfinite(rate) and rate > 0):
        raise InputError(f"rate is {rate}, expected a positive number of samples a second")
    duration = trajectory.duration
    if duration * rate + len(trajectory.breakpoints) > _MAXIMUM_SAMPLES:
        raise InputError(
            f"{duration:g} s at {rate:g} Hz need more than {_MAXIMUM_SAMPLES} samples, expected a lower rate"
        )
    breakpoints = trajectory.breakpoints - trajectory.breakpoints[0]
    if np.diff(breakpoints).min() < 2 * NANOSECOND:
        raise InputError("a piece of the motion is shorter than 2 ns, too short for a controller's clock")
    grid = np.arange(math.ceil(duration * rate)) / rate
    step = min(_SHORTEST_STEP, 0.25 / rate)
    near = np.searchsorted(breakpoints, grid)
    left = np.abs(grid - breakpoints[np.clip(near - 1, 0, None)])
    right = np.abs(grid - breakpoints[np.clip(near, None, breakpoints.size - 1)])
    return np.union1d(breakpoints, grid[np.minimum(left, right) > step])


def _needed_scale(task: TrajectoryTask, motion: Trajectory, samples: ControllerSamples) -> float | None:
    """Return the slowing with which the controller's quintic keeps the limits; 1 when it does already."""
    from ocp_traj.audit import audit

    drawn = interpolated(samples, motion)
    ratios = [extremum for extremum in audit(task, drawn).limits.values() if extremum.broken]
    if not ratios:
        return 1.0
    powers = [getattr(limited_quantity(extremum.limit), "order", 0) for extremum in ratios]
    if not all(powers) or not all(math.isfinite(extremum.ratio) for extremum in ratios):
        return None
    return float(max(extremum.ratio ** (1.0 / power) for extremum, power in zip(ratios, powers)))


def interpolated(samples: ControllerSamples, motion: Trajectory) -> Trajectory:
    """Return the quintic motion a joint-trajectory controller draws through the samples."""
    t = samples.nanoseconds * NANOSECOND
    coefficients = hermite_pieces(t, samples.q, samples.v, samples.a)
    waypoints = np.round((motion.waypoint_times - motion.breakpoints[0]) / NANOSECOND) * NANOSECOND
    return Trajectory(t, coefficients, waypoints, "quintic", motion.case)


def to_ros2(samples: ControllerSamples, joint_names: Sequence[str]) -> str:
    """Return a FollowJointTrajectory goal as YAML, as ``ros2 action send_goal`` takes it.

    Raises
    ------
    InputError
        The number of names is not the number of joints, or two are equal.
    """
    if len(joint_names) != samples.q.shape[1] or len(set(joint_names)) != len(joint_names):
        raise InputError(
            f"{len(joint_names)} joint names given, expected {samples.q.shape[1]} different ones"
        )
    lines = [
        "trajectory:",
        "  joint_names: [" + ", ".join(_quote(name) for name in joint_names) + "]",
        "  points:",
    ]
    for place, time in enumerate(samples.nanoseconds.astype(np.int64).tolist()):
        lines.append(f"    - positions: {_flow(samples.q[place])}")
        lines.append(f"      velocities: {_flow(samples.v[place])}")
        lines.append(f"      accelerations: {_flow(samples.a[place])}")
        lines.append(f"      time_from_start: {{sec: {time // 10**9}, nanosec: {time % 10**9}}}")
    return "\n".join(lines) + "\n"


def _flow(values: Array) -> str:
    return "[" + ", ".join(_yaml_number(value) for value in values.tolist()) + "]"


def _yaml_number(value: float) -> str:
    """Return all digits; YAML 1.1 takes a number with an exponent only with a point in it."""
    text = format(value, ".17g")
    if "e" in text and "." not in text:
        return text.replace("e", ".0e")
    return text if "." in text or "e" in text else text + ".0"


def _quote(name: str) -> str:
    return "'" + name.replace("'", "''") + "'"


def to_urscript(
    trajectory: Trajectory, rate: float, name: str = "ocp_traj_motion", joint_names: Sequence[str] = ()
) -> tuple[str, float]:
    """Return a URScript program that streams the motion with ``servoj``, and how much slower it is.

    The program first moves to the start with ``movej``. The motion is slowed by less than one control period
    so that it ends on a sample; between samples the controller moves linearly. Names of the joints are a comment.

    Raises
    ------
    InputError
        The motion has not six joints, or the rate is no rate of a UR controller.
    """
    if trajectory.n != 6:
        raise InputError(f"the motion has {trajectory.n} joints, expected 6 for a UR arm")
    if not (math.isfinite(rate) and 1 <= rate <= 500):
        raise InputError(
            f"rate is {rate:g} Hz, expected 1 to 500 (125 for CB3 controllers, 500 for e-Series)"
        )
    periods = max(math.ceil(trajectory.duration * rate - 1e-9), 1)
    if periods > _MAXIMUM_SAMPLES:
        raise InputError(
            f"{trajectory.duration:g} s at {rate:g} Hz are too many samples, expected a lower rate"
        )
    scale = max(periods / rate / trajectory.duration, 1.0)
    slowed = trajectory.scaled(scale)
    q = slowed(slowed.breakpoints[0] + np.arange(periods + 1) / rate)
    comment = [f"# joints: {', '.join(joint_names)}"] if joint_names else []
    lines = [*comment, f"def {name}():", f"  movej({_joints(q[0])}, a=0.5, v=0.3)"]
    lines += [f"  servoj({_joints(row)}, 0, 0, {1 / rate:.6f}, 0.03, 1000)" for row in q[1:]]
    lines += ["  stopj(10.0)", "end", f"{name}()"]
    return "\n".join(lines) + "\n", scale


def _joints(q: Array) -> str:
    return "[" + ", ".join(f"{value:.12f}" for value in q.tolist()) + "]"
