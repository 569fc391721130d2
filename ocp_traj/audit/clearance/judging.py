"""How near a motion comes to what it must not touch, in words and numbers for the verdict."""

from __future__ import annotations

import numpy as np

from ocp_traj.audit.clearance.certificate import Certificate, Found, Witness
from ocp_traj.audit.motion import Motion
from ocp_traj.audit.verdict import CLEARANCE_SCALE, Clearance, Extremum
from ocp_traj.collision.cell import Cell, cell_of
from ocp_traj.task import TrajectoryTask


def judge_clearance(
    task: TrajectoryTask, motion: Motion
) -> tuple[Clearance | None, list[Extremum], list[str]]:
    """Judge whether a motion keeps clear of everything its task names.

    Returns
    -------
    Clearance or None
        None for a task without a scene.
    list of Extremum
        The smallest clearance as a limit.
    list of str
        A sentence for each pair that touches, comes too near, or could not be decided.
    """
    if task.collision is None or task.robot is None:
        return None, [], []
    cell = cell_of(task.robot, task.collision)
    left_out = tuple(str(entry) for entry in cell.left_out)
    if not np.isfinite(motion.trajectory.coefficients).all() or not cell.pairs:
        return Clearance(None, None, None, not cell.pairs, left_out=left_out), [], []
    found = Certificate(cell, motion).run()
    sentences = [_sentence(cell, witness) for witness in found.witnesses.values()]
    worst = _worst(cell, found)
    if worst is None:
        return Clearance(None, None, None, not sentences, None, left_out, found.distances), [], sentences
    names = cell.pair_names[worst.pair]
    bound = None if found.witnesses or found.bound is None else found.bound.distance
    clearance = Clearance(
        worst.distance, names, worst.time, not found.witnesses, bound, left_out, found.distances
    )
    ratio = 1.0 + (worst.margin - worst.distance) / CLEARANCE_SCALE
    peak = Extremum(
        "clearance", -1, worst.time, ratio, worst.gap, worst.distance, worst.margin, note=" and ".join(names)
    )
    return clearance, [peak], sentences


def stays_clear(task: TrajectoryTask, motion: Motion, scale: float) -> bool:
    """Return whether a motion that keeps clear does so, too, when it runs slower by a factor.

    The path stays the same; only contact on purpose has a window of time that the slowed motion may leave.
    """
    if task.collision is None or not task.collision.contact or scale == 1.0 or not scale > 0.0:
        return True
    clearance = judge_clearance(task, Motion.of(motion.trajectory.scaled(scale)))[0]
    return clearance is not None and clearance.proved


def _worst(cell: Cell, found: Found) -> Witness | None:
    """Return the deepest witness, else the nearest that was measured; pairs left out do not count."""
    counted = [entry for entry in found.witnesses.values() if not cell.pairs[entry.pair].left_out]
    return min(counted, key=lambda entry: entry.slack) if counted else found.nearest


def _sentence(cell: Cell, witness: Witness) -> str:
    pair = cell.pairs[witness.pair]
    a, b = cell.names(pair)
    if not witness.decided:
        return (
            f"collision: {a} and {b} at {witness.time:.6g} s: could not be decided, "
            f"{1e3 * witness.distance:.3g} mm against a margin of {1e3 * witness.margin:.3g} mm"
        )
    if witness.distance < 0:
        text = f"collision: {a} meets {b} at {witness.time:.6g} s, {-1e3 * witness.distance:.3g} mm inside"
    else:
        text = f"collision: {a} is {1e3 * witness.distance:.3g} mm from {b} at {witness.time:.6g} s"
    if witness.margin > 0:
        text += f", expected {1e3 * witness.margin:.3g} mm"
    elif witness.margin < 0:
        text += f", {-1e3 * witness.margin:.3g} mm allowed"
    return text + (", a pair left out by the SRDF" if pair.left_out else "")
