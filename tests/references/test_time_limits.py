"""References keep a time limit and say what they left undone; clocks are the tests' own, so no machine is too slow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from ocp_traj.cli.main import run
from ocp_traj.deadline import NO_DEADLINE, Deadline
from ocp_traj.exceptions import InputError
from ocp_traj.references import collect_references, summary
from ocp_traj.references.bounds import kinematic_bound as bounds
from ocp_traj.references.bounds.double_integrator import least_total, shortest_total
from ocp_traj.references.bounds.kinematic_estimate import LocalSearch, local_optimum, stop_durations
from ocp_traj.references.bounds.kinematic_proof import prove_lower
from ocp_traj.references.reference import Reference, ReferenceFinding, ReferenceRequest
from ocp_traj.references.timing import convex_reference as convex
from ocp_traj.references.timing.jerk_limited_reference import jerk_limited_reference
from ocp_traj.references.timing.result import ReferenceResult
from ocp_traj.references.timing.toppra_reference import refine, toppra_reference
from ocp_traj.task import Limits, TrajectoryTask

LIMITS = Limits(velocity=1.0, acceleration=2.0)


@dataclass
class Clock:
    """A clock that stands still but for what is added to it, s."""

    now: float = 0.0
    asked: list[float] = field(default_factory=list)

    def __call__(self) -> float:
        return self.now


def zigzag(waypoints: int, joints: int = 2, **limits: float) -> TrajectoryTask:
    rng = np.random.default_rng(waypoints)
    points = rng.uniform(-1.0, 1.0, (waypoints, joints))
    return TrajectoryTask(points, Limits(velocity=1.0, acceleration=2.0, **limits), name="zigzag")


def test_a_deadline_counts_down_on_its_clock() -> None:
    clock = Clock(100.0)
    deadline = Deadline(10.0, clock)
    clock.now = 104.0
    assert (deadline.spent, deadline.left, deadline.passed) == (4.0, 6.0, False)
    assert deadline.fraction(0.5).left == 3.0
    clock.now = 111.0
    assert (deadline.left, deadline.passed) == (0.0, True)
    assert str(deadline) == "10 s"
    assert NO_DEADLINE.left == np.inf and not NO_DEADLINE.passed


def test_no_grid_is_begun_that_would_not_end_in_time() -> None:
    clock, asked = Clock(), []

    def solve(cells: int) -> ReferenceResult:
        asked.append(cells)
        clock.now += cells / 100.0  # 2 s for the first grid
        return ReferenceResult("toppra", "mine", 1.0 + 1.0 / cells)

    result = refine(solve, 1e-9, None, Deadline(15.0, clock))  # 2 + 4 + 8 s, then 16 s
    assert asked == [200, 400, 800] and clock.now <= 15.0
    assert result.duration == 1.0 + 1.0 / 800
    assert "allowed for 800 cells only" in result.reason


def test_a_failure_in_time_is_told_with_the_grid_it_is_of() -> None:
    clock = Clock()

    def solve(cells: int) -> ReferenceResult:
        clock.now += 2.0
        return ReferenceResult("toppra", "mine", None, "no speed exists")

    result = refine(solve, 1e-9, None, Deadline(3.0, clock))
    assert result.duration is None and result.reason.startswith("no speed exists (with 200 cells")


def test_without_time_no_path_is_begun() -> None:
    task = zigzag(4, jerk=20.0)
    for method in (toppra_reference, convex.convex_reference, jerk_limited_reference):
        result = method(task, "chord", time_limit=0.0)
        assert result.duration is None and "time limit" in result.reason


def test_the_convex_problem_takes_the_cells_there_is_time_for(monkeypatch: pytest.MonkeyPatch) -> None:
    def fastest(task: TrajectoryTask, path: str, **_: object) -> ReferenceResult:
        """TOPP-RA at a pace of 1 ms a cell."""
        return ReferenceResult("toppra", path, 1.0, s=np.linspace(0, 1, 400), points=400, solve_time=0.4)

    task = zigzag(4)
    monkeypatch.setattr(convex, "toppra_reference", fastest)
    limit = 150 * convex.WORK * 1e-3
    fine = convex.convex_reference(task, "chord", time_limit=limit + 1e4)
    assert fine.points == 400 and not fine.reason
    monkeypatch.setattr(convex, "best_backend", lambda: "COO")
    monkeypatch.setattr(convex, "Deadline", lambda seconds: Deadline(seconds, Clock()))
    few = convex.convex_reference(task, "chord", time_limit=limit)
    assert few.points in (149, 150) and few.duration == pytest.approx(fine.duration, rel=1e-2)
    assert "of 400 cells" in few.reason
    none = convex.convex_reference(task, "chord", time_limit=0.2 * limit)
    assert none.duration is None and "do not allow for the convex problem" in none.reason


def test_no_start_of_the_estimate_is_made_that_would_not_end_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    from ocp_traj.references.bounds import kinematic_estimate

    clock, starts = Clock(), []
    solve = kinematic_estimate.EstimateProblem.solve

    def slow(problem: object, guess: np.ndarray) -> object:
        starts.append(guess)
        clock.now += 3.0
        return solve(problem, guess)  # type: ignore[arg-type]

    monkeypatch.setattr(kinematic_estimate.EstimateProblem, "solve", slow)
    _, limits, _ = bounds.joint_limits(zigzag(3))
    found = local_optimum(limits, LocalSearch(8, np.random.default_rng(0), Deadline(10.0, clock)))
    assert len(starts) == 3 and found is not None
    assert found.total <= stop_durations(limits).sum()


def test_a_proof_without_time_still_bounds_by_full_speed() -> None:
    _, limits, _ = bounds.joint_limits(zigzag(6))
    stops = float(stop_durations(limits).sum())
    outcome = prove_lower(limits, stops, 2e-3, Deadline(0.0, Clock()), 1000)
    assert outcome.nodes == 0 and 0.0 < outcome.lower < stops


def test_many_totals_at_once_give_what_bisection_gives() -> None:
    _, limits, _ = bounds.joint_limits(zigzag(6))
    proportions = stop_durations(limits) / stop_durations(limits).sum()
    largest = 2.0 * float(stop_durations(limits).sum())
    one_by_one = float(shortest_total(limits, proportions[None, :], largest)[0])
    assert least_total(limits, proportions, largest, NO_DEADLINE) == pytest.approx(one_by_one, rel=1e-12)
    assert least_total(limits, proportions, 0.01 * largest, NO_DEADLINE) == np.inf
    hurried = least_total(limits, proportions, largest, Deadline(0.0, Clock()))
    assert one_by_one <= hurried <= one_by_one * (1 + 1e-3)


def test_references_share_one_limit_and_the_patient_one_comes_last(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, given = Clock(), []

    def taking(name: str, seconds: float) -> Callable[[ReferenceRequest], ReferenceFinding]:
        def find(request: ReferenceRequest) -> ReferenceFinding:
            given.append((name, request.time_limit))
            clock.now += min(seconds, request.time_limit)
            return ReferenceFinding({"a": 1.0})

        return find

    known = (
        Reference("patient", "", taking("patient", np.inf), patient=True),
        Reference("quick", "", taking("quick", 1.0)),
        Reference("greedy", "", taking("greedy", np.inf)),
    )
    monkeypatch.setattr(summary, "all_references", lambda: known)
    monkeypatch.setattr(summary, "Deadline", lambda seconds: Deadline(seconds, clock))
    found = collect_references(zigzag(3), time_limit=10.0)
    assert given == [("quick", pytest.approx(10 / 3)), ("greedy", 4.5), ("patient", 4.5)]
    assert clock.now == 10.0 and list(found.findings) == ["patient", "quick", "greedy"]
    given.clear()
    collect_references(zigzag(3))
    assert sum(seconds for _, seconds in given[1:]) == pytest.approx(summary.USUAL_SECONDS - 1.0)
    with pytest.raises(InputError, match="expected a positive number of seconds"):
        collect_references(zigzag(3), time_limit=0.0)


def test_the_command_takes_a_limit(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["reference", "fang-2020-task-1", "--time-limit", "1e-6"]) == 0
    assert "the time limit left no time for this path" in " ".join(capsys.readouterr().out.split())
    assert run(["reference", "fang-2020-task-1", "--time-limit", "0"]) == 2
