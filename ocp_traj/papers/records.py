"""Runs of a paper's experiments, kept line by line so that nothing finished is run again."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.papers.experiments import PUBLISHED_PROTOCOL, Experiment
from ocp_traj.papers.paper import Paper

if TYPE_CHECKING:
    from metaheuristics import History, Solution
    from ocp_traj.solving import SolveResult
    from ocp_traj.task import TrajectoryTask

THINNED = 120
"""Most points of a kept history after its first `DENSE` ones, which are all kept."""

DENSE = 40


class Records:
    """Finished runs of one paper, in a JSON-lines file.

    A line that was cut off by a killed process is dropped; everything before it counts.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._rows: dict[str, dict[str, Any]] = {}
        self._chosen: dict[tuple[str, str], list[str]] = {}
        self._cut_off = False
        if path.exists():
            text = path.read_text(encoding="utf-8")
            self._cut_off = bool(text) and not text.endswith("\n")
            for line in text.splitlines():
                try:
                    row = json.loads(line)
                except json.JSONDecodeError:
                    continue
                self._rows[row["key"]] = row

    def get(self, key: str) -> dict[str, Any] | None:
        """Return a finished row."""
        return self._rows.get(key)

    def add(self, key: str, row: dict[str, Any]) -> dict[str, Any]:
        """Keep a row."""
        row = {"key": key, **row}
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write("\n" * self._cut_off + json.dumps(row, allow_nan=False) + "\n")
        self._cut_off = False
        self._rows[key] = row
        return row

    def computed(self, name: str, work: Callable[[], dict[str, Any]], digest: str) -> dict[str, Any]:
        """Return a named result that is not a run (a reference, a certificate, a timing), computing it once."""
        key = _digest(["computed", name, digest])
        return self.get(key) or self.add(key, {"kind": name, **work()})

    def choose(self, runs: Iterable[tuple[str, Experiment]]) -> None:
        """Say which runs the page is about, in the order of seeds; older ones in the file are left out."""
        self._chosen = {}
        for key, experiment in runs:
            self._chosen.setdefault((experiment.group, experiment.label), []).append(key)

    def runs(self, label: str, group: str) -> list[dict[str, Any]]:
        """Return the finished runs of one row of one group, by seed."""
        keys = self._chosen.get((group, label), [])
        return [self._rows[key] for key in keys if key in self._rows]

    def values(self, label: str, field: str, group: str) -> Array:
        """Return one number a run; infeasible runs count as infinite for `duration`, `energy`, `objective`."""
        judged = field in ("duration", "energy", "objective")
        return np.array(
            [
                np.inf if row[field] is None or (judged and not row["feasible"]) else row[field]
                for row in self.runs(label, group)
            ],
            dtype=np.float64,
        )

    def raw(self, label: str, field: str, group: str) -> Array:
        """Return one number a run, whatever the audit says; infinite where there is none."""
        rows = self.runs(label, group)
        return np.array([np.inf if row[field] is None else row[field] for row in rows], dtype=np.float64)

    def part(self, label: str, joint: int, field: str, group: str) -> Array:
        """Return one number a run of one joint (from 1) optimised alone; infinite where nothing kept the limits."""
        found = [
            next(part[field] for part in row["parts"] if part["joint"] == joint)
            for row in self.runs(label, group)
        ]
        return np.array([np.inf if value is None else value for value in found], dtype=np.float64)


def _digest(parts: list[Any]) -> str:
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]


def experiment_key(paper: Paper, experiment: Experiment, seed: int) -> str:
    """Return the key of one run: it changes with the task, the solver, the budget and the seed."""
    from ocp_traj.case import task_digest

    task = paper.task(experiment.overrides)
    return _digest([task_digest(task), task.search.protocol, experiment.solver, experiment.budget, seed])


