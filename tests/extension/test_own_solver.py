"""A solver and an optimiser are added by one file and one line inside the package, or from outside without touching it:
listed, solved, audited, compared and plotted like the others."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

import ocp_traj as ot
from metaheuristics import Solution, Status
from ocp_traj.exceptions import UnavailableError
from ocp_traj.solvers import Outcome, Request, Solver, parse_solver, solver_table

ROOT = Path(__file__).parents[2]
CASE = "machines-2024-490"

SOLVER = '''"""The first guess, run as fast as the limits allow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import ocp_traj as ot
from metaheuristics import Solution, Status
from ocp_traj.solvers.solver import Outcome, Request, Solver


@dataclass(frozen=True)
class SlowedGuess(Solver):
    """Slows the first guess down into its limits."""

    kind: ClassVar[str] = "third-party"
    margin: float = 1.0

    def run(self, task: ot.TrajectoryTask, request: Request) -> Outcome:
        problem = ot.transcribe(task)
        guess = problem.decode(problem.guess)
        scale = ot.audit(task, guess).smallest_feasible_scale
        if scale is None:
            return Outcome(None, Solution.failed(problem, "no slowing helps"))
        motion = guess.scaled(self.margin * scale)
        x, cost = problem.encode(motion), motion.duration
        solution = Solution(problem=problem, x=x, cost=cost, status=Status.CONVERGED, evaluations=1)
        return Outcome(motion, solution, {"evaluate": 1})
