"""The scaled encoding runs every candidate at its best feasible speed: checked by the plain encoding and the audit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from helpers.condensed_tasks import CUSTOM_OBJECTIVE, FAMILIES, LIMITS, OBJECTIVES, make_task
from ocp_traj import audit
from ocp_traj.exceptions import InputError
from ocp_traj.robot.additions import Friction
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.condensed import CondensedNlp

FRICTIONS = {
    "no friction": None,
    "coulomb": Friction(np.zeros(6), np.linspace(0.2, 1.5, 6)),
    "viscous": Friction(np.linspace(1.0, 20.0, 6), np.zeros(6)),
    "both": Friction(np.linspace(20.0, 1.0, 6), np.linspace(0.2, 2.0, 6)),
}
TORQUE = {"torque": [60.0, 80.0, 40.0, 10.0, 5.0, 3.0]}


def scaled_and_plain(task: TrajectoryTask, **options: Any) -> tuple[CondensedNlp, CondensedNlp]:
    return CondensedNlp(task, encoding="scaled", **options), CondensedNlp(task, **options)


def proportions(nlp: CondensedNlp, count: int = 6) -> np.ndarray:
    return np.random.default_rng(7).uniform(nlp.lower, nlp.upper, (count, nlp.dimension))


def at_scales(plain: CondensedNlp, x: np.ndarray, scales: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cost and total violation of one candidate slowed by every scale."""
    X = np.repeat(x[None], len(scales), axis=0)
    X[:, : plain.segments] = np.exp(X[:, : plain.segments]) * scales[:, None]
    evaluation = plain.evaluate(X)
    return evaluation.cost, evaluation.total_violation


def scale_of(nlp: CondensedNlp, x: np.ndarray) -> float:
    return nlp.decode(x).duration / float(np.exp(x[: nlp.segments]).sum())


@pytest.mark.parametrize(
    "limit", ["velocity", "acceleration", "jerk", "torque", "cartesian_speed", "per gap"]
)
@pytest.mark.parametrize("family", FAMILIES)
def test_the_smallest_scale_is_feasible_and_a_smaller_one_is_not(family: str, limit: str) -> None:
    limits = TORQUE if limit == "torque" else LIMITS[limit]
    scaled, plain = scaled_and_plain(make_task(family, limits))
    X = proportions(scaled)
    evaluation = scaled.evaluate(X)
    assert evaluation.total_violation.max() < 1e-9
    for k, x in enumerate(X):
        scale = scale_of(scaled, x)
        cost, violation = at_scales(plain, x, scale * np.array([1.0 + 1e-9, 1.0 - 1e-6, 0.9]))
        assert violation[0] < 1e-12
        assert violation[1] > 0
        assert violation[2] > 1e-3
        assert evaluation.cost[k] == pytest.approx(cost[0], rel=1e-8)


@pytest.mark.parametrize("friction", FRICTIONS)
def test_torque_limits_scale_as_the_audit_says(friction: str) -> None:
    task = make_task("cubic", {**TORQUE, **LIMITS["acceleration"]}, friction=FRICTIONS[friction])
    scaled = CondensedNlp(task, encoding="scaled", samples=400)
    for x in proportions(scaled, 3):
        scale = audit(task, scaled.decode(x)).smallest_feasible_scale
        assert scale == pytest.approx(1.0, abs=2e-4)


@pytest.mark.parametrize("family", ["cubic", "3-5-3"])
def test_exact_extrema_leave_the_audit_nothing_to_scale(family: str) -> None:
    task = make_task(family, {**LIMITS["velocity"], **LIMITS["acceleration"], **LIMITS["jerk"]})
    scaled = CondensedNlp(task, encoding="scaled")
    for x in proportions(scaled):
        assert audit(task, scaled.decode(x)).smallest_feasible_scale == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("objective", [name for name in OBJECTIVES if name != "time"])
