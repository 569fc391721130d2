"""A limit and costs from outside the package are read, solved, judged, compared and drawn like those inside."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

import ocp_traj as ot
from helpers import own_quantities
from ocp_traj.audit.costs import objective_value
from ocp_traj.audit.measures import COST_MEASURES, LIMIT_MEASURES
from ocp_traj.case import load_case, task_digest
from ocp_traj.case.writing import dumps
from ocp_traj.comparison.runs.compare import compare
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.comparison.runs.store import Store
from ocp_traj.exceptions import CaseError, InputError, TaskError
from ocp_traj.pareto import pareto_front
from ocp_traj.pictures.motion import motion_picture
from ocp_traj.pictures.svg import draw_picture
from ocp_traj.transcription import CondensedNlp, ExtraPoints, LiftedNlp

WAYPOINTS = np.deg2rad([[0, -90, 90, 0, 0, 0], [40, -60, 60, 20, 30, 0], [60, -100, 80, 0, 0, 30]])
POWER = 30.0

CASE = """
schema = 1
name = "own-power"
[robot]
model = "ur5"
[waypoints]
unit = "deg"
joints = [[0, -90, 90, 0, 0, 0], [40, -60, 60, 20, 30, 0], [60, -100, 80, 0, 0, 30]]
[limits]
velocity = 3.0
acceleration = 8.0
power = 30.0
[objective]
time = 1.0
squared_speed = 0.05
"""


@pytest.fixture(autouse=True)
def everything_registered() -> Iterator[None]:
    with own_quantities.registered():
        yield


def make_task(power: float | None = POWER, **changes: object) -> ot.TrajectoryTask:
    others = {} if power is None else {"power": power}
    limits = ot.Limits(velocity=3.0, acceleration=8.0, others=others)
    return ot.TrajectoryTask(WAYPOINTS, limits, ot.load_robot("ur5"), virtual_knots=1, **changes)  # type: ignore[arg-type]


def powers(task: ot.TrajectoryTask, trajectory: ot.Trajectory, count: int = 20_001) -> np.ndarray:
    """Return the power of every joint on a dense grid, W, by Pinocchio's inverse dynamics."""
    t = np.linspace(0.0, trajectory.duration, count)
    q, v, a = (trajectory(t, order) for order in range(3))
    assert task.robot is not None
    return np.asarray(task.robot.torque(q, v, a) * v)


@pytest.mark.parametrize("solver", ["ipopt", "pso"])
def test_a_solver_keeps_the_limit_where_it_decides_the_time(solver: str) -> None:
    free, limited = (ot.solve(make_task(power), solver, seed=0, budget=3000) for power in (None, POWER))
    assert free.feasible and limited.feasible and limited.trajectory is not None
    assert np.abs(powers(free.task, free.trajectory)).max() > 1.2 * POWER
    assert np.abs(powers(limited.task, limited.trajectory)).max() <= POWER * (1 + 1e-6)
    assert limited.audit is not None and limited.audit.limits["power"].ratio > 0.8


def test_the_judge_finds_the_peak_and_the_slowing_that_mends_it() -> None:
    free = ot.solve(make_task(None), "ipopt")
    task = make_task()
    verdict = ot.audit(task, free.trajectory)
    peak = verdict.limits["power"]
    dense = np.abs(powers(task, free.trajectory))
    assert not verdict.feasible and peak.ratio >= dense.max() / POWER * (1 - 1e-9)
    assert peak.ratio == pytest.approx(dense.max() / POWER, rel=1e-5)
    assert peak.joint == int(dense.max(axis=0).argmax())
    assert "W" in str(peak) and f"{POWER:.9g}" in str(peak)
    scale = verdict.smallest_feasible_scale
    assert scale is not None and scale > 1.0
    assert ot.audit(task, free.trajectory.scaled(scale)).feasible
    assert not ot.audit(task, free.trajectory.scaled(scale * (1 - 1e-5))).feasible


@pytest.mark.parametrize("name", ["squared_speed", "braking"])
def test_a_cost_is_minimised_and_the_judge_measures_it_by_itself(name: str) -> None:
    duration = 1.3 * float(ot.solve(make_task(None), "ipopt").duration)
    fixed = {"duration": (duration, duration)}
    priced = ot.solve(make_task(None, objective=ot.Objective(others={name: 2.0}, **fixed)), "ipopt")
    other = ot.solve(make_task(None, objective=ot.Objective(jerk=1.0, **fixed)), "ipopt")
    assert priced.feasible and other.feasible
    task, trajectory = priced.task, priced.trajectory

    def integrand(t: float) -> float:
        q, v, a = (trajectory(np.array([t]), order) for order in range(3))
        if name == "squared_speed":
            return float((v**2).sum())
        assert task.robot is not None
        return float(np.maximum(-task.robot.torque(q, v, a) * v, 0.0).sum())

    edges = np.linspace(0.0, trajectory.duration, 400)
    value = sum(quad(integrand, *pair, limit=20)[0] for pair in zip(edges[:-1], edges[1:]))
    assert priced.objective == pytest.approx(2.0 * value, rel=1e-6)
    assert objective_value(task, other.trajectory) > 1.001 * priced.objective


def test_all_forms_give_the_same_value_of_a_cost() -> None:
    task = make_task(None, objective=ot.Objective(time=1.0, others={"squared_speed": 0.1}))
    plain = CondensedNlp(task, samples=64)
    trajectory = plain.decode(plain.guess)
    expected = objective_value(task, trajectory)
    assert plain.evaluate(plain.guess).cost[0] == pytest.approx(expected, rel=1e-7)
    lifted = LiftedNlp(task, trajectory, 64, ExtraPoints())
    assert lifted.evaluate(lifted.layout.encode(trajectory)).cost[0] == pytest.approx(expected, rel=1e-7)


