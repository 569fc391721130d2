"""From a task to a numerical problem: nothing else builds x, f and g."""

from __future__ import annotations

from ocp_traj.transcription.curve import build_trajectory, trajectory_from_durations
from ocp_traj.transcription.guess import initial_guess, insert_knots
from ocp_traj.transcription.lifted import ExtraPoints, LiftedNlp

__all__ = ["ExtraPoints", "LiftedNlp", "build_trajectory", "initial_guess", "insert_knots", "trajectory_from_durations"]
