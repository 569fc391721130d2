"""What `reference --json` and `solve --json --references` carry."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np

from ocp_traj.references import reference_columns, references
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.trajectory import Trajectory


def small_task() -> TrajectoryTask:
    points = np.array([[0.0, 0.0], [1.0, 0.5], [2.0, 2.0]])
    return TrajectoryTask(points, Limits(velocity=1.0, acceleration=2.0), name="small")


def test_the_dictionary_has_the_form_of_the_contract() -> None:
    found = references(small_task())
    assert list(found)[:5] == ["schema", "case", "kinematic_bound", "toppra", "convex"]
    assert found["schema"] == 1 and found["case"] == "small"
    assert set(found["kinematic_bound"]) == {"lower", "estimate"}
    for method in ("toppra", "convex"):
        assert set(found[method]) == {"uniform", "chord"}
        assert all(value >= found["kinematic_bound"]["lower"] for value in found[method].values())
    json.dumps(found, allow_nan=False)


def test_the_path_of_a_motion_is_timed_under_the_name_spline() -> None:
    coefficients = np.zeros((2, 2, 2))
    coefficients[:, :, 0] = [[0.0, 0.0], [1.0, 0.5]]
    coefficients[:, :, 1] = [[1.0, 0.5], [1.0, 1.5]]
    motion = Trajectory(np.array([0.0, 1.0, 2.0]), coefficients, np.array([0.0, 1.0, 2.0]))
    found = references(small_task(), motion, convex=False)
    # two straight lines with a stop at the corner: 1 + 0.5 s, then 1.5 + 0.5 s
    assert abs(found["toppra"]["spline"] - 3.5) < 1e-2
    assert found["convex"] == {"uniform": None, "chord": None, "spline": None}


def test_what_failed_is_null_with_a_message() -> None:
    found = references(TrajectoryTask(np.array([[0.0], [1.0]]), Limits()))
    assert found["toppra"] == {"uniform": None, "chord": None}
    assert found["kinematic_bound"] == {"lower": None, "estimate": None}
    assert (
        found["messages"]["toppra.chord"]
        == "no velocity, acceleration or torque limit bounds the speed along this path"
    )


def test_columns_of_a_result_hold_the_better_path() -> None:
    task = small_task()
    found = references(task, convex=False)
    assert reference_columns(task)["toppra"] == min(found["toppra"].values())


def test_importing_the_package_loads_no_heavy_library() -> None:
    heavy = ("casadi", "cvxpy", "toppra", "clarabel", "scipy")
    code = f"import sys, ocp_traj.references; print([m for m in {heavy} if m in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"
