"""What a peer answered, as the exact curve it describes, so that our audit can judge it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from scipy.interpolate import PPoly

from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

T = TypeVar("T")


@dataclass(frozen=True)
class PeerAnswer:
    """A peer's motion for a task.

    Attributes
    ----------
    peer : str
    setting : str
        What the user of that peer had to choose.
    trajectory : Trajectory or None
        The very curve the peer describes; None where it gave none.
    seconds : float
        CPU time of building and solving, the least of the repetitions.
    message : str
        Why there is no motion.
    timed : float or None
        Duration of a motion whose curve the peer does not tell, s.
    """

    peer: str
    setting: str
    trajectory: Trajectory | None
    seconds: float
    message: str = ""
    timed: float | None = None

    @property
    def duration(self) -> float | None:
        """Duration of the motion, s."""
        return self.timed if self.trajectory is None else self.trajectory.duration


def least_cpu_time(call: Callable[[], T], repeats: int = 1) -> tuple[T, float]:
    """Return what a call returns and the least CPU time of several."""
    times = []
    for _ in range(max(repeats, 1)):
        began = time.process_time()
        answer = call()
        times.append(time.process_time() - began)
    return answer, min(times)


def from_piecewise(curve: PPoly, waypoint_times: Any, family: str) -> Trajectory:
    """Return SciPy's piecewise polynomial with values (n,) as a trajectory; empty pieces are dropped."""
    keep = np.diff(curve.x) > 0
    coefficients = np.moveaxis(curve.c[::-1], 0, -1)[keep]  # (m, n, degree + 1), ascending
    breakpoints = np.concatenate([curve.x[:-1][keep], curve.x[-1:]])
    return Trajectory(breakpoints, coefficients, np.asarray(waypoint_times, dtype=np.float64), family)


def symmetric_limit(task: TrajectoryTask, name: str) -> np.ndarray:
    """Return a task's limit as the (n,) numbers most peers ask for; the smaller side, the tightest gap."""
    limits = np.asarray(task.limits.get(name))
    smallest: np.ndarray = np.minimum(-limits[:, 0], limits[:, 1]).min(axis=0)
    return smallest
