"""MoveIt's time-optimal trajectory generation (Kunz and Stilman 2012), as Tesseract's wheels ship it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from helpers.peers.answer import PeerAnswer, least_cpu_time, symmetric_limit
from ocp_traj.task import TrajectoryTask

ANGLE = 1e-3
"""MoveIt's default `min_angle_change`, rad."""


@dataclass(frozen=True)
class TimedRows:
    """What it returns: times (N,), velocities and accelerations (N, n) at the points given."""

    t: np.ndarray
    v: np.ndarray
    a: np.ndarray


def solve_with_totg(task: TrajectoryTask, *, path_tolerance: float = 0.1, repeats: int = 1) -> PeerAnswer:
    """Return the timing it gives the waypoints.

    It rounds corners by up to `path_tolerance` (MoveIt's default is 0.1 rad) and does not return the rounded path, so
    there is no curve to audit. Jerk is not looked at.
    """
    rows, seconds = least_cpu_time(lambda: timed_rows(task, path_tolerance), repeats)
    setting = f"path tolerance {path_tolerance:g}"
    if rows is None:
        return PeerAnswer("TOTG", setting, None, seconds, "no timing found")
    return PeerAnswer("TOTG", setting, None, seconds, timed=float(rows.t[-1]))


def timed_rows(task: TrajectoryTask, path_tolerance: float, points_per_gap: int = 1) -> TimedRows | None:
    """Return its rows at the waypoints, and at `points_per_gap` - 1 points on the line between two of them."""
    q = _with_points_between(np.asarray(task.waypoints), points_per_gap)
    limits = [np.stack([-bound, bound], axis=1) for bound in _limits(task)]
    return _time(q, limits, path_tolerance)


def _limits(task: TrajectoryTask) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return velocity, acceleration and jerk limits; the last is asked for and not used."""
    acceleration = symmetric_limit(task, "acceleration")
    return symmetric_limit(task, "velocity"), acceleration, 1e3 * acceleration


def _with_points_between(waypoints: np.ndarray, count: int) -> np.ndarray:
    shares = np.arange(1, count + 1)[:, None] / count
    pieces = [start + (end - start) * shares for start, end in zip(waypoints, waypoints[1:])]
    return np.concatenate([waypoints[:1], *pieces])


def _time(q: np.ndarray, limits: list[np.ndarray], tolerance: float) -> TimedRows | None:
    from tesseract_robotics import tesseract_command_language as language
    from tesseract_robotics.tesseract_time_parameterization import (
        InstructionsTrajectory,
        TimeOptimalTrajectoryGeneration,
    )

    names = [f"joint{joint + 1}" for joint in range(q.shape[1])]
    program = language.CompositeInstruction("DEFAULT")
    for row in q:
        state = language.StateWaypointPoly_wrap_StateWaypoint(language.StateWaypoint(names, row))
        move = language.MoveInstruction(state, language.MoveInstructionType_FREESPACE, "DEFAULT")
        program.appendMoveInstruction(language.MoveInstructionPoly_wrap_MoveInstruction(move))
    timed = InstructionsTrajectory(program)
    full = np.ones(1)
    if not TimeOptimalTrajectoryGeneration(tolerance, ANGLE).compute(timed, *limits, full, full, full):
        return None
    t = np.array([timed.getTimeFromStart(index) for index in range(timed.size())])
    return TimedRows(t, *_read_rows(language, program, len(t)))


def _read_rows(language: Any, program: Any, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities and accelerations, (N, n) each; every wrapper is kept alive while it is read."""
    instructions = program.getInstructions()
    velocities, accelerations = [], []
    for index in range(count):
        instruction = instructions[index]
        move = language.InstructionPoly_as_MoveInstructionPoly(instruction)
        waypoint = move.getWaypoint()
        state = language.WaypointPoly_as_StateWaypointPoly(waypoint)
        velocities.append(np.array(state.getVelocity()).ravel())
        accelerations.append(np.array(state.getAcceleration()).ravel())
    return np.array(velocities), np.array(accelerations)
