"""Solvers are found by name, with parameters, and say why they cannot be loaded."""

from __future__ import annotations

import sys
from collections.abc import Callable

import pytest

from helpers.condensed_tasks import LIMITS, make_task
from ocp_traj.exceptions import InputError, UnavailableError, UnknownNameError
from ocp_traj.solvers import parse_solver, solver_names, solver_table, split_solvers
from ocp_traj.solvers.gradient.multistart import MultiStart
from ocp_traj.solvers.hybrid import Hybrid
from ocp_traj.solvers.population.population import Population
from ocp_traj.solvers.registry import ENTRIES
from ocp_traj.solving import solve

TINY = '''
from dataclasses import dataclass
from typing import ClassVar

from metaheuristics import History, Solution, Status
from ocp_traj.solvers import Outcome, Solver
from ocp_traj.transcription.condensed.condensed import CondensedNlp


@dataclass(frozen=True)
class Guess(Solver):
    """Answers with the closed-form timing, slowed by a factor."""

    kind: ClassVar[str] = "third-party"
    slower: float = 1.0

    def run(self, task, request):
        nlp = CondensedNlp(task)
        x = nlp.guess * self.slower
        found = nlp.evaluate(x)
        solution = Solution(nlp, x, float(found.cost[0]), found.violation[0], Status.CONVERGED, "guessed", 1, 0.0, 0.0,
                            History.empty(len(x)))
        return Outcome(nlp.decode(x), solution, {"evaluate": 1})
'''


def test_every_name_of_the_package_is_listed_and_loads() -> None:
    rows = {row.name: row for row in solver_table()}
    assert set(ENTRIES) <= set(rows)
    for name in ("ipopt", "pso", "issa+ipopt", "ipopt-multistart", "de"):
        assert rows[name].available, rows[name].reason
        assert rows[name].summary


def test_parameters_reach_the_solver_and_its_optimiser() -> None:
    solver = parse_solver("pso[population=20,encoding=scaled,inertia=constant,restarts=true]")
    assert isinstance(solver, Population)
    assert (solver.encoding, solver.restarts) == ("scaled", True)
    assert solver.optimizer().population == 20  # type: ignore[attr-defined]
    hybrid = parse_solver("issa+ipopt[starts=2,share=0.3,population=40]")
    assert isinstance(hybrid, Hybrid)
    assert (hybrid.starts, hybrid.share, hybrid.population.method) == (2, 0.3, "issa-a")
    assert hybrid.population.optimizer().population == 40  # type: ignore[attr-defined]
    several = parse_solver("ipopt-multistart[starts=7,spread=0.2]")
    assert isinstance(several, MultiStart)
    assert (several.starts, several.spread) == (7, 0.2)


@pytest.mark.parametrize("name", ["de+ipopt", "issa-b+ipopt", "ssa-debiased+ipopt"])
def test_any_population_method_can_be_finished_by_ipopt(name: str) -> None:
    solver = parse_solver(name)
    assert isinstance(solver, Hybrid)
    assert solver.population.method == name.removesuffix("+ipopt")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nothing", "solver 'nothing' is unknown, expected one of ipopt, "),
        ("ipopt+ipopt", "is unknown"),
        ("pso[population]", "'population' cannot be read, expected key=value"),
        ("pso[colour=red]", "has no setting 'colour'"),
        ("pso]", "cannot be read, expected name"),
        ("pso@paper-q", "has no preset 'paper-q'"),
    ],
)
def test_a_wrong_name_says_what_is_wrong(text: str, message: str) -> None:
    with pytest.raises(UnknownNameError) as caught:
        parse_solver(text)
    assert message in str(caught.value)


def test_presets_are_spelt_in_small_letters() -> None:
    plain = parse_solver("pso[preset=paper-d-plain]").optimizer()  # type: ignore[attr-defined]
    assert (plain.population, plain.weight, plain.cognitive) == (50, 0.7, 2.0)
    both = parse_solver("tadf-ssa[preset=paper-tadf-ssa]").optimizer()  # type: ignore[attr-defined]
    assert (both.population, both.tent, both.adaptive) == (100, True, True)


@pytest.mark.parametrize(
    "text", ["pso+ipopt[starts=0]", "pso+ipopt[share=2]", "ipopt-multistart[spread=-1]", "pso[start=luck]"]
)
def test_a_wrong_value_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        parse_solver(text)


def test_lists_split_at_commas_outside_brackets() -> None:
    assert split_solvers("pso[a=1,b=2], ipopt,pso+ipopt") == ["pso[a=1,b=2]", "ipopt", "pso+ipopt"]


def test_a_package_of_somebody_else_adds_a_solver_by_entry_point(install: Callable[..., None]) -> None:
    install("tiny", {"tiny-guess": "tiny_solver:Guess"}, {"tiny_solver": TINY})
    assert "tiny-guess" in solver_names()
    row = next(row for row in solver_table() if row.name == "tiny-guess")
    assert (row.available, row.kind) == (True, "third-party")
    assert row.summary == "Answers with the closed-form timing, slowed by a factor."
    task = make_task("quintic", LIMITS["velocity"])
    plain, slow = solve(task, "tiny-guess"), solve(task, "tiny-guess[slower=1.5]")
    assert plain.feasible
    assert plain.solution.message == "guessed"
    assert slow.solution.x == pytest.approx(1.5 * plain.solution.x)
    with pytest.raises(UnknownNameError, match="has no setting 'faster', expected one of slower"):
        parse_solver("tiny-guess[faster=1]")


def test_a_package_that_does_not_load_is_listed_with_its_reason(install: Callable[..., None]) -> None:
    broken = {"broken-one": "broken_solver:Guess", "missing-one": "missing_solver:Guess"}
    install("broken", broken, {"broken_solver": "raise RuntimeError('no licence found')"})
    rows = {row.name: row for row in solver_table()}
    assert not rows["broken-one"].available
    assert "no licence found" in rows["broken-one"].reason
    assert "missing_solver" in rows["missing-one"].reason
    with pytest.raises(UnavailableError, match="no licence found"):
        parse_solver("broken-one")


def test_a_missing_library_is_the_reason_of_its_solvers(
    own_entry_points: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pymoo", None)
    for name in [name for name in sys.modules if name.startswith("ocp_traj.solvers.third_party.pymoo_")]:
        monkeypatch.delitem(sys.modules, name)
    rows = {row.name: row for row in solver_table()}
    assert not rows["pymoo-pso"].available
    assert "pymoo" in rows["pymoo-pso"].reason
    assert rows["scipy-de"].available


def test_an_own_name_cannot_be_taken_by_another_package(install: Callable[..., None]) -> None:
    install("taker", {"pso": "tiny_solver:Guess"}, {"tiny_solver": TINY})
    assert isinstance(parse_solver("pso"), Population)
    assert solver_names().count("pso") == 1
