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

from metaheuristics.settings import check_settings
from ocp_traj.exceptions import InputError, UnavailableError, UnknownNameError
from ocp_traj.solvers.solver import Solver

GROUP = "ocp_traj.solvers"


@dataclass(frozen=True)
class Entry:
    """Where a solver lives: module, class, the settings its name stands for, and the packages it needs."""

    module: str
    attribute: str
    kind: str
    summary: str
    settings: dict[str, Any] = field(default_factory=dict)
    requires: tuple[str, ...] = ()


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


def _population(method: str, summary: str, requires: tuple[str, ...] = ()) -> Entry:
    return Entry(
        "ocp_traj.solvers.population.population", "Population", "population", summary, {"method": method}, requires
    )


def _hybrid(method: str, summary: str, requires: tuple[str, ...] = ()) -> Entry:
    return Entry("ocp_traj.solvers.hybrid", "Hybrid", "hybrid", summary, {"method": method}, requires)


def _plugin(plugin: str, summary: str) -> Entry:
    return Entry("ocp_traj.solvers.gradient.gradient", "Gradient", "gradient", summary, {"plugin": plugin})


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
    "pso": _population("pso", "particle swarm, inertia 0.9 to 0.4, c1 = c2 = 2"),
    "pso-constriction": _population("pso-constriction", "particle swarm with constriction values"),
    "pso-d": _population("pso-d", "particle swarm of paper D, trigonometric schedules"),
    "ssa": _population("ssa", "sparrow search as published"),
    "ssa-debiased": _population("ssa-debiased", "sparrow search without the pull towards the origin"),
    "issa-a": _population(
        "issa-a", "sparrow search of paper A: elite opposition, Gauss-Cauchy, non-dominated sorting"
    ),
    "issa-b": _population(
        "issa-b", "sparrow search of paper B: 2-D logistic chaos, Levy flights, reverse learning"
    ),
    "t-ssa": _population("t-ssa", "sparrow search of paper C: Tent chaos"),
    "adf-ssa": _population("adf-ssa", "sparrow search of paper C: adaptive step factors"),
    "tadf-ssa": _population("tadf-ssa", "sparrow search of paper C: Tent chaos and adaptive step factors"),
    "de": _population("de", "differential evolution"),
    "random": _population("random", "uniform random search"),
    "cmaes": _population("cmaes", "covariance matrix adaptation", ("cmaes",)),
    "pso+ipopt": _hybrid("pso", "particle swarm, then IPOPT from the best few motions"),
    "ssa+ipopt": _hybrid("ssa", "sparrow search as published, then IPOPT from the best few motions"),
    "issa+ipopt": _hybrid(
        "issa-a", "paper A's improved sparrow search, then IPOPT from the best few motions"
    ),
    "cmaes+ipopt": _hybrid("cmaes", "CMA-ES, then IPOPT from the best few motions", ("cmaes",)),
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
            solver = parse_solver(name)
            check = getattr(solver, "check_available", None)
            if check is not None:
                check()
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
    _check_kinds(name, cls, settings)
    make = getattr(cls, "from_settings", None)
    if make is not None:
        made: Solver = make(settings)
        return made
    return _construct(name, cls, settings)


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
            raise UnknownNameError(f"solver {name!r} is unknown, expected one of {', '.join(solver_names())}")
        try:
            return points[name].load(), {}
        except Exception as error:  # somebody else's package: whatever it raises is the reason we report
            raise UnavailableError(f"solver {name!r} cannot be loaded: {error}") from error
    try:
        for package in entry.requires:
            importlib.import_module(package)
        module = importlib.import_module(entry.module)
    except ImportError as error:
        raise UnavailableError(f"solver {name!r} cannot be loaded: {error}") from error
    return getattr(module, entry.attribute), dict(entry.settings)


def _made_hybrid(name: str) -> Entry | None:
    """Return the entry of ``method+ipopt`` for any population method of this package, listed or not."""
    method, plus, plugin = name.partition("+")
    entry = ENTRIES.get(method)
    if not plus or plugin != "ipopt" or entry is None or entry.kind != "population":
        return None
    return _hybrid(str(entry.settings["method"]), entry.summary, entry.requires)


def _check_kinds(name: str, cls: Any, settings: dict[str, Any]) -> None:
    """Refuse settings that are not of the kind their fields are declared to be."""
    if dataclasses.is_dataclass(cls):
        try:
            check_settings(f"solver {name!r}", cast(type, cls), settings)
        except ValueError as error:
            raise InputError(str(error)) from None


def _construct(name: str, cls: type[Solver], settings: dict[str, Any]) -> Solver:
    known: list[str] = (
        [entry.name for entry in dataclasses.fields(cls)] if dataclasses.is_dataclass(cls) else []
    )
    unknown = set(settings) - set(known)
    if unknown:
        raise UnknownNameError(
            f"solver {name!r} has no setting {min(unknown)!r}, expected one of {', '.join(known) or 'none'}"
        )
    try:
        return cls(**settings)
    except (TypeError, ValueError) as error:
        raise InputError(f"solver {name!r}: {error}") from error


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
