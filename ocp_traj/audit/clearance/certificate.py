"""Clearance at every instant: a separating plane for every pair of bodies and interval of time, or a witness.

coal proposes the normal of a plane in the middle of an interval; support functions prove what it separates, and a
bound of the motion (`separation`) that it does so over the whole interval. Where that fails, coarse bodies give way to
the finer pieces of their covers, and intervals are halved. Nothing rests on the accuracy of coal: a wrong normal proves
less. Refuted is a pair only by an instant at which it is too near; what is undecided at 1e-7 s is not feasible.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.audit.clearance.placements import Placements
from ocp_traj.audit.clearance.separation import Frames, Index, Mask, Side, Stretch, second_order, separation
from ocp_traj.audit.clearance.surface import Surface
from ocp_traj.audit.motion import Motion
from ocp_traj.collision.cell import TOLERANCE, Cell
from ocp_traj.collision.distances import Measure

SHORTEST = 1e-7
"""Half of the shortest interval that is looked at, s."""

MOST_DISTANCES = 300_000
"""Distances of two bodies after which what is left is called undecided."""

_WIDTH = 0.25  # longest interval looked at, s
_ROWS = 40_000  # pairs times intervals at once, for memory
_FINE, _FRACTION = 1e-4, 0.5  # the smallest clearance is proved to half of what was seen, or to 0.1 mm,
_PATIENCE = 250  # unless that takes more distances than these: then that margins are kept is enough


@dataclass(frozen=True)
class Witness:
    """An instant at which two bodies are too near, or around which that could not be decided.

    Attributes
    ----------
    pair : int
        Number among the cell's pairs.
    time : float
        s.
    distance, margin : float
        m; the margin is negative where the bodies may overlap.
    gap : int
        From 0.
    decided : bool
    """

    pair: int
    time: float
    distance: float
    margin: float
    gap: int
    decided: bool = True

    @property
    def slack(self) -> float:
        """Distance less margin, m."""
        return self.distance - self.margin


@dataclass
class Found:
    """What is known of a motion so far.

    Attributes
    ----------
    nearest : Witness or None
        The least slack (distance less margin) that was measured.
    coarse : Witness or None
        The least that was measured of coarse pieces, no more than the true one there.
    bound : Witness or None
        The least that was proved, over an interval around its time.
    witnesses : dict
        The deepest of each two bodies, by their names.
    distances : int
        Distances of two bodies that were measured.
    """

    nearest: Witness | None = None
    coarse: Witness | None = None
    bound: Witness | None = None
    witnesses: dict[tuple[str, str], Witness] = field(default_factory=dict)
    distances: int = 0

    @property
    def wanted(self) -> float:
        """Slack that is enough to prove, m."""
        if self.nearest is None or self.distances > _PATIENCE:
            return -TOLERANCE
        slack = self.nearest.slack
        return max(slack - max(_FINE, _FRACTION * abs(slack)), -TOLERANCE)


@dataclass(frozen=True)
class _Intervals:
    """Intervals of time (k,), each inside one polynomial piece: s from its start."""

    piece: Index
    start: Array
    end: Array

    def with_halves(self) -> _Intervals:
        """Return these, then their earlier halves, then the later ones."""
        middle = 0.5 * (self.start + self.end)
        starts, ends = (self.start, self.start, middle), (self.end, middle, self.end)
        return _Intervals(np.tile(self.piece, 3), np.concatenate(starts), np.concatenate(ends))

    def rows(self, chosen: Index) -> _Intervals:
        return _Intervals(self.piece[chosen], self.start[chosen], self.end[chosen])


@dataclass(frozen=True)
class _Rows:
    """Pairs of pieces over intervals, with what is known of them in the middle.

    Attributes
    ----------
    pair, interval : (r,)
        Numbers of the pair of pieces and of the interval.
    a, b : Side
    levers : two (r, n)
    moved : (r,)
        How far the bodies can come nearer within the interval, first order, m.
    margin : (r,)
        m, negative where the pair may overlap then.
    """

    pair: Index
    interval: Index
    a: Side
    b: Side
    levers: tuple[Array, Array]
    moved: Array
    margin: Array

    def rows(self, chosen: Index) -> _Rows:
        levers = self.levers[0][chosen], self.levers[1][chosen]
        sides = self.a.rows(chosen), self.b.rows(chosen)
        return _Rows(
            self.pair[chosen], self.interval[chosen], *sides, levers, self.moved[chosen], self.margin[chosen]
        )


@dataclass(frozen=True)
class _Instants:
    """The middles of intervals: where everything is and how it moves around them.

    Attributes
    ----------
    time : (k,)
        s.
    gap : (k,)
        From 0.
    """

    time: Array
    gap: Index
    stretch: Stretch
    frames: Frames


class Certificate:
    """The search for planes and witnesses along one motion.

    Parameters
    ----------
    cell : Cell
    motion : Motion
    """

    def __init__(self, cell: Cell, motion: Motion) -> None:
        self.cell, self.motion = cell, motion
        self.kinematics = Placements(cell.robot)
        self.surface = Surface(cell, self.kinematics)
        self.found = Found()

    def run(self) -> Found:
        """Decide all pairs over the whole motion."""
        intervals = self._first_intervals()
        step = max(1, _ROWS // len(self.cell.pairs))
        for first in range(0, len(intervals.piece), step):
            some = intervals.rows(np.arange(first, min(first + step, len(intervals.piece))))
            pair, interval = self._first_rows(some)
            while len(pair):
                some, pair, interval = self._advance(some, pair, interval)
        for place in (self.found.coarse, self.found.bound):
            self._measure_finely(place)
        return self.found

    def _measure_finely(self, place: Witness | None) -> None:
        """Measure by the finest pieces where coarse ones or a proof have less slack than the nearest known."""
        nearest = self.found.nearest
        if place is None or nearest is None or place.slack >= nearest.slack:
            return
        measure = Measure(self.kinematics.at(self.motion.trajectory([place.time]))[0])
        distance = self.cell.distance(self.cell.pairs[place.pair], measure)
        self.found.distances += measure.calls
        if distance - place.margin < nearest.slack:
            self.found.nearest = replace(place, distance=distance)

    def _first_intervals(self) -> _Intervals:
        """Cut the motion at its breakpoints, where contact may begin or end, and so that no interval is long."""
        trajectory = self.motion.trajectory
        breakpoints = np.asarray(trajectory.breakpoints)
        edges = [
            float(trajectory.waypoint_times[contact.waypoint]) + sign * contact.within
            for contact in self.cell.scene.contact
            for sign in (-1.0, 1.0)
        ]
        piece, start, end = [], [], []
        for number, (low, high) in enumerate(zip(breakpoints[:-1], breakpoints[1:], strict=True)):
            even = np.linspace(0.0, high - low, max(1, int(np.ceil((high - low) / _WIDTH))) + 1)
            cuts = np.unique([*even, *(edge - low for edge in edges if low < edge < high)])
            piece += [number] * (len(cuts) - 1)
            start += cuts[:-1].tolist()
            end += cuts[1:].tolist()
        return _Intervals(np.array(piece), np.array(start), np.array(end))

    def _first_rows(self, intervals: _Intervals) -> tuple[Index, Index]:
        """Return all pairs in the intervals in whose gaps both bodies are there."""
        gaps = self.motion.gaps[intervals.piece]
        there = np.ones((len(self.cell.pairs), len(gaps)), dtype=bool)
        for number, entry in enumerate(self.cell.pairs):
            if entry.gaps is not None:
                there[number] = np.isin(gaps, entry.gaps)
        pair, interval = np.nonzero(there)
        return pair, interval

    def _advance(
        self, intervals: _Intervals, pair: Index, interval: Index
    ) -> tuple[_Intervals, Index, Index]:
        """Close the rows that can be proved or refuted; return the others with finer pieces or in half the time."""
        used, interval = np.unique(interval, return_inverse=True)
        intervals, interval = intervals.rows(used), np.asarray(interval).reshape(-1)
        instants = self._instants(intervals)
        rows = self._rows(instants, pair, interval)
        apart = np.linalg.norm(rows.b.centre - rows.a.centre, axis=1) - rows.a.ball - rows.b.ball
        if self.found.nearest is None:
            self._look(rows, instants, apart)
        far = apart - rows.moved - rows.margin >= self._wanted(rows)
        self.found.bound = self._nearer(
            self.found.bound, rows, instants, apart - rows.moved, np.flatnonzero(far)
        )
        rows = rows.rows(np.flatnonzero(~far))
        if not len(rows.pair):
            return intervals, rows.pair, rows.interval
        kept, finer = self._decide(rows, instants)
        return self._rest(intervals, instants, rows, kept, finer)

    def _instants(self, intervals: _Intervals) -> _Instants:
        half, middle = 0.5 * (intervals.end - intervals.start), 0.5 * (intervals.end + intervals.start)
        stretch = Stretch.of(np.asarray(self.motion.trajectory.coefficients)[intervals.piece], middle, half)
        frames = Frames.of(self.kinematics, stretch.q)
        gaps = np.asarray(self.motion.gaps)[intervals.piece]
        return _Instants(self.motion.starts[intervals.piece] + middle, gaps, stretch, frames)

    def _rows(self, instants: _Instants, pair: Index, interval: Index) -> _Rows:
        a, b = self.surface.sides(pair, instants.frames.places, interval)
        travel = instants.stretch.travel[interval]
        levers = a.levers(instants.frames, interval, travel), b.levers(instants.frames, interval, travel)
        moved = (levers[0] * travel).sum(axis=1) + (levers[1] * travel).sum(axis=1)
        return _Rows(pair, interval, a, b, levers, moved, self._margins(instants, pair, interval))

    def _margins(self, instants: _Instants, pair: Index, interval: Index) -> Array:
        pairs, times = self.surface.pair[pair], instants.time[interval]
        margins = self.cell.margins[pairs]
        for contact in self.cell.scene.contact:
            meant = np.array([set(names) == set(contact.bodies) for names in self.cell.pair_names])
            time = self.motion.trajectory.waypoint_times[contact.waypoint]
            near = meant[pairs] & (np.abs(times - time) < contact.within)
            margins = np.where(near, np.minimum(margins, -contact.depth), margins)
        return np.asarray(margins)

    def _wanted(self, rows: _Rows) -> Array:
        """Return the slack that is enough for each row: that of pairs left out need not be known."""
        return np.where(self.surface.left_out[rows.pair], -TOLERANCE, self.found.wanted)

    def _look(self, rows: _Rows, instants: _Instants, apart: Array) -> None:
        """Measure the pair that seems nearest exactly, so that what is clearly farther is left alone at once."""
        judged = np.flatnonzero(~self.surface.left_out[rows.pair])
        if len(judged):
            row = int(judged[np.argmin((apart - rows.margin)[judged])])
            measure = Measure(instants.frames.places[rows.interval[row]])
            pair = self.cell.pairs[int(self.surface.pair[rows.pair[row]])]
            distances = np.full(len(rows.pair), self.cell.distance(pair, measure))
            self.found.nearest = self._witness(rows, instants, distances, row)
            self.found.distances += measure.calls

    def _decide(self, rows: _Rows, instants: _Instants) -> tuple[Mask, Mask]:
        """Close what is proved or refuted; return which rows stay, and which of those as finer pieces."""
        normals, distances = self._propose(rows, instants)
        exact = ~self.surface.divisible[rows.pair]
        fine, coarse = np.flatnonzero(exact), np.flatnonzero(~exact)
        self.found.nearest = self._nearer(self.found.nearest, rows, instants, distances, fine)
        self.found.coarse = self._nearer(self.found.coarse, rows, instants, distances, coarse)
        wanted = self._wanted(rows) + rows.margin
        plane = separation(rows.a, rows.b, normals)
        proved = plane - rows.moved
        weak = np.flatnonzero(~(proved >= wanted))
        if len(weak):
            some = rows.rows(weak)
            better = second_order(
                some.a, some.b, normals[weak], some.levers, instants.frames, instants.stretch, some.interval
            )
            proved[weak] = np.fmax(proved[weak], better)
        closed = proved >= wanted
        self.found.bound = self._nearer(self.found.bound, rows, instants, proved, np.flatnonzero(closed))
        least = rows.margin - TOLERANCE
        refuted = ~closed & exact & (distances < least) & ~(plane >= least)
        self._note(rows, instants, distances, np.flatnonzero(refuted))
        finer = ~closed & ~exact & ~(plane >= wanted)
        tiny = ~closed & ~refuted & ~finer & (instants.stretch.half[rows.interval] < SHORTEST)
        self._note(rows, instants, proved, np.flatnonzero(tiny), decided=False)
        return ~(closed | refuted | tiny), finer

    def _propose(self, rows: _Rows, instants: _Instants) -> tuple[Array, Array]:
        """Return normals (r, 3) and distances (r,) in the middle; the line of centres where coal has no normal."""
        normals, distances = np.empty((len(rows.pair), 3)), np.empty(len(rows.pair))
        measures: dict[int, Measure] = {}
        for row, (pair, interval) in enumerate(zip(rows.pair.tolist(), rows.interval.tolist(), strict=True)):
            if interval not in measures:
                measures[interval] = Measure(instants.frames.places[interval])
            distances[row], normals[row] = measures[interval].plane(*self.surface.bodies_of(pair))
        self.found.distances += len(rows.pair)
        length = np.sqrt((normals * normals).sum(axis=1))
        usable = length > 0.5
        scale = np.where(usable & ~self.surface.fixed_normal[rows.pair], length, 1.0)
        towards = rows.b.centre - rows.a.centre
        return np.where(usable[:, None], normals / scale[:, None], _unit(towards)), distances

    def _rest(
        self, intervals: _Intervals, instants: _Instants, rows: _Rows, kept: Mask, finer: Mask
    ) -> tuple[_Intervals, Index, Index]:
        """Return what is left to do: rows of finer pieces over the same intervals, others over their halves."""
        if self.found.witnesses:
            known = np.array([names in self.found.witnesses for names in self.cell.pair_names])
            kept = kept & ~known[self.surface.pair[rows.pair]]
        if self.found.distances > MOST_DISTANCES:
            unknown = np.full(len(rows.pair), np.nan)
            self._note(rows, instants, unknown, np.flatnonzero(kept), decided=False)
            kept = np.zeros_like(kept)
        count = len(intervals.piece)
        pair: list[Index] = [self.surface.finer(int(rows.pair[row])) for row in np.flatnonzero(kept & finer)]
        coarse = rows.interval[kept & finer]
        interval = [np.full(len(new), own) for new, own in zip(pair, coarse, strict=True)]
        halved = kept & ~finer
        pair += [rows.pair[halved], rows.pair[halved]]
        interval += [count + rows.interval[halved], 2 * count + rows.interval[halved]]
        return intervals.with_halves(), np.concatenate(pair), np.concatenate(interval)

    def _nearer(
        self, known: Witness | None, rows: _Rows, instants: _Instants, distances: Array, chosen: Index
    ) -> Witness | None:
        """Return what has the least slack: what is known, or one of the chosen rows whose pairs count."""
        counted = chosen[~self.surface.left_out[rows.pair[chosen]]]
        if not len(counted):
            return known
        row = int(counted[np.argmin((distances - rows.margin)[counted])])
        nearest = self._witness(rows, instants, distances, row)
        return nearest if known is None or nearest.slack < known.slack else known

    def _note(
        self, rows: _Rows, instants: _Instants, distances: Array, chosen: Index, decided: bool = True
    ) -> None:
        """Keep the deepest witness of each two bodies; a decided one before an undecided one."""
        for row in chosen.tolist():
            witness = replace(self._witness(rows, instants, distances, row), decided=decided)
            names = self.cell.pair_names[witness.pair]
            known = self.found.witnesses.get(names)
            deeper = known is None or witness.slack < known.slack
            if known is None or (decided, deeper) > (known.decided, False):
                self.found.witnesses[names] = witness

    def _witness(self, rows: _Rows, instants: _Instants, distances: Array, row: int) -> Witness:
        interval = int(rows.interval[row])
        pair = int(self.surface.pair[rows.pair[row]])
        distance, margin = float(distances[row]), float(rows.margin[row])
        return Witness(pair, float(instants.time[interval]), distance, margin, int(instants.gap[interval]))


def _unit(directions: Array) -> Array:
    """Return unit vectors (r, 3) along directions, along z where they vanish."""
    length = np.linalg.norm(directions, axis=1, keepdims=True)
    return np.where(length > 0, directions / np.where(length > 0, length, 1.0), [0.0, 0.0, 1.0])
