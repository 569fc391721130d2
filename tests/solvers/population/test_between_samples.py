"""An answer without a violation of its own is not refused for what lies between samples."""

from __future__ import annotations

import numpy as np
import pytest

import ocp_traj as ot
from ocp_traj.solvers import Request, parse_solver
from ocp_traj.solvers.population.between_samples import look_between, may_be_refused
from ocp_traj.transcription.condensed.condensed import CondensedNlp


@pytest.mark.parametrize("solver", ["cmaes[encoding=scaled]", "cmaes", "scipy-de[encoding=scaled]"])
def test_the_least_energy_in_a_bounded_time_is_not_refused_between_samples(solver: str) -> None:
    task = ot.load_case("ur5-palletizing")
    result = ot.solve(task, solver, seed=0, budget=3000)
    assert result.solution.evaluations <= 3000
    assert result.solution.feasible
    assert result.feasible, result.diagnosis


def test_without_the_second_look_it_would_be() -> None:
    task = ot.load_case("ur5-palletizing")
    solver = parse_solver("cmaes[encoding=scaled]")
    nlp = solver.problem(task)  # type: ignore[attr-defined]
    solution = solver.search(nlp, Request(seed=0, budget=2700))  # type: ignore[attr-defined]
    missed = look_between(task, nlp, solution.x)
    assert solution.feasible and 1e-4 < missed.excess < 0.1
    outcome = solver.run(task, Request(seed=0, budget=3000))
    assert outcome.solution.evaluations > 2700
    assert outcome.trajectory is not None and ot.audit(task, outcome.trajectory).feasible
    np.testing.assert_array_equal(outcome.solution.history.cost[:3], solution.history.cost[:3])


def test_a_position_limit_of_a_cubic_is_kept_between_samples_too() -> None:
    """A swarm that rides along joint 3's limit, which a waypoint lies on."""
    cubic = ['spline.family="cubic"', "spline.virtual_knots=3"]
    task = ot.load_case("machines-2024-490", cubic)
    nlp = CondensedNlp(task, encoding="scaled")
    X = np.random.default_rng(5).uniform(nlp.lower, nlp.upper, (60, nlp.dimension))
    over = nlp.evaluate(X).total_violation
    verdicts = [ot.audit(task, nlp.decode(x)) for x in X]
    assert 5 < (over > 0).sum() < 60
    assert [verdict.feasible for verdict in verdicts] == (over == 0).tolist()


def test_budget_is_kept_only_where_slowing_may_not_mend() -> None:
    bounded, free = ot.load_case("ur5-palletizing"), ot.load_case("ur5-torque-limited")
    cubic = ["spline.family=cubic", "spline.virtual_knots=3", "objective.bounds.duration=[0, 9]"]
    exact = ot.load_case("machines-2024-490", cubic)
    kept = [may_be_refused(task, CondensedNlp(task)) for task in (bounded, free, exact)]
    assert kept == [True, False, False]
    result = ot.solve(free, "random", budget=300)
    assert result.solution.evaluations == 300
