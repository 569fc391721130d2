"""One start: the stages of virtual knots, the motion that is started from, and points added between samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ocp_traj.exceptions import InputError
from ocp_traj.solvers import Request
from ocp_traj.solvers.gradient.account import Account
from ocp_traj.solvers.gradient.attempt import attempt, continuation, fit_guess, loosened
from ocp_traj.solvers.gradient.settings import GradientSettings
from ocp_traj.spline import get_family
from ocp_traj.task import Limits, TrajectoryTask
from ocp_traj.transcription import initial_guess

SETTINGS = GradientSettings(compiled=False)


def task(**changes: object) -> TrajectoryTask:
    limits = Limits(velocity=2.0, acceleration=4.0)
    return TrajectoryTask([[0.0, 0.0], [1.0, 0.5], [0.5, 1.0]], limits, **{"virtual_knots": 0, **changes})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("family", "knots", "stages"),
    [
        ("cubic", 0, [0]),
        ("cubic", 1, [1]),
        ("cubic", 3, [1, 3]),
        ("cubic", 15, [1, 7, 15]),
        ("cubic", 40, [1, 4, 9, 19, 40]),
        ("quintic", 0, [0]),
        ("quintic", 2, [0, 2]),
        ("septic", 15, [0, 7, 15]),
    ],
)
def test_few_knots_come_first_and_the_number_wanted_last(family: str, knots: int, stages: list[int]) -> None:
    assert continuation(get_family(family), knots) == stages


def test_a_motion_of_the_same_form_is_started_from_as_it_is() -> None:
    motion = initial_guess(task())
    assert fit_guess(task(), motion) is motion
    finer = fit_guess(task(virtual_knots=3), motion)
    assert len(finer.breakpoints) == 4 * 2 + 1
    times = np.linspace(0.0, motion.duration, 50)
    np.testing.assert_allclose(finer(times), motion(times), atol=1e-9)


def test_of_a_motion_of_another_family_the_timing_is_kept() -> None:
    motion = initial_guess(task(family="quintic"), np.array([1.0, 2.0]))
    fitted = fit_guess(task(), motion)
    assert fitted.family == "cubic"
    assert np.divide(*fitted.segment_durations) == pytest.approx(0.5)


def test_a_motion_through_other_waypoints_is_refused() -> None:
    other = TrajectoryTask([[0.0, 0.0], [1.0, 1.0]], Limits(velocity=1.0, acceleration=1.0))
    with pytest.raises(InputError, match="passes 2 waypoints, expected 3"):
        fit_guess(task(), initial_guess(other))


def test_continuation_and_warm_starts_lead_to_the_same_optimum() -> None:
    wanted = task(virtual_knots=3)
    cold = attempt(wanted, None, SETTINGS, Account(Request()), continued=True)
    warm = attempt(wanted, cold.trajectory, SETTINGS, Account(Request()), continued=False)
    assert cold.solved and warm.solved
    assert warm.trajectory.duration == pytest.approx(cold.trajectory.duration, rel=1e-5)


def test_without_rounds_no_point_is_added() -> None:
    """A position is limited at the knots only until rounds add points where it is broken."""
    points = np.array([0.0, 0.5, 1.0, 0.98, 0.3, 0.0])[:, None]
    bent = TrajectoryTask(points, Limits(velocity=20.0, acceleration=40.0, position=[[-5.0], [1.005]]), virtual_knots=0)
    highest = []
    for rounds in (0, 8):
        answer = attempt(bent, None, replace(SETTINGS, rounds=rounds), Account(Request()), continued=False)
        assert answer.solved
        times = np.linspace(0.0, answer.trajectory.duration, 2001)
        highest.append(float(answer.trajectory(times).max()))
    assert highest[0] > 1.1 and highest[1] < 1.005 + 1e-6


def test_a_loose_call_is_never_tighter_than_asked_for() -> None:
    assert loosened(SETTINGS).tolerance == SETTINGS.tuning.loose_tolerance
    assert loosened(replace(SETTINGS, tolerance=0.1)).tolerance == 0.1
