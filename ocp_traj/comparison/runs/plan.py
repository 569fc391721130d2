"""What a comparison runs: cases x solvers x budgets x seeds, with seeds that depend on the plan alone."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ocp_traj.exceptions import InputError, did_you_mean

DEFAULT_CASES = ("ur5-torque-limited", "machines-2024-490")
DEFAULT_SOLVERS = ("ipopt", "pso", "ssa", "de", "cmaes", "cmaes[encoding=scaled]")
DEFAULT_RUNNER = "ocp_traj.comparison.runs.runner:solve_case"
DEFAULT_RUNNER_KEY = "ocp_traj.comparison.runner:solve_case"
"""What the default runner is called in the keys of stored runs, wherever its module lives."""
_MAXIMUM_RUNS = 1_000_000
_MAXIMUM_GIGABYTES = 2**20


@dataclass(frozen=True)
class CaseChoice:
    """A case by name or path, with ``key=value`` overrides as in ``--set``."""

    case: str
    overrides: tuple[str, ...] = ()


@dataclass(frozen=True)
class RunSpec:
    """One run: everything a worker needs, and everything its row is found by.

    Parameters
    ----------
    case, overrides
        As in `CaseChoice`.
    case_name, case_digest
        Name of the case with its overrides, and hash of everything that matters in it.
    solver
        Full name with parameters.
    seed, seed_index
        The number the solver gets, and its place in the plan (from 0).
    budget
        Evaluations allowed, or None for the solver's own default.
    time_limit
        Seconds the solver may take; it is stopped from outside when it does not stop by itself.
    memory_limit
        Bytes a run may take beyond the loaded libraries, or None.
    runner
        ``module:function`` that executes the run, see `ocp_traj.comparison.runs.runner`.
    """

    case: str
    overrides: tuple[str, ...]
    case_name: str
    case_digest: str
    solver: str
    seed: int
    seed_index: int
    budget: int | None
    time_limit: float | None
    memory_limit: int | None
    runner: str = DEFAULT_RUNNER

    @property
    def settings_digest(self) -> str:
        """Hash of the settings outside the case and the solver's name."""
        runner = DEFAULT_RUNNER_KEY if self.runner == DEFAULT_RUNNER else self.runner
        settings = [self.budget, self.time_limit, self.memory_limit, runner]
        return hashlib.sha256(json.dumps(settings).encode()).hexdigest()[:16]

    @property
    def key(self) -> tuple[str, str, str, int]:
        """Case digest, solver, settings digest, seed: the primary key of the run's row."""
        return (self.case_digest, self.solver, self.settings_digest, self.seed)

    def to_json(self) -> dict[str, Any]:
        """Return the specification as plain JSON values."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> RunSpec:
        """Rebuild a specification from `to_json`."""
        return cls(**{**values, "overrides": tuple(values["overrides"])})


@dataclass(frozen=True)
class Plan:
    """Cases x solvers x budgets x seeds, and the limits of every run.

    Parameters
    ----------
    cases, solvers
        What is compared; solvers by full name, for instance ``pso[inertia=linear]``.
    seeds
        Number of seeds.
    seed
        Root all seeds are derived from.
    budgets
        Evaluations allowed; None leaves it to each solver. Every budget is a run of its own.
    time_limit, memory_limit
        Seconds and bytes a run may take.
    references
        Whether TOPP-RA and the kinematic bound are computed once a case.
    runner
        ``module:function`` that executes one run.
    """

    cases: tuple[CaseChoice, ...] = tuple(CaseChoice(name) for name in DEFAULT_CASES)
    solvers: tuple[str, ...] = DEFAULT_SOLVERS
    seeds: int = 3
    seed: int = 0
    budgets: tuple[int | None, ...] = (None,)
    time_limit: float | None = 60.0
    memory_limit: int | None = 4 * 2**30
    references: bool = True
    runner: str = DEFAULT_RUNNER

    def __post_init__(self) -> None:
        if not self.cases:
            raise InputError("a plan needs at least one case")
        if not self.solvers:
            raise InputError("a plan needs at least one solver")
        for name, count in (("cases", self.cases), ("solvers", self.solvers), ("budgets", self.budgets)):
            if len(set(count)) != len(count):
                raise InputError(f"the plan names one of its {name} twice")
        if self.seeds < 1:
            raise InputError(f"seeds is {self.seeds}, expected 1 or more")
        for budget in self.budgets:
            if budget is not None and budget < 1:
                raise InputError(f"budget is {budget}, expected 1 or more evaluations")
        if self.time_limit is not None and not (0 < self.time_limit < math.inf):
            raise InputError(f"time limit is {self.time_limit}, expected a positive number of seconds")
        if self.memory_limit is not None and self.memory_limit <= 0:
            raise InputError(f"memory limit is {self.memory_limit}, expected a positive number of bytes")
        if self.size > _MAXIMUM_RUNS:
            raise InputError(f"the plan has {self.size} runs, expected at most {_MAXIMUM_RUNS}")

    @property
    def size(self) -> int:
        """Number of runs."""
        return len(self.cases) * len(self.solvers) * len(self.budgets) * self.seeds

    def runs(self, identify: Callable[[CaseChoice], tuple[str, str]]) -> tuple[RunSpec, ...]:
        """Return every run, seeds outermost, so that an interrupted comparison is balanced.

        Parameters
        ----------
        identify
            Gives the label of a case and its digest; called once a case.

        Raises
        ------
        InputError
            Two cases are the same problem, or different problems of the same name.
        """
        identities = [(choice, *identify(choice)) for choice in self.cases]
        _refuse_ambiguous(identities)
        return tuple(
            RunSpec(
                choice.case,
                choice.overrides,
                name,
                digest,
                solver,
                derive_seed(self.seed, name, index),
                index,
                budget,
                self.time_limit,
                self.memory_limit,
                self.runner,
            )
            for index in range(self.seeds)
            for choice, name, digest in identities
            for budget in self.budgets
            for solver in self.solvers
        )

    def to_json(self) -> dict[str, Any]:
        """Return the plan as plain JSON values."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Plan:
        """Rebuild a plan from `to_json`."""
        cases = tuple(CaseChoice(entry["case"], tuple(entry["overrides"])) for entry in values["cases"])
        rest = {"cases": cases, "solvers": tuple(values["solvers"]), "budgets": tuple(values["budgets"])}
        return cls(**{**values, **rest})


