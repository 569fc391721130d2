"""Meshes are read and thinned without losing their shape, and the viewer moves them as the robot moves."""

from __future__ import annotations

import base64
import struct
from pathlib import Path

import numpy as np
import pytest

from ocp_traj.comparison.report.report import TEMPLATES
from ocp_traj.exceptions import InputError
from ocp_traj.pictures.meshes import Mesh, read_mesh, thin_out
from ocp_traj.pictures.viewer import Scene, robot_parts, scene_data, stick_parts, tube, viewer_html
from ocp_traj.robot import load_robot, robot_from_dh, robot_from_urdf
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])

_COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.5" name="half"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="f" count="12">{points}</float_array><technique_common>
<accessor source="#f" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
{faces}
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene"><node><translate>0 0 2</translate>
<rotate>0 0 1 90</rotate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>"""


def volume(mesh: Mesh) -> float:
    """Signed volume of a closed mesh."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]] for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def binary_stl() -> bytes:
    data = b"binary".ljust(80) + struct.pack("<I", 4)
    for face in FACES:
        data += struct.pack("<12fH", 0, 0, 0, *CORNERS[face].ravel(), 0)
    return data


def ascii_stl() -> bytes:
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in CORNERS[face])
        + "endloop\nendfacet\n"
        for face in FACES
    )
    return f"solid x\n{facets}endsolid".encode()


def obj() -> bytes:
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS] + [
        f"f {a + 1}/1 {b + 1}/1 {c + 1}/1" for a, b, c in FACES
    ]
    return "\n".join(lines).encode()


@pytest.mark.parametrize(
    ("name", "data"),
    [("a.stl", binary_stl()), ("b.STL", ascii_stl()), ("c.obj", obj())],
    ids=["binary", "ascii", "obj"],
)
def test_a_tetrahedron_is_read(tmp_path: Path, name: str, data: bytes) -> None:
    (tmp_path / name).write_bytes(data)
    mesh = read_mesh(tmp_path / name)
    assert (len(mesh.vertices), len(mesh.triangles)) == (4, 4)
    assert volume(mesh) == pytest.approx(1 / 6)


@pytest.mark.parametrize("kind", ["triangles", "polylist"])
def test_collada_is_placed_by_its_nodes_and_unit(tmp_path: Path, kind: str) -> None:
    indices = " ".join(f"{corner} 0" for face in FACES for corner in face)
    counts = "<vcount>3 3 3 3</vcount>" if kind == "polylist" else ""
    faces = (
        f'<{kind} count="4"><input semantic="VERTEX" source="#v" offset="0"/>'
        f'<input semantic="NORMAL" source="#s" offset="1"/>{counts}<p>{indices}</p></{kind}>'
    )
    points = " ".join(str(value) for value in CORNERS.ravel())
    (tmp_path / "m.dae").write_text(_COLLADA.format(points=points, faces=faces))
    mesh = read_mesh(tmp_path / "m.dae")
    x, y, z = CORNERS.T
    turned = 0.5 * np.stack([-y, x, z + 2.0], axis=1)
    found = mesh.vertices[np.lexsort(np.round(mesh.vertices.T, 6))]
    single = 2 * np.finfo(np.float32).eps  # meshes are read in single precision
    np.testing.assert_allclose(found, turned[np.lexsort(turned.T)], rtol=0, atol=single)
    assert volume(mesh) == pytest.approx(1 / 48)


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("x.ply", b""),
        ("x.dae", b"<COLLADA"),
        ("x.dae", b"<!DOCTYPE a [<!ENTITY b 'c'>]><a/>"),
        ("x.obj", b"v 0 0 0\nf 1 2 3"),
        ("missing-corner.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 9\n"),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"),
        ("cut.stl", binary_stl()[:-30]),
    ],
)
def test_what_is_no_mesh_is_refused(tmp_path: Path, name: str, data: bytes) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=name):
        read_mesh(tmp_path / name)


def test_thinning_keeps_volume_and_limit() -> None:
    mesh = tube(np.zeros(3), np.array([0.0, 0.0, 1.0]), 0.5)
    fine = subdivided(subdivided(subdivided(mesh)))
    thin = thin_out(fine, 400)
    assert len(fine.triangles) > 3000
    assert 100 < len(thin.triangles) <= 400
    assert volume(thin) == pytest.approx(volume(fine), rel=0.1)


