"""What must hold for every task, whatever its numbers: symmetries of the problem, and order between problems."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helpers.random_tasks import random_task
from ocp_traj.audit import audit
from ocp_traj.solving import solve
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.transcription import insert_knots

SEEDS = st.integers(0, 10**6)
FEW = settings(
    max_examples=8,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
    database=None,
)
CLOSE = 2e-5
"""Relative: two runs on the same problem in other units stop at slightly different points."""


def limits_of(task: TrajectoryTask, change) -> Limits:
    """The task's limits with every (G, 2, n) array passed through `change(name, array)`."""
    names = ("position", "velocity", "acceleration", "jerk")
    return Limits(**{name: change(name, np.array(task.limits.get(name))) for name in names})


def duration(task: TrajectoryTask) -> float:
    result = solve(task, "ipopt")
    assert result.feasible, result
    assert result.duration is not None
    return result.duration


@given(SEEDS, st.floats(-2, 2))
@FEW
def test_faster_limits_shorten_the_motion_by_the_same_factor(seed, decades):
    task, factor = random_task(seed), 10.0**decades
    powers = {"position": 0, "velocity": 1, "acceleration": 2, "jerk": 3}
    faster = replace(task, limits=limits_of(task, lambda name, array: array * factor ** powers[name]))
    assert duration(faster) * factor == pytest.approx(duration(task), rel=CLOSE)


@given(SEEDS, st.sampled_from([np.pi / 180, 1e-3, 57.3]))
@FEW
def test_units_of_the_joints_do_not_matter(seed, unit):
    task = random_task(seed)
    other = replace(
        task, waypoints=task.waypoints * unit, limits=limits_of(task, lambda _, array: array * unit)
    )
    assert duration(other) == pytest.approx(duration(task), rel=CLOSE)


@given(SEEDS)
@FEW
def test_the_order_of_the_joints_does_not_matter(seed):
    task = random_task(seed)
    order = np.random.default_rng(seed).permutation(task.n)
    other = replace(
        task,
        waypoints=task.waypoints[:, order],
        limits=limits_of(task, lambda _, a: a[:, :, order]),
        tolerance=task.tolerance[:, order],
        boundary=replace(task.boundary, velocity=0.0),
    )
    assert duration(other) == pytest.approx(duration(task), rel=CLOSE)


@given(SEEDS)
@FEW
def test_mirrored_joints_take_the_same_time(seed):
    task = random_task(seed)
    sign = np.random.default_rng(seed).choice([-1.0, 1.0], task.n)
    other = replace(task, waypoints=task.waypoints * sign)
    assert duration(other) == pytest.approx(duration(task), rel=CLOSE)


@given(SEEDS)
@FEW
def test_a_motion_backwards_takes_the_same_time(seed):
    task = random_task(seed)
    other = replace(task, waypoints=task.waypoints[::-1])
    assert duration(other) == pytest.approx(duration(task), rel=CLOSE)


@given(SEEDS, st.floats(1.0, 2.0))
@FEW
def test_wider_limits_never_take_longer_from_the_same_start(seed, factor):
    task = random_task(seed)
    narrow = solve(task, "ipopt")
    assert narrow.feasible
    wider = replace(task, limits=limits_of(task, lambda name, array: array * factor))
    wide = solve(wider, "ipopt", warm_start=narrow.trajectory)
    assert wide.feasible
    assert wide.duration <= narrow.duration * (1 + 1e-9)


@given(SEEDS)
@FEW
def test_an_added_constraint_never_shortens_the_motion(seed):
    task = random_task(seed, jerk=True)
    with_jerk = solve(task, "ipopt")
    assert with_jerk.feasible
    free = replace(task, limits=limits_of(task, lambda name, a: a * np.inf if name == "jerk" else a))
    without = solve(free, "ipopt", warm_start=with_jerk.trajectory)
    assert without.feasible
    assert without.duration <= with_jerk.duration * (1 + 1e-9)


@given(SEEDS)
@FEW
def test_inserted_virtual_knots_never_lengthen_the_motion(seed):
    task = random_task(seed)
    base = solve(task, "ipopt")
    assert base.feasible
    count = 2 * task.virtual_knots + 1
    finer = solve(
        replace(task, virtual_knots=count), "ipopt", warm_start=insert_knots(base.trajectory, count)
    )
    assert finer.feasible
    assert finer.duration <= base.duration * (1 + 1e-9)


@given(SEEDS)
@FEW
def test_inserting_knots_keeps_the_motion(seed):
    task = random_task(seed, moving_ends=True)
    curve = solve(task, "ipopt").trajectory
    finer = insert_knots(curve, 2 * task.virtual_knots + 1)
    t = np.linspace(0, curve.duration, 97)
    for order in range(3):
        size = np.abs(curve(t, order)).max()
        np.testing.assert_allclose(finer(t, order), curve(t, order), atol=1e-9 * size)


@given(SEEDS)
@FEW
def test_waypoints_inserted_on_the_curve_change_nothing(seed):
    """Knots of an optimal cubic made waypoints: the same motion is still there, so the answer is no slower."""
    drawn = random_task(seed)
    boundary = replace(drawn.boundary, acceleration=None, jerk=None)
    task = replace(drawn, family="cubic", virtual_knots=1, boundary=boundary)
    free = solve(task, "ipopt")
    assert free.feasible
    knots = free.trajectory(free.trajectory.breakpoints)
    repeat = limits_of(task, lambda _, array: np.repeat(array, 2, axis=0))
    objective = replace(task.objective, gap_durations=None)
    through = TrajectoryTask(knots, repeat, family="cubic", virtual_knots=0, objective=objective)
    result = solve(
        through, "ipopt", warm_start=replace(free.trajectory, waypoint_times=free.trajectory.breakpoints)
    )
    assert result.feasible
    assert result.duration <= free.duration * (1 + 1e-4)


@given(SEEDS, st.floats(1.0, 5.0))
@FEW
def test_a_slowed_motion_passes_the_audit_of_slowed_limits(seed, factor):
    task = random_task(seed)
    motion = solve(task, "ipopt").trajectory
    powers = {"position": 0, "velocity": 1, "acceleration": 2, "jerk": 3}
    slowed = replace(task, limits=limits_of(task, lambda name, array: array / factor ** powers[name]))
    assert audit(slowed, motion.scaled(factor)).feasible
    scale = audit(task, motion.scaled(factor)).smallest_feasible_scale
    assert scale == pytest.approx(1 / factor, rel=1e-4)
