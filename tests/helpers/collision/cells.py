"""Cells and motions for tests of collision: a UR5 among boxes, and published problems."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ocp_traj.arrays import Array
from ocp_traj.collision import CollisionScene, Shape, Solid
from ocp_traj.robot import Robot, load_robot, robot_from_urdf
from ocp_traj.robot.packaged import PACKAGED_ROBOTS, data_folder
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory

PROBLEMS = Path(__file__).parents[2] / "data" / "collision" / "problems.jsonl"
"""Starts and goals among obstacles, one JSON object a line: MotionBenchMaker's (Chamzas et al. 2022), from VAMP."""

FREE = Limits(position=np.inf, velocity=np.inf, acceleration=np.inf, torque=np.inf)
"""No limits but those of collision."""


def clamped(waypoints: Any, times: Any) -> Trajectory:
    """Return the cubic spline through waypoints, at rest at both ends."""
    spline = CubicSpline(times, waypoints, bc_type="clamped")
    return Trajectory(times, spline.c[::-1].transpose(1, 2, 0), times, "cubic")


def task_among(scene: CollisionScene, waypoints: Any, robot: Robot | None = None) -> TrajectoryTask:
    """Return a task of an arm (the UR5) in a scene, without limits of its joints."""
    arm = load_robot("ur5") if robot is None else robot
    boundary = Boundary(acceleration=None)
    return TrajectoryTask(waypoints, FREE, arm, boundary=boundary, collision=scene)


def random_scene(rng: np.random.Generator, count: int = 10) -> CollisionScene:
    """Return boxes around a robot that stands at the origin."""
    solids = []
    while len(solids) < count:
        centre = rng.uniform([-0.9, -0.9, -0.6], [0.9, 0.9, 1.2])
        if np.linalg.norm(centre[:2]) > 0.35:
            shape = Shape("box", tuple(rng.uniform(0.05, 0.25, 3)))
            solids.append(Solid(f"box{len(solids)}", shape, (*centre, 0, 0, 0, 1)))
    return CollisionScene(tuple(solids))


def random_motion(rng: np.random.Generator) -> Trajectory:
    """Return a motion of 3 s of a UR5 through three random postures."""
    spread, middle = np.array([2.5, 1.2, 1.5, 2.0, 2.0, 3.0]), np.array([0.0, -1.2, 0.5, 0.0, 0.0, 0.0])
    return clamped(rng.uniform(-1.0, 1.0, (3, 6)) * spread + middle, [0.0, 1.5, 3.0])


def solid_of(entry: dict[str, Any]) -> Solid:
    """Return an obstacle of a published problem."""
    kind = next(name for name in ("box", "sphere", "cylinder") if name in entry)
    size = entry[kind]
    sizes = {"box": lambda: size, "sphere": lambda: [size], "cylinder": lambda: [size["radius"], size["length"]]}
    return Solid(entry["name"], Shape(kind, tuple(sizes[kind]())), tuple(entry["pose"]))


def problems(path: Path = PROBLEMS) -> Iterator[dict[str, Any]]:
    """Yield published problems; ``scene`` holds their obstacles."""
    for line in path.read_text(encoding="utf-8").splitlines():
        entry = json.loads(line)
        yield {**entry, "scene": CollisionScene(tuple(solid_of(item) for item in entry["obstacles"]))}


def panda_with_open_fingers(folder: Path) -> Robot:
    """Return the Panda with its fingers at 0.065 m, wider than their range, as the published problems have it.

    The description is written to `folder`; ROS_PACKAGE_PATH has to lead to the robots' data.
    """
    entry = PACKAGED_ROBOTS["panda"]
    text = (data_folder() / entry.urdf).read_text(encoding="utf-8")
    for number, sign in ((1, 1.0), (2, -1.0)):
        pattern = rf'(<joint name="panda_finger_joint{number}".*?<origin rpy="[^"]*" xyz=")([^"]*)(")'
        match = re.search(pattern, text, re.DOTALL)
        assert match is not None
        x, y, z = (float(word) for word in match[2].split())
        text = text[: match.start(2)] + f"{x} {y + sign * 0.065} {z}" + text[match.end(2) :]
    path = folder / "panda.urdf"
    path.write_text(text, encoding="utf-8")
    return robot_from_urdf(path, entry.lock, tool=entry.tool, name="panda")


def configurations(motion: Trajectory, count: int) -> Array:
    """Return a motion's configurations at even times, (count, n)."""
    return motion(np.linspace(0.0, motion.duration, count))
