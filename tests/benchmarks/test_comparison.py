"""Measures what the comparison promises: workers that pay, reports that are quick. Nothing here asserts a time."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from helpers.databases import connections_with
from helpers.processes import child_environment
from ocp_traj.comparison.report.report import write_report
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.store import Store

_SCRIPT = """
import sys, time
from pathlib import Path
from helpers import comparison_fakes as fakes
from ocp_traj.comparison.runs.compare import compare
from ocp_traj.comparison.runs.plan import CaseChoice, Plan

def run(folder, seeds):
    plan = Plan((CaseChoice("one"),), ("work:1.0",), seeds=seeds, references=False, runner=fakes.RUNNER)
    compare(plan, Path(folder), jobs=int(sys.argv[2]), identify=fakes.identify)

run(sys.argv[1] + "/warm", 4)
started = time.perf_counter()
run(sys.argv[1] + "/measured", 40)
print(time.perf_counter() - started)
"""


def seconds_with(jobs: int, folder: Path) -> float:
    """Wall time of 40 runs of one second of work each, workers warm."""
    done = subprocess.run(
        [sys.executable, "-c", _SCRIPT, str(folder), str(jobs)],
        env=child_environment(),
        capture_output=True,
        text=True,
        check=True,
    )
    return float(done.stdout)


def test_two_workers_against_one(tmp_path: Path) -> None:
    one, two = seconds_with(1, tmp_path / "one"), seconds_with(2, tmp_path / "two")
    print(
        f"\n40 runs of 1 s of work: {one:.1f} s with one worker, {two:.1f} s with two, {one / two:.2f} times faster"
    )


def test_report_of_ten_thousand_rows(tmp_path: Path) -> None:
    cases = tuple(CaseChoice(f"case-{number}") for number in range(20))
    plan = Plan(cases, tuple(f"solver-{number}" for number in range(5)), seeds=100, references=False)
    rng = np.random.default_rng(0)
    environment = {
        "python": "",
        "versions": {},
        "machine": {"system": "", "processor": "", "cores": 1, "memory_gb": None},
        "git": None,
    }
    # filling is not what is measured
    with connections_with("PRAGMA synchronous = OFF"), Store(tmp_path, create=True) as store:
        specs = plan.runs(lambda choice: (choice.case, choice.case))
        number = store.add_plan(plan, environment, specs)
        for spec in specs:
            store.add_case(spec)
            store.add_run(spec, _record(rng), number)
    started = time.perf_counter()
    files = write_report(tmp_path)
    size = files.html.stat().st_size / 1e6
    print(f"\nreport of {len(specs)} rows: {time.perf_counter() - started:.1f} s, {size:.2f} MB")


def _record(rng: np.random.Generator) -> RunRecord:
    cost = 1.0 + np.sort(rng.exponential(size=60))[::-1]
    return RunRecord(
        "converged",
        claimed=True,
        feasible=True,
        objective=float(cost[-1]),
        duration=float(cost[-1]),
        dimension=7,
        evaluations=600,
        build_time=0.01,
        solve_time=0.1,
        wall_time=0.2,
        history={
            "evaluations": list(range(10, 601, 10)),
            "cost": cost.tolist(),
            "violation": [0.0] * 60,
            "seconds": np.linspace(0.001, 0.1, 60).tolist(),
        },
    )
