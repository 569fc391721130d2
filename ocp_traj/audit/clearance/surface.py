"""The pairs of convex pieces that a cell's pairs of bodies are judged by, coarse ones first."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ocp_traj.arrays import Array
from ocp_traj.audit.clearance.placements import Placements
from ocp_traj.audit.clearance.separation import Index, Mask, Side
from ocp_traj.collision.bodies import Body, Convex, HalfSpace
from ocp_traj.collision.cell import Cell
from ocp_traj.collision.covers import Piece


class Surface:
    """Tables of pieces and of pairs of pieces; both grow while coarse ones give way to finer ones.

    The first pairs of pieces are those of the cell's pairs, in their order.

    Parameters
    ----------
    cell : Cell
    kinematics : Placements
    """

    def __init__(self, cell: Cell, kinematics: Placements) -> None:
        self.cell = cell
        self.movers = kinematics.movers
        self.pieces: list[Piece] = [part.piece for part in cell.parts]
        self.bodies: list[Convex] = [piece.body for piece in self.pieces]
        self.joints = np.array([part.joint for part in cell.parts], dtype=np.int64)
        self.centres = np.array([body.centre for body in self.bodies]).reshape(-1, 3)
        self.balls = np.array([body.ball for body in self.bodies])
        self.first = np.array([pair.first for pair in cell.pairs], dtype=np.int64)
        self.second = np.array([pair.second for pair in cell.pairs], dtype=np.int64)
        self.pair: Index = np.arange(len(cell.pairs))
        self.left_out: Mask = _mask(pair.left_out for pair in cell.pairs)
        self.divisible: Mask = self._divisible(self.pair)
        self.fixed_normal: Mask = self._half_spaces(self.first)
        self._children: dict[int, Index] = {}
        self._finer_pieces: dict[int, Index] = {}

    def _divisible(self, pairs: Index) -> Mask:
        """Return which pairs have a piece that finer ones can take the place of."""
        return _mask(
            self.pieces[self.first[number]].divisible or self.pieces[self.second[number]].divisible
            for number in pairs
        )

    def _half_spaces(self, numbers: Index) -> Mask:
        return _mask(isinstance(self.bodies[number], HalfSpace) for number in numbers)

    def bodies_of(self, number: int) -> tuple[Convex, int, Body, int]:
        """Return the two bodies of a pair of pieces, each with the joint that carries it."""
        first, second = self.first[number], self.second[number]
        body = self.bodies[second]
        assert isinstance(body, Body)  # half-spaces stand still and come first
        return self.bodies[first], int(self.joints[first]), body, int(self.joints[second])

    def sides(self, pairs: Index, places: Array, interval: Index) -> tuple[Side, Side]:
        """Return both bodies of rows: pairs of pieces (r,) in intervals (r,) with placements (k, n + 1, 4, 4)."""
        first, second = self.first[pairs], self.second[pairs]
        movers = self.movers[self.joints]
        own = movers[second] & ~movers[first], movers[first] & ~movers[second]
        return (
            self._side(first, own[1], places, interval),
            self._side(second, own[0], places, interval),
        )

    def _side(self, number: Index, movers: Mask, places: Array, interval: Index) -> Side:
        place = places[interval, self.joints[number]]
        centre = np.einsum("rij,rj->ri", place[:, :3, :3], self.centres[number]) + place[:, :3, 3]
        return Side(self.bodies, number, place, movers, centre, self.balls[number])

    def finer(self, number: int) -> Index:
        """Return the pairs of finer pieces that take the place of a pair."""
        if number not in self._children:
            firsts = self._pieces_below(int(self.first[number]))
            seconds = self._pieces_below(int(self.second[number]))
            start, count = len(self.first), len(firsts) * len(seconds)
            self.first = np.concatenate([self.first, np.repeat(firsts, len(seconds))])
            self.second = np.concatenate([self.second, np.tile(seconds, len(firsts))])
            self.pair = np.concatenate([self.pair, np.full(count, self.pair[number])])
            self.left_out = np.concatenate([self.left_out, np.full(count, self.left_out[number])])
            new = np.arange(start, start + count)
            self.divisible = np.concatenate([self.divisible, self._divisible(new)])
            self.fixed_normal = np.concatenate([self.fixed_normal, self._half_spaces(self.first[new])])
            self._children[number] = new
        return self._children[number]

    def _pieces_below(self, number: int) -> NDArray[np.int64]:
        """Return the numbers of a piece's finer pieces, its own where it has none."""
        if number not in self._finer_pieces:
            finer = self.pieces[number].finer
            start = len(self.pieces)
            self.pieces += finer
            self.bodies += [piece.body for piece in finer]
            if finer:
                self.joints = np.concatenate([self.joints, np.full(len(finer), self.joints[number])])
                self.centres = np.concatenate([self.centres, [piece.body.centre for piece in finer]])
                self.balls = np.concatenate([self.balls, [piece.body.ball for piece in finer]])
            numbers = np.arange(start, start + len(finer)) if finer else np.array([number])
            self._finer_pieces[number] = numbers
        return self._finer_pieces[number]


def _mask(values: Iterable[bool]) -> Mask:
    return np.array(list(values), dtype=np.bool_)
