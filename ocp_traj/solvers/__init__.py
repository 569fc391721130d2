"""Solvers of trajectory tasks: one interface, one registry, one file per solver."""

from __future__ import annotations

from ocp_traj.solvers.registry import SolverInfo, parse_solver, solver_names, solver_table, split_solvers
from ocp_traj.solvers.solver import Outcome, Request, Solver

__all__ = [
    "Outcome",
    "Request",
    "Solver",
    "SolverInfo",
    "parse_solver",
    "solver_names",
    "solver_table",
    "split_solvers",
]
