"""Random problems of every kind, each known beforehand to be feasible or not, and reproducible from one integer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ocp_traj.spline import FAMILIES
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.curve import build_trajectory

IMPOSSIBLE = ("", "waypoint outside position limits", "too little time", "zero limit on a joint that moves")


@dataclass(frozen=True)
class RandomProblem:
    """A task and what is known about it.

    `flaw` is empty for a problem with a motion: `witness`, which keeps all limits, is one.
    """

    task: TrajectoryTask
    flaw: str
    witness: Trajectory | None


def random_problem(seed: int) -> RandomProblem:
    """2 to 10 waypoints, 1 to 8 joints, any family, limits over six decades; about one in eight is impossible."""
    rng = np.random.default_rng([2026, seed])
    flaw = str(rng.choice(IMPOSSIBLE, p=[0.88, 0.04, 0.04, 0.04]))
    n = int(rng.integers(1, 9))
    family = str(rng.choice(sorted(FAMILIES)))
    count = int(rng.integers(4 if family == "3-5-3" else 2, 11))
    knots = int(rng.integers(0, 4)) if family == "cubic" else int(rng.choice([0, 0, 0, 1, 2]))
    knots = 0 if family == "3-5-3" else knots
    size = 10.0 ** rng.uniform(-4, 2, n)
    waypoints = rng.uniform(-1, 1, (count, n)) * size
    if rng.random() < 0.2 and count > 2:  # a stop, and a joint that hardly does anything
        waypoints[count // 2, int(rng.integers(n))] = waypoints[count // 2 - 1, 0]
    pace = 10.0 ** rng.uniform(-2, 1)
    limits = {
        "velocity": _two_sided(rng, size * pace),
        "acceleration": _two_sided(rng, size * pace**2 * 10.0 ** rng.uniform(-0.5, 1.0)),
    }
    if rng.random() < 0.6:
        limits["jerk"] = _two_sided(rng, size * pace**3 * 10.0 ** rng.uniform(0.0, 2.0))
    if rng.random() < 0.3:  # another velocity limit in every gap
        limits["velocity"] = limits["velocity"] * rng.uniform(0.5, 1.0, (count - 1, 1, 1))
    boundary = (
        Boundary(acceleration=0.0) if family == "cubic" and knots and rng.random() < 0.3 else Boundary()
    )
    task = TrajectoryTask(
        waypoints,
        Limits(**limits),
        family=family,
        virtual_knots=knots,
        boundary=boundary,
        name=f"random-{seed}",
    )
    witness = _witness(task, rng)
    if rng.random() < 0.3:
        task = task.changed(limits=_with_position(task, witness, rng))
    if rng.random() < 0.2 and not flaw:  # a duration that the witness has
        duration = witness.duration * np.array([rng.uniform(0.2, 1.0), 1.0])
        task = task.changed(objective=Objective(time=1.0, duration=duration))
    return (
        RandomProblem(task, "", witness) if not flaw else RandomProblem(_spoilt(task, flaw, rng), flaw, None)
    )


def _two_sided(rng: np.random.Generator, size: np.ndarray) -> np.ndarray:
    """(2, n) lower and upper limits, often not symmetric."""
    skew = rng.uniform(0.5, 1.0, (2, len(size))) if rng.random() < 0.5 else np.ones((2, len(size)))
    return np.array([[-1.0], [1.0]]) * skew * size


def _witness(task: TrajectoryTask, rng: np.random.Generator) -> Trajectory:
    """A motion of the family without virtual knots, slow enough for every derivative limit."""
    bare = task.changed(virtual_knots=0, boundary=Boundary())
    durations = rng.uniform(0.5, 1.0, task.gaps)
    curve = build_trajectory(bare, durations, np.asarray(task.waypoints))
    scale = 0.0
    for gap in range(task.gaps):
        t = np.linspace(*curve.waypoint_times[gap : gap + 2], 200)
        for order, name in ((1, "velocity"), (2, "acceleration"), (3, "jerk")):
            lower, upper = task.limits.get(name)[gap]
            ratio = np.maximum(curve(t, order) / upper, curve(t, order) / lower)
            scale = max(scale, float(ratio.max()) ** (1.0 / order))
    return curve.scaled(1.01 * scale)


def _with_position(task: TrajectoryTask, witness: Trajectory, rng: np.random.Generator) -> Limits:
    """The task's limits, and position limits that the witness keeps by 1 % or more of its range."""
    q = witness(np.linspace(0.0, witness.duration, 200 * task.gaps))
    room = np.ptp(q, axis=0) * rng.uniform(0.01, 0.2)
    names = ("velocity", "acceleration", "jerk")
    return Limits(
        position=np.stack([q.min(axis=0) - room, q.max(axis=0) + room]),
        **{name: task.limits.get(name) for name in names},
    )


def _spoilt(task: TrajectoryTask, flaw: str, rng: np.random.Generator) -> TrajectoryTask:
    names = ("position", "velocity", "acceleration", "jerk")
    limits = {name: np.array(task.limits.get(name)) for name in names}
    joint = int(rng.integers(task.n))
    if flaw.startswith("waypoint"):
        column = task.waypoints[:, joint]
        limits["position"][:, 1, joint] = column.max() - 10.0 ** rng.uniform(-6, -1) * np.ptp(column)
        limits["position"][:, 0, joint] = column.min() - np.ptp(column)
        return task.changed(limits=Limits(**limits))
    if flaw.startswith("zero"):
        limits["velocity"][:, :, joint] = 0.0
        return task.changed(limits=Limits(**limits))
    travel = np.abs(np.diff(task.waypoints, axis=0))
    fastest = np.maximum(limits["velocity"][:, 1], -limits["velocity"][:, 0])
    needed = float((travel / fastest).max(axis=1).sum())
    return task.changed(objective=Objective(time=1.0, duration=(0.0, rng.uniform(0.3, 0.99) * needed)))