def test_the_best_scale_beats_every_scale_of_a_fine_grid(objective: str, friction: str) -> None:
    """Brute force: the same candidate at 800 speeds, through the plain encoding."""
    limits = {**LIMITS["velocity"], "torque": [150.0, 150.0, 100.0, 28.0, 28.0, 28.0]}
    cost = {**OBJECTIVES[objective], "duration": (0.0, 12.0)}
    scaled, plain = scaled_and_plain(
        make_task("quintic", limits, cost, friction=FRICTIONS[friction]), samples=8
    )
    X = proportions(scaled, 4)
    evaluation = scaled.evaluate(X)
    assert evaluation.total_violation.max() < 1e-9
    inside = 0
    for k, x in enumerate(X):
        total = float(np.exp(x[: scaled.segments]).sum())
        costs, violation = at_scales(plain, x, np.geomspace(0.05, 12.0 / total, 800))
        feasible = violation <= 1e-12
        best = costs[feasible].min()
        inside += 0 < costs[feasible].argmin() < feasible.sum() - 1
        assert evaluation.cost[k] <= best * (1 + 1e-9)
        at_best, over = at_scales(plain, x, np.array([scale_of(scaled, x)]))
        assert at_best[0] == pytest.approx(evaluation.cost[k], rel=1e-9)
        assert over[0] < 1e-8
    if objective in ("acceleration", "jerk"):
        assert inside > 0  # the minimum is not always at an end of the allowed speeds


def test_bounds_of_durations_limit_the_scale() -> None:
    free = CondensedNlp(make_task("quintic", LIMITS["velocity"]), encoding="scaled")
    x = proportions(free, 1)[0]
    duration = free.decode(x).duration
    slow = make_task("quintic", LIMITS["velocity"], {"time": 1.0, "duration": (duration * 1.5, np.inf)})
    nlp = CondensedNlp(slow, encoding="scaled")
    assert nlp.decode(x).duration == pytest.approx(1.5 * duration)
    assert nlp.evaluate(x).total_violation[0] < 1e-12
    fast = make_task("quintic", LIMITS["velocity"], {"time": 1.0, "duration": (0.0, duration / 1.25)})
    nlp = CondensedNlp(fast, encoding="scaled")
    assert nlp.evaluate(x).total_violation[0] == pytest.approx(0.25)
    gap = make_task("quintic", LIMITS["velocity"], {"time": 1.0, "gap_durations": [[5.0, 50.0]] * 4})
    nlp = CondensedNlp(gap, encoding="scaled")
    assert np.diff(nlp.decode(x).waypoint_times).min() == pytest.approx(5.0)


def test_gravity_over_a_torque_limit_is_reported_at_any_speed() -> None:
    task = make_task("quintic", {"torque": [150.0, 1.0, 100.0, 28.0, 28.0, 28.0]})
    nlp = CondensedNlp(task, encoding="scaled")
    X = proportions(nlp)
    violation = nlp.evaluate(X).violation
    row = int(violation[0].argmax())
    assert (violation[:, row] > 1.0).all()
    assert nlp.label(row).startswith("limits at rest")


def test_a_joint_that_must_not_move_is_reported_at_any_speed() -> None:
    nlp = CondensedNlp(make_task("quintic", {"velocity": [0.0, *[1.0] * 5]}), encoding="scaled")
    assert (nlp.evaluate(proportions(nlp)).total_violation >= 1.0).all()


def test_what_does_not_scale_is_refused() -> None:
    with pytest.raises(InputError, match="needs a motion from rest to rest"):
        CondensedNlp(make_task(boundary={"velocity": [[0.1] * 6, [0.0] * 6]}), encoding="scaled")
    with pytest.raises(InputError, match="does not know how torque_rate scales"):
        CondensedNlp(make_task(limits=LIMITS["torque_rate"]), encoding="scaled")
    task = make_task(objective={"time": 1.0, "custom": (CUSTOM_OBJECTIVE,)})
    with pytest.raises(InputError, match="does not know how cost custom scales"):
        CondensedNlp(task, encoding="scaled")


def test_the_total_of_the_durations_does_not_matter() -> None:
    nlp = CondensedNlp(
        make_task("septic", {**LIMITS["velocity"], **TORQUE}, OBJECTIVES["energy"]), encoding="scaled"
    )
    X = proportions(nlp)
    np.testing.assert_allclose(nlp.evaluate(X + 0.1).cost, nlp.evaluate(X).cost, rtol=1e-8)
