"""Bounds of the distance of moving bodies over intervals: none is above the truth, each is tight to its order."""

from __future__ import annotations

from collections.abc import Callable
from math import comb
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from helpers.collision.cells import random_scene
from ocp_traj.audit.clearance.placements import Placements
from ocp_traj.audit.clearance.separation import Frames, Stretch, second_order, separation
from ocp_traj.audit.clearance.surface import Surface
from ocp_traj.collision import Cell, CollisionScene, Shape, Solid, cell_of
from ocp_traj.collision.distances import Measure
from ocp_traj.robot import Robot, load_robot, robot_from_dh, robot_from_urdf

GANTRY = """<?xml version="1.0"?>
<robot name="gantry">
  <link name="root"><collision><geometry><box size="0.3 0.3 0.1"/></geometry></collision></link>
  <link name="left"><collision>
    <origin xyz="0.2 0 0.1"/><geometry><box size="0.4 0.1 0.1"/></geometry></collision></link>
  <link name="left_tip"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="right"><collision>
    <origin xyz="0 0.2 0"/><geometry><cylinder radius="0.05" length="0.5"/></geometry></collision></link>
  <joint name="a" type="prismatic"><parent link="root"/><child link="left"/><origin xyz="0 0 0.3"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="b" type="revolute"><parent link="left"/><child link="left_tip"/>
    <origin xyz="0.5 0 0" rpy="1 0 0"/><axis xyz="0 1 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="c" type="revolute"><parent link="root"/><child link="right"/>
    <origin xyz="0.2 0.3 0.2"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>
"""
"""Two branches on one root, one of which slides."""


def gantry(folder: Path) -> Robot:
    path = folder / "gantry.urdf"
    path.write_text(GANTRY, encoding="utf-8")
    return robot_from_urdf(path)


def arm(folder: Path) -> Robot:
    return load_robot("ur5")


ROBOTS: dict[str, Callable[[Path], Robot]] = {"ur5": arm, "gantry": gantry}


@pytest.mark.parametrize("name", ["ur5", "panda", "kinova", "so100", "scara"])
def test_placements_are_those_of_pinocchio(name: str) -> None:
    kinds = ["revolute", "prismatic", "revolute"]
    scara = robot_from_dh("modified", [0, 0.3, 0.2], [0, 0.4, 0], [0.1] * 3, [0] * 3, joints=kinds)
    robot = scara if name == "scara" else load_robot(name)
    rng = np.random.default_rng(0)
    q = rng.uniform(-2, 2, (20, robot.n))
    data = robot.bare_model.createData()
    for row, found in zip(q, Placements(robot).at(q), strict=True):
        pin.forwardKinematics(robot.bare_model, data, row)
        np.testing.assert_allclose(found, [place.homogeneous for place in data.oMi], atol=1e-12)


def check_bounds(cell: Cell, rounds: int, seed: int) -> tuple[int, float, float, float]:
    """Return how many bounds were compared, and by how much the largest of either order exceeded the truth, m."""
    rng = np.random.default_rng(seed)
    kinematics, n = Placements(cell.robot), cell.robot.n
    surface = Surface(cell, kinematics)
    pair = np.arange(len(cell.pairs))
    worst = [-np.inf, -np.inf, -np.inf]
    for _ in range(rounds):
        half = np.array([10.0 ** rng.uniform(-3, -0.5)])
        sizes = 10.0 ** rng.uniform(-1, 0.7, 4) * [0.5, 1.0, 1.0, 1.0]
        local = rng.normal(size=(1, n, 4)) * sizes
        start = np.stack([_shifted(local, power, -half[0]) for power in range(4)], axis=-1)
        stretch = Stretch.of(start, half, half)
        frames = Frames.of(kinematics, stretch.q)
        interval = np.zeros(len(pair), dtype=np.int64)
        a, b = surface.sides(pair, frames.places, interval)
        travel = stretch.travel[interval]
        levers = a.levers(frames, interval, travel), b.levers(frames, interval, travel)
        measure = Measure(frames.places[0])
        normals = np.array([measure.plane(*surface.bodies_of(int(number)))[1] for number in pair])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        first = separation(a, b, normals) - sum((lever * travel).sum(axis=1) for lever in levers)
        second = second_order(a, b, normals, levers, frames, stretch, interval)
        apart = np.linalg.norm(b.centre - a.centre, axis=1) - a.ball - b.ball
        balls = apart - sum((lever * travel).sum(axis=1) for lever in levers)
        tau = np.linspace(-half[0], half[0], 12)
        truth = np.full(len(pair), np.inf)
        for places in kinematics.at((local[0] @ (tau ** np.arange(4)[:, None])).T):
            here = Measure(places)
            truth = np.minimum(truth, [here.plane(*surface.bodies_of(int(number)))[0] for number in pair])
        for order, bound in enumerate((balls, first, second)):
            worst[order] = max(worst[order], float((bound - truth).max()))
    return 3 * rounds * len(pair), *worst


