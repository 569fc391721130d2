"""Solvers by name. A new one is a file with a `Solver` subclass, and one line in `ENTRIES`.

A package of somebody else adds its own through the entry-point group ``ocp_traj.solvers``: the entry's name is
the solver's, its object a `Solver` subclass. Nothing here imports a solver before it is asked for.
"""

from __future__ import annotations

import dataclasses
import importlib
import re
from dataclasses import dataclass, field
from importlib import metadata
from typing import Any, cast

from metaheuristics.algorithms.registry import Method, registry
from metaheuristics.settings import check_settings
from ocp_traj.exceptions import InputError, UnavailableError, UnknownNameError, did_you_mean
from ocp_traj.solvers.solver import Solver
from ocp_traj.task import TrajectoryTask

GROUP = "ocp_traj.solvers"


@dataclass(frozen=True)
class Entry:
    """Where a solver lives: module, class, and the settings its name stands for."""

    module: str
    attribute: str
    kind: str
    summary: str
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class SolverInfo:
    """A row of ``ocp-traj list solvers``.

    Attributes
    ----------
    name : str
    kind : str
        ``gradient``, ``population``, ``hybrid`` or ``third-party``.
    available : bool
        Whether it can be loaded and used here.
    reason : str
        Why not; empty when it can.
    summary : str
        One line.
    """

    name: str
    kind: str
    available: bool
    reason: str
    summary: str = ""


def _population(name: str, method: Method) -> Entry:
    home = "ocp_traj.solvers.population.population"
    return Entry(home, "Population", "population", method.summary, {"method": name})


def _hybrid(population: Entry) -> Entry:
    summary = f"{population.summary}; then IPOPT from the best few motions"
    return Entry("ocp_traj.solvers.hybrid", "Hybrid", "hybrid", summary, population.settings)


def _plugin(plugin: str, summary: str) -> Entry:
    return Entry("ocp_traj.solvers.gradient.gradient", "Gradient", "gradient", summary, {"plugin": plugin})


_METHODS = {name: _population(name, method) for name, method in registry.items()}
"""Every population method, also the variants that have no summary and are not listed."""

ENTRIES: dict[str, Entry] = {
    "ipopt": _plugin("ipopt", "interior point with exact sparse derivatives"),
    "uno": _plugin("uno", "Uno's interior point with line search"),
    "sleqp": _plugin("sleqp", "active set, sequential linear and equality-constrained quadratic programs"),
    "fatrop": _plugin("fatrop", "interior point, here without the structure of stages"),
    "sqpmethod": _plugin("sqpmethod", "CasADi's sequential quadratic programming over PIQP, for small tasks"),
    "alpaqa": _plugin("alpaqa", "augmented Lagrangian with proximal gradients, coarse, for small tasks"),
    "blocksqp": _plugin("blocksqp", "block-structured sequential quadratic programming, needs HSL's MA27"),
    "madnlp": _plugin("madnlp", "interior point, needs a CasADi built with it"),
    "snopt": _plugin("snopt", "sequential quadratic programming, needs a licence"),
    "knitro": _plugin("knitro", "interior point and active set, needs a licence"),
    "worhp": _plugin("worhp", "sequential quadratic programming, needs a licence"),
    **{name: entry for name, entry in _METHODS.items() if entry.summary},
    "pso+ipopt": _hybrid(_METHODS["pso"]),
    "ssa+ipopt": _hybrid(_METHODS["ssa"]),
    "issa+ipopt": _hybrid(_METHODS["issa-a"]),
    "cmaes+ipopt": _hybrid(_METHODS["cmaes"]),
    "ipopt-multistart": Entry(
        "ocp_traj.solvers.gradient.multistart",
        "MultiStart",
        "hybrid",
        "IPOPT from random proportions of the durations",
    ),
}


def solver_names() -> list[str]:
    """Return the names of all solvers, this package's first, then those found by entry point."""
    return [*ENTRIES, *sorted(name for name in _entry_points() if name not in ENTRIES)]


def solver_table() -> list[SolverInfo]:
    """Return every solver with the reason why it cannot be loaded, if so."""
    rows = []
    for name in solver_names():
        entry = ENTRIES.get(name)
        reason = ""
        try:
            parse_solver(name).check_available()
        except UnavailableError as error:
            reason = str(error)
        kind = entry.kind if entry else "third-party"
        rows.append(SolverInfo(name, kind, not reason, reason, entry.summary if entry else _summary(name)))
    return rows


def _summary(name: str) -> str:
    """Return the first line of a third party's own description, and where it comes from."""
    point = _entry_points()[name]
    try:
        words = (point.load().__doc__ or "").strip().splitlines()
    except Exception:  # its reason is in the table already
        words = []
    return words[0] if words else f"found by entry point {point.value}"


