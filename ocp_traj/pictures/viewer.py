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
from ocp_traj.exceptions import OcpTrajError
from ocp_traj.pictures.meshes import Mesh, read_mesh, thin_out
from ocp_traj.pictures.motion import tool_path
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

if TYPE_CHECKING:
    from ocp_traj.robot.meshes import VisualMesh
    from ocp_traj.robot.robot import Robot

_LOGGER = logging.getLogger(__name__)

FRAMES = 160
TRIANGLES = 1400
"""Triangles of one mesh at most."""

_SIDES = 14


@dataclass(frozen=True)
class Part:
    """A mesh that moves with a link: 0 is the root, i what joint i moves (`Robot.link_placements`); with its colour."""

    link: int
    mesh: Mesh
    colour: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Scene:
    """One motion to show."""

    name: str
    task: TrajectoryTask
    trajectory: Trajectory


def robot_parts(robot: Robot) -> list[Part]:
    """Return the robot's own meshes, thinned out, or tubes between its joints where it has none.

    A mesh that cannot be read is left out, and said so in the log.
    """
    from ocp_traj.robot.meshes import visual_meshes

    parts = []
    try:
        for visual in visual_meshes(robot):
            try:
                parts.append(_mesh_part(visual))
            except OcpTrajError as error:
                _LOGGER.warning("%s; it is left out of the picture", error)
    except OcpTrajError as error:
        _LOGGER.warning("no meshes for %s: %s", robot.name, error)
    return parts or stick_parts(robot)


def _mesh_part(visual: VisualMesh) -> Part:
    mesh = thin_out(read_mesh(visual.path), TRIANGLES)
    vertices = mesh.vertices * visual.scale @ visual.placement[:3, :3].T + visual.placement[:3, 3]
    return Part(visual.link, Mesh(vertices, mesh.triangles), visual.colour)


def stick_parts(robot: Robot) -> list[Part]:
    """Return tubes from joint to joint and a drum on every joint axis; sizes follow the robot's reach."""
    placements = robot.link_placements(np.zeros(robot.n))
    parents = [link.parent + 1 for link in robot.links]
    carrier, tool = robot.frame_placement()
    ends = [
        (parent, (np.linalg.inv(placements[parent]) @ placements[number + 1])[:3, 3])
        for number, parent in enumerate(parents)
    ]
    ends.append((carrier, tool[:3, 3]))
    reach = sum(float(np.linalg.norm(end)) for _, end in ends) or 1.0
    parts = [
        Part(parent, tube(np.zeros(3), end, 0.018 * reach))
        for parent, end in ends
        if np.linalg.norm(end) > 1e-4 * reach
    ]
    for number, link in enumerate(robot.links):
        half = 0.03 * reach * link.alignment[:, 2]  # the joint's axis
        parts.append(Part(number + 1, tube(-half, half, 0.026 * reach)))
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
        poses = np.array([robot.link_placements(q) for q in scene.trajectory(t)])
        motions.append(
            {
                "name": scene.name,
                "robot": list(robots).index(key),
                "duration": scene.trajectory.duration,
                "links": poses.shape[1],
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
        "link": part.link,
        "colour": part.colour,
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
