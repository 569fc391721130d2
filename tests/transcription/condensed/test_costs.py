"""Costs of the condensed form, against integrals of what Pinocchio says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from helpers.condensed_rows import candidates, motion_for
from helpers.row_oracle import (
    GAPS,
    make_task,
    torque,
)
from ocp_traj.task import Limits, Motor, Objective
from ocp_traj.transcription.condensed.condensed import CondensedNlp

COSTS = {
    "energy": lambda robot, q, v, a: np.abs(torque(robot, q, v, a) * v).sum(),
    "energy_without_regeneration": lambda robot, q, v, a: np.maximum(torque(robot, q, v, a) * v, 0.0).sum(),
    "torque": lambda robot, q, v, a: np.square(torque(robot, q, v, a) / [1.0, 9.0, 12.0]).sum(),
    "acceleration": lambda robot, q, v, a: np.square(a).sum(),
    "motor_loss": lambda robot, q, v, a: (np.square(torque(robot, q, v, a)) * [2e-3, 8e-3, 18e-3]).sum(),
}
MOTOR = Motor(torque_constant=[1.0, 0.5, 1 / 3], resistance=0.2, gear_ratio=10.0)


@pytest.mark.parametrize("encoding", ["durations", "scaled"])
@pytest.mark.parametrize("name", COSTS)
def test_costs_of_populations_are_integrals_of_what_pinocchio_says(
    arm: Any, name: str, encoding: str
) -> None:
    limits = Limits(torque=[[-np.inf, -9.0, -8.0], [np.inf, 7.0, 12.0]], velocity=2.0, position=np.inf)
    task = make_task(
        arm,
        "cubic",
        1,
        objective=Objective(time=0.5, duration=(0.0, 9.0), motor=MOTOR, **{name: 0.3}),
        limits=limits,
        constraints=(),
    )
    nlp = CondensedNlp(task, encoding=encoding, samples=8)
    X = candidates(nlp)
    for x, cost in zip(X, nlp.evaluate(X).cost):
        scale = 1.0 if encoding == "durations" else nlp.decode(x).duration / np.exp(x[:GAPS]).sum()
        motion = motion_for(nlp, x, scale)
        total = 0.5 * motion.durations.sum()
        for segment, h in enumerate(motion.durations):
            values = [COSTS[name](arm, *motion.state(segment, k / 4)) for k in range(5)]
            # Simpson's rule, exact for the square of a cubic's acceleration
            total += 0.3 * h / 12 * np.dot([1.0, 4.0, 2.0, 4.0, 1.0], values)
        assert cost == pytest.approx(total, rel=1e-9)
