"""Families of a user's own, from outside the package: solved, judged, compared and drawn as those inside are."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ocp_traj as ot
from ocp_traj.comparison.runs.compare import compare
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.comparison.runs.runner import solve_case
from ocp_traj.comparison.runs.store import Store
from ocp_traj.exceptions import TaskError
from ocp_traj.pictures.motion import motion_picture
from ocp_traj.spline import FAMILIES, Family, Piece, UniformFamily

POINTS = np.array([[0.0, 0.5], [1.0, 0.2], [0.4, 0.9]])
LIMITS = ot.Limits(velocity=[1.0, 0.5], acceleration=[2.0, 3.0])

CASE = """
schema = 1
name = "stops"
[limits]
velocity = 1.0
acceleration = 2.0
[waypoints]
joints = [[0.0], [1.0], [0.4]]
unit = "rad"
[spline]
family = "stop-and-go"
"""


class Nonic(UniformFamily):
    """Degree nine, continuous up to the eighth derivative, at rest up to the snap."""

    name = "nonic"
    degree = 9
    continuity = 8


class StopAndGo(Family):
    """Quintics that come to rest at every waypoint."""

    name = "stop-and-go"
    degree = 5
    continuity = 2
    takes_virtual_knots = False
    takes_end_conditions = False

    def pieces(self, durations: list[Any], positions: list[Any], ends: Any) -> list[Piece]:
        """Return one quintic per gap."""
        return [
            Piece(5, h, (start, 0.0 * start, 0.0 * start, end, 0.0 * end, 0.0 * end))
            for h, start, end in zip(durations, positions, positions[1:])
        ]


def run(request: Mapping[str, Any]) -> dict[str, Any]:
    """Execute one run of a comparison where the family is known."""
    FAMILIES["stop-and-go"] = StopAndGo()
    return solve_case(request)


def stops(points: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray) -> float:
    """Return the least duration of quintics from rest to rest: peaks 15/8 d/T and 10/sqrt(3) d/T^2."""
    travel = np.abs(np.diff(points, axis=0))
    times = np.maximum(15 / 8 * travel / velocity, np.sqrt(10 / np.sqrt(3) * travel / acceleration))
    return float(times.max(axis=1).sum())


@pytest.mark.parametrize(
    ("solver", "tolerance"),
    [("ipopt", 1e-6), ("cmaes[encoding=scaled]", 1e-6), ("pso[encoding=log-durations]", 1e-3)],
)
def test_a_family_without_a_lifted_form_is_solved_to_its_closed_form(solver: str, tolerance: float) -> None:
    task = ot.TrajectoryTask(POINTS, LIMITS, family=StopAndGo())
    result = ot.solve(task, solver, seed=1, budget=None if solver == "ipopt" else 4000)
    assert result.feasible and result.trajectory is not None
    least = stops(POINTS, np.array([1.0, 0.5]), np.array([2.0, 3.0]))
    assert result.duration == pytest.approx(least, rel=tolerance)
    inner = result.trajectory.waypoint_times[1]
    np.testing.assert_allclose(result.trajectory(inner, 1), 0.0, atol=1e-9)


@pytest.mark.parametrize("form", ["ipopt", "cmaes[encoding=scaled]"])
def test_a_uniform_family_of_a_new_degree_is_solved_to_its_closed_form(form: str) -> None:
    task = ot.TrajectoryTask(POINTS[:2], ot.Limits(velocity=1.0), family=Nonic())
    result = ot.solve(task, form, seed=1, budget=None if form == "ipopt" else 500)
    assert result.feasible
    # the peak of t^4 (1 - t)^4 over its integral
    assert result.duration == pytest.approx(315 / 128, rel=1e-5)


@pytest.mark.parametrize("knots", [0, 2])
def test_gradients_and_populations_agree_on_a_uniform_family(knots: int) -> None:
    task = ot.TrajectoryTask(POINTS, ot.Limits(velocity=1.0, jerk=30.0), family=Nonic(), virtual_knots=knots)
    smooth = ot.solve(task, "ipopt")
    assert smooth.feasible and smooth.trajectory is not None
    nlp = ot.transcribe(task, encoding="scaled")
    x = nlp.encode(smooth.trajectory)  # type: ignore[attr-defined]
    judged = nlp.evaluate(x[None])
    assert judged.cost[0] == pytest.approx(smooth.duration, rel=2e-2)
    assert ot.audit(task, nlp.decode(x)).waypoint_error < 1e-9
    if not knots:
        found = ot.solve(task, "cmaes[encoding=scaled]", seed=1, budget=1500)
        assert found.duration == pytest.approx(smooth.duration, rel=1e-3)


def test_a_family_is_a_value_with_a_name() -> None:
    task = ot.TrajectoryTask(POINTS, LIMITS, family=StopAndGo())
    named = ot.TrajectoryTask(POINTS, LIMITS, family="cubic")
    assert task.family == "stop-and-go" and f"{task.family}" == "stop-and-go" != named.family
    assert named.family == "cubic" == FAMILIES["cubic"] and {named.family: 1}["cubic"] == 1  # type: ignore[index]
    assert isinstance(task.family, StopAndGo) and task.changed(tolerance=0.1).family is task.family
    assert pickle.loads(pickle.dumps(named)).family == "cubic"
    assert ot.task_digest(task) != ot.task_digest(named)
    with pytest.raises(TaskError, match="stop-and-go takes none"):
        task.changed(virtual_knots=1)
    with pytest.raises(TaskError, match="stop-and-go has given end accelerations and free end jerks"):
        task.changed(boundary=ot.Boundary(jerk=0.0))


def test_a_motion_of_an_own_family_is_drawn_and_written(tmp_path: Path) -> None:
    from ocp_traj.pictures.matplotlib_ import save_picture

    task = ot.TrajectoryTask(POINTS, LIMITS, family=StopAndGo())
    result = ot.solve(task, "ipopt")
    assert result.trajectory is not None and result.trajectory.family == "stop-and-go"
    save_picture(motion_picture(task, result.trajectory), tmp_path / "motion.png")
    assert (tmp_path / "motion.png").stat().st_size > 1000


def test_an_own_family_is_compared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    monkeypatch.setitem(FAMILIES, "stop-and-go", StopAndGo())
    case = tmp_path / "stops.toml"
    case.write_text(CASE, encoding="utf-8")
    solvers = ("ipopt", "pso[encoding=scaled]")
    plan = Plan(
        (CaseChoice(str(case)),),
        solvers,
        seeds=1,
        budgets=(300,),
        references=False,
        runner="test_own_family:run",
    )
    compare(plan, tmp_path / "study")
    with Store(tmp_path / "study") as store:
        rows = {row.solver: row.record for row in store.rows()}
    assert set(rows) == set(solvers)
    least = stops(POINTS[:, :1], np.array([1.0]), np.array([2.0]))
    for record in rows.values():
        assert record.feasible, record.message
        assert record.duration == pytest.approx(least, rel=2e-2)