def run_one(paper: Paper, experiment: Experiment, seed: int) -> dict[str, Any]:
    """Run one experiment with one seed; `seconds` are of the wall clock, `processor` includes judging."""
    task = paper.task(experiment.overrides)
    began = time.process_time()
    result, parts = _solve(task, experiment, seed)
    spent = time.process_time() - began
    audit = result.audit
    return {
        "solver": experiment.solver,
        "seed": seed,
        "feasible": result.feasible,
        "status": result.status,
        "message": result.message,
        "objective": _number(result.objective),
        "duration": _number(result.duration),
        "energy": _number(result.energy),
        "segments": [float(h) for h in result.segment_durations],
        "worst": None if audit is None or audit.worst is None else audit.worst.to_json(),
        "scale": None if audit is None else _number(audit.smallest_feasible_scale),
        "scaled_by": result.scaled_by,
        "evaluations": result.solution.evaluations,
        "seconds": result.solution.build_time + result.solution.solve_time,
        "processor": spent,
        "generations": result.solution.history.generations_to_within(1e-3),
        "history": _course(result.solution.history),
        "parts": [
            {
                "joint": joint + 1,
                "cost": _number(part.cost) if part.feasible else None,
                "evaluations": part.evaluations,
                "seconds": part.solve_time,
                "generations": part.history.generations_to_within(1e-3),
                "history": _course(part.history, positions=True),
            }
            for joint, part in parts.items()
        ],
    }


def _solve(
    task: TrajectoryTask, experiment: Experiment, seed: int
) -> tuple[SolveResult, dict[int, Solution]]:
    """Solve; with the per-joint protocol also return each joint's own solution."""
    from ocp_traj.solvers import Request, parse_solver
    from ocp_traj.solvers.per_joint import join_joints, search_joints
    from ocp_traj.solvers.population.population import Population
    from ocp_traj.solving import judge, solve

    solver = parse_solver(experiment.solver)
    if task.search.protocol == "per-joint" and isinstance(solver, Population):
        parts = search_joints(task, Request(seed, experiment.budget), solver)
        return judge(task, experiment.solver, seed, join_joints(task, parts, solver)), parts
    return solve(task, experiment.solver, seed=seed, budget=experiment.budget), {}


def _course(history: History, positions: bool = False) -> dict[str, Any]:
    """Return a thinned history for JSON; `positions` keeps the best candidates too."""
    last = max(len(history) - 1, 0)
    kept = np.unique(
        np.concatenate([np.arange(min(DENSE, last + 1)), np.linspace(0, last, THINNED).astype(int)])
    )
    kept = kept[: len(history)]
    course: dict[str, Any] = {
        "generation": kept.tolist(),
        "evaluations": [int(history.evaluations[k]) for k in kept],
        "cost": [_number(float(history.cost[k])) for k in kept],
        "violation": [_number(float(history.violation[k])) for k in kept],
    }
    if positions:
        course["x"] = [[round(float(value), 6) for value in history.x[k]] for k in kept]
    return course


def _number(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else float(value)


def plan(paper: Paper, seeds: int, reduced: bool) -> list[tuple[Experiment, int]]:
    """Return every run a page needs, those of the paper's own protocol first."""
    runs = [
        (experiment, seed)
        for seed in range(seeds)
        for experiment in paper.experiments(reduced)
        if seed == 0 or not experiment.once
    ]
    return sorted(runs, key=lambda run: run[0].group != PUBLISHED_PROTOCOL)


def run_missing(
    paper: Paper,
    records: Records,
    seeds: int,
    reduced: bool,
    jobs: int,
    progress: Callable[[int, int], object],
) -> None:
    """Run what is not in the records yet; one process writes, `jobs` of them work."""
    everything = plan(paper, seeds, reduced)
    keyed = [(experiment_key(paper, experiment, seed), experiment, seed) for experiment, seed in everything]
    records.choose((key, experiment) for key, experiment, _ in keyed)
    missing = list({entry[0]: entry for entry in keyed if records.get(entry[0]) is None}.values())
    done = sum(records.get(key) is not None for key, _, _ in keyed)
    progress(done, len(everything))
    for key, row in _execute(paper, missing, jobs):
        records.add(key, row)
        done += sum(key == other for other, _, _ in keyed)
        progress(done, len(everything))


def _execute(
    paper: Paper, missing: list[tuple[str, Experiment, int]], jobs: int
) -> Iterable[tuple[str, dict[str, Any]]]:
    if jobs <= 1 or len(missing) <= 1:
        for key, experiment, seed in missing:
            yield key, run_one(paper, experiment, seed)
        return
    from joblib import Parallel, delayed

    parallel = Parallel(n_jobs=jobs, return_as="generator_unordered")
    yield from parallel(delayed(_keyed)(paper.key, *entry) for entry in missing)


def _keyed(paper_key: str, key: str, experiment: Experiment, seed: int) -> tuple[str, dict[str, Any]]:
    from ocp_traj.papers import get_paper

    return key, run_one(get_paper(paper_key), experiment, seed)
