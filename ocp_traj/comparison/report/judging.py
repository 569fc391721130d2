"""From stored runs to what can be said about solvers: success by the audit, gaps, costs, tests."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.report.profiles import Course, course_of
from ocp_traj.comparison.report.statistics import (
    Friedman,
    Interval,
    PairTest,
    bootstrap_median,
    compare_pairs,
    friedman,
    median,
)
from ocp_traj.comparison.runs.store import StoredRun
from ocp_traj.references.reference import Reference

CASES_AS_BLOCKS = 6
"""From this many problems on, tests are over problems (medians), not over single runs."""


@dataclass(frozen=True)
class ComparedProblem:
    """A case under one setting, with what is known about its answer.

    Parameters
    ----------
    digest, settings_digest
        What makes runs comparable.
    name, label
        The case's name, and that with the budget where the comparison has several.
    best
        Best audited objective of any run here.
    references
        Durations by reference and part, s; those that were found.
    missing_references
        Which references could not be computed, and why.
    """

    digest: str
    settings_digest: str
    name: str
    label: str
    best: float | None
    references: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    missing_references: tuple[str, ...] = ()

    @property
    def key(self) -> tuple[str, str]:
        """What rows are grouped by."""
        return (self.digest, self.settings_digest)

    def known(self, reference: Reference) -> Mapping[str, float]:
        """Return the durations of a reference by part, s."""
        return self.references.get(reference.name, {})

    def best_of(self, reference: Reference) -> float | None:
        """Return the duration of a reference that results are compared with, s."""
        part = reference.best(self.known(reference))
        return None if part is None else self.known(reference)[part]

    @property
    def toppra(self) -> float | None:
        """Best TOPP-RA duration over its paths, s."""
        return min(self.references.get("toppra", {}).values(), default=None)

    @property
    def toppra_path(self) -> str:
        """The path of that duration."""
        timings = self.references.get("toppra", {})
        return min(timings, key=lambda name: timings[name], default="")

    @property
    def lower_bound(self) -> float | None:
        """Certified shortest duration under velocity and acceleration limits, s."""
        return self.references.get("kinematic_bound", {}).get("lower")

    @property
    def estimate(self) -> float | None:
        """Estimate of the same, s: a local optimum."""
        return self.references.get("kinematic_bound", {}).get("estimate")


@dataclass(frozen=True)
class Group:
    """All runs of one solver on one problem."""

    problem: ComparedProblem
    solver: str
    rows: tuple[StoredRun, ...]
    courses: tuple[Course, ...]

    @property
    def successes(self) -> int:
        """Runs whose answer the audit accepts."""
        return sum(row.record.feasible for row in self.rows)

    @property
    def honest(self) -> int:
        """Runs whose own claim agrees with the audit."""
        return sum(row.record.return_code_correct for row in self.rows)

    @property
    def failures(self) -> Counter[str]:
        """Why runs failed, counted."""
        return Counter(describe_failure(row) for row in self.rows if not row.record.feasible)

    @property
    def best(self) -> StoredRun | None:
        """The feasible run of the best objective (the first seed among equals)."""
        feasible = [row for row in self.rows if row.record.feasible]
        return min(feasible, key=lambda row: (objective_of(row), row.seed_index), default=None)

    def values(self, name: str) -> Array:
        """Return a number of every run's record; runs that have none are infinite."""
        return np.array([_or_infinite(getattr(row.record, name)) for row in self.rows])

    def objectives(self) -> Array:
        """Return the audited objective of every run, infinite where the audit refuses."""
        return np.array([objective_of(row) for row in self.rows])

    def durations(self) -> Array:
        """Return the duration of every run, infinite where the audit refuses."""
        return np.array(
            [_or_infinite(row.record.duration) if row.record.feasible else np.inf for row in self.rows]
        )


@dataclass(frozen=True)
class Judgement:
    """Everything a report says.

    Parameters
    ----------
    problems, solvers
        In the order shown; solvers by mean rank.
    groups
        Runs by (problem key, solver).
    ranks, pairs
        Tests over blocks; None and empty when fewer than two solvers or blocks share runs.
    block_kind
        ``problems`` or ``runs``.
    ratios
        (blocks, solvers) objective over the best of the problem, infinite where failed.
    """

    problems: tuple[ComparedProblem, ...]
    solvers: tuple[str, ...]
    groups: Mapping[tuple[tuple[str, str], str], Group]
    ranks: Friedman
    pairs: tuple[PairTest, ...]
    block_kind: str
    ratios: Array

    def group(self, problem: ComparedProblem, solver: str) -> Group | None:
        """Return the runs of a solver on a problem, or None when there are none yet."""
        return self.groups.get((problem.key, solver))

    def of_solver(self, solver: str) -> list[Group]:
        """Return the groups of one solver, in the problems' order."""
        return [
            self.groups[problem.key, solver]
            for problem in self.problems
            if (problem.key, solver) in self.groups
        ]


def objective_of(row: StoredRun) -> float:
    """Return a run's objective, infinite where the audit refuses its answer."""
    return _or_infinite(row.record.objective) if row.record.feasible else np.inf


def _or_infinite(value: float | None) -> float:
    return np.inf if value is None else float(value)