def derive_seed(root: int, case: str, index: int) -> int:
    """Return a seed in [0, 2^31) from the plan's root, the case and the place, never from order or workers.

    All solvers get the same seed on the same case, so their runs pair up.
    """
    text = f"{root}/{case}/{index}".encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:4], "big") >> 1


def canonical_name(solver: str) -> str:
    """Return a solver's name with its parameters in alphabetical order and without spaces.

    So ``pso[b=2, a=1]`` and ``pso[a=1,b=2]`` are one solver.
    """
    name, bracket, rest = solver.strip().partition("[")
    parameters = sorted(
        "=".join(side.strip() for side in part.split("="))
        for part in rest.rstrip("] ").split(",")
        if part.strip()
    )
    return f"{name.strip()}[{','.join(parameters)}]" if bracket and parameters else name.strip()


def _refuse_ambiguous(identities: Sequence[tuple[CaseChoice, str, str]]) -> None:
    digests: dict[str, CaseChoice] = {}
    labels: dict[str, CaseChoice] = {}
    for choice, label, digest in identities:
        if digest in digests:
            raise InputError(
                f"cases {digests[digest].case!r} and {choice.case!r} are the same problem, expected each once"
            )
        if label in labels:
            raise InputError(f"cases {labels[label].case!r} and {choice.case!r} are both named {label!r}")
        digests[digest] = labels[label] = choice


