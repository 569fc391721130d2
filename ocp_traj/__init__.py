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
    from ocp_traj.audit import Verdict, audit
    from ocp_traj.audit.costs import energy, objective_value
    from ocp_traj.case import case_names, load_case, task_digest, write_case
    from ocp_traj.exceptions import (
        CaseError,
        InputError,
        OcpTrajError,
        RobotError,
        TaskError,
        UnavailableError,
        UnknownNameError,
        UnreachablePoseError,
    )
    from ocp_traj.pareto import ParetoFront, pareto_front
    from ocp_traj.references import (
        certify,
        convex_reference,
        kinematic_bound,
        toppra_reference,
    )
    from ocp_traj.robot import (
        Friction,
        Payload,
        Robot,
        load_robot,
        robot_from_dh,
        robot_from_urdf,
        robot_names,
    )
    from ocp_traj.solvers import solver_names, solver_table
    from ocp_traj.solving import SolveResult, solve
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
    from ocp_traj.trajectory_files import read_csv, write_csv
    from ocp_traj.transcription import trajectory_from_durations, transcribe

_MODULES = {
    "ocp_traj.audit": ("Verdict", "audit"),
    "ocp_traj.case": ("case_names", "load_case", "task_digest", "write_case"),
    "ocp_traj.audit.costs": ("energy", "objective_value"),
    "ocp_traj.exceptions": (
        "CaseError",
        "InputError",
        "OcpTrajError",
        "RobotError",
        "TaskError",
        "UnavailableError",
        "UnknownNameError",
        "UnreachablePoseError",
    ),
    "ocp_traj.references": (
        "certify",
        "convex_reference",
        "kinematic_bound",
        "toppra_reference",
    ),
    "ocp_traj.robot": (
        "Friction",
        "Payload",
        "Robot",
        "load_robot",
        "robot_from_dh",
        "robot_from_urdf",
        "robot_names",
    ),
    "ocp_traj.solving": ("SolveResult", "solve"),
    "ocp_traj.solvers": ("solver_names", "solver_table"),
    "ocp_traj.pareto": ("ParetoFront", "pareto_front"),
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
    "ocp_traj.trajectory_files": ("read_csv", "write_csv"),
    "ocp_traj.transcription": ("trajectory_from_durations", "transcribe"),
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
    "ParetoFront",
    "Payload",
    "Robot",
    "RobotError",
    "Search",
    "SolveResult",
    "TaskError",
    "Trajectory",
    "TrajectoryTask",
    "UnavailableError",
    "UnknownNameError",
    "UnreachablePoseError",
    "Verdict",
    "__version__",
    "audit",
    "case_names",
    "certify",
    "convex_reference",
    "energy",
    "kinematic_bound",
    "load_case",
    "load_robot",
    "objective_value",
    "pareto_front",
    "read_csv",
    "robot_from_dh",
    "robot_from_urdf",
    "robot_names",
    "solve",
    "solver_names",
    "solver_table",
    "task_digest",
    "toppra_reference",
    "trajectory_from_durations",
    "transcribe",
    "write_case",
    "write_csv",
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