def _shifted(local: np.ndarray, power: int, by: float) -> np.ndarray:
    """Return a coefficient of polynomials (..., 4) about a point that lies `by` further on."""
    return sum(local[..., k] * comb(k, power) * by ** (k - power) for k in range(power, local.shape[-1]))


@pytest.mark.parametrize("name", ROBOTS)
def test_no_bound_is_above_the_truth(name: str, tmp_path: Path) -> None:
    scene = random_scene(np.random.default_rng(5), 4)
    floor = Solid("floor", Shape("halfspace", (0.0, 0.0, 1.0, -0.5)))
    post = Solid("post", Shape("cylinder", (0.05, 1.0)), (0.5, 0.5, 0, 0, 0, 0, 1))
    tool = Solid("tool", Shape("capsule", (0.03, 0.1)), (0, 0, 0.1, 0, 0, 0, 1))
    cell = cell_of(ROBOTS[name](tmp_path), CollisionScene((*scene.obstacles, floor, post), (tool,)))
    compared, *above = check_bounds(cell, 20, 1)
    assert compared >= 1000
    assert max(above) <= 2e-6  # coal's own accuracy


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_no_bound_is_above_the_truth_a_hundred_thousand_times(name: str, tmp_path: Path) -> None:
    cell = cell_of(ROBOTS[name](tmp_path), random_scene(np.random.default_rng(6)))
    compared, *above = check_bounds(cell, 1 + 100_000 // (3 * len(cell.pairs)), 2)
    assert compared >= 100_000
    assert max(above) <= 2e-6


def test_the_first_order_loses_in_proportion_to_time_and_the_second_to_its_square() -> None:
    cell = cell_of(load_robot("ur5"), random_scene(np.random.default_rng(3), 1))
    kinematics = Placements(cell.robot)
    surface = Surface(cell, kinematics)
    pair = np.flatnonzero([cell.names(pair)[1] == "box0" for pair in cell.pairs])[-1:]
    polynomial = np.random.default_rng(0).normal(size=(1, 6, 4))
    lost = []
    for half in (1e-2, 1e-3):
        stretch = Stretch.of(polynomial, np.array([0.5]), np.array([half]))
        frames = Frames.of(kinematics, stretch.q)
        none = np.zeros(1, dtype=np.int64)
        a, b = surface.sides(pair, frames.places, none)
        levers = a.levers(frames, none, stretch.travel), b.levers(frames, none, stretch.travel)
        normal = np.array([Measure(frames.places[0]).plane(*surface.bodies_of(int(pair[0])))[1]])
        normal /= np.linalg.norm(normal)
        middle = separation(a, b, normal)
        ends = b.lowest_at_ends(normal, frames, stretch, none) + a.lowest(-normal)
        second = second_order(a, b, normal, levers, frames, stretch, none)
        lost.append([float((levers[1] * stretch.travel).sum()), float((ends.min(axis=0) - second)[0])])
        assert second[0] <= middle[0]
    assert lost[0][0] / lost[1][0] == pytest.approx(10.0, rel=0.1)
    assert lost[0][1] / lost[1][1] == pytest.approx(100.0, rel=0.1)
