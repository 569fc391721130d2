"""Covers of meshes: they hold the mesh, piece by piece, and finer ones hold less besides it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ocp_traj.collision.bodies import SIGNS, Body, transformed
from ocp_traj.collision.covers import Piece, cover, holds
from ocp_traj.collision.mesh_files import read_mesh
from ocp_traj.robot import load_robot
from ocp_traj.robot.meshes import collision_shapes

FACES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


def boxes(*placed: tuple[list[float], list[float]]) -> tuple[np.ndarray, np.ndarray]:
    """Return a mesh of boxes: (centre, sizes) each."""
    vertices = np.concatenate([np.array(centre) + 0.5 * SIGNS * size for centre, size in placed])
    return vertices, np.concatenate([FACES + 8 * number for number in range(len(placed))])


TROUGH = boxes(([0, 0, 0], [1.0, 0.4, 0.1]), ([0, 0.2, 0.2], [1.0, 0.1, 0.4]), ([0, -0.2, 0.2], [1.0, 0.1, 0.4]))
"""A floor and two walls, open above."""


def distances_from(pieces: list[Piece], points: np.ndarray) -> np.ndarray:
    """Return how far points are outside the nearest of the pieces, by the planes of its faces."""
    from scipy.spatial import ConvexHull

    beyond = []
    for piece in pieces:
        assert isinstance(piece.body, Body)
        equations = ConvexHull(piece.body.vertices).equations
        beyond.append((points @ equations[:, :3].T + equations[:, 3]).max(axis=1))
    return np.min(beyond, axis=0)


@pytest.mark.parametrize("most", [1, 2, 4, 7, 16, 64])
def test_a_cover_has_at_most_as_many_pieces_as_it_may_and_holds_the_mesh(most: int) -> None:
    tree = cover(*TROUGH, most)
    pieces = tree.finest()
    assert 1 <= len(pieces) <= most
    assert holds(pieces, *TROUGH)


def test_a_finer_cover_leaves_the_inside_of_a_trough_free() -> None:
    inside = np.array([[0.0, 0.0, 0.3], [0.4, 0.05, 0.2]])
    tree = cover(*TROUGH, 16)
    assert (distances_from([tree], inside) < 0).all()
    assert (distances_from(tree.finest(), inside) > 0.01).all()


@pytest.mark.parametrize("number", range(10))
def test_every_point_of_a_solid_lies_in_a_piece(number: int) -> None:
    rng = np.random.default_rng(number)
    placed = [(rng.uniform(-0.3, 0.3, 3).tolist(), rng.uniform(0.1, 0.5, 3).tolist()) for _ in range(4)]
    vertices, faces = boxes(*placed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    place = np.eye(4)
    place[:3, :3] = turn
    points = np.concatenate([np.array(c) + rng.uniform(-0.5, 0.5, (2000, 3)) * s for c, s in placed])
    tree = cover(transformed(place, vertices), faces, 16)
    assert distances_from(tree.finest(), transformed(place, points)).max() <= 1e-9


@pytest.mark.parametrize("name", ["ur5", "panda"])
def test_the_covers_of_an_arm_hold_its_meshes(name: str) -> None:
    for shape in collision_shapes(load_robot(name)):
        if shape.path is not None:
            mesh = read_mesh(shape.path)
            vertices = mesh.vertices * shape.size
            assert holds(cover(vertices, mesh.triangles, 16).finest(), vertices, mesh.triangles)


def test_a_cover_that_lost_a_piece_or_a_corner_is_found_out() -> None:
    pieces = cover(*TROUGH, 4).finest()
    assert not holds(pieces[1:], *TROUGH)
    body = pieces[0].body
    assert isinstance(body, Body)
    smaller = replace(pieces[0], body=Body(body.vertices * 0.999))
    assert not holds([smaller, *pieces[1:]], *TROUGH)
