"""Certificates for the best durations of a spline family."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.references import certify
from ocp_traj.references.bounds.certify import SplineBounds, exact_total
from ocp_traj.references.bounds.enclosure import Enclosure
from ocp_traj.spline import EndConditions, get_family
from ocp_traj.task import Boundary, Limits, Objective, TrajectoryTask


def test_an_enclosure_contains_values_and_slopes() -> None:
    rng = np.random.default_rng(0)
    low = rng.uniform(0.2, 1.0, size=(50, 3))
    high = low + rng.uniform(0.0, 0.2, size=(50, 3))
    positions = [row[None, :] for row in rng.normal(size=(4, 2))]
    zero = np.zeros((1, 2))
    for name in ("cubic", "3-5-3"):
        orders = (1,) if name == "cubic" else (1, 2)
        ends = EndConditions(dict.fromkeys(orders, zero), dict.fromkeys(orders, zero))
        boxes = get_family(name).pieces(Enclosure.variables(low, high), positions, ends)
        for _ in range(5):
            h = low + rng.random(low.shape) * (high - low)
            values = get_family(name).pieces([h[:, [g]] for g in range(3)], positions, ends)
            step = 1e-6
            for piece, box in enumerate(boxes):
                for power, entry in enumerate(box.coefficients()):
                    value = np.broadcast_to(values[piece].coefficients()[power], (50, 2))
                    if not isinstance(entry, Enclosure):
                        continue
                    assert (value >= entry.low[0] - 1e-9).all() and (value <= entry.high[0] + 1e-9).all()
                    for g in range(3):
                        moved = h + step * (np.arange(3) == g)
                        other = get_family(name).pieces([moved[:, [k]] for k in range(3)], positions, ends)
                        slope = (np.broadcast_to(other[piece].coefficients()[power], (50, 2)) - value) / step
                        slack = 1e-3 * (1 + np.abs(slope))
                        assert (slope >= entry.low[1 + g] - slack).all()
                        assert (slope <= entry.high[1 + g] + slack).all()


def test_machines_optimum_is_certified(machines: TrajectoryTask) -> None:
    result = certify(machines)
    assert result.certified and result.gap <= 1.1e-3
    assert result.upper == pytest.approx(4.3104, abs=1e-4)


def test_fanuc_optimum_is_certified(fanuc: TrajectoryTask) -> None:
    result = certify(fanuc)
    assert result.certified and result.gap <= 1.1e-3
    assert result.upper == pytest.approx(1.2242, abs=2e-4)


def test_the_certified_durations_keep_the_limits(fanuc: TrajectoryTask) -> None:
    from ocp_traj.audit import audit
    from ocp_traj.transcription import trajectory_from_durations

    result = certify(fanuc, gap=0.02)
    verdict = audit(fanuc, trajectory_from_durations(fanuc, result.durations))
    assert verdict.feasible
    assert verdict.smallest_feasible_scale == pytest.approx(1.0, abs=1e-6)


def test_a_straight_cubic_is_known_in_closed_form() -> None:
    # one clamped cubic over d: peak acceleration 6 d / T^2, peak velocity 1.5 d / T
    task = TrajectoryTask(np.array([[0.0], [2.0]]), Limits(velocity=1.0, acceleration=100.0), virtual_knots=0)
    result = certify(task)
    assert result.certified
    assert result.upper == pytest.approx(3.0, rel=1e-9)


def test_no_random_durations_beat_a_certificate() -> None:
    rng = np.random.default_rng(3)
    points = rng.normal(size=(4, 2))
    task = TrajectoryTask(points, Limits(velocity=1.0, acceleration=1.5, jerk=8.0), family="cubic", virtual_knots=0)
    result = certify(task, gap=0.05)
    assert result.certified
    totals, _ = SplineBounds(task).totals(rng.dirichlet(np.ones(3), 3000))
    assert totals.min() >= result.lower
    p = result.durations / result.durations.sum()
    assert exact_total(task, SplineBounds(task), p) == pytest.approx(result.upper, rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"virtual_knots": 1}, "the task has virtual knots, certificates are for durations alone"),
        ({"boundary": Boundary(velocity=[[0.1], [0.0]])}, "the ends are not at rest"),
        ({"objective": Objective(jerk=1.0)}, "the objective is not time alone"),
        ({"objective": Objective(duration=(0.0, 9.0))}, "bounds on durations are not covered"),
        ({"limits": Limits()}, "no velocity, acceleration or jerk limit bounds the time"),
        ({"tolerance": 0.1}, "tolerances around waypoints are not covered"),
    ],
)
def test_what_is_not_covered_is_said(changes: dict[str, object], message: str) -> None:
    task = TrajectoryTask(np.array([[0.0], [1.0]]), Limits(acceleration=1.0), virtual_knots=0).changed(**changes)
    result = certify(task)
    assert result.lower is None and not result.certified and result.message == message


def test_five_gaps_are_too_many() -> None:
    result = certify(TrajectoryTask(np.arange(6.0)[:, None], Limits(acceleration=1.0), virtual_knots=0))
    assert result.message == "the task has 5 gaps, certificates are for up to 4"
