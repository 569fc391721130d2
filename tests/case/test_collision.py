"""The ``[collision]`` table: read to the letter, written back, part of the digest, refused by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ocp_traj.case import dumps, load_case_text, task_digest
from ocp_traj.collision import Contact, Shape, Solid
from ocp_traj.exceptions import CaseError

CASE = """
schema = 1
name = "cell"
[robot]
model = "ur5"
[waypoints]
joints = [[0, -1, 1, 0, 0.5, 0], [0.5, -1, 1, 0, 0.5, 0], [1, -1, 1, 0, 0.5, 0]]
[limits]
acceleration = 5
[collision]
"""

FULL = """
margin = 0.001
self = false
self_margin = 0.002
pairs = "srdf"
cover = 4
ignore = [["forearm_link", "wrist_2_link"]]
tool = [{ name = "gripper", capsule = { radius = 0.04, length = 0.12 }, pose = [0, 0, 0.06, 0, 0, 0, 1], gaps = [2] }]
[[collision.obstacles]]
name = "shelf"
box = [0.8, 0.3, 0.02]
pose = [0.6, 0.0, 0.5, 0, 0, 0, 1]
margin = 0.02
gaps = [1, 2]
[[collision.obstacles]]
name = "floor"
halfspace = [0, 0, 1, -0.1]
[[collision.obstacles]]
name = "ball"
sphere = 0.1
[[collision.obstacles]]
name = "post"
cylinder = { radius = 0.1, length = 1 }
[[collision.obstacles]]
name = "vise"
mesh = "vise.stl"
[[collision.obstacles]]
name = "case"
mesh = "vise.stl"
convex = true
[[collision.contact]]
bodies = ["gripper", "ball"]
waypoint = 3
within = 0.15
depth = 0.001
"""

STL = """solid v
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 0 {top}
endloop
endfacet
endsolid v
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "vise.stl").write_text(STL.format(top=1))
    return tmp_path


def test_every_key_is_read_and_written_back(folder: Path) -> None:
    task = load_case_text(CASE + FULL, folder=folder)
    scene = task.collision
    assert scene is not None
    assert (scene.margin, scene.self_margin, scene.with_itself, scene.pairs, scene.cover) == (
        0.001, 0.002, False, "srdf", 4,
    )  # fmt: skip
    assert scene.tool == (
        Solid("gripper", Shape("capsule", (0.04, 0.12)), (0, 0, 0.06, 0, 0, 0, 1), gaps=(1,)),
    )
    assert [solid.shape.kind for solid in scene.obstacles] == [
        "box", "halfspace", "sphere", "cylinder", "mesh", "mesh",
    ]  # fmt: skip
    assert [solid.shape.convex for solid in scene.obstacles] == [False] * 5 + [True]
    assert scene.obstacles[0].margin == 0.02
    assert scene.obstacles[0].gaps == (0, 1)
    assert scene.contact == (Contact(("gripper", "ball"), 2, 0.15, 0.001),)
    again = load_case_text(dumps(task, folder), folder=folder)
    assert again.collision == scene
    assert task_digest(again) == task_digest(task)


@pytest.mark.parametrize(
    "change",
    [
        ("margin = 0.001", "margin = 0.003"),
        ("0.6, 0.0, 0.5", "0.6, 0.0, 0.51"),
        ("depth = 0.001", "depth = 0.002"),
        ("cover = 4", "cover = 16"),
        ("convex = true", "convex = false"),
        ('"wrist_2_link"', '"wrist_3_link"'),
        ("gaps = [1, 2]", "gaps = [1]"),
    ],
)
def test_everything_said_of_the_scene_enters_the_digest(folder: Path, change: tuple[str, str]) -> None:
    task = load_case_text(CASE + FULL, folder=folder)
    assert task_digest(load_case_text(CASE + FULL.replace(*change), folder=folder)) != task_digest(task)


def test_the_contents_of_a_mesh_enter_the_digest(folder: Path) -> None:
    before = task_digest(load_case_text(CASE + FULL, folder=folder))
    (folder / "vise.stl").write_text(STL.format(top=2))
    assert task_digest(load_case_text(CASE + FULL, folder=folder)) != before


