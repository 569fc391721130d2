"""What `solve` gives back: the contract's JSON, the audit's verdict, and motions made exact by uniform scaling."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np
import pytest

import ocp_traj as ot
from metaheuristics import Solution, Status
from ocp_traj.exceptions import UnknownNameError
from ocp_traj.solvers import Outcome, Request, Solver
from ocp_traj.solving import MENDING_ROUNDS, judge, solve
from ocp_traj.task import Limits, Objective, TrajectoryTask
from ocp_traj.trajectory_files import from_json
from ocp_traj.transcription import CondensedNlp, trajectory_from_durations

KEYS = {
    "schema", "case", "solver", "seed", "status", "message", "feasible", "objective", "duration", "energy",
    "segment_durations", "worst", "evaluations", "build_time", "solve_time", "references", "trajectory", "versions",
}  # fmt: skip


def simple_task(**changes) -> TrajectoryTask:
    return TrajectoryTask(
        [[0.0], [1.0], [0.5]], Limits(velocity=2.0, acceleration=4.0), name="simple", **{"virtual_knots": 0, **changes}
    )


def outcome_of(task: TrajectoryTask, durations, status=Status.CONVERGED, message="I am perfect") -> Outcome:
    nlp = CondensedNlp(task)
    solution = Solution(
        problem=nlp,
        x=np.asarray(durations),
        cost=float(np.sum(durations)),
        violation=np.zeros(1),
        status=status,
        message=message,
        evaluations=1,
    )
    return Outcome(trajectory_from_durations(task, durations), solution)


def test_the_result_as_json_has_the_contracts_keys_and_finite_numbers():
    result = solve(simple_task())
    written = result.to_json()
    assert set(written) >= KEYS
    json.dumps(written, allow_nan=False)
    assert written["feasible"] is True
    assert written["energy"] is None
    assert written["status"] == "converged"
    assert sum(written["segment_durations"]) == pytest.approx(written["duration"])
    again = from_json(written["trajectory"])
    np.testing.assert_array_equal(again.breakpoints, result.trajectory.breakpoints)


def test_a_motion_over_its_limits_by_less_than_two_percent_is_slowed_into_them():
    task = simple_task()
    best = solve(task)
    fast = best.segment_durations / 1.01
    result = judge(task, "lucky", 0, outcome_of(task, fast))
    assert result.feasible
    assert result.scaled_by == pytest.approx(1.01, rel=1e-3)
    assert result.duration == pytest.approx(best.duration, rel=1e-3)


def test_a_motion_far_over_its_limits_is_not_made_another_motion():
    task = simple_task()
    fast = solve(task).segment_durations / 1.5
    result = judge(task, "liar", 0, outcome_of(task, fast))
    assert not result.feasible
    assert result.scaled_by == 1.0
    assert "acceleration" in result.message
    assert "joint 1" in result.message


def test_a_solver_without_a_motion_is_no_success():
    task = simple_task()
    solution = outcome_of(task, [1.0, 1.0], Status.FAILED, "nothing found").solution
    result = judge(task, "empty", 0, Outcome(None, solution, diagnosis="no start"))
    assert not result.feasible
    written = result.to_json()
    assert written["trajectory"] is None
    assert written["duration"] is None
    assert written["segment_durations"] == []
    assert written["message"] == "nothing found no start"


def test_a_solver_of_ones_own_is_asked_like_any_other():
    class Halves(Solver):
        kind = "population"

        def run(self, task: TrajectoryTask, request: Request) -> Outcome:
            return outcome_of(task, np.full(task.gaps, 5.0 + request.seed))

    result = solve(simple_task(), Halves(), seed=2)
    assert result.feasible
    assert result.duration == pytest.approx(14.0)
    assert result.solver == "Halves"


def test_starting_from_a_better_motion_never_loses_it():
    task = simple_task(virtual_knots=1)
    best = solve(task)
    again = solve(task, "ipopt", warm_start=best.trajectory)
    assert again.duration <= best.duration


def test_an_unknown_solver_is_refused_with_the_names_there_are():
    with pytest.raises(UnknownNameError, match=r"'nope' is unknown, expected one of ipopt"):
        solve(simple_task(), "nope")


def test_a_result_prints_its_verdict_and_its_cost():
    result = solve(simple_task())
    words = str(result)
    assert "feasible by the audit" in words
    assert "evaluations" in words
    assert "<pre>" in result._repr_html_()


def test_the_contracts_first_program_runs():
    task = ot.load_case("machines-2024-490")
    result = ot.solve(task, "ipopt", seed=0)
    assert result.duration == pytest.approx(4.3104, abs=1e-4)
    assert result.trajectory([0.0, 1.0], derivative=1).shape == (2, 6)
    verdict = ot.audit(task, result.trajectory)
    assert verdict.feasible
    assert verdict.worst is not None
    nlp = ot.transcribe(task, form="condensed", encoding="durations")
    evaluation = nlp.evaluate(np.full((5, nlp.dimension), 2.0))
    assert evaluation.cost.shape == (5,)
    assert evaluation.violation.shape[0] == 5
    assert (evaluation.violation >= 0).all()
    assert nlp.g.numel() == evaluation.violation.shape[1]


def test_toppra_gives_no_start_where_waypoints_repeat():
    """Its path leaves repeated waypoints out, so it has fewer gaps than the task."""
    from ocp_traj.solvers.gradient.starts import toppra_durations

    limits = Limits(velocity=1.0, acceleration=2.0)
    task = TrajectoryTask([[0.0], [1.0], [2.0]], limits)
    assert toppra_durations(task).shape == (2,)
    assert toppra_durations(TrajectoryTask([[0.0], [1.0], [1.0], [2.0]], limits)) is None


@pytest.mark.filterwarnings("error")
def test_limits_are_drawn_in_but_not_beyond_the_waypoints():
    from ocp_traj.solvers.mending import tightened

    position = [[-1.0, -np.inf, -np.inf], [1.05, 2.0, np.inf]]
    limits = Limits(velocity=1.0, acceleration=4.0, position=position)
    drawn_in = tightened(TrajectoryTask([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]], limits), 0.1)
    np.testing.assert_allclose(drawn_in.position, [[[-0.795, -np.inf, -np.inf], [1.0, 1.8, np.inf]]])
    np.testing.assert_allclose(drawn_in.get("acceleration"), 3.6 * np.array([[[-1.0] * 3, [1.0] * 3]]))


def test_a_second_solve_gets_what_is_left_of_budget_and_time():
    rest = Request(3, 27, 1000.0).less(20, 1.5)
    assert (rest.seed, rest.budget, rest.time_limit, rest.exhausted()) == (3, 7, 998.5, None)
    assert Request(3, 20).less(20, 1.5).exhausted() is Status.BUDGET_EXHAUSTED
    assert Request(3, 21).less(20, 1.5).exhausted() is None
    assert Request(3, 21).less(20, 1.5).exhausted(2) is Status.BUDGET_EXHAUSTED
    assert Request(3, None, 1.5).less(20, 1.5).exhausted() is Status.TIME_EXHAUSTED
    endless = Request(3).less(20, 1.5)
    assert endless.budget is None and endless.time_limit is None and endless.exhausted(10**9) is None


@dataclass(frozen=True)
class Overlooks(Solver):
    """Answers with prepared durations: the first ones cold, the second ones when it is asked to go on."""

    kind: ClassVar[str] = "gradient"

    cold: tuple[float, ...] = ()
    warm: tuple[float, ...] = ()
    asked: list[tuple[TrajectoryTask, Request]] = field(default_factory=list)

    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        self.asked.append((task, request))
        found = outcome_of(task, self.cold if request.warm_start is None else self.warm)
        solution = replace(found.solution, evaluations=10, solve_time=0.25)
        return replace(found, solution=solution, counts={"nlp_f": 3})


def test_a_converged_motion_a_little_over_its_limits_is_solved_again_with_tighter_ones():
    """Slowing mends no position, so a converged answer 1 % beyond one is taken up again."""
    low, high = (1.2, 0.8), (0.8, 1.2)
    peaks = [
        trajectory_from_durations(simple_task(), h)(np.linspace(0, 2, 20_001)).max() for h in (low, high)
    ]
    good, bad = (low, high) if peaks[0] < peaks[1] else (high, low)
    position = [[-1.0], [max(peaks) / 1.01]]
    assert min(peaks) < position[1][0]
    limits = Limits(velocity=20.0, acceleration=40.0, position=position)
    task = TrajectoryTask([[0.0], [1.0], [0.5]], limits)

    solver = Overlooks(cold=bad, warm=good)
    result = solve(task, solver, budget=100)
    assert result.feasible and result.segment_durations == pytest.approx(good)
    (_, first), (again, rest) = solver.asked
    assert first.warm_start is None and rest.warm_start is not None and rest.budget == 90
    assert (again.limits.get("velocity") == task.limits.get("velocity")).all()  # only what is broken is drawn in
    assert 1.0 <= again.limits.position[0, 1, 0] < position[1][0]
    assert result.solution.evaluations == 20 and result.counts == {"nlp_f": 6}
    assert result.solution.solve_time >= 0.5
    np.testing.assert_array_equal(result.task.limits.position, task.limits.position)

    stubborn = Overlooks(cold=bad, warm=bad)
    result = solve(task, stubborn)
    assert len(stubborn.asked) == 1 + MENDING_ROUNDS
    assert result.feasible and result.status == "stalled"  # by the slow motion that rest-to-rest tasks have
    assert "The motion is a slow one, made without solving" in result.message
    drawn_in = [asked.limits.position[0, 1, 0] for asked, _ in stubborn.asked]
    assert drawn_in == sorted(drawn_in, reverse=True) and drawn_in[2] < drawn_in[1]  # a little more each time

    spent = Overlooks(cold=bad, warm=good)
    assert solve(task, spent, budget=10).status == "stalled" and len(spent.asked) == 1


def test_a_septic_rests_a_moment_at_a_point_given_twice():
    """Nothing but rounding keeps such a segment from vanishing, and its derivatives from growing without bound."""
    points = [2.4344, -4.3653, -5.1774, -3.5905, -5.3214, -5.3214, 2.5587, 4.0902, -3.9814, -1.5353]
    limits = Limits(position=[[-13.6], [9.5]], velocity=0.119, acceleration=3.6e-3)
    bounds = [[0.0, np.inf]] * 4 + [[0.0, 1e4]] + [[0.0, np.inf]] * 4  # without, equal points are passed once
    objective = Objective(gap_durations=bounds)
    task = TrajectoryTask(np.array(points)[:, None], limits, family="septic", objective=objective)
    result = solve(task)
    assert result.feasible, result.diagnosis
    rest = result.trajectory.segment_durations[4]
    assert 1e-3 < rest / result.duration < 1e-2
