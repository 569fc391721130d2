"""Offsets of virtual knots: what they are measured from, in which units, and that they lose no motion."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import ocp_traj as ot
from helpers.condensed_tasks import LIMITS, WAYPOINTS, make_task
from ocp_traj.exceptions import InputError, TaskError
from ocp_traj.solvers import parse_solver
from ocp_traj.task import Search, TrajectoryTask
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.curve import build_trajectory, trajectory_from_durations

KNOTS = [("cubic", 1), ("cubic", 3), ("quintic", 2), ("septic", 1)]
CUBIC = ('spline.family="cubic"', "spline.virtual_knots=3")


def variables(nlp: CondensedNlp, seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).uniform(nlp.lower, nlp.upper)


@pytest.mark.parametrize(("family", "knots"), KNOTS)
@pytest.mark.parametrize("encoding", ["durations", "log-durations", "scaled"])
def test_without_offsets_the_motion_is_the_family_s_own_whatever_the_shares(
    family: str, knots: int, encoding: str
) -> None:
    task = make_task(family, LIMITS["velocity"], virtual_knots=knots)
    nlp = CondensedNlp(task, encoding=encoding)
    x = variables(nlp)
    x[nlp.segments :] = 0.0
    motion = nlp.decode(x)
    own = trajectory_from_durations(task, np.diff(motion.waypoint_times))
    t = np.linspace(0.0, motion.duration, 97)
    for order in range(4):
        size = np.abs(own(t, order)).max()
        np.testing.assert_allclose(motion(t, order), own(t, order), atol=1e-9 * size)
    assert np.ptp(np.diff(motion.breakpoints).reshape(task.gaps, -1), axis=1).min() > 0


def test_a_clamped_cubic_is_the_anchor_where_end_accelerations_are_given() -> None:
    task = make_task("cubic", LIMITS["velocity"], virtual_knots=3, boundary={"acceleration": 0.0})
    nlp = CondensedNlp(task)
    decided = [1, nlp.segments - 1]
    assert not np.isin(decided, nlp.encoding.offsets.knots).any()
    assert nlp.dimension == nlp.segments + (3 * task.gaps - 2) * task.n
    x = variables(nlp)
    x[nlp.segments :] = 0.0
    motion = nlp.decode(x)
    free = task.changed(virtual_knots=0, boundary=ot.Boundary(velocity=0.0, acceleration=None))
    clamped = build_trajectory(free, np.diff(motion.waypoint_times), np.asarray(task.waypoints))
    kept = np.setdiff1d(np.arange(nlp.segments + 1), decided)
    times = np.asarray(motion.breakpoints)[kept]
    np.testing.assert_allclose(motion(times), clamped(times), atol=1e-9)
    np.testing.assert_allclose(motion([0.0, motion.duration], 2), 0.0, atol=1e-9)


def test_the_unit_is_local_travel_and_a_tenth_of_the_largest_where_a_joint_rests() -> None:
    points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.5, 0.0, 0.5], [1.5, 0.0, 0.5], [1.6, 2.0, 0.5]]
    task = TrajectoryTask(np.array(points), ot.Limits(velocity=1.0), virtual_knots=1)
    expected = [[1.0, 0.1, 0.5], [1.0, 0.1, 0.5], [0.5, 2.0, 0.2], [0.1, 2.0, 0.2]]
    np.testing.assert_allclose(CondensedNlp(task).encoding.unit, expected, rtol=1e-12)
    chord = CondensedNlp(task, offsets="chord")
    np.testing.assert_allclose(chord.encoding.unit, [[0.8, 1.0, 0.25]] * 4, rtol=1e-12)
    x = np.concatenate([np.ones(4), np.zeros(4), np.full(12, 0.5)])
    middle = chord.decode(x)(np.arange(4) + 0.5)
    np.testing.assert_allclose(middle, (np.array(points[1:]) + points[:-1]) / 2 + [0.4, 0.5, 0.125], rtol=1e-12)


def test_a_joint_that_never_moves_can_be_moved() -> None:
    still = np.ptp(WAYPOINTS, axis=0) == 0
    task = make_task("cubic", LIMITS["velocity"], virtual_knots=1)
    nlp = CondensedNlp(task)
    motion = nlp.decode(variables(nlp))
    assert still.any()
    assert np.abs(motion(np.asarray(motion.breakpoints)[1::2])[:, still] - WAYPOINTS[0, still]).max() > 0.005


@pytest.mark.parametrize("offsets", ["spline", "chord"])
def test_the_box_is_the_task_s_and_the_chord_s_is_one(offsets: str) -> None:
    task = make_task("cubic", LIMITS["velocity"], virtual_knots=1).changed(search=Search((0.1, 3.0), offset=0.25))
    nlp = CondensedNlp(task, offsets=offsets)
    half = 0.25 if offsets == "spline" else 1.0
    np.testing.assert_array_equal(np.abs(nlp.lower[nlp.segments :]), half)
    np.testing.assert_array_equal(nlp.upper[nlp.segments :], half)
    assert (nlp.lower[: task.gaps], nlp.upper[: task.gaps]) == (pytest.approx(0.1), pytest.approx(3.0))


@pytest.mark.parametrize(
    ("case", "overrides"),
    [("ur5-torque-limited", ()), ("machines-2024-490", CUBIC), ("yu-2025-four-points", ())],
)
def test_the_gradient_solver_s_optimum_is_encoded_and_decoded_without_loss(
    case: str, overrides: tuple[str, ...]
) -> None:
    task = ot.load_case(case, overrides)
    best = ot.solve(task, "ipopt")
    assert best.trajectory is not None and best.duration is not None
    for encoding in ("log-durations", "scaled"):
        nlp = CondensedNlp(task, encoding=encoding)
        again = nlp.decode(nlp.encode(best.trajectory))
        assert again.duration == pytest.approx(best.duration, rel=1e-6)
        t = np.linspace(0.0, 1.0, 200)
        one, two = best.trajectory(t * best.duration), again(t * again.duration)
        np.testing.assert_allclose(two, one, atol=1e-6)


def test_a_solver_s_name_chooses_the_offsets_and_a_result_names_them() -> None:
    task = ot.load_case("yu-2025-four-points", ["search.offset=0.2"])
    shown: dict[str, Any] = {}
    for name, expected in (
        ("random[encoding=scaled]", {"from": "spline", "box": 0.2}),
        ("random[offsets=chord]", {"from": "chord", "box": 1.0}),
    ):
        result = ot.solve(task, name, budget=50)
        shown[name] = json.loads(json.dumps(result.to_json()))["offsets"]
        assert shown[name] == expected
    plain = ot.solve(ot.load_case("machines-2024-490"), "random", budget=50)
    assert plain.to_json()["offsets"] is None
    assert ot.solve(task, "ipopt").to_json()["offsets"] is None
    with pytest.raises(InputError, match="offsets 'knots' are unknown, expected one of spline, chord"):
        parse_solver("pso[offsets=knots]").run(task, ot.solvers.Request(budget=10))


@pytest.mark.parametrize("offset", [0.0, -1.0, np.inf, [0.1, 0.2]])
def test_an_impossible_box_is_refused(offset: Any) -> None:
    with pytest.raises(TaskError, match="offset"):
        make_task("cubic", LIMITS["velocity"]).changed(search=Search(offset=offset))


def test_symbols_of_both_readings_agree_with_the_evaluation() -> None:
    import casadi as ca

    task = make_task("cubic", LIMITS["velocity"], virtual_knots=2, boundary={"acceleration": 0.0})
    for offsets in ("spline", "chord"):
        nlp = ot.transcribe(task, samples=6, offsets=offsets)
        x = variables(nlp)
        cost, rows = ca.Function("nlp", [nlp.x], [nlp.f, nlp.g])(x)
        judged = nlp.evaluate(x)
        assert float(cost) == pytest.approx(judged.cost[0], rel=1e-12)
        np.testing.assert_allclose(nlp.violations(np.array(rows).ravel()), judged.violation[0], atol=1e-9)