def test_the_scaled_encoding_uses_the_law_a_cost_states_and_refuses_what_states_none() -> None:
    task = make_task(None, objective=ot.Objective(time=1.0, others={"squared_speed": 0.1}))
    scaled = CondensedNlp(task, encoding="scaled", samples=64)
    best = scaled.decode(scaled.guess)
    costs = [objective_value(task, best.scaled(factor)) for factor in (1.0, 1.05, 1.2)]
    assert scaled.evaluate(scaled.guess).cost[0] == pytest.approx(costs[0], rel=1e-7)
    assert costs[0] <= min(costs) + 1e-9
    with pytest.raises(InputError, match="does not know how power scales, expected encoding 'durations'"):
        CondensedNlp(make_task(), encoding="scaled")
    with pytest.raises(InputError, match="does not know how cost braking scales"):
        CondensedNlp(make_task(None, objective=ot.Objective(others={"braking": 1.0})), encoding="scaled")


def test_a_case_file_names_them_and_reads_back_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(CASE)
    task = load_case(path)
    np.testing.assert_array_equal(task.limits.get("power")[0], [[-POWER] * 6, [POWER] * 6])
    assert task.objective.weights == {"time": 1.0, "squared_speed": 0.05}
    path.write_text(dumps(task, tmp_path))
    assert task_digest(load_case(path)) == task_digest(task)
    digests = {task_digest(load_case(path, change)) for change in ((), ("limits.power=20.0",))}
    assert len(digests) == 2
    with pytest.raises(CaseError, match=r"limits.power: -1 given, expected a limit of 0 or more"):
        load_case(path, ("limits.power=-1.0",))


def test_a_row_that_is_registered_changes_no_digest_of_tasks_without_it() -> None:
    task = load_case("fanuc-m10id8l")
    with_rows = task_digest(task)
    assert "power" not in task.limits.names and "braking" not in task.objective.names
    own_quantities.JOINT_LIMITS.pop("power")
    try:
        assert task_digest(task) == task_digest(load_case("fanuc-m10id8l")) == with_rows
    finally:
        own_quantities.JOINT_LIMITS["power"] = own_quantities.Quantity("power", "W", needs_inertia=True)


def test_a_comparison_runs_them_and_a_picture_shows_the_limit(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(CASE)
    plan = Plan(
        (CaseChoice(str(path)),),
        ("ipopt", "pso"),
        seeds=1,
        budgets=(1000,),
        references=False,
        runner="helpers.own_quantities:run",
    )
    compare(plan, tmp_path / "study")
    with Store(tmp_path / "study") as store:
        rows = {row.solver: row.record for row in store.rows()}
    assert set(rows) == {"ipopt", "pso"}
    assert all(record.feasible for record in rows.values()), [record.message for record in rows.values()]
    result = ot.solve(load_case(path), "ipopt", seed=0)
    assert rows["ipopt"].objective == pytest.approx(result.objective, rel=1e-6)
    for relative in (False, True):
        picture = motion_picture(result.task, result.trajectory, relative)
        panel = next(panel for panel in picture.panels if panel.title == "Power")
        shown = np.abs(np.concatenate([line.y for line in panel.lines if not line.dashed])).max()
        largest = np.abs(powers(result.task, result.trajectory)).max() / (POWER if relative else 1.0)
        assert shown == pytest.approx(largest, rel=2e-2)
        assert "Power" in draw_picture(picture)


def test_the_front_takes_a_cost_by_name() -> None:
    front = pareto_front(make_task(None), points=3, objective="squared_speed")
    assert front.unit == "rad^2/s" and front.feasible.all()
    assert (np.diff(front.values) < 0).all()


def test_what_has_no_row_or_no_measure_is_refused_in_words() -> None:
    with pytest.raises(TaskError, match=r"limits.heat: is no further quantity, those known are: power"):
        ot.TrajectoryTask(WAYPOINTS, ot.Limits(others={"heat": 1.0}))
    with pytest.raises(TaskError, match=r"limits.velocity: is no further quantity"):
        ot.TrajectoryTask(WAYPOINTS, ot.Limits(others={"velocity": 1.0}))
    with pytest.raises(TaskError, match=r"objective.heat: is no further cost, those known are: braking"):
        ot.TrajectoryTask(WAYPOINTS, objective=ot.Objective(others={"heat": 1.0}))
    with pytest.raises(TaskError, match=r"limits.power: needs a robot with inertia"):
        ot.TrajectoryTask(WAYPOINTS, ot.Limits(velocity=1.0, others={"power": 1.0}))
    with pytest.raises(TaskError, match=r"objective.braking: needs a robot with inertia"):
        ot.TrajectoryTask(WAYPOINTS, ot.Limits(velocity=1.0), objective=ot.Objective(others={"braking": 1.0}))
    motion = ot.solve(make_task(None), "ipopt").trajectory
    measure = LIMIT_MEASURES.pop("power"), COST_MEASURES.pop("braking")
    try:
        with pytest.raises(InputError, match=r"limits.power: the judge has no measure of it"):
            ot.audit(make_task(), motion)
        with pytest.raises(InputError, match=r"objective.braking: the judge has no measure of it"):
            objective_value(make_task(None, objective=ot.Objective(others={"braking": 1.0})), motion)
    finally:
        LIMIT_MEASURES["power"], COST_MEASURES["braking"] = measure
