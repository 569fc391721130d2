"""Compare optimal-control solvers on robot-arm trajectories: one problem, one budget, one judge.

Public names are imported when first used, so ``import ocp_traj`` is light::

    import ocp_traj as ot

    task = ot.load_case("ur5-palletizing")
    result = ot.solve(task, "ipopt", seed=0)
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from ocp_traj.case import case_names, load_case, task_digest, write_case
    from ocp_traj.exceptions import CaseError, InputError, OcpTrajError, TaskError
    from ocp_traj.robot import (
        Friction,
        Payload,
        Robot,
        load_robot,
        robot_from_dh,
        robot_from_urdf,
        robot_names,
    )
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
    from ocp_traj.trajectory import Trajectory

_MODULES = {
    "ocp_traj.case": ("case_names", "load_case", "task_digest", "write_case"),
    "ocp_traj.exceptions": ("CaseError", "InputError", "OcpTrajError", "TaskError"),
    "ocp_traj.robot": (
        "Friction",
        "Payload",
        "Robot",
        "load_robot",
        "robot_from_dh",
        "robot_from_urdf",
        "robot_names",
    ),
    "ocp_traj.task": (
        "Boundary",
        "CustomConstraint",
        "CustomObjective",
        "Limits",
        "Motor",
        "Objective",
        "Search",
        "TrajectoryTask",
    ),
    "ocp_traj.trajectory": ("Trajectory",),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "Boundary",
    "CaseError",
    "CustomConstraint",
    "CustomObjective",
    "Friction",
    "InputError",
    "Limits",
    "Motor",
    "Objective",
    "OcpTrajError",
    "Payload",
    "Robot",
    "Search",
    "TaskError",
    "Trajectory",
    "TrajectoryTask",
    "__version__",
    "case_names",
    "load_case",
    "load_robot",
    "robot_from_dh",
    "robot_from_urdf",
    "robot_names",
    "task_digest",
    "write_case",
]


class _Package(ModuleType):
    """Keeps a module, once imported, from hiding the function of the same name (`audit`, `solve`)."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    """Import a public name from its module when it is first asked for."""
    if name not in _HOME:
        raise AttributeError(f"module 'ocp_traj' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    """Return the public names, for completion in an editor."""
    return sorted(__all__)
