"""Record the answers of every packaged case, and hold them against an earlier record, bit for bit.

Run it once in the older state and once in the newer one::

    python tests/benchmarks/unchanged_results.py --save before.json
    python tests/benchmarks/unchanged_results.py --against before.json

It exits with 1 and names every run whose status, feasibility, objective, evaluations or motion differ.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

import ocp_traj as ot

SOLVERS = ("ipopt", "pso", "ssa", "cmaes")
SEEDS = (0, 1, 2)


def answer(case: str, solver: str, seed: int) -> dict[str, Any]:
    """Return what one run gave, the motion as a digest of its exact bits."""
    result = ot.solve(ot.load_case(case), solver, seed=seed)
    motion = result.trajectory
    bits = b"" if motion is None else b"".join(
        np.ascontiguousarray(part).tobytes() for part in (motion.breakpoints, motion.coefficients)
    )
    return {
        "status": result.status,
        "feasible": result.feasible,
        "objective": None if result.objective is None else float(result.objective).hex(),
        "evaluations": result.solution.evaluations,
        "motion": hashlib.sha256(bits).hexdigest(),
    }


def answers(cases: list[str], solvers: list[str]) -> dict[str, dict[str, Any]]:
    """Return every run's answer by its name."""
    found = {}
    for case, solver, seed in product(cases, solvers, SEEDS):
        name = f"{case} {solver} {seed}"
        found[name] = answer(case, solver, seed)
        print(name, found[name]["status"], file=sys.stderr, flush=True)
    return found


def main() -> int:
    """Save the answers or compare them with saved ones."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--save", type=Path)
    parser.add_argument("--against", type=Path)
    parser.add_argument("--cases", nargs="*", default=ot.case_names())
    parser.add_argument("--solvers", nargs="*", default=list(SOLVERS))
    options = parser.parse_args()
    found = answers(options.cases, options.solvers)
    if options.save:
        options.save.write_text(json.dumps(found, indent=1))
    if not options.against:
        return 0
    before = json.loads(options.against.read_text())
    different = [name for name, now in found.items() if before.get(name) != now]
    for name in different:
        print(f"{name}: {before.get(name)} before, {found[name]} now")
    print(f"{len(found) - len(different)} of {len(found)} runs are the same, bit for bit")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
