"""Starts and goals of published problems touch nothing, by covers that hold the meshes."""

from __future__ import annotations

from pathlib import Path

import pytest

from helpers.collision.cells import panda_with_open_fingers, problems
from ocp_traj.collision import CollisionScene, cell_of
from ocp_traj.robot import Robot, load_robot
from ocp_traj.robot.packaged import data_folder


@pytest.mark.parametrize("name", ["ur5", "panda"])
def test_published_starts_and_goals_are_free(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = robot_named(name, tmp_path, monkeypatch)
    chosen = [problem for problem in problems() if problem["robot"] == name]
    assert len(chosen) == 7
    for problem in chosen:
        cell = cell_of(robot, problem["scene"])
        for end in ("start", "goal"):
            found = [str(overlap) for overlap in cell.collisions(problem[end])]
            assert not found, (problem["family"], end, found)


def robot_named(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Robot:
    if name == "ur5":
        return load_robot("ur5")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(data_folder().parents[1]))
    return panda_with_open_fingers(folder)


def test_one_hull_a_link_is_too_coarse_and_finer_pieces_are_not() -> None:
    end = [0.0809, -1.4063, 2.3989, 2.1423, -0.4582, 0.0042]  # goal of bookshelf_small 9
    coarse, fine = (cell_of(load_robot("ur5"), CollisionScene(cover=cover)) for cover in (1, 16))
    assert [overlap.bodies for overlap in coarse.collisions(end)] == [("wrist_2_link", "forearm_link")]
    assert fine.collisions(end) == []
