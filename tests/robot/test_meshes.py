"""Meshes and link placements for pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from ocp_traj.exceptions import RobotError
from ocp_traj.robot import load_robot, robot_from_dh, robot_from_urdf, robot_names
from ocp_traj.robot.meshes import visual_meshes
from ocp_traj.robot.packaged import PACKAGED_ROBOTS, data_folder

MESH_URDF = """<?xml version="1.0"?>
<robot name="one">
  <link name="root"><visual><geometry><box size="1 1 1"/></geometry></visual></link>
  <link name="tip"><visual><geometry><mesh filename="package://nowhere/tip.stl"/></geometry></visual></link>
  <joint name="j" type="revolute"><parent link="root"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>
"""


@pytest.mark.parametrize("name", robot_names())
def test_meshes_are_files_carried_by_the_right_links(name: str) -> None:
    robot = load_robot(name)
    meshes = visual_meshes(robot)
    assert len(meshes) >= robot.n - 1
    assert all(mesh.path.is_file() for mesh in meshes)
    assert {mesh.link for mesh in meshes} <= set(range(robot.n + 1))


@pytest.mark.parametrize("name", ["ur5", "so100", "kinova"])
def test_meshes_stand_where_pinocchio_puts_them(name: str) -> None:
    robot = load_robot(name)
    path = data_folder() / PACKAGED_ROBOTS[name].urdf
    model = pin.buildModelFromUrdf(str(path))
    shapes = pin.buildGeomFromUrdf(
        model, str(path), pin.GeometryType.VISUAL, package_dirs=[str(path.parents[4])]
    )
    q = np.clip(np.full(robot.n, 0.4), *robot.position_limits)
    full = pin.neutral(model)
    for index, joint in enumerate(robot.joint_names):
        at = model.joints[model.getJointId(joint)]
        if at.nq == 2:
            full[at.idx_q : at.idx_q + 2] = np.cos(q[index]), np.sin(q[index])
        else:
            full[at.idx_q] = q[index]
    data, shape_data = model.createData(), shapes.createData()
    pin.updateGeometryPlacements(model, data, shapes, shape_data, full)
    expected = [
        placement.homogeneous
        for placement, shape in zip(shape_data.oMg, shapes.geometryObjects, strict=True)
        if Path(shape.meshPath).suffix
    ]
    links = robot.link_placements(q)
    found = [links[mesh.link] @ mesh.placement for mesh in visual_meshes(robot)]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_link_placements_start_with_the_root_and_use_the_base() -> None:
    robot = load_robot("ur5").with_changes(base="base")
    placements = robot.link_placements(np.zeros(6))
    assert placements.shape == (7, 4, 4)
    np.testing.assert_allclose(placements[0], np.diag([-1.0, -1.0, 1.0, 1.0]), atol=1e-10)
    np.testing.assert_allclose(placements[6], robot.pose(np.zeros(6), "wrist_3_link"), atol=1e-12)


def test_a_dh_robot_has_no_meshes() -> None:
    assert visual_meshes(robot_from_dh("standard", [1.0], [0.0], [0.0], [0.0])) == []


def test_a_missing_mesh_is_left_out_and_said_so(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "one.urdf").write_text(MESH_URDF)
    robot = robot_from_urdf(tmp_path / "one.urdf")
    assert visual_meshes(robot) == []
    (record,) = caplog.records
    assert "mesh package://nowhere/tip.stl of " in record.getMessage() and "is not there" in record.getMessage()
    (tmp_path / "one.urdf").unlink()
    with pytest.raises(RobotError, match=r"one\.urdf does not exist"):
        visual_meshes(robot)
