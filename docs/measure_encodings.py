"""Measure tables of ``docs/encodings.md``: ``python docs/measure_encodings.py papers|scaled|hybrids [SEEDS [CASE]]``.

Prints one row of a table as soon as its runs are done; with a case, the rows of that case alone.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np

import ocp_traj as ot
from ocp_traj.solvers import parse_solver
from ocp_traj.solving import SolveResult

ENCODINGS = ("durations", "log-durations", "scaled")

PAPERS = (
    ("ur5-palletizing", 50, ("issa-a[preset=paper]", "ssa", "pso[preset=paper-a]")),
    ("machines-2024-490", 1000, ("issa-b[preset=paper]", "ssa[population=30]", "pso[preset=paper-b]")),
    ("ur5-helix", 80, ("tadf-ssa[preset=paper]", "t-ssa", "adf-ssa", "ssa[safety=0.5]")),
    ("fanuc-m10id8l", 200, ("pso-d[preset=paper-d]", "pso[preset=paper-d-plain]")),
)
"""Case, generations, methods with the settings of papers A to D."""

SCALED = (("machines-2024-490", 3000), ("zou-2024-eight-points", 20_000))

SWARMS = ("cmaes", "de", "pso", "ssa-debiased", "ssa", "random")

HYBRIDS = ("machines-2024-490", "zou-2024-eight-points", "yu-2025-four-points", "ur5-palletizing")

PARTS = (
    "ipopt",
    "ipopt-multistart",
    "pso[encoding=scaled]",
    "pso+ipopt",
    "issa-a[encoding=scaled]",
    "issa+ipopt",
    "pso[encoding=scaled,start=ipopt]",
)
HYBRID_BUDGET = 2000


def paper_rows(seeds: int, only: str) -> Iterator[str]:
    """Yield what each paper's method reaches with the paper's own population and generations."""
    for case, generations, methods in PAPERS:
        if only not in ("", case):
            continue
        task = ot.load_case(case, ['search.protocol="shared"'])
        for method in methods:
            optimizer = parse_solver(method).optimizer()  # type: ignore[attr-defined]
            budget = optimizer.initial_evaluations + generations * optimizer.evaluations_per_generation
            for encoding in ENCODINGS:
                name = method.replace("]", f",encoding={encoding}]")
                name = name if "[" in name else f"{name}[encoding={encoding}]"
                results = [ot.solve(task, name, seed=seed, budget=budget) for seed in range(seeds)]
                yield f"| {case} | {method} | {budget} | {encoding} | {spread(results)} |"


def scaled_rows(seeds: int, only: str) -> Iterator[str]:
    """Yield medians with equal budgets in `durations` and in `scaled`."""
    for case, budget in SCALED:
        if only not in ("", case):
            continue
        task = ot.load_case(case)
        for method in SWARMS:
            for encoding in ("durations", "scaled"):
                name = f"{method}[encoding={encoding}]"
                results = [ot.solve(task, name, seed=seed, budget=budget) for seed in range(seeds)]
                yield f"| {case} | {method} | {budget} | {encoding} | {spread(results)} |"


def hybrid_rows(seeds: int, only: str) -> Iterator[str]:
    """Yield hybrids and their parts within one budget."""
    for case in HYBRIDS:
        if only not in ("", case):
            continue
        task = ot.load_case(case)
        for solver in PARTS:
            results = [ot.solve(task, solver, seed=seed, budget=HYBRID_BUDGET) for seed in range(seeds)]
            spent = int(np.median([result.solution.evaluations for result in results]))
            yield f"| {case} | {solver} | {spent} | {spread(results)} |"


def spread(results: list[SolveResult]) -> str:
    """Return the median, the best and the worst objective of the feasible answers, and how many there are."""
    values = [
        float(result.objective) for result in results if result.feasible and result.objective is not None
    ]
    if not values:
        return f"- | - | 0 of {len(results)}"
    return f"{np.median(values):.6g} | {min(values):.6g}, {max(values):.6g} | {len(values)} of {len(results)}"


if __name__ == "__main__":
    tables = {"papers": paper_rows, "scaled": scaled_rows, "hybrids": hybrid_rows}
    table, seeds, case = (*sys.argv[1:], *("papers", "20", "")[len(sys.argv) - 1 :])
    for row in tables[table](int(seeds), case):
        print(row, flush=True)
