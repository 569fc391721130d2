"""Runs of a case's experiments and further results on it, kept in the library's store: nothing finished runs again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.runs.compare import ComparisonProgress, compare, identify_case
from ocp_traj.comparison.runs.plan import CaseChoice, Plan, RunSpec
from ocp_traj.comparison.runs.store import Store, StoredRun
from ocp_traj.papers.experiments import PUBLISHED_PROTOCOL, Experiment
from ocp_traj.papers.runner import RUNNER

JUDGED_NUMBERS = ("duration", "energy", "objective")
"""Numbers that count only where the audit accepts the motion."""


@dataclass(frozen=True)
class ExperimentPlan(Plan):
    """A plan of chosen runs instead of a product: every experiment has its own budget, and seeds are 0, 1, 2 ...

    Parameters
    ----------
    experiments : tuple of Experiment
        On one case, those of the paper's own protocol first.
    """

    experiments: tuple[Experiment, ...] = ()

    @property
    def size(self) -> int:
        """Number of runs."""
        return len(self._chosen())

    def _chosen(self) -> list[tuple[Experiment, int]]:
        """Return every run, seeds outermost, those of the paper's own protocol first."""
        runs = [
            (experiment, seed)
            for seed in range(self.seeds)
            for experiment in self.experiments
            if seed == 0 or not experiment.once
        ]
        return sorted(runs, key=lambda run: run[0].group != PUBLISHED_PROTOCOL)

    def runs(self, identify: Callable[[CaseChoice], tuple[str, str]]) -> tuple[RunSpec, ...]:
        """Return every run, see `Plan.runs`."""
        return tuple(spec for _, spec in self.specifications(identify))

    def specifications(
        self, identify: Callable[[CaseChoice], tuple[str, str]]
    ) -> list[tuple[Experiment, RunSpec]]:
        """Return every run beside its experiment."""
        known = {choice: identify(choice) for choice in self.cases}
        (case,) = {choice.case for choice in self.cases}
        return [
            (
                experiment,
                RunSpec(
                    case, experiment.overrides, *known[CaseChoice(case, experiment.overrides)], experiment.solver,
                    seed, seed, experiment.budget, self.time_limit, self.memory_limit, self.runner,
                ),
            )
            for experiment, seed in self._chosen()
        ]  # fmt: skip

    def to_json(self) -> dict[str, Any]:
        """Return the plan as plain JSON values, as any plan is stored: without the choice among its runs."""
        values = super().to_json()
        del values["experiments"]
        return values


def plan_experiments(case: str, experiments: Sequence[Experiment], seeds: int) -> ExperimentPlan:
    """Return the plan of a case's experiments, each with `seeds` seeds; nothing limits time or memory."""
    return ExperimentPlan(
        tuple(CaseChoice(case, overrides) for overrides in dict.fromkeys(e.overrides for e in experiments)),
        tuple(dict.fromkeys(e.solver for e in experiments)),
        seeds,
        budgets=tuple(dict.fromkeys(e.budget for e in experiments)),
        time_limit=None,
        memory_limit=None,
        references=False,
        runner=RUNNER,
        experiments=tuple(experiments),
    )


class Records:
    """Finished runs and further results of one case.

    Parameters
    ----------
    folder : pathlib.Path
        Of the store; created where it is not there.
    case : str
        Name of the packaged case.

    Raises
    ------
    InputError
        The folder cannot be written, or holds a damaged store.
    """

    def __init__(self, folder: Path, case: str) -> None:
        self.folder = folder
        self.case = case
        self._rows: dict[tuple[str, str], list[StoredRun]] = {}
        _, self._digest = identify_case(CaseChoice(case))
        with Store(folder, create=True) as store:
            self._results = store.results(self._digest)

    def run(self, plan: ExperimentPlan, jobs: int, progress: Callable[[int, int], object]) -> None:
        """Run what is missing, and choose the plan's runs; `progress` gets how many of how many are finished."""

        def report(state: ComparisonProgress) -> None:
            progress(state.finished, state.total)

        compare(plan, self.folder, jobs, progress=report)
        self.choose(plan)

    def choose(self, plan: ExperimentPlan) -> None:
        """Say which runs the page is about, in the order of seeds; others in the store are left out."""
        with Store(self.folder) as store:
            stored = {row.key: row for row in store.rows()}
        self._rows = {}
        for experiment, spec in plan.specifications(identify_case):
            if spec.key in stored:
                self._rows.setdefault((experiment.group, experiment.label), []).append(stored[spec.key])

    def computed(self, name: str, work: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """Return a named result that is not a run (a reference, a certificate, a timing), computing it once."""
        if name not in self._results:
            with Store(self.folder) as store:
                store.add_result(self._digest, name, work())
                self._results = store.results(self._digest)
        return self._results[name]

    def runs(self, label: str, group: str) -> list[StoredRun]:
        """Return the finished runs of one row of one group, by seed."""
        return self._rows.get((group, label), [])

    def values(self, label: str, field: str, group: str) -> Array:
        """Return one number per run; infeasible runs count as infinite for `JUDGED_NUMBERS`."""
        refused = [field in JUDGED_NUMBERS and not row.record.feasible for row in self.runs(label, group)]
        return np.where(refused, np.inf, self.raw(label, field, group))

    def raw(self, label: str, field: str, group: str) -> Array:
        """Return one number per run, whatever the audit says; infinite where there is none."""
        return _numbers([number_of(row, field) for row in self.runs(label, group)])

    def parts(self, label: str, group: str, joint: int) -> list[dict[str, Any]]:
        """Return what each run found for one joint (from 1) optimised alone; an empty table where it found nothing."""
        found = [row.record.details.get("parts", []) for row in self.runs(label, group)]
        return [next((part for part in parts if part["joint"] == joint), {}) for parts in found]

    def part(self, label: str, joint: int, field: str, group: str) -> Array:
        """Return one number per run of one joint (from 1) optimised alone; infinite where nothing kept the limits."""
        return _numbers([part.get(field) for part in self.parts(label, group, joint)])


def number_of(row: StoredRun, field: str) -> float | None:
    """Return a number of a run's record or of its details; ``seconds`` are of the wall clock, building included."""
    record = row.record
    if field == "seconds":
        return None if record.solve_time is None else (record.build_time or 0.0) + record.solve_time
    return record.details.get(field) if field in record.details else getattr(record, field, None)


def _numbers(values: Sequence[float | None]) -> Array:
    return np.array([np.inf if value is None else value for value in values], dtype=np.float64)
