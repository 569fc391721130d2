"""Every derivative of the lifted form against finite differences: all families, limits and objectives, all entries."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from helpers.condensed_tasks import (
    CUSTOM_CONSTRAINT,
    CUSTOM_OBJECTIVE,
    LIMITS,
    OBJECTIVES,
    WAYPOINTS,
    make_task,
)
from ocp_traj.robot.additions import Friction
from ocp_traj.transcription import initial_guess
from ocp_traj.transcription.lifted.lifted import ExtraPoints, LiftedNlp

STEP = 2e-4
STENCIL = ((-2, 1 / 12), (-1, -8 / 12), (1, 8 / 12), (2, -1 / 12))
"""Fourth-order central differences."""

DIRECTIONS = 8
"""Random directions, each with a share of every variable: one wrong entry shows in all of them."""

TOLERANCE = 1e-7
"""Of the sum of entries times directions, for each row."""

CORNERS = WAYPOINTS[:3]
PER_GAP = np.stack([np.stack([-np.full(6, v), np.full(6, v)]) for v in (0.5, 1.0)])
LIMIT_CASES = {**LIMITS, "per gap": {"velocity": PER_GAP, "acceleration": 2 * PER_GAP}}

CASES: dict[str, dict[str, Any]] = {
    **{f"limit {name}": {"limits": limits} for name, limits in LIMIT_CASES.items()},
    **{f"objective {name}": {"objective": objective} for name, objective in OBJECTIVES.items()},
    "custom limit": {"constraints": (CUSTOM_CONSTRAINT,)},
    "custom objective": {"objective": {"time": 1.0, "custom": (CUSTOM_OBJECTIVE,)}},
    "viscous friction": {
        "limits": LIMITS["torque"],
        "friction": Friction(viscous=[2.0] * 6, coulomb=[0.0] * 6),
    },
    "bounds on durations": {
        "objective": {"time": 1.0, "duration": (0.5, 3.0), "gap_durations": [[0.1, 2.0], [0.2, np.inf]]}
    },
    "everything at once": {
        "limits": {**LIMITS["torque"], **LIMITS["velocity"], **LIMITS["jerk"], **LIMITS["cartesian_speed"]},
        "objective": {**OBJECTIVES["energy"], "jerk": 0.01, "torque": 0.2, "custom": (CUSTOM_OBJECTIVE,)},
        "constraints": (CUSTOM_CONSTRAINT,),
    },
}

PLACES = ExtraPoints(((0, 0, 1, 0.3), (1, 0, 1, 0.3), (1, 1, 0, 0.77)), ((0, 0.1234), (1, 0.5678), (1, 1.0)))
"""As if limits had been found broken there."""


def lifted(family: str, virtual_knots: int, changes: dict[str, Any], extra: ExtraPoints) -> LiftedNlp:
    task = make_task(family, virtual_knots=virtual_knots, waypoints=CORNERS, **changes)
    return LiftedNlp(task, initial_guess(task), 4, extra)


def point_near(nlp: LiftedNlp) -> np.ndarray:
    rng = np.random.default_rng(1)
    guess = np.asarray(nlp.guess)
    x = guess * (1 + 0.05 * rng.standard_normal(len(guess))) + 0.02 * rng.standard_normal(len(guess))
    x[: nlp.layout.segments] = np.abs(guess[: nlp.layout.segments]) * rng.uniform(
        0.8, 1.2, nlp.layout.segments
    )
    return x


def directions_at(x: np.ndarray) -> np.ndarray:
    """Return (d, DIRECTIONS) directions in the size of the variables."""
    rng = np.random.default_rng(4)
    signs = rng.choice([-1.0, 1.0], (len(x), DIRECTIONS))
    return signs * rng.uniform(0.5, 1.0, signs.shape) * np.maximum(np.abs(x), 0.1)[:, None]


def check(exact: np.ndarray, function: Any, x: np.ndarray) -> None:
    """Compare a matrix (outputs, inputs) times directions with differences of the function along them."""
    directions = directions_at(x)
    measured = [
        sum(weight * function(x + k * STEP * direction) for k, weight in STENCIL) / STEP
        for direction in directions.T
    ]
    scale = np.abs(exact) @ np.abs(directions[:, :1])  # of each row, so that small rows count
    rounding = 100 * np.finfo(float).eps * np.abs(function(x)).max(initial=1.0) / STEP
    error = np.abs(exact @ directions - np.stack(measured, axis=1)) / (TOLERANCE * scale + rounding)
    assert error.max(initial=0.0) <= 1.0


def dense(matrix: Any) -> np.ndarray:
    return np.array(ca.densify(matrix))


def check_derivatives(x: np.ndarray, count: int, derivatives: dict[str, Any]) -> None:
    """Compare gradient, Jacobian and Hessian of the Lagrangian with differences of the function one order below."""
    grad, jac, hess = (derivatives[name] for name in ("grad_f", "jac_g", "hess_lag"))
    check(dense(grad(x, [])[1]).reshape(1, -1), lambda z: np.atleast_1d(float(grad(z, [])[0])), x)
    check(dense(jac(x, [])[1]).reshape(count, -1), lambda z: np.array(jac(z, [])[0]).ravel(), x)
    factor, multipliers = 0.7, np.random.default_rng(2).standard_normal(count)

    def lagrangian_gradient(z: np.ndarray) -> np.ndarray:
        rows = ca.mtimes(jac(z, [])[1].T, ca.DM(multipliers))
        return factor * dense(grad(z, [])[1]).ravel() + dense(rows).ravel()

    upper = dense(hess(x, [], factor, multipliers))
    assert not np.tril(upper, -1).any()
    check(upper + np.triu(upper, 1).T, lagrangian_gradient, x)


@pytest.mark.parametrize("virtual_knots", [0, 1])
@pytest.mark.parametrize("family", ["cubic", "quintic", "septic"])
@pytest.mark.parametrize("name", CASES)
def test_gradient_jacobian_and_hessian_match_differences(name: str, family: str, virtual_knots: int) -> None:
    nlp = lifted(family, virtual_knots, CASES[name], ExtraPoints())
    check_derivatives(point_near(nlp), len(nlp.g_lower), nlp.derivatives)


@pytest.mark.parametrize("family", ["cubic", "quintic", "septic"])
def test_points_added_between_samples_have_right_derivatives_too(family: str) -> None:
    nlp = lifted(family, 0, CASES["everything at once"], PLACES)
    plain = lifted(family, 0, CASES["everything at once"], ExtraPoints())
    assert len(nlp.g_lower) > len(plain.g_lower)
    check_derivatives(point_near(nlp), len(nlp.g_lower), nlp.derivatives)


@pytest.mark.parametrize("family", ["cubic", "quintic", "septic"])
@pytest.mark.parametrize(
    "name", ["limit torque", "limit torque_rate", "objective energy", "everything at once"]
)
def test_the_symbols_give_the_same_values_and_derivatives_as_the_ready_functions(
    name: str, family: str
) -> None:
    nlp = lifted(family, 0, CASES[name], ExtraPoints())
    x = point_near(nlp)
    symbolic = ca.Function(
        "symbolic", [nlp.x], [nlp.f, nlp.g, ca.gradient(nlp.f, nlp.x), ca.jacobian(nlp.g, nlp.x)]
    )
    f, g, slope, jacobian = symbolic(x)
    ready_f, ready_slope = nlp.derivatives["grad_f"](x, [])
    ready_g, ready_jacobian = nlp.derivatives["jac_g"](x, [])
    for one, other in ((f, ready_f), (g, ready_g), (slope, ready_slope), (jacobian, ready_jacobian)):
        a, b = dense(one), dense(other)
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-10 * max(np.abs(b).max(initial=0.0), 1.0))


def test_the_elastic_problem_has_right_derivatives() -> None:
    from ocp_traj.solvers.gradient.reasons.elastic import elastic_problem, soft_bounds, soft_rows
    from ocp_traj.solvers.gradient.settings import Tuning

    nlp = lifted("cubic", 1, CASES["everything at once"], ExtraPoints())
    rows, bounds = soft_rows(nlp), soft_bounds(nlp)
    problem, options = elastic_problem(nlp, rows, bounds, Tuning())
    soft = len(rows) + len(bounds)
    x = np.concatenate([point_near(nlp), np.random.default_rng(3).uniform(0, 1, 2 * soft)])
    ready = {"grad_f": options["grad_f"], "jac_g": options["jac_g"]}
    value = ca.Function("elastic", [problem["x"]], [problem["f"], problem["g"]])
    count = int(problem["g"].numel())
    check(dense(ready["grad_f"](x, [])[1]).reshape(1, -1), lambda z: np.atleast_1d(float(value(z)[0])), x)
    check(dense(ready["jac_g"](x, [])[1]).reshape(count, -1), lambda z: np.array(value(z)[1]).ravel(), x)


def test_one_wrong_entry_would_be_noticed() -> None:
    nlp = lifted("cubic", 0, CASES["limit torque"], ExtraPoints())
    x, jac = point_near(nlp), nlp.derivatives["jac_g"]
    jacobian = dense(jac(x, [])[1])
    wrong = jacobian.copy()
    row, column = np.argwhere(np.abs(jacobian) > 0.01 * np.abs(jacobian).max())[-1]
    wrong[row, column] *= 1 + 1e-4
    check(jacobian, lambda z: np.array(jac(z, [])[0]).ravel(), x)
    with pytest.raises(AssertionError):
        check(wrong, lambda z: np.array(jac(z, [])[0]).ravel(), x)
