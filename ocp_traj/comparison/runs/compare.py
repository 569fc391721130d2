"""The main job: execute what is missing of a plan and keep every finished run."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ocp_traj.comparison.runs.environment import describe_environment
from ocp_traj.comparison.runs.execute import execute
from ocp_traj.comparison.runs.plan import CaseChoice, Plan, RunSpec
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.store import Store, missing
from ocp_traj.exceptions import InputError
from ocp_traj.references.registry import all_references

REFERENCE_SECONDS = 60.0
"""Time each of a case's references may take in a comparison."""

REFERENCE_RUNNER = "ocp_traj.comparison.runs.runner:find_reference"
"""What computes a reference of a case."""


@dataclass(frozen=True)
class ComparisonProgress:
    """Told after every finished run: how many of how many, and which."""

    finished: int
    total: int
    spec: RunSpec | None
    record: RunRecord | None


def identify_case(choice: CaseChoice) -> tuple[str, str]:
    """Return a case's label (its name, and the overrides) and its digest."""
    from ocp_traj.case import load_case, task_digest

    task = load_case(choice.case, choice.overrides)
    label = task.name + (f" [{', '.join(choice.overrides)}]" if choice.overrides else "")
    return label, task_digest(task)


def compare(
    plan: Plan,
    folder: Path,
    jobs: int = 1,
    dask: str | None = None,
    progress: Callable[[ComparisonProgress], None] | None = None,
    identify: Callable[[CaseChoice], tuple[str, str]] = identify_case,
) -> None:
    """Execute the runs of `plan` that `folder` does not hold yet.

    Parameters
    ----------
    plan
        What to run.
    folder
        Where ``results.sqlite`` and ``trajectories/`` are, or will be.
    jobs, dask
        As in `ocp_traj.comparison.runs.execute.execute`.
    progress
        Called at the start, and after every run.
    identify
        Gives label and digest of a case.

    Raises
    ------
    InputError
        The plan contradicts itself, or another comparison is writing into the folder.
    """
    specs = plan.runs(identify)
    with Store(folder, create=True) as store, _only_writer(folder):
        workers = {"workers": dask or jobs}
        number = store.add_plan(plan, {**describe_environment(), **workers}, specs)
        for spec in specs:
            store.add_case(spec)
        todo = missing(store, specs)
        report = progress or _say_nothing
        report(ComparisonProgress(len(specs) - len(todo), len(specs), None, None))
        for finished, (spec, record) in enumerate(_run_all(store, plan, todo, specs, jobs, dask), start=1):
            store.add_run(spec, record, number)
            report(ComparisonProgress(len(specs) - len(todo) + finished, len(specs), spec, record))


def _say_nothing(_: ComparisonProgress) -> None:
    pass


def _run_all(
    store: Store, plan: Plan, todo: list[RunSpec], specs: tuple[RunSpec, ...], jobs: int, dask: str | None
) -> Iterator[tuple[RunSpec, RunRecord]]:
    """Yield finished runs; references go through the same workers and straight into the store."""
    references = _missing_references(store, specs) if plan.references else []
    requests = [_reference_request(spec, part) for spec, part in references]
    requests += [spec.to_json() for spec in todo]
    for place, answer in execute(requests, jobs, dask):
        if place < len(references):
            spec, part = references[place]
            store.add_reference(spec.case_digest, part, _reference(answer))
        else:
            yield todo[place - len(references)], RunRecord.from_json(answer)


def _missing_references(store: Store, specs: tuple[RunSpec, ...]) -> list[tuple[RunSpec, str]]:
    """Return the parts that are not there; one that failed, for want of time perhaps, is tried again."""
    known = store.cases()
    first = {spec.case_digest: spec for spec in reversed(specs)}
    return [
        (spec, part)
        for part in (reference.name for reference in all_references() if reference.compared)
        for digest, spec in first.items()
        if "failed" in (known[digest]["reference"] or {}).get(part, {"failed": "never tried"})
    ]


def _reference_request(spec: RunSpec, part: str) -> dict[str, Any]:
    return {
        "kind": "reference",
        "runner": REFERENCE_RUNNER,
        "reference": part,
        "case": spec.case,
        "overrides": spec.overrides,
        "time_limit": REFERENCE_SECONDS,
        "memory_limit": spec.memory_limit,
    }


def _reference(answer: dict[str, Any]) -> dict[str, Any]:
    if answer.get("state") == "done":
        return answer["answer"]
    return {"failed": f"{answer.get('reason')}: {answer.get('message')}"}


@contextmanager
def _only_writer(folder: Path) -> Iterator[None]:
    """Refuse a second comparison in the same folder; the lock vanishes with the process, however it ends."""
    try:
        import fcntl
    except ImportError:  # Windows: two comparisons in one folder would do work twice, but mix nothing up
        yield
        return
    try:
        handle = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise InputError(f"cannot write into {folder}: {error.strerror or error}") from None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(handle)
        raise InputError(f"another comparison is writing into {folder}") from None
    try:
        yield
    finally:
        os.close(handle)
