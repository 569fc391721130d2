"""A robot in its cell: all bodies, the pairs that are judged, and what can be said before anything moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.collision.bodies import Body
from ocp_traj.collision.covers import Piece
from ocp_traj.collision.distances import Measure
from ocp_traj.collision.pairs import LeftOut, Pair, pairs_of
from ocp_traj.collision.parts import Part, parts_of
from ocp_traj.collision.scene import CollisionScene

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

TOLERANCE = 1e-6
"""A margin is kept when the distance is at least the margin less this, m."""


@dataclass(frozen=True, eq=False)
class Cell:
    """A robot and its scene, ready to be judged.

    Attributes
    ----------
    robot : Robot
    scene : CollisionScene
    parts : tuple of Part
    pairs : tuple of Pair
    left_out : tuple of LeftOut
    """

    robot: Robot
    scene: CollisionScene
    parts: tuple[Part, ...]
    pairs: tuple[Pair, ...]
    left_out: tuple[LeftOut, ...]

    def names(self, pair: Pair) -> tuple[str, str]:
        """Return the names of a pair's bodies, the robot's or the farther one first."""
        return self.parts[pair.second].owner, self.parts[pair.first].owner

    @cached_property
    def pair_names(self) -> list[tuple[str, str]]:
        """Names of all pairs' bodies."""
        return [self.names(pair) for pair in self.pairs]

    @cached_property
    def margins(self) -> Array:
        """Margins of all pairs, m."""
        return np.array([pair.margin for pair in self.pairs])

    def allowed_depth(self, pair: Pair, waypoint: int | None) -> float:
        """Return how far a pair may overlap at a waypoint, m; 0 where it may not."""
        names = set(self.names(pair))
        depths = [c.depth for c in self.scene.contact if set(c.bodies) == names and c.waypoint == waypoint]
        return max(depths, default=0.0)

    def collisions(self, q: Array, gap: int | None = None, waypoint: int | None = None) -> list[Overlap]:
        """Return the pairs that are nearer than their margin at a configuration, deepest first.

        Parameters
        ----------
        q : (n,)
            rad or m.
        gap : int, optional
            Only bodies that are there in this gap, from 0.
        waypoint : int, optional
            Contact that is meant at this waypoint, from 0, is allowed.
        """
        places = Measure(self.root_placements(q))
        found = []
        for pair in self.pairs:
            if gap is not None and pair.gaps is not None and gap not in pair.gaps:
                continue
            depth = self.allowed_depth(pair, waypoint)
            least = (-depth if depth else pair.margin) - TOLERANCE
            distance = self.distance(pair, places, least)
            if distance < least:
                found.append(Overlap(self.names(pair), distance, pair.margin, pair.left_out))
        return sorted(found, key=lambda overlap: overlap.distance)

    def root_placements(self, q: Array) -> Array:
        """Return the placements (n + 1, 4, 4) of the joints in the root's frame."""
        return np.asarray(self.robot.base_placement @ self.robot.link_placements(q))

    def distance(self, pair: Pair, places: Array | Measure, enough: float = np.inf) -> float:
        """Return the distance of a pair by its finest covers, m; at most that where it is `enough` or more.

        Parameters
        ----------
        pair : Pair
        places : (n + 1, 4, 4)
            Or a `Measure` of them, for several pairs.
        enough : float
            m.
        """
        measure = places if isinstance(places, Measure) else Measure(places)
        a, b = self.parts[pair.first], self.parts[pair.second]

        def coarse(x: Piece, y: Piece) -> float:
            assert isinstance(y.body, Body)  # a half-space stands still and comes first
            return measure.plane(x.body, a.joint, y.body, b.joint)[0]

        return _finest(coarse, a.piece, b.piece, coarse(a.piece, b.piece), enough)


def _finest(coarse: Callable[[Piece, Piece], float], a: Piece, b: Piece, distance: float, best: float) -> float:
    """Return the least distance of the finest pieces of two covers, or `best` where that is less; nearest first."""
    if distance >= best or not (a.divisible or b.divisible):
        return distance
    finer = [(coarse(x, y), x, y) for x in a.finer or (a,) for y in b.finer or (b,)]
    least = np.inf
    for own, x, y in sorted(finer, key=lambda entry: entry[0]):
        if own < min(least, best):
            least = min(least, _finest(coarse, x, y, own, min(least, best)))
    return least if least < np.inf else best


@dataclass(frozen=True)
class Overlap:
    """Two bodies that are nearer than they may be.

    Attributes
    ----------
    bodies : two str
    distance, margin : float
        m.
    left_out : bool
        An SRDF says that they never touch.
    """

    bodies: tuple[str, str]
    distance: float
    margin: float
    left_out: bool = False

    def __str__(self) -> str:
        return f"{' and '.join(self.bodies)} {depth_in_words(self.distance, self.margin)}"


def depth_in_words(distance: float, margin: float) -> str:
    """Return how far bodies overlap, or how near they are against their margin, in mm."""
    if distance < 0:
        return f"overlap by {-1e3 * distance:.3g} mm"
    return f"are {1e3 * distance:.3g} mm apart, closer than {1e3 * margin:.3g} mm"


def cell_of(robot: Robot, scene: CollisionScene) -> Cell:
    """Return a robot in its scene.

    Parameters
    ----------
    robot : Robot
    scene : CollisionScene

    Returns
    -------
    Cell

    Raises
    ------
    RobotError
        A mesh of the robot or the SRDF cannot be read.
    TaskError
        A mesh of the scene cannot be read.
    """
    return _cell(robot, robot.description, None if robot.source is None else robot.source.srdf, scene)


@lru_cache(maxsize=32)
def _cell(robot: Robot, description: Path | None, srdf: Path | None, scene: CollisionScene) -> Cell:
    parts = parts_of(robot, scene)
    return Cell(robot, scene, parts, *pairs_of(robot, scene, parts))