def describe_failure(row: StoredRun) -> str:
    """Return in a few words why a run did not succeed."""
    record = row.record
    if record.reason:
        return record.reason
    said = "claimed success, but" if record.claimed else f"{record.status.replace('_', ' ')}:"
    if record.worst is None:
        return f"{said} no answer"
    return f"{said} {record.worst['limit']} at {_or_infinite(record.worst['ratio']):.4g} of its limit"


def judge(rows: Sequence[StoredRun], cases: Mapping[str, Mapping[str, Any]]) -> Judgement:
    """Judge stored runs.

    Parameters
    ----------
    rows
        All runs to compare; see `ocp_traj.comparison.runs.store.Store.rows`.
    cases
        By digest: ``reference`` as stored.
    """
    problems = _problems(rows, cases)
    groups = _groups(rows, problems)
    solvers = sorted({row.solver for row in rows})
    values, kind = _blocks(problems, solvers, groups)
    ranks = friedman(values, solvers)
    pairs = compare_pairs(values, solvers) if len(values) and len(solvers) > 1 else []
    order = sorted(
        range(len(solvers)), key=lambda place: (_nan_last(ranks.ranks[solvers[place]]), solvers[place])
    )
    ordered = tuple(solvers[place] for place in order)
    return Judgement(problems, ordered, groups, ranks, tuple(pairs), kind, values[:, order])


def _nan_last(value: float) -> float:
    return np.inf if np.isnan(value) else value


def _problems(
    rows: Sequence[StoredRun], cases: Mapping[str, Mapping[str, Any]]
) -> tuple[ComparedProblem, ...]:
    found: dict[tuple[str, str], StoredRun] = {}
    best: dict[tuple[str, str], float] = defaultdict(lambda: np.inf)
    settings: dict[str, set[str]] = defaultdict(set)
    for row in rows:
        key = (row.case_digest, row.settings_digest)
        found.setdefault(key, row)
        settings[row.case_digest].add(row.settings_digest)
        best[key] = min(best[key], objective_of(row))
    problems = [
        _problem(row, cases.get(row.case_digest, {}), best[key], len(settings[row.case_digest]) > 1)
        for key, row in found.items()
    ]
    return tuple(sorted(problems, key=lambda problem: problem.label))


def _problem(row: StoredRun, case: Mapping[str, Any], best: float, several: bool) -> ComparedProblem:
    reference = case.get("reference") or {}
    known = {
        name: {part: value for part, value in found.items() if isinstance(value, (int, float))}
        for name, found in reference.items()
    }
    budget = "own budget" if row.budget is None else f"{row.budget} evaluations"
    label = f"{row.case_name} ({budget})" if several else row.case_name
    return ComparedProblem(
        row.case_digest,
        row.settings_digest,
        row.case_name,
        label,
        best if np.isfinite(best) else None,
        known,
        tuple(
            f"{part.replace('_', ' ')}: {found['failed']}"
            for part, found in reference.items()
            if "failed" in found
        ),
    )


def _groups(
    rows: Sequence[StoredRun], problems: Sequence[ComparedProblem]
) -> dict[tuple[tuple[str, str], str], Group]:
    collected: dict[tuple[tuple[str, str], str], list[StoredRun]] = defaultdict(list)
    for row in rows:
        collected[(row.case_digest, row.settings_digest), row.solver].append(row)
    known = {problem.key: problem for problem in problems}
    return {
        (key, solver): Group(known[key], solver, tuple(found), _courses(found))
        for (key, solver), found in collected.items()
    }


def _courses(rows: Sequence[StoredRun]) -> tuple[Course, ...]:
    """Return the courses; a run that died is taken to have spent what the longest of its siblings did."""
    told = [row.record.evaluations for row in rows if row.record.evaluations is not None]
    assumed = max([*told, *(row.budget for row in rows if row.budget is not None)], default=1)
    return tuple(course_of(row, assumed) for row in rows)


def _blocks(
    problems: Sequence[ComparedProblem],
    solvers: Sequence[str],
    groups: Mapping[tuple[tuple[str, str], str], Group],
) -> tuple[Array, str]:
    """Return objective ratios (blocks, solvers); blocks that miss a solver are left out, being unfinished."""
    if len(problems) >= CASES_AS_BLOCKS:
        medians = [
            [_median_ratio(groups.get((problem.key, solver))) for solver in solvers] for problem in problems
        ]
        complete = [row for row in medians if not any(np.isnan(value) for value in row)]
        return np.array(complete).reshape(len(complete), len(solvers)), "problems"
    blocks: list[list[float]] = []
    for problem in problems:
        by_seed = [
            {row.seed: _ratio(problem, objective_of(row)) for row in group.rows} if group else {}
            for group in (groups.get((problem.key, solver)) for solver in solvers)
        ]
        common = sorted(set.intersection(*(set(entry) for entry in by_seed)))
        blocks += [[entry[number] for entry in by_seed] for number in common]
    return np.array(blocks).reshape(len(blocks), len(solvers)), "runs"


def _ratio(problem: ComparedProblem, objective: float) -> float:
    if problem.best is None:
        return np.inf
    return objective / problem.best if problem.best > 0 else 1.0 + objective - problem.best


def _median_ratio(group: Group | None) -> float:
    if group is None:
        return np.nan
    return _ratio(group.problem, median(group.objectives()))


def median_interval(values: Array, label: str) -> Interval:
    """Return median and interval with a generator that depends on the label alone."""
    return bootstrap_median(values, np.random.default_rng([*label.encode()]))