_PLAN_KEYS = {
    "schema", "cases", "solvers", "seeds", "seed", "budget", "time_limit", "memory_limit_gb", "references",
}  # fmt: skip


def plan_from_table(table: Mapping[str, Any], file: str) -> Plan:
    """Return the plan a TOML plan file states.

    Keys: ``schema = 1``, ``cases`` (names, paths or ``{case = "...", set = ["key=value"]}``), ``solvers``,
    ``seeds``, ``seed``, ``budget`` (number or list), ``time_limit`` (s), ``memory_limit_gb``, ``references``.
    Paths are relative to the plan file.

    Raises
    ------
    InputError
        A key is unknown or of the wrong type; names file and key.
    """
    unknown = sorted(set(table) - _PLAN_KEYS)
    if unknown:
        raise InputError(
            f"{file}: {unknown[0]}: unknown key, expected one of {', '.join(sorted(_PLAN_KEYS))}"
            f"{did_you_mean(unknown[0], _PLAN_KEYS)}"
        )
    if table.get("schema") != 1:
        raise InputError(f"{file}: schema: {table.get('schema')!r} given, expected 1")
    budget = table.get("budget")
    budgets = budget if isinstance(budget, list) else [budget]
    for name, kinds, expected in (
        ("seeds", int, "a whole number"), ("seed", int, "a whole number"),
        ("time_limit", (int, float), "a number of seconds"), ("memory_limit_gb", (int, float), "a number"),
        ("references", bool, "true or false"),
    ):  # fmt: skip
        given = table.get(name)
        if given is not None and (
            not isinstance(given, kinds) or (isinstance(given, bool) and kinds is not bool)
        ):
            raise InputError(f"{file}: {name}: {given!r} given, expected {expected}")
    if any(
        entry is not None and (not isinstance(entry, int) or isinstance(entry, bool)) for entry in budgets
    ):
        raise InputError(f"{file}: budget: {budget!r} given, expected a whole number or a list of them")
    values: dict[str, Any] = {
        name: table[name] for name in ("seeds", "seed", "time_limit", "references") if name in table
    }
    if "cases" in table:
        values["cases"] = tuple(
            _case_choice(entry, file) for entry in _as_list(table["cases"], "cases", file)
        )
    if "solvers" in table:
        values["solvers"] = tuple(
            _as_string(entry, "solvers", file) for entry in _as_list(table["solvers"], "solvers", file)
        )
    if "memory_limit_gb" in table:
        given = table["memory_limit_gb"]
        if not 0 < given < _MAXIMUM_GIGABYTES:
            raise InputError(f"{file}: memory_limit_gb: {given!r} given, expected a positive number of GB")
        values["memory_limit"] = int(given * 2**30)
    if not budgets:
        raise InputError(f"{file}: budget: an empty list given, expected a number of evaluations")
    return Plan(budgets=tuple(budgets), **values)


def _as_list(value: Any, key: str, file: str) -> list[Any]:
    if not isinstance(value, list):
        raise InputError(f"{file}: {key}: {value!r} given, expected a list")
    return value


def _as_string(value: Any, key: str, file: str) -> str:
    if not isinstance(value, str):
        raise InputError(f"{file}: {key}: {value!r} given, expected a string")
    return value


def _case_choice(entry: Any, file: str) -> CaseChoice:
    overrides: tuple[str, ...] = ()
    if isinstance(entry, dict):
        unknown = sorted(set(entry) - {"case", "set"})
        if unknown:
            raise InputError(f"{file}: cases: unknown key {unknown[0]!r}, expected case or set")
        overrides = tuple(
            _as_string(item, "cases.set", file) for item in _as_list(entry.get("set", []), "cases.set", file)
        )
        entry = entry.get("case")
    name = _as_string(entry, "cases", file)
    beside = Path(file).parent / name
    return CaseChoice(str(beside) if name.endswith(".toml") else name, overrides)
