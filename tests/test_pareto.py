"""The front of duration against effort: its ends, its order, what is dominated, and what has no second objective."""

from __future__ import annotations

import json
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from helpers.small_tasks import arm_task
from ocp_traj.audit.costs import energy, jerk_cost
from ocp_traj.exceptions import InputError
from ocp_traj.pareto import (
    FAST,
    dominated_points,
    follow_front,
    pareto_front,
    second_objective,
)
from ocp_traj.quantities import COSTS
from ocp_traj.robot import load_robot
from ocp_traj.solving import solve
from ocp_traj.task import Boundary, CustomObjective, Limits, Motor, Objective, TrajectoryTask

LIMITS = Limits(velocity=2.0, acceleration=4.0, jerk=60.0)


def bare_task(**changes) -> TrajectoryTask:
    return TrajectoryTask(
        [[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]], LIMITS, name="bare", virtual_knots=1, **changes
    )


def short_task(**changes) -> TrajectoryTask:
    points = np.deg2rad([[0, -90, 90, -90, -90, 0], [30, -70, 80, -100, -90, 20]])
    return arm_task(points, virtual_knots=2, boundary=Boundary(acceleration=0.0), name="arm", **changes)


def test_a_front_starts_at_the_shortest_motion_and_never_grows() -> None:
    task = bare_task()
    front = pareto_front(task, 4, objective="jerk", slowest=1.5)
    shortest = solve(task).duration
    assert front.feasible.all()
    assert front.durations[0] <= shortest * (1 + 2 * FAST)
    np.testing.assert_allclose(front.bounds[[0, -1]], [shortest * (1 + FAST), 1.5 * shortest])
    assert (np.diff(front.durations) > 0).all()
    assert (np.diff(front.values) < 0).all()
    assert (front.durations <= front.bounds * (1 + 1e-9)).all()
    assert front.efficient.all()


def test_the_values_are_those_of_the_motions_without_any_weight() -> None:
    front = pareto_front(bare_task(objective=Objective(time=1.0, jerk=7.0)), 3)
    assert front.quantity == "jerk"
    for value, result in zip(front.values, front.results):
        assert value == pytest.approx(jerk_cost(result.trajectory), rel=1e-9)


def test_a_slow_smooth_motion_follows_the_law_of_uniform_scaling() -> None:
    """Far from all limits the least jerk integral is proportional to the duration to the power of minus 5."""
    front = pareto_front(bare_task(), 4, objective="jerk", slowest=4.0)
    slope = np.log(front.values[-1] / front.values[-2]) / np.log(front.durations[-1] / front.durations[-2])
    assert slope == pytest.approx(-5.0, abs=1e-3)


def test_each_point_is_as_good_as_a_solve_from_scratch() -> None:
    task = bare_task()
    front = pareto_front(task, 3, objective="acceleration")
    for bound, value in zip(front.bounds[1:], front.values[1:]):
        alone = solve(task.changed(objective=Objective(acceleration=1.0, duration=(0.0, float(bound)))))
        assert value <= alone.objective * (1 + 1e-5)


@pytest.mark.parametrize("name", [name for name, row in COSTS.items() if row.needs_inertia])
def test_every_objective_of_an_arm_has_a_front(name: str) -> None:
    motor = Motor(torque_constant=0.1, resistance=0.5, gear_ratio=100.0)
    robot = load_robot("ur5")
    if COSTS[name].unit != "J" or name == "motor_loss":  # holding against gravity costs most in slow motions
        robot = robot.with_changes(gravity=[0.0, 0.0, 0.0])
    task = short_task(robot=robot, objective=Objective(time=1.0, motor=motor))
    front = pareto_front(task, 3, objective=name, slowest=1.5)
    assert front.feasible.all(), front
    assert front.unit == COSTS[name].unit
    assert front.values[1] < front.values[0]
    if name == "energy":
        assert front.values[0] == pytest.approx(energy(task, front.results[0].trajectory), rel=1e-9)


def test_costs_that_time_makes_dearer_end_the_front_and_repeated_points_are_called_dominated() -> None:
    """Holding an arm costs squared torque every second, so motions slower than some are no use."""
    motor = Motor(torque_constant=0.1, resistance=0.5, gear_ratio=100.0)
    front = pareto_front(short_task(objective=Objective(motor=motor)), 5, objective="motor_loss", slowest=5.0)
    assert front.feasible.all()
    assert front.verdicts[0] == "efficient"
    assert front.verdicts[-1] == "dominated"
    assert front.durations[-1] < 0.9 * front.bounds[-1]
    assert (np.diff(front.values) <= 1e-9 * front.values[0]).all()


def test_weights_beside_time_are_kept_together_and_a_users_own_objective_counts() -> None:
    import casadi as ca

    q, v, a, tau = (ca.SX.sym(name, 2) for name in ("q", "v", "a", "tau"))
    own = CustomObjective("speed", ca.Function("speed", [q, v, a, tau], [ca.sumsqr(v)]), 0.5)
    task = bare_task(objective=Objective(time=1.0, acceleration=0.1, custom=(own,)))
    front = pareto_front(task, 3)
    assert (front.quantity, front.unit) == ("acceleration + speed", "weighted")
    assert (np.diff(front.values) < 0).all()