def test_a_case_without_a_scene_has_none() -> None:
    task = load_case_text(CASE.replace("[collision]", ""))
    assert task.collision is None
    assert "collision" not in dumps(task)


def test_poses_turn_and_move() -> None:
    solid = Solid("s", Shape("sphere", (1.0,)), (1, 2, 3, 0, 0, np.sqrt(0.5), np.sqrt(0.5)))
    expected = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    np.testing.assert_allclose(solid.placement, expected, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "key", "problem"),
    [
        ("margn = 1", "collision.margn", "unknown key"),
        ("margin = -0.1", "collision.margin", "-0.1 given, expected a length of 0 or more, m"),
        ("self_margin = inf", "collision.self_margin", "inf given, expected a finite number"),
        ("self = 1", "collision.self", "1 given, expected true or false"),
        ("pairs = 'all'", "collision.pairs", "the text 'all' given, expected one of adjacent, srdf"),
        ("cover = 0", "collision.cover", "0 given, expected 1 to 256 convex pieces"),
        ("ignore = ['a']", "collision.ignore[1]", "the text 'a' given, expected two names of bodies"),
        ("ignore = [['a', 'base_link']]", "collision.ignore", "'a' is no body"),
        ("obstacles = [{ name = 'x' }]", "collision.obstacles[1]", "no shape given"),
        ("obstacles = [{ name = 'x', sphere = 1, box = [1, 1, 1] }]", "collision.obstacles[1]", "box and sphere"),
        ("obstacles = [{ name = 'x', sphere = 0 }]", "collision.obstacles[1]", "expected sizes above 0"),
        ("obstacles = [{ name = 'x', box = [1, 1] }]", "collision.obstacles[1].box", "expected 3 numbers"),
        ("obstacles = [{ name = 'x', halfspace = [0, 0, 0, 1] }]", "collision.obstacles[1]", "normal 0"),
        ("obstacles = [{ name = 'x', cylinder = { radius = 1 } }]", "obstacles[1].cylinder.length", "missing"),
        ("obstacles = [{ name = 'x', sphere = 1, pose = [0, 0, 0, 0, 0, 0, 2] }]", "obstacles[1]", "length 1"),
        ("obstacles = [{ name = 'x', sphere = 1, gaps = [3] }]", "obstacles[1].gaps", "expected gaps from 1 to 2"),
        ("obstacles = [{ name = 'x', sphere = 1, gaps = [] }]", "obstacles[1].gaps", "an empty list given"),
        ("obstacles = [{ name = 'x', mesh = 'no.stl' }]", "obstacles[1].mesh", "does not exist"),
        ("obstacles = [{ name = 'x', mesh = '/etc/passwd' }]", "obstacles[1].mesh", "leads out of the case's folder"),
        ("obstacles = [{ name = 'x', sphere = 1, convex = true }]", "obstacles[1].convex", "belongs to a mesh"),
        ("obstacles = [{ name = 'x', sphere = 1 }, { name = 'x', sphere = 1 }]", "collision", "two bodies"),
        ("tool = [{ name = 'x', sphere = 1, margin = 1 }]", "tool[1].margin", "unknown key"),
        ("tool = [{ name = 'x', halfspace = [0, 0, 1, 0] }]", "collision.tool", "expected a body of finite size"),
        ("contact = [{ waypoint = 1, within = 1, depth = 1 }]", "contact[1].bodies", "expected two names"),
        (
            "contact = [{ bodies = ['a', 'b'], waypoint = 4, within = 1, depth = 1 }]",
            "collision.contact[1].waypoint",
            "4 given, expected a whole number from 0 to 3",
        ),
    ],
)
def test_a_wrong_scene_is_refused_by_key(text: str, key: str, problem: str) -> None:
    with pytest.raises(CaseError) as refused:
        load_case_text(CASE + text)
    assert refused.value.key.endswith(key)
    assert problem in refused.value.problem


def test_a_scene_without_a_robot_is_refused() -> None:
    with pytest.raises(CaseError, match="collision: needs a robot, but the case has no"):
        load_case_text(CASE.replace('[robot]\nmodel = "ur5"', ""))
