"""The robot moving along its motions in a page: data for a small WebGL viewer, no network, no library."""

from __future__ import annotations

import base64
import json
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.meshes import Mesh, read_mesh, thin_out
from ocp_traj.comparison.pictures import tool_path
from ocp_traj.exceptions import OcpTrajError
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

_LOGGER = logging.getLogger(__name__)

FRAMES = 160
TRIANGLES = 1400
"""Triangles of one mesh at most."""

_SIDES = 14


@dataclass(frozen=True)
class Part:
    """A mesh that moves with a joint; -1 stands still with the base."""

    joint: int
    mesh: Mesh


@dataclass(frozen=True)
class Scene:
    """One motion to show."""

    name: str
    task: TrajectoryTask
    trajectory: Trajectory


def joint_poses(robot: Robot, q: Array) -> Array:
    """Return the placements (N, n, 4, 4) of all joint frames in the base frame for positions (N, n)."""
    links = robot.links
    poses = np.empty((len(q), len(links), 4, 4))
    start = np.linalg.inv(robot.base_placement)
    for number, link in enumerate(links):
        fixed = np.eye(4)
        fixed[:3, :3], fixed[:3, 3] = link.rotation, link.translation
        moved = np.broadcast_to(np.eye(4), (len(q), 4, 4)).copy()
        if link.prismatic:
            moved[:, 2, 3] = q[:, number]
        else:
            cosine, sine = np.cos(q[:, number]), np.sin(q[:, number])
            moved[:, 0, 0], moved[:, 0, 1], moved[:, 1, 0], moved[:, 1, 1] = cosine, -sine, sine, cosine
        parent = start if link.parent < 0 else poses[:, link.parent]
        poses[:, number] = parent @ fixed @ moved
    return poses


def robot_parts(robot: Robot) -> list[Part]:
    """Return the robot's own meshes, thinned out, or tubes between its joints where it has none."""
    try:
        parts = _mesh_parts(robot)
    except OcpTrajError as error:
        _LOGGER.info("no meshes for %s: %s", robot.name, error)
        parts = []
    return parts or stick_parts(robot)


def _mesh_parts(robot: Robot) -> list[Part]:
    parts: list[Part] = []
    if not hasattr(robot, "visual_meshes"):
        return parts
    for visual in robot.visual_meshes():
        mesh = thin_out(read_mesh(Path(visual.path)), TRIANGLES)
        vertices = mesh.vertices * np.asarray(visual.scale)
        placed = vertices @ visual.placement[:3, :3].T + visual.placement[:3, 3]
        joint = visual.joint
        if joint >= 0:
            placed = placed @ robot.links[joint].alignment  # into link axes, whose z is the joint axis
        else:
            base = np.linalg.inv(robot.base_placement)
            placed = placed @ base[:3, :3].T + base[:3, 3]
        parts.append(Part(joint, Mesh(placed, mesh.triangles)))
    return parts


def stick_parts(robot: Robot) -> list[Part]:
    """Return tubes from joint to joint and a drum on every joint axis; sizes follow the robot's reach."""
    links = robot.links
    joint, tool = robot.frame_placement()
    ends: list[tuple[int, Array]] = [(link.parent, link.translation) for link in links]
    if joint > 0:
        ends.append((joint - 1, links[joint - 1].alignment.T @ tool[:3, 3]))
    reach = sum(float(np.linalg.norm(end)) for _, end in ends) or 1.0
    parts = []
    base = np.linalg.inv(robot.base_placement)
    for parent, end in ends:
        begin: Array = np.zeros(3)
        if parent < 0:
            begin, end = np.asarray(base[:3, 3]), np.asarray(base[:3, :3] @ end + base[:3, 3])
        if np.linalg.norm(end - begin) > 1e-4 * reach:
            parts.append(Part(parent, tube(begin, end, 0.018 * reach)))
    drum = np.array([0.0, 0.0, 0.03 * reach])
    parts += [Part(number, tube(-drum, drum, 0.026 * reach)) for number in range(len(links))]
    return parts