def subdivided(mesh: Mesh) -> Mesh:
    """Every triangle cut into four."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]] for corner in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    corners = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    vertices, inverse = np.unique(corners, axis=0, return_inverse=True)
    return Mesh(vertices, inverse.reshape(-1, 3))


def test_a_tube_is_closed() -> None:
    mesh = tube(np.array([0.0, 0, 0]), np.array([0.0, 0, 2]), 0.5)
    sides = 14
    assert abs(volume(mesh)) == pytest.approx(2 * 0.25 * sides / 2 * np.sin(2 * np.pi / sides))


def test_ur5_has_its_meshes_on_every_link() -> None:
    parts = robot_parts(load_robot("ur5"))
    assert {part.link for part in parts} == set(range(7))
    assert all(len(part.mesh.triangles) <= 1400 for part in parts)
    reach = max(np.abs(part.mesh.vertices).max() for part in parts)
    assert 0.3 < reach < 0.6  # the upper arm is 0.425 m long


def test_one_missing_mesh_costs_one_mesh_and_materials_give_the_colours(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "arm.urdf").write_text(COLOURED)
    (tmp_path / "whole.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    (tmp_path / "broken.stl").write_text("no mesh")
    robot = robot_from_urdf(tmp_path / "arm.urdf")
    assert [part.colour for part in robot_parts(robot)] == [(1.0, 0.5, 0.0), (0.2, 0.3, 0.4), None]
    told = [record.getMessage() for record in caplog.records]
    assert len(told) == 2 and all(text.endswith("; it is left out of the picture") for text in told)
    task = TrajectoryTask(np.array([[0.0], [0.3]]), robot=robot, virtual_knots=3)
    line = Trajectory(np.array([0.0, 1.0]), np.array([[[0.0, 0.3]]]), np.array([0.0, 1.0]))
    parts = scene_data([Scene("a", task, line)])["robots"][0]["parts"]
    assert [part["colour"] for part in parts] == [(1.0, 0.5, 0.0), (0.2, 0.3, 0.4), None]


COLOURED = """<robot name="coloured"><material name="orange"><color rgba="1 0.5 0 1"/></material>
<link name="base">
<visual><geometry><mesh filename="whole.obj"/></geometry><material name="orange"/></visual>
<visual><geometry><mesh filename="missing.obj"/></geometry><material name="orange"/></visual>
<visual><geometry><mesh filename="broken.stl"/></geometry></visual></link>
<link name="tip">
<visual><geometry><mesh filename="whole.obj"/></geometry>
<material name=""><color rgba="0.2 0.3 0.4 1"/></material></visual>
<visual><geometry><mesh filename="whole.obj"/></geometry><material name="unknown"/></visual></link>
<joint name="j" type="continuous"><parent link="base"/><child link="tip"/></joint></robot>"""


def test_a_robot_without_meshes_is_drawn_as_tubes() -> None:
    robot = robot_from_dh("standard", [0.5, 0.4], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], "rad")
    parts = stick_parts(robot)
    assert {part.link for part in parts} == {1, 2}
    assert max(np.linalg.norm(part.mesh.vertices, axis=1).max() for part in parts) == pytest.approx(
        0.5, rel=0.01
    )


def test_the_page_holds_the_poses_of_the_robot() -> None:
    robot = load_robot("ur5")
    task = TrajectoryTask(np.array([np.zeros(6), np.full(6, 0.3)]), robot=robot, virtual_knots=3, name="<x>")
    line = Trajectory(
        np.array([0.0, 1.0]), np.stack([np.zeros(6), np.full(6, 0.3)], axis=1)[None], np.array([0.0, 1.0])
    )
    scenes = [Scene("a </script> b", task, line)]
    motion = scene_data(scenes)["motions"][0]
    poses = np.frombuffer(base64.b64decode(motion["poses"]), "<f4").reshape(motion["frames"], 7, 3, 4)
    np.testing.assert_allclose(poses[-1], robot.link_placements(np.full(6, 0.3))[:, :3], atol=1e-6)
    page = viewer_html(scenes, TEMPLATES)
    assert page.count("</script>") == 2
    assert viewer_html([], TEMPLATES) == ""