'''

SOLVER_LINE = (
    '    "slowed-guess": Entry("ocp_traj.solvers.slowed_guess", "SlowedGuess", "third-party", "slowed guess"),\n'
)

OPTIMISER = '''"""Candidates drawn around the best one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from metaheuristics.arrays import FloatArray
from metaheuristics.optimizer import Optimizer, State


@dataclass(frozen=True)
class HillClimber(Optimizer[State]):
    """Steps from the best candidate, normal with a fraction of the box."""

    step: float = 0.05

    def propose(self, state: State, rng: np.random.Generator) -> tuple[FloatArray, State]:
        best = state.positions[state.ordering.find_best(state.cost, state.violation)]
        return best + self.step * state.frame.width * rng.standard_normal(state.positions.shape), state

    def absorb(self, state: State, X: FloatArray, cost: FloatArray, violation: FloatArray) -> State:
        if state.phase == 0:
            X, cost, violation = (
                np.concatenate(pair)
                for pair in ((state.positions, X), (state.cost, cost), (state.violation, violation))
            )
        kept = state.ordering.sort(cost, violation)[: self.population]
        generation = state.generation + (state.phase == 0)
        return state.evolve(
            generation=generation, phase=0, positions=X[kept], cost=cost[kept], violation=violation[kept]
        )
'''

OPTIMISER_LINE = '    "climber": Method(HillClimber, {}, "steps from the best candidate"),\n'
OPTIMISER_IMPORT = "from metaheuristics.algorithms.hill_climber import HillClimber\n"


def extended(folder: Path, file: str, text: str, registry: str, changes: dict[str, str]) -> Path:
    """Return a copy of both packages with one file more, and lines put after others in a registry."""
    for package in ("ocp_traj", "metaheuristics"):
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / file).write_text(text)
    known = (folder / registry).read_text()
    for before, line in changes.items():
        assert known.count(before) == 1
        known = known.replace(before, before + line)
    (folder / registry).write_text(known)
    return folder


def command(tree: Path, *arguments: str) -> str:
    """Run ``ocp-traj`` of a copy and return what it prints."""
    environment = {**os.environ, "PYTHONPATH": str(tree), "COLUMNS": "200"}
    run = subprocess.run(
        [sys.executable, "-m", "ocp_traj", *arguments],
        capture_output=True,
        text=True,
        env=environment,
        cwd=tree,
    )
    assert run.returncode in (0, 1) and "Traceback" not in run.stderr, run.stderr
    return run.stdout


def check_everywhere(tree: Path, solver: str) -> None:
    """Check that a solver is listed, solves, is audited, compared and plotted."""
    assert solver.partition("[")[0] in command(tree, "list", "solvers").split()
    answer = command(
        tree, "solve", CASE, "--solver", solver, "--budget", "500", "--output", "motion.csv", "--json", "result.json"
    )
    assert "feasible" in answer
    assert json.loads((tree / "result.json").read_text())["feasible"] is True
    assert "feasible" in command(tree, "audit", CASE, "--trajectory", "motion.csv")
    command(tree, "plot", "result.json")
    pictures = [path for path in tree.iterdir() if path.suffix == ".png"]
    assert pictures and pictures[0].read_bytes()[:4] == b"\x89PNG"
    chosen = ("--solvers", f"{solver},random", "--seeds", "1", "--budget", "500", "--no-references")
    assert "[2/2]" in command(tree, "compare", CASE, *chosen, "--output", "compared")
    assert solver in (tree / "compared" / "report.md").read_text()


def test_a_solver_is_one_file_and_one_line(tmp_path: Path) -> None:
    registry = "ocp_traj/solvers/registry.py"
    line = {"ENTRIES: dict[str, Entry] = {\n": SOLVER_LINE}
    tree = extended(tmp_path, "ocp_traj/solvers/slowed_guess.py", SOLVER, registry, line)
    check_everywhere(tree, "slowed-guess")
    answer = json.loads(command(tree, "solve", CASE, "--solver", "slowed-guess[margin=2]", "--json", "-"))
    plain = json.loads((tree / "result.json").read_text())
    assert answer["duration"] == pytest.approx(2 * plain["duration"])


def test_an_optimiser_is_one_file_and_one_line_and_its_hybrid_comes_with_it(tmp_path: Path) -> None:
    registry = "metaheuristics/algorithms/registry.py"
    lines = {
        "registry: dict[str, Method] = {\n": OPTIMISER_LINE,
        "import EliteSparrowSearch\n": OPTIMISER_IMPORT,
    }
    tree = extended(tmp_path, "metaheuristics/algorithms/hill_climber.py", OPTIMISER, registry, lines)
    check_everywhere(tree, "climber[encoding=scaled]")
    answer = command(tree, "solve", CASE, "--solver", "climber+ipopt[step=0.1]", "--budget", "400", "--json", "-")
    assert json.loads(answer)["duration"] == pytest.approx(4.310382, rel=1e-6)


@dataclass(frozen=True)
class Stretched(Solver):
    """The closed-form timing, of somebody else's package."""

    kind: ClassVar[str] = "third-party"

    def run(self, task: ot.TrajectoryTask, request: Request) -> Outcome:
        nlp = ot.transcribe(task)
        return Outcome(nlp.decode(nlp.guess), Solution(problem=nlp, x=nlp.guess, cost=1.0, status=Status.CONVERGED))


def test_a_class_of_somebody_else_needs_no_registry() -> None:
    task = ot.load_case(CASE)
    result = ot.solve(task, Stretched())
    assert result.solver == "Stretched"
    assert result.audit is not None and result.audit.feasible == ot.audit(task, result.trajectory).feasible


def test_an_entry_point_that_is_no_solver_is_listed_with_its_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    from importlib.metadata import EntryPoint

    from ocp_traj.solvers import registry

    point = EntryPoint("not-one", "math:sqrt", registry.GROUP)
    monkeypatch.setattr(registry, "_entry_points", lambda: {"not-one": point})
    (row,) = (row for row in solver_table() if row.name == "not-one")
    assert not row.available and "math:sqrt is" in row.reason and "expected a subclass of" in row.reason
    with pytest.raises(UnavailableError, match=r"expected a subclass of ocp_traj\.solvers\.Solver"):
        parse_solver("not-one")