def tube(begin: Array, end: Array, radius: float) -> Mesh:
    """Return a closed cylinder between two points."""
    axis = (end - begin) / np.linalg.norm(end - begin)
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    across = np.cross(axis, helper) / np.linalg.norm(np.cross(axis, helper))
    angles = 2 * np.pi * np.arange(_SIDES) / _SIDES
    ring = radius * (np.cos(angles)[:, None] * across + np.sin(angles)[:, None] * np.cross(axis, across))
    vertices = np.concatenate([begin + ring, end + ring, [begin, end]])
    here, there = np.arange(_SIDES), (np.arange(_SIDES) + 1) % _SIDES
    low, high = 2 * _SIDES, 2 * _SIDES + 1
    triangles = np.concatenate(
        [
            np.stack([here, there, here + _SIDES], axis=1),
            np.stack([there, there + _SIDES, here + _SIDES], axis=1),
            np.stack([there, here, np.full(_SIDES, low)], axis=1),
            np.stack([here + _SIDES, there + _SIDES, np.full(_SIDES, high)], axis=1),
        ]
    )
    return Mesh(vertices, triangles)


def scene_data(scenes: Sequence[Scene]) -> dict[str, Any]:
    """Return everything the viewer needs as JSON values; equal robots are stored once."""
    robots: dict[str, dict[str, Any]] = {}
    motions = []
    for scene in scenes:
        robot = scene.task.robot
        if robot is None:
            continue
        key = robot.digest()
        if key not in robots:
            robots[key] = {"parts": [_packed_part(part) for part in robot_parts(robot)]}
        t = np.linspace(scene.trajectory.breakpoints[0], scene.trajectory.breakpoints[-1], FRAMES)
        poses = joint_poses(robot, scene.trajectory(t))
        motions.append(
            {
                "name": scene.name,
                "robot": list(robots).index(key),
                "duration": scene.trajectory.duration,
                "joints": robot.n,
                "frames": FRAMES,
                "poses": _encode(poses[:, :, :3, :].astype("<f4")),
                "path": _encode(tool_path(scene.task, scene.trajectory, t).astype("<f4")),
                "waypoints": _encode(np.asarray(tool_path_of_waypoints(scene)).astype("<f4")),
            }
        )
    return {"robots": list(robots.values()), "motions": motions}


def tool_path_of_waypoints(scene: Scene) -> Array:
    """Return where the tool is at the waypoints (K, 3)."""
    return tool_path(scene.task, scene.trajectory, np.asarray(scene.trajectory.waypoint_times))


def _packed_part(part: Part) -> dict[str, Any]:
    """Quantise vertices to 16 bits of the mesh's box: far below what a screen shows."""
    vertices, triangles = part.mesh.vertices, part.mesh.triangles
    offset = vertices.min(axis=0)
    scale = float(max((vertices - offset).max(), 1e-9)) / 65535.0
    return {
        "joint": part.joint,
        "offset": offset.tolist(),
        "scale": scale,
        "vertices": _encode(np.round((vertices - offset) / scale).astype("<u2")),
        "triangles": _encode(triangles.astype("<u2")),
    }


def _encode(values: np.ndarray[Any, Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def viewer_html(scenes: Sequence[Scene], templates: Path) -> str:
    """Return the viewer as a piece of HTML with its data and script, or nothing without a robot."""
    data = scene_data(scenes)
    if not data["motions"]:
        return ""
    # "<" must not appear in the data: a script element ends at the first "</script".
    content = json.dumps(data).replace("<", "\\u003c")
    script = (templates / "viewer.js").read_text(encoding="utf-8")
    return (
        '<div class="viewer"><canvas aria-label="Robot moving along the chosen motion" role="img"></canvas>'
        '<div class="controls"><button type="button" class="play">Pause</button>'
        '<select aria-label="Motion"></select>'
        '<input type="range" min="0" max="1" step="0.001" value="0" aria-label="Time"><output></output>'
        "</div></div>"
        f'<script type="application/json" id="viewer-data">{content}</script><script>{script}</script>'
    )
