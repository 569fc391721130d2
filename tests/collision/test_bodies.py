"""Support functions are exact: a plane they prove is one that no point of the body crosses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from ocp_traj.arrays import Array
from ocp_traj.collision.bodies import Body, HalfSpace, box, capsule, cylinder, half_space, hull, sphere
from ocp_traj.collision.distances import Measure

RNG = np.random.default_rng(1)


def placement() -> Array:
    from scipy.spatial.transform import Rotation

    place = np.eye(4)
    place[:3, :3] = Rotation.random(random_state=3).as_matrix()
    place[:3, 3] = [0.3, -0.2, 0.5]
    return place


def directions(count: int) -> Array:
    return RNG.normal(size=(count, 3)) * RNG.uniform(0.1, 3.0, (count, 1))


def of_ball(count: int) -> Array:
    points = RNG.normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def of_cylinder(count: int) -> Array:
    angle, height = RNG.uniform(0, 2 * np.pi, count), RNG.choice([-0.2, 0.2], count)
    return np.column_stack([0.1 * np.cos(angle), 0.1 * np.sin(angle), height])


def of_capsule(count: int) -> Array:
    return 0.1 * of_ball(count) + np.column_stack([np.zeros((count, 2)), RNG.choice([-0.2, 0.2], count)])


def of_box(count: int) -> Array:
    return RNG.choice([-0.5, 0.5], (count, 3)) * [0.2, 0.4, 0.6]


SOLIDS: dict[str, tuple[Callable[[Array], Body], Callable[[int], Array]]] = {
    "sphere": (lambda place: sphere(0.1, place), lambda count: 0.1 * of_ball(count)),
    "capsule": (lambda place: capsule(0.1, 0.4, place), of_capsule),
    "cylinder": (lambda place: cylinder(0.1, 0.4, place), of_cylinder),
    "box": (lambda place: box(np.array([0.2, 0.4, 0.6]), place), of_box),
}


@pytest.mark.parametrize("kind", SOLIDS)
def test_the_lowest_point_of_a_solid_is_the_lowest_of_its_surface(kind: str) -> None:
    make, surface = SOLIDS[kind]
    place = placement()
    body = make(place)
    points = surface(40_000) @ place[:3, :3].T + place[:3, 3]
    g = directions(50)
    lowest, sampled = body.lowest(g), (points @ g.T).min(axis=0)
    assert (lowest <= sampled + 1e-12).all()
    assert (sampled - lowest <= 2e-3 * np.linalg.norm(g, axis=1)).all()
    assert np.linalg.norm(points - body.centre, axis=1).max() <= body.ball + 1e-12


def test_a_half_space_is_bounded_along_its_normal_only() -> None:
    body = half_space(np.array([0.0, 0.0, 2.0]), 0.2, np.eye(4))
    assert body.lowest(-body.normal[None])[0] == pytest.approx(-0.1)
    assert np.isneginf(body.lowest(np.array([[0.0, 1e-9, -1.0], [0.0, 0.0, 1.0]]))).all()


@pytest.mark.parametrize("kind", SOLIDS)
def test_the_plane_that_is_proposed_proves_the_distance(kind: str) -> None:
    body, other = SOLIDS[kind][0](placement()), hull(RNG.normal(size=(40, 3)) * 0.1)
    for _ in range(20):
        place = np.eye(4)
        place[:3, 3] = RNG.normal(size=3)
        nearest = Measure(np.array([np.eye(4), place])).nearest(body, 0, other, 1)
        distance, normal, (on_body, on_other) = nearest.distance, nearest.normal, nearest.points
        proved = other.lowest(normal[None])[0] + normal @ place[:3, 3] + body.lowest(-normal[None])[0]
        assert proved <= distance + 1e-6
        if distance > 1e-3:
            assert proved == pytest.approx(distance, abs=1e-5)
            assert np.linalg.norm(on_other - on_body) == pytest.approx(distance, abs=1e-5)


def test_the_distance_from_a_half_space_is_that_of_the_lowest_point() -> None:
    floor = HalfSpace(np.array([0.0, 0.0, 1.0]), 0.1)
    nearest = Measure(np.eye(4)[None]).nearest(floor, 0, sphere(0.2, placement()), 0)
    distance, normal, (below, above) = nearest.distance, nearest.normal, nearest.points
    assert distance == pytest.approx(0.5 - 0.2 - 0.1)
    np.testing.assert_allclose(above, [0.3, -0.2, 0.3], atol=1e-12)
    np.testing.assert_allclose(below, [0.3, -0.2, 0.1], atol=1e-12)
    assert normal @ (above - below) == pytest.approx(distance)


@pytest.mark.parametrize("points", [np.zeros((1, 3)), np.eye(3)[:2], np.eye(3), np.eye(4)[:, :3] * [1, 1, 0]])
def test_points_in_a_plane_become_a_body_that_holds_them(points: Array) -> None:
    body = hull(points)
    g = directions(50)
    assert (body.lowest(g) <= (points @ g.T).min(axis=0)).all()
    assert Measure(np.eye(4)[None]).plane(body, 0, sphere(0.1, placement()), 0)[0] > 0
