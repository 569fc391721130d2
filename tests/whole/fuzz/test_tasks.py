"""A task built by hand from anything: a task or one sentence with its key, and what a task asks of its forms."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ocp_traj.case import task_digest
from ocp_traj.exceptions import InputError, TaskError, UnknownNameError
from ocp_traj.spline import get_family
from ocp_traj.task import Boundary, CustomConstraint, Limits, Objective, Search, TrajectoryTask
from ocp_traj.transcription import trajectory_from_durations, transcribe
from ocp_traj.transcription.nlp import Nlp

POINTS = [[0.0, 0.0], [1.0, 2.0], [2.0, 0.0]]
ODD = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=5)
    | st.sampled_from([1e308, 5e-324, 10**400, "cubic", "zero", [1.0, 2.0], [[-1.0, -1.0], [1.0, 1.0]]]),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=8,
)


@pytest.mark.parametrize(
    ("given_", "key", "reason"),
    [
        ({"waypoints": [[0.0], [1.0, 2.0]]}, "waypoints", "rows differ in length"),
        ({"waypoints": 3.0}, "waypoints", "have shape"),
        ({"waypoints": [[0.0, 0.0]]}, "waypoints", "1 given, expected at least 2"),
        ({"waypoints": [[0.0, 0.0], [np.nan, 1.0]]}, "waypoints", "waypoint 2, joint 1 is nan"),
        ({"tolerance": -1.0}, "waypoints.tolerance", "numbers of 0 or more"),
        ({"tolerance": [1.0, 1.0, 1.0]}, "waypoints.tolerance", "expected one, 2 or"),
        ({"limits": Limits(velocity="fast")}, "limits.velocity", "is not a number"),
        ({"limits": Limits(velocity=np.nan)}, "limits.velocity", "contains nan"),
        ({"limits": Limits(velocity=[1.0, -2.0])}, "limits.velocity", "-2 is negative"),
        ({"limits": Limits(jerk=[1.0, 1.0, 1.0])}, "limits.jerk", "has shape"),
        ({"limits": Limits(velocity=[[1.0, 1.0], [-1.0, -1.0]])}, "limits.velocity", "joint 1 is above"),
        ({"limits": Limits(velocity=[[0.5, -1.0], [1.0, 1.0]])}, "limits.velocity", "must contain 0"),
        ({"limits": Limits(cartesian_speed=(("tool", -1.0),))}, "limits.cartesian_speed", "positive speed"),
        ({"boundary": Boundary(velocity=[0.0, 0.0, 0.0])}, "boundary.velocity", "expected two rows"),
        (
            {"boundary": Boundary(velocity="slow", acceleration=[[]])},
            "boundary.acceleration",
            "expected two rows",
        ),
        ({"boundary": Boundary(jerk=[None, 10**400])}, "boundary.jerk", "expected numbers"),
        ({"objective": Objective(time="long")}, "objective.time", "'long' given, expected numbers"),
        ({"objective": Objective(duration="long")}, "objective.bounds.duration", "expected numbers"),
        ({"tolerance": "small"}, "waypoints.tolerance", "'small' given, expected numbers"),
        ({"limits": Limits(velocity=10**400)}, "limits.velocity", "is not a number"),
        ({"waypoints": [[10**400, 0.0], [0.0, 0.0]]}, "waypoints", "something else than numbers"),
        ({"family": ["cubic"]}, "spline.family", "is unknown"),
        ({"boundary": Boundary(velocity=None)}, "boundary.velocity", "cannot be free"),
        ({"boundary": Boundary(jerk=np.inf)}, "boundary.jerk", "finite"),
        ({"objective": Objective(time=-1.0)}, "objective.time", "is not a weight"),
        ({"objective": Objective(energy=np.nan)}, "objective.energy", "is not a weight"),
        ({"objective": Objective(duration=(2.0, 1.0))}, "objective.bounds.duration", "lower <= upper"),
        ({"objective": Objective(duration=(0.0, np.nan))}, "objective.bounds.duration", "has shape"),
        ({"objective": Objective(gap_durations=[[0.0, 1.0]])}, "objective.bounds.gap_durations", "has shape"),
        ({"objective": Objective(motor_loss=1.0)}, "objective.motor_loss", "robot.motor"),
        ({"search": Search(duration=(0.0, 1.0))}, "search.duration", "expected"),
        ({"search": Search(duration=(1.0, np.inf))}, "search.duration", "two finite positive"),
        ({"search": Search(protocol="all")}, "search.protocol", "'all' is unknown"),
        ({"family": "linear"}, "spline.family", "'linear' is unknown"),
        ({"virtual_knots": -1}, "spline.virtual_knots", "whole number"),
        ({"virtual_knots": True}, "spline.virtual_knots", "whole number"),
        ({"family": "3-5-3"}, "spline.family", "at least 4 waypoints"),
        ({"family": "3-5-3", "virtual_knots": 1}, "spline.virtual_knots", "takes none"),
        (
            {"waypoints": [[0.0], [1.0]], "boundary": Boundary(acceleration=0.0), "virtual_knots": 1},
            "spline.virtual_knots",
            "free coefficients",
        ),
        (
            {"waypoints": [[0.0]] * 4, "family": "3-5-3", "boundary": Boundary(acceleration=None)},
            "boundary",
            "3-5-3 has given end accelerations",
        ),
    ],
)
def test_a_task_that_contradicts_itself_is_refused_with_its_key(
    given_: dict[str, Any], key: str, reason: str
) -> None:
    with pytest.raises(TaskError) as raised:
        TrajectoryTask(**{"waypoints": POINTS, "limits": Limits(velocity=1.0), **given_})
    assert raised.value.key == key
    assert reason in str(raised.value)


@settings(max_examples=400)
@given(
    st.sampled_from(["position", "velocity", "acceleration", "jerk", "torque", "torque_rate"]),
    ODD,
    st.sampled_from(["waypoints", "tolerance", "virtual_knots", "family"]),
    ODD,
)
def test_any_limits_and_settings_are_a_task_or_refused(limit: str, value: Any, key: str, other: Any) -> None:
    try:
        task = TrajectoryTask(
            **{"waypoints": POINTS, "limits": Limits(**{limit: value}), key: other}  # type: ignore[arg-type]
        )
    except InputError as error:
        assert str(error)
    else:
        assert task.limits.get(limit).shape == (task.gaps, 2, task.n)
        assert np.isfinite(task.waypoints).all()


def test_names_that_do_not_exist_list_those_that_do() -> None:
    with pytest.raises(UnknownNameError, match=r"'bezier' is unknown, expected one of .*cubic"):
        get_family("bezier")
    task = TrajectoryTask(POINTS, Limits(velocity=1.0))
    with pytest.raises(InputError, match="form 'dense' is unknown, expected one of"):
        transcribe(task, form="dense")
    four = TrajectoryTask([[0.0], [1.0], [0.0], [1.0]], Limits(velocity=1.0), family="3-5-3")
    with pytest.raises(InputError, match="has the condensed form only"):
        transcribe(four, form="lifted")


@pytest.mark.parametrize("durations", [[1.0], [1.0, 0.0], [1.0, -1.0], [1.0, np.nan], [1.0, np.inf], 1.0])
def test_durations_that_are_none_are_refused(durations: Any) -> None:
    with pytest.raises(InputError, match="given, expected"):
        trajectory_from_durations(TrajectoryTask(POINTS, Limits(velocity=1.0)), durations)


def test_rows_have_names_and_a_row_that_is_not_there_has_none() -> None:
    nlp = transcribe(TrajectoryTask(POINTS, Limits(velocity=1.0), virtual_knots=1), form="lifted")
    count = sum(map(len, nlp.rows))
    assert "gap" in nlp.label(0)
    assert "gap" in nlp.label(count - 1)
    with pytest.raises(IndexError, match=f"row {count} of {count}"):
        nlp.label(count)


def test_the_plain_evaluation_agrees_with_the_symbols() -> None:
    nlp = transcribe(TrajectoryTask(POINTS, Limits(velocity=1.0, acceleration=2.0)), form="lifted")
    X = np.stack([nlp.guess, 1.1 * nlp.guess])
    plain = Nlp.evaluate(nlp, X)
    function = ca.Function("f", [nlp.x], [nlp.f, nlp.g])
    for place, x in enumerate(X):
        f, g = (np.array(part).ravel() for part in function(x))
        assert plain.cost[place] == pytest.approx(f[0], rel=1e-14)
        expected = np.maximum(np.maximum(g - nlp.g_upper, nlp.g_lower - g), 0.0)
        np.testing.assert_allclose(plain.violation[place], expected, rtol=1e-14, atol=0)


def test_a_constraint_of_ones_own_is_part_of_the_digest() -> None:
    q, v, a = (ca.SX.sym(name, 2) for name in "qva")
    digests = {task_digest(TrajectoryTask(POINTS, Limits(velocity=1.0)))}
    for upper in (1.0, 2.0):
        for expression in (q[0] + q[1], q[0] - q[1]):
            function = ca.Function("sum", [q, v, a], [expression])
            constraint = CustomConstraint("sum", function, lower=-np.inf, upper=upper)
            task = TrajectoryTask(POINTS, Limits(velocity=1.0), constraints=(constraint,))
            digests.add(task_digest(task))
    assert len(digests) == 5
