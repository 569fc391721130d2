"""The best speed of a candidate, against limits worked out apart."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from helpers.condensed_rows import SAMPLES, candidates, grid, motion_for
from helpers.row_oracle import (
    FRAMES,
    GAPS,
    LIMITS,
    ORDERS,
    Motion,
    instant_limits,
    make_arm,
    make_task,
    torque,
)
from ocp_traj.task import Limits, Objective
from ocp_traj.transcription.condensed.condensed import CondensedNlp

TORQUE_LIMITS = (
    np.array([[[-30.0, -70.0, -14.0], [25.0, 80.0, 17.0]]] * 3) * np.array([1.0, 1.2, 0.9])[:, None, None]
)
FRICTIONS = {"none": (0.0, 0.0), "viscous": (3.0, 0.0), "coulomb": (0.0, 2.0), "both": (2.0, 1.0)}


def largest_excess(robot: Any, motion: Motion, names: Any, per_gap: int) -> float:
    """Return by how much a motion is over a limit, in units of the limit, where largest."""
    worst = -np.inf
    for segment in range(GAPS * per_gap):
        gap = segment // per_gap
        for name, bounds in names.items():
            if name in ORDERS:
                values = motion.extremes(ORDERS[name], segment)
                found = np.maximum(values[0] / bounds[gap, 1], values[1] / bounds[gap, 0])
                worst = max(worst, float(found.max()) - 1.0)
            else:
                for fraction in grid(per_gap):
                    tau = torque(robot, *motion.state(segment, fraction))
                    worst = max(
                        worst, float(np.maximum(tau / bounds[gap, 1], tau / bounds[gap, 0]).max()) - 1.0
                    )
    return worst


@pytest.mark.parametrize("limit", ["velocity", "acceleration", "jerk", *FRICTIONS])
@pytest.mark.parametrize(("family", "knots"), [("cubic", 0), ("quintic", 1)])
def test_the_best_speed_keeps_every_limit_and_touches_one(
    arm: Any, tmp_path: Any, family: str, knots: int, limit: str
) -> None:
    if limit in FRICTIONS:
        robot, names = make_arm(tmp_path, FRICTIONS[limit]), {"torque": TORQUE_LIMITS}
    else:
        robot, names = arm, {limit: LIMITS[limit].copy()}
    free = {"velocity": np.inf, "torque": np.inf, "position": np.inf}
    task = make_task(
        robot,
        family,
        knots,
        limits=Limits(**{**free, **names}),
        constraints=(),
        objective=Objective(time=2.0),
    )
    nlp = CondensedNlp(task, encoding="scaled", samples=SAMPLES)
    X = candidates(nlp)
    evaluation = nlp.evaluate(X)
    assert evaluation.violation.max(initial=0.0) < 1e-12
    for k, x in enumerate(X):
        total = float(np.exp(x[:GAPS]).sum())
        scale = nlp.decode(x).duration / total
        assert evaluation.cost[k] == pytest.approx(2.0 * total * scale, rel=1e-12)
        slow, fast = (motion_for(nlp, x, scale * factor) for factor in (1 + 1e-9, 1 - 1e-6))
        assert largest_excess(robot, slow, names, knots + 1) <= 1e-10
        assert largest_excess(robot, fast, names, knots + 1) > 0


def test_frames_set_the_best_speed_too(arm: Any) -> None:
    limits = Limits(velocity=np.inf, torque=np.inf, cartesian_speed=FRAMES)
    task = make_task(arm, "cubic", limits=limits, constraints=(), objective=Objective(time=1.0))
    nlp = CondensedNlp(task, encoding="scaled", samples=SAMPLES)
    for x in candidates(nlp):
        scale = nlp.decode(x).duration / float(np.exp(x).sum())
        motion = motion_for(nlp, x)
        function, bounds, _, _ = instant_limits(arm, "cartesian_speed")
        found = [function(*motion.state(s, f)) / bounds[0, 1] for s in range(GAPS) for f in grid(1)]
        assert scale == pytest.approx(np.sqrt(np.max(found)), rel=1e-9)


def test_what_stands_still_over_a_torque_limit_is_told_in_units_of_the_limit(arm: Any) -> None:
    """Gravity alone: of the arm at the sampled positions, which do not depend on the speed."""
    bounds = np.array([[-1e3, -2.0, -1e3], [1e3, 5.0, 1e3]])
    for own in (bounds, -bounds[::-1]):
        task = make_task(
            arm, "cubic", limits=Limits(position=LIMITS["position"], velocity=2.0, torque=own), constraints=()
        )
        nlp = CondensedNlp(task, encoding="scaled", samples=SAMPLES)
        X = candidates(nlp)
        names = [block.limit for block in nlp.rows for _ in range(len(block))]
        row = names.index("limits at rest")
        assert names[row + 1 :] == ["duration"] * 5
        assert set(names[:row]) == {"position"}
        for k, x in enumerate(X):
            motion = motion_for(nlp, x)
            still = [
                torque(arm, motion.at(0, s, f), np.zeros(3), np.zeros(3))[1]
                for s in range(GAPS)
                for f in grid(1)
            ]
            excess = max(np.max(still) - own[1, 1], own[0, 1] - np.min(still)) / 5.0
            assert nlp.evaluate(X).violation[k, row] == pytest.approx(excess, rel=1e-9)
            assert excess > 0
