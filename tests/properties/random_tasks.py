"""Random but solvable kinematic tasks, reproducible from one integer."""

from __future__ import annotations

import numpy as np

from ocp_traj.task import Boundary, Limits, TrajectoryTask

FAMILIES = ("cubic", "quintic", "septic")


def random_task(seed: int, *, moving_ends: bool = False, jerk: bool | None = None) -> TrajectoryTask:
    """A task with 2 to 6 waypoints, 1 to 8 joints, any family, and limits over several decades."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    family = str(rng.choice(FAMILIES))
    knots = int(rng.integers(0, 3)) if family == "cubic" else 0
    count = int(rng.integers(2, 7))
    scale = 10.0 ** rng.uniform(-3, 2, n)
    waypoints = rng.uniform(-1, 1, (count, n)) * scale
    velocity = scale * 10.0 ** rng.uniform(-0.5, 0.5, n)
    acceleration = scale * 10.0 ** rng.uniform(-0.5, 0.5, n)
    limits = {"velocity": velocity, "acceleration": acceleration}
    if jerk if jerk is not None else rng.random() < 0.5:
        limits["jerk"] = scale * 10.0 ** rng.uniform(0.0, 1.0, n)
    boundary = Boundary()
    if moving_ends:
        boundary = Boundary(velocity=0.1 * velocity * rng.uniform(-1, 1, (2, n)))
    return TrajectoryTask(
        waypoints,
        Limits(**limits),
        family=family,
        virtual_knots=knots,
        boundary=boundary,
        name=f"random-{seed}",
    )
