"""What a cell consists of, what is left out of it, and which waypoints cannot be passed, in words."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.collision.cell import TOLERANCE, Cell, Overlap, cell_of
from ocp_traj.collision.distances import Measure
from ocp_traj.collision.pairs import SRDF, LeftOut

if TYPE_CHECKING:
    from ocp_traj.collision.scene import CollisionScene
    from ocp_traj.robot.robot import Robot

SAMPLES = 300
"""Random configurations at which pairs left out are looked at."""


def waypoint_collisions(cell: Cell, waypoints: Array) -> Iterator[tuple[int, Overlap]]:
    """Yield the waypoints, from 0, at which something touches or is too near, each with its deepest pair.

    A body that comes or goes with a gap counts on its side of the waypoint.

    Parameters
    ----------
    cell : Cell
    waypoints : (K, n)
        rad or m.
    """
    last = len(waypoints) - 1
    for number, waypoint in enumerate(waypoints):
        sides = {max(number - 1, 0), min(number, last - 1)}
        found = [overlap for gap in sides for overlap in cell.collisions(waypoint, gap, number)]
        if found:
            yield number, min(found, key=lambda overlap: overlap.distance - overlap.margin)


def waypoint_conflict(robot: Robot, scene: CollisionScene, waypoints: Array) -> str:
    """Return a sentence where a waypoint touches something, else an empty one."""
    for number, overlap in waypoint_collisions(cell_of(robot, scene), waypoints):
        return f"collision: waypoint {number + 1}: {overlap}."
    return ""


def describe_cell(cell: Cell, waypoints: Array) -> list[str]:
    """Return lines about a cell: bodies, pieces, pairs, what is left out and whether it can touch, bad waypoints.

    Parameters
    ----------
    cell : Cell
    waypoints : (K, n)
        rad or m.
    """
    owners = {(part.kind, part.owner) for part in cell.parts}
    counts = {kind: sum(own == kind for own, _ in owners) for kind in ("link", "tool", "obstacle")}
    finest = sum(part.piece.budget if part.piece.divisible else 1 for part in cell.parts)
    lines = [
        f"collision: {counts['link']} links, {counts['tool']} bodies at the tool, {counts['obstacle']} obstacles; "
        f"{len(cell.parts)} convex pieces, up to {finest} where those are too coarse; {len(cell.pairs)} pairs"
    ]
    if not counts["link"]:
        lines.append(f"  {cell.robot.name} has no collision geometry: only bodies at the tool are judged")
    for reason in dict.fromkeys(entry.reason for entry in cell.left_out):
        named = [entry for entry in cell.left_out if entry.reason == reason]
        lines.append(f"  left out, {reason}: {', '.join(f'{a} - {b}' for a, b in (e.bodies for e in named))}")
    for entry, fraction in touching_left_out(cell):
        lines.append(
            f"  {entry.bodies[0]} - {entry.bodies[1]} are left out, yet touch at {100 * fraction:.2g} % of random "
            "configurations; a motion in which they do is refused"
        )
    lines += [
        f"  waypoint {number + 1}: {overlap}" for number, overlap in waypoint_collisions(cell, waypoints)
    ]
    return lines


def touching_left_out(cell: Cell, samples: int = SAMPLES) -> Iterator[tuple[LeftOut, float]]:
    """Yield the pairs that an SRDF leaves out and that touch, with the fraction of random configurations where they do.

    Parameters
    ----------
    cell : Cell
    samples : int
        Configurations within the position limits (a turn where there is none).
    """
    left_out = [pair for pair in cell.pairs if pair.left_out]
    if not left_out:
        return
    lower, upper = cell.robot.position_limits
    lower, upper = np.where(np.isfinite(lower), lower, -np.pi), np.where(np.isfinite(upper), upper, np.pi)
    hits: dict[frozenset[str], int] = {}
    for q in np.random.default_rng(0).uniform(lower, upper, (samples, cell.robot.n)):
        measure = Measure(cell.root_placements(q))
        touching = {
            frozenset(cell.names(pair))
            for pair in left_out
            if cell.distance(pair, measure, -TOLERANCE) < -TOLERANCE
        }
        for names in touching:
            hits[names] = hits.get(names, 0) + 1
    for entry in cell.left_out:
        count = hits.get(frozenset(entry.bodies), 0)
        if entry.reason == SRDF and count:
            yield entry, count / samples
