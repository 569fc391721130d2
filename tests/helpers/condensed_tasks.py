"""Small tasks for the tests of the condensed form."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from ocp_traj.robot import load_robot
from ocp_traj.robot.additions import Friction
from ocp_traj.task import (
    Boundary,
    CustomConstraint,
    CustomObjective,
    Limits,
    Motor,
    Objective,
    Search,
    TrajectoryTask,
)

UR5 = load_robot("ur5")
WAYPOINTS = np.deg2rad(
    [
        [-48.9, -64.7, 108.5, -133.7, -90.0, 131.1],
        [-39.0, -94.6, 91.8, -87.2, -90.0, 141.0],
        [14.0, -103.3, 99.0, -85.7, -90.0, 194.0],
        [40.3, -92.9, 103.3, -100.5, -90.0, 220.3],
        [48.7, -68.2, 118.5, -140.3, -90.0, 228.7],
    ]
)
"""Joint 5 stands still."""

FAMILIES = ("cubic", "quintic", "septic", "3-5-3")

LIMITS: dict[str, dict[str, Any]] = {
    "position": {
        "position": np.deg2rad([[-50.0, -110, 80, -145, -100, 100], [50.0, -60, 119, -80, -80, 230]])
    },
    "velocity": {"velocity": [1.0, 1.2, 0.8, 1.5, np.inf, 1.0]},
    "acceleration": {"acceleration": np.array([[-2.0] * 6, [3.0] * 6])},
    "jerk": {"jerk": 15.0},
    "torque": {"torque": [60.0, 80.0, 40.0, 10.0, 5.0, np.inf]},
    "torque_rate": {"torque_rate": 200.0},
    "cartesian_speed": {"cartesian_speed": (("tool0", 0.5),)},
    "per gap": {
        "velocity": np.stack([np.stack([-np.full(6, v), np.full(6, v)]) for v in (0.5, 1.0, 0.7, 0.9)])
    },
}
UNLIMITED = {"position": np.inf, "velocity": np.inf, "torque": np.inf}

MOTOR = Motor(torque_constant=np.linspace(0.05, 0.1, 6), resistance=0.5, gear_ratio=100.0)

OBJECTIVES: dict[str, dict[str, Any]] = {
    "time": {"time": 1.0},
    "energy": {"energy": 1.0, "time": 0.5},
    "energy_without_regeneration": {"energy_without_regeneration": 1.0},
    "torque": {"torque": 1.0, "time": 1.0},
    "acceleration": {"acceleration": 0.1, "time": 1.0},
    "jerk": {"jerk": 0.01, "time": 1.0},
    "motor_loss": {"motor_loss": 1.0, "time": 1.0, "motor": MOTOR},
}


def custom_speed() -> Any:
    q, v, a, tau = (ca.SX.sym(name, 6) for name in ("q", "v", "a", "tau"))
    return ca.Function("speed", [q, v, a, tau], [ca.vertcat(ca.sumsqr(v), q[0] * v[1])])


def custom_cost() -> Any:
    q, v, a, tau = (ca.SX.sym(name, 6) for name in ("q", "v", "a", "tau"))
    return ca.Function("effort", [q, v, a, tau], [ca.sumsqr(a) + ca.sumsqr(q)])


CUSTOM_CONSTRAINT = CustomConstraint("speed", custom_speed(), upper=[1.5, 0.4])
CUSTOM_OBJECTIVE = CustomObjective("effort", custom_cost(), 0.3)


def make_task(
    family: str = "cubic",
    limits: dict[str, Any] | None = None,
    objective: dict[str, Any] | None = None,
    *,
    virtual_knots: int = 0,
    boundary: dict[str, Any] | None = None,
    friction: Friction | None = None,
    constraints: tuple[CustomConstraint, ...] = (),
    robot: Any = UR5,
    waypoints: Any = WAYPOINTS,
    search: Any = (0.2, 2.0),
) -> TrajectoryTask:
    if friction is not None:
        robot = robot.with_changes(friction=friction)
    return TrajectoryTask(
        waypoints=waypoints,
        limits=Limits(**{**UNLIMITED, **({} if limits is None else limits)}),
        robot=robot,
        family=family,
        virtual_knots=virtual_knots,
        boundary=Boundary(**({} if boundary is None else boundary)),
        objective=Objective(**({"time": 1.0} if objective is None else objective)),
        search=Search(search),
        constraints=constraints,
        name="small",
    )