def parse_solver(text: str) -> Solver:
    """Return the solver that ``name[key=value,...]`` or ``name@preset[...]`` stands for.

    Parameters
    ----------
    text : str
        For instance ``"pso[inertia=linear,population=50]"``.

    Raises
    ------
    UnknownNameError
        There is no such solver, setting or preset; the message lists what there is.
    UnavailableError
        It exists but cannot be loaded here; says why.
    """
    match = re.fullmatch(r"\s*([\w+.-]+)(?:@([\w+.-]+))?(?:\[(.*)\])?\s*", text, re.DOTALL)
    if match is None:
        raise UnknownNameError(
            f"solver {text!r} cannot be read, expected name, name[key=value,...] or name@preset"
        )
    name, preset, parameters = match.groups()
    cls, settings = _load(name)
    given = {} if parameters is None else _read_parameters(text, parameters)
    if preset is not None:
        given = {"preset": preset, **given}
    settings |= given
    try:
        if dataclasses.is_dataclass(cast(object, cls)):
            check_settings(f"solver {name!r}", cast(type, cls), settings)
        return cls.from_settings(settings)
    except (TypeError, ValueError) as error:
        kind = UnknownNameError if isinstance(error, UnknownNameError) else InputError
        raise kind(f"solver {name!r}: {error}") from error


def follow_protocol(solver: Solver, task: TrajectoryTask) -> Solver:
    """Return the solver as the task's protocol wants it: a population method may move every joint alone.

    Parameters
    ----------
    solver : Solver
    task : TrajectoryTask
        Its ``search.protocol`` is ``"shared"`` or ``"per-joint"``.

    Returns
    -------
    Solver
        The same one, or a `PerJoint` around it.
    """
    if task.search.protocol != "per-joint":
        return solver
    from ocp_traj.solvers.per_joint import PerJoint
    from ocp_traj.solvers.population.condensed import CondensedSolver

    return PerJoint(solver) if isinstance(solver, CondensedSolver) else solver


def split_solvers(text: str) -> list[str]:
    """Split a comma-separated list of solvers; commas inside brackets belong to a solver.

    Parameters
    ----------
    text : str

    Returns
    -------
    list of str
        Each as `parse_solver` takes it.

    Examples
    --------
    >>> split_solvers("ipopt, pso[inertia=linear,population=50]")
    ['ipopt', 'pso[inertia=linear,population=50]']
    """
    parts = re.split(r",(?![^\[]*\])", text)
    return [part.strip() for part in parts if part.strip()]


def _entry_points() -> dict[str, metadata.EntryPoint]:
    return {entry.name: entry for entry in metadata.entry_points(group=GROUP)}


def _load(name: str) -> tuple[type[Solver], dict[str, Any]]:
    entry = ENTRIES.get(name) or _made_hybrid(name)
    if entry is None:
        points = _entry_points()
        if name not in points:
            known = solver_names()
            raise UnknownNameError(
                f"solver {name!r} is unknown, expected one of {', '.join(known)}{did_you_mean(name, known)}"
            )
        try:
            cls = points[name].load()
        except Exception as error:  # somebody else's package: whatever it raises is the reason we report
            raise UnavailableError(f"solver {name!r} cannot be loaded: {error}") from error
        if not (isinstance(cls, type) and issubclass(cls, Solver)):
            raise UnavailableError(
                f"solver {name!r} cannot be loaded: {points[name].value} is {cls!r}, expected a subclass of "
                "ocp_traj.solvers.Solver"
            )
        return cls, {}
    try:
        module = importlib.import_module(entry.module)
    except ImportError as error:
        raise UnavailableError(f"solver {name!r} cannot be loaded: {error}") from error
    return getattr(module, entry.attribute), dict(entry.settings)


def _made_hybrid(name: str) -> Entry | None:
    """Return the entry of ``method+ipopt`` for any population method of this package."""
    method, _, plugin = name.partition("+")
    return _hybrid(_METHODS[method]) if plugin == "ipopt" and method in _METHODS else None


def _read_parameters(text: str, parameters: str) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for part in parameters.split(","):
        key, separator, value = part.partition("=")
        if not separator or not key.strip():
            raise UnknownNameError(f"solver {text!r}: {part!r} cannot be read, expected key=value")
        values[key.strip()] = read_value(value.strip())
    return values


def read_value(text: str) -> Any:
    """Read a whole number, a number, true, false or none; anything else is a word."""
    if text.lower() in ("true", "false", "none"):
        return {"true": True, "false": False, "none": None}[text.lower()]
    for convert in (int, float):
        try:
            return convert(text)
        except ValueError:
            continue
    return text.strip("'\"")