def test_the_tasks_own_bound_ends_the_front() -> None:
    front = pareto_front(bare_task(objective=Objective(jerk=1.0, duration=(0.0, 2.5))), 3)
    assert front.bounds[-1] == 2.5
    assert front.durations.max() <= 2.5 * (1 + 1e-9)


def test_a_task_without_any_motion_is_one_infeasible_point_with_its_reason() -> None:
    task = TrajectoryTask([[0.0], [1.0]], Limits(velocity=0.0), name="stuck")
    front = pareto_front(task, 3, objective="acceleration")
    assert len(front.results) == 1
    assert front.verdicts == ("infeasible",)
    assert "velocity: joint 1, gap 1" in front.results[0].message
    assert "infeasible" in str(front)
    assert front.to_json()["points"][0]["bound"] is None
    json.dumps(front.to_json(), allow_nan=False)


def test_a_better_kind_of_motion_found_late_is_carried_back(monkeypatch: pytest.MonkeyPatch) -> None:
    from ocp_traj import pareto

    real, calls = pareto.solve, []

    def careless(task, *arguments, **options):
        """Give back the start, not an optimum, for the second and the third point on the way there."""
        calls.append(task)
        if len(calls) in (3, 4):
            return real(task, "ipopt[iterations=0,attempts=1]", **options)
        return real(task, *arguments, **options)

    honest = pareto_front(bare_task(), 4, objective="jerk", slowest=1.5)
    monkeypatch.setattr(pareto, "solve", careless)
    points = list(pareto.follow_front(bare_task(), 4, objective="jerk", slowest=1.5))
    assert [point.index for point in points] == [0, 1, 2, 3, 2, 1]
    front = pareto.collect_front(bare_task(), "jerk", points)
    assert points[1].result.objective > 1.01 * front.values[1]
    np.testing.assert_allclose(front.values, honest.values, rtol=1e-4)


def test_points_are_dominated_by_feasible_ones_only_and_the_first_of_equals_stays() -> None:
    durations = np.array([1.0, 2.0, 2.0, 3.0, 0.5, np.nan])
    values = np.array([5.0, 3.0, 3.0 * (1 + 1e-9), 4.0, 1.0, np.nan])
    feasible = np.array([True, True, True, True, False, False])
    np.testing.assert_array_equal(
        dominated_points(durations, values, feasible), [False, False, True, True, False, False]
    )


@pytest.mark.parametrize(
    ("name", "words"),
    [
        (
            None,
            "bare weighs time only and has no robot with inertia: choose the second objective, one of acceleration",
        ),
        (
            "energy",
            "energy needs a robot with inertia, but bare has none; expected one of acceleration, jerk",
        ),
        ("beauty", "the objective 'beauty' is unknown, expected one of energy"),
    ],
)
def test_a_task_without_second_objective_says_what_it_could_have(name: str | None, words: str) -> None:
    with pytest.raises(InputError) as caught:
        pareto_front(bare_task(), 3, objective=name)
    assert words in str(caught.value)


def test_motor_loss_without_motors_and_senseless_numbers_are_refused() -> None:
    with pytest.raises(InputError, match=r"motor_loss needs the motors' parameters"):
        second_objective(short_task(), "motor_loss")
    with pytest.raises(InputError, match="a front of 1 points was asked for, expected at least 2"):
        pareto_front(bare_task(), 1, objective="jerk")
    with pytest.raises(InputError, match=r"1\.0 times the shortest, expected more than 1"):
        list(follow_front(bare_task(), 3, objective="jerk", slowest=1.0))


def test_an_arm_that_weighs_time_only_gets_energy() -> None:
    assert second_objective(short_task()).weights == {"energy": 1.0}


def test_a_front_prints_as_text_html_and_json_and_is_frozen() -> None:
    front = pareto_front(bare_task(), 2, objective="jerk")
    lines = str(front).splitlines()
    assert lines[0] == "bare: duration against jerk, 2 of 2 points efficient"
    assert lines[1].split() == [
        "point",
        "at",
        "most,",
        "s",
        "duration,",
        "s",
        "jerk,",
        "rad^2/s^5",
        "verdict",
        "status",
    ]
    assert f"{front.durations[1]:.4f}" in lines[3]
    page = front._repr_html_()
    assert page.count("<tr>") == 3
    assert "<caption>bare: duration against jerk</caption>" in page
    written = json.loads(json.dumps(front.to_json(), allow_nan=False))
    assert [point["duration"] for point in written["points"]] == list(front.durations)
    assert written["points"][0]["result"]["trajectory"] is not None
    with pytest.raises(FrozenInstanceError):
        front.quantity = "none"  # type: ignore[misc]
    with pytest.raises(ValueError, match="read-only"):
        front.values[0] = 0.0
