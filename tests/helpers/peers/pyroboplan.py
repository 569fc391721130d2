"""pyroboplan's CubicTrajectoryOptimization: cubics with free segment times, solved by SNOPT through Drake."""

from __future__ import annotations

import contextlib
import io
from typing import Any

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from helpers.peers.answer import PeerAnswer, from_piecewise, least_cpu_time, symmetric_limit
from ocp_traj.task import TrajectoryTask


def solve_with_pyroboplan(
    task: TrajectoryTask, *, knots: int | None = None, samples: int = 11, repeats: int = 1
) -> PeerAnswer:
    """Return pyroboplan's motion.

    Its knots are the waypoints; `knots` is for two waypoints only, where it may place more in between. End
    accelerations are free.
    """
    from pyroboplan.trajectory.trajectory_optimization import (
        CubicTrajectoryOptimization,
        CubicTrajectoryOptimizationOptions,
    )

    count = knots or len(task.waypoints)
    limits: dict[str, Any] = {}
    for name, short in (("velocity", "vel"), ("acceleration", "accel"), ("jerk", "jerk")):
        if task.limited(name):
            bound = symmetric_limit(task, name)
            limits |= {f"min_{short}": -bound, f"max_{short}": bound}
    options = CubicTrajectoryOptimizationOptions(
        num_waypoints=count, samples_per_segment=samples, max_segment_time=10.0, **limits
    )
    planner = CubicTrajectoryOptimization(*_joints_only(task), options)
    path = list(np.asarray(task.waypoints))
    with contextlib.redirect_stdout(io.StringIO()) as said:
        found, seconds = least_cpu_time(lambda: planner.plan(path), repeats)
    setting = f"{count} knots, {samples} samples a segment"
    if found is None:
        return PeerAnswer("pyroboplan", setting, None, seconds, said.getvalue().strip().splitlines()[-1])
    times = np.array([found.segment_times[0][0], *(segment[-1] for segment in found.segment_times)])
    knots_q = np.array([found.evaluate(t)[0] for t in times])
    knots_v = np.array([found.evaluate(t)[1] for t in times])
    curve = CubicHermiteSpline(times, knots_q, knots_v)
    waypoint_times = times if knots is None else times[[0, -1]]
    return PeerAnswer("pyroboplan", setting, from_piecewise(curve, waypoint_times, "cubic"), seconds)


def _joints_only(task: TrajectoryTask) -> tuple[Any, Any]:
    """Return a Pinocchio model that has the task's joints and position limits, and no bodies to collide."""
    import pinocchio

    model = pinocchio.Model()
    lower, upper = np.asarray(task.limits.get("position"))[0]
    for joint in range(task.n):
        parent = model.addJoint(
            joint, pinocchio.JointModelRZ(), pinocchio.SE3.Identity(), f"joint{joint + 1}"
        )
        assert parent == joint + 1
    model.lowerPositionLimit, model.upperPositionLimit = lower, upper
    return model, pinocchio.GeometryModel()
