"""Costs of the lifted form, against integrals of what Pinocchio says."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from helpers.lifted_rows import (
    SAMPLES,
    states_near,
    variables,
)
from helpers.row_oracle import (
    DEGREES,
    Motion,
    make_task,
    torque,
)
from ocp_traj.task import (
    CustomObjective,
    Limits,
    Motor,
    Objective,
)
from ocp_traj.transcription import initial_guess
from ocp_traj.transcription.lifted.lifted import ExtraPoints, LiftedNlp


def smooth_effort() -> Any:
    q, v, a, tau = (ca.SX.sym(name, 3) for name in ("q", "v", "a", "tau"))
    return ca.Function("effort", [q, v, a, tau], [ca.sumsqr(tau) * 0.1 + q[0] * a[1]])


OBJECTIVES: dict[str, Any] = {
    "energy": lambda robot, q, v, a: np.abs(torque(robot, q, v, a) * v).sum(),
    "energy_without_regeneration": lambda robot, q, v, a: np.maximum(torque(robot, q, v, a) * v, 0.0).sum(),
    "torque": lambda robot, q, v, a: np.square(torque(robot, q, v, a) / [1.0, 9.0, 12.0]).sum(),
    "motor_loss": lambda robot, q, v, a: (np.square(torque(robot, q, v, a)) * [2e-3, 8e-3, 18e-3]).sum(),
    "custom": lambda robot, q, v, a: 1.5 * (np.square(torque(robot, q, v, a)).sum() * 0.1 + q[0] * a[1]),
}
MOTOR = Motor(torque_constant=[1.0, 0.5, 1 / 3], resistance=0.2, gear_ratio=10.0)


def integral(motion: Motion, function: Any, count: int) -> float:
    """Return Simpson's rule with `count` intervals a segment."""
    total = 0.0
    for segment, h in enumerate(motion.durations):
        values = [function(*motion.state(segment, k / count)) for k in range(count + 1)]
        weights = [1.0, *[4.0, 2.0] * (count // 2 - 1), 4.0, 1.0]
        total += h * float(np.dot(weights, values)) / (3 * count)
    return total


@pytest.mark.parametrize(("samples", "knots"), [(4, 0), (12, 1)])
@pytest.mark.parametrize("name", OBJECTIVES)
def test_costs_are_integrals_of_what_pinocchio_says(arm: Any, name: str, samples: int, knots: int) -> None:
    weights: dict[str, Any] = {"custom": (CustomObjective("effort", smooth_effort(), 1.5),)}
    objective = Objective(time=0.5, motor=MOTOR, **(weights if name == "custom" else {name: 1.0}))
    limits = Limits(torque=[[-np.inf, -9.0, -8.0], [np.inf, 7.0, 12.0]], velocity=np.inf)
    task = make_task(arm, "cubic", knots, objective=objective, limits=limits, constraints=())
    nlp = LiftedNlp(task, initial_guess(task), samples, ExtraPoints())
    durations, motion = states_near(np.random.default_rng(4), 3, nlp.layout.segments)
    x = variables(nlp, motion)
    slacks = len(nlp.lower) - len(x)
    f = ca.Function("f", [nlp.x], [nlp.f, nlp.g])
    if (
        slacks
    ):  # every row duration value / unit - plus + minus = 0 holds at the guess, and here with the least cost
        rows = np.array([block.limit == name for block in nlp.rows for _ in range(len(block))])
        assert np.abs(np.array(f(nlp.guess)[1]).ravel()[rows]).max() < 1e-9
        assert (np.asarray(nlp.lower)[-slacks:] == 0).all()
        assert np.isinf(np.asarray(nlp.upper)[-slacks:]).all()
        assert (nlp.guess[-slacks:] > 0).all()
        assert (np.asarray(nlp.g_lower)[rows] == 0).all()
        assert (np.asarray(nlp.g_upper)[rows] == 0).all()
        jacobian = np.array(ca.densify(nlp.derivatives["jac_g"](np.append(x, np.zeros(slacks)), [])[1]))[rows]
        values = np.array(f(np.append(x, np.zeros(slacks)))[1]).ravel()[rows]
        chosen = np.zeros(slacks)
        for row, value in zip(jacobian[:, -slacks:], values):
            assert sorted(row[row != 0]) == [-1.0, 1.0]
            chosen[np.argmax(row == (-1.0 if value > 0 else 1.0))] = abs(value)
        x = np.append(x, chosen)
        assert np.abs(np.array(f(x)[1]).ravel()[rows]).max() < 1e-12
    count = max(2, 2 * round(max(samples, 8) / (2 * (knots + 1))))
    expected = 0.5 * durations.sum() + integral(motion, lambda *u: OBJECTIVES[name](arm, *u), count)
    assert float(f(x)[0]) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("family", "knots"), [("cubic", 1), ("quintic", 0), ("septic", 0)])
def test_squared_derivatives_are_integrated_exactly(arm: Any, family: str, knots: int) -> None:
    degree = DEGREES[family]
    task = make_task(arm, family, knots, objective=Objective(acceleration=0.3, jerk=0.02), limits=Limits())
    nlp = LiftedNlp(task, initial_guess(task), SAMPLES, ExtraPoints())
    _, motion = states_near(np.random.default_rng(9), degree, nlp.layout.segments)
    expected = 0.0
    for order, weight in ((2, 0.3), (3, 0.02)):
        for segment, h in enumerate(motion.durations):
            for column in motion.coefficients(order, segment).T:
                expected += weight * np.polyval(np.polyint(np.polymul(column, column)), h)
    assert float(ca.Function("f", [nlp.x], [nlp.f])(variables(nlp, motion))) == pytest.approx(
        expected, rel=1e-9
    )
