"""A user's own limit: its scale divides its bounds, once, in both forms and in the audit."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from helpers.row_oracle import (
    GAPS,
    custom_function,
    make_task,
)
from ocp_traj.audit import audit
from ocp_traj.task import CustomConstraint, Limits, TrajectoryTask
from ocp_traj.transcription import transcribe


def test_bounds_of_a_custom_limit_are_divided_by_its_scale(arm: Any) -> None:
    from ocp_traj.limits.custom import CustomLimit, custom_scale

    function = custom_function()
    given = CustomConstraint("own", function, [-4.0, -np.inf], [8.0, 2.0], scale=0.5)
    plain = CustomConstraint("own", function, [-4.0, -np.inf], [3.0, 2.0])
    none = CustomConstraint("own", function, 0.0, np.inf)
    assert [custom_scale(each) for each in (given, plain, none)] == [0.5, 4.0, 1.0]
    task = make_task(arm, "cubic", constraints=(given, plain, none))
    limit = CustomLimit()
    assert limit.joints(task) == [-1] * 6
    bounds = [[-8.0, -np.inf, -1.0, -np.inf, 0.0, 0.0], [16.0, 4.0, 0.75, 0.5, np.inf, np.inf]]
    np.testing.assert_array_equal(limit.bounds(task), [bounds] * GAPS)
    assert not limit.applies(make_task(arm, "cubic", constraints=()))
    np.testing.assert_array_equal(limit.scales(task), np.ones((GAPS, 6)))  # and by nothing else


@pytest.mark.parametrize("scale", [None, 2.0, 100.0])
def test_a_custom_limit_is_over_by_its_own_scale_in_both_forms_and_the_audit(scale: float | None) -> None:
    q, v, a, tau = (ca.SX.sym(name, 1) for name in ("q", "v", "a", "tau"))
    top = CustomConstraint("own", ca.Function("own", [q, v, a, tau], [q]), -0.5, 0.5, scale)
    task = TrajectoryTask([[0.0], [1.5], [0.0]], Limits(velocity=1.0), constraints=(top,))
    over = 1.0 / (scale or 0.5)  # the waypoint itself
    condensed, lifted = transcribe(task, "condensed"), transcribe(task, "lifted")
    found = [float(nlp.evaluate(np.asarray(nlp.guess)[None]).violation.max()) for nlp in (condensed, lifted)]
    assert found == pytest.approx([over, over], rel=1e-6)
    verdict = audit(task, condensed.decode(np.asarray(condensed.guess)))
    assert verdict.worst is not None and verdict.worst.ratio == pytest.approx(1.0 + over, rel=1e-6)
