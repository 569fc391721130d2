"""Every row of the lifted form, its bounds and its label, against values worked out apart (`helpers.row_oracle`).

Both sides of every limit are tried, asymmetric, in the gap they belong to.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from helpers.lifted_rows import (
    EXTRA,
    SAMPLES,
    Row,
    compare,
    continuity_rows,
    derivative_rows,
    instant_rows,
    linear_rows,
    states_near,
    told_rows,
    variables,
)
from helpers.row_oracle import (
    DEGREES,
    GAPS,
    custom_function,
    custom_values,
    make_task,
    unconnected,
)
from ocp_traj.task import (
    CustomConstraint,
    Limits,
    Objective,
)
from ocp_traj.transcription import initial_guess
from ocp_traj.transcription.lifted.lifted import ExtraPoints, LiftedNlp


@pytest.mark.parametrize("meets", [True, False])
@pytest.mark.parametrize(("family", "knots"), [("cubic", 0), ("cubic", 2), ("quintic", 1), ("septic", 0)])
def test_every_row_has_the_value_and_the_bounds_worked_out_apart(
    arm: Any, family: str, knots: int, meets: bool
) -> None:
    degree, rng = DEGREES[family], np.random.default_rng(3)
    task = make_task(arm, family, knots)
    nlp = LiftedNlp(task, initial_guess(task), SAMPLES, EXTRA)
    durations, motion = states_near(rng, degree, nlp.layout.segments)
    if not meets:
        states = motion.knots * rng.uniform(0.8, 1.2, motion.knots.shape)
        motion = unconnected(degree, durations, states)
    rows = derivative_rows(nlp, motion, EXTRA) + linear_rows(nlp, motion) + continuity_rows(nlp, motion)
    rows += instant_rows(nlp, motion, arm, EXTRA)
    compare(told_rows(nlp, variables(nlp, motion)), rows)
    if meets:
        assert all(abs(row[4]) < 1e-8 for row in continuity_rows(nlp, motion))


@pytest.mark.parametrize(("lower", "upper"), [(0.0, np.inf), (-np.inf, 0.0), (0.0, 0.0)])
def test_a_limit_of_zero_is_no_unit(arm: Any, lower: float, upper: float) -> None:
    own = CustomConstraint("own", custom_function(), lower, upper)
    task = make_task(arm, "cubic", limits=Limits(torque=np.inf), constraints=(own,), objective=Objective())
    nlp = LiftedNlp(task, initial_guess(task), SAMPLES, ExtraPoints())
    _, motion = states_near(np.random.default_rng(5), 3, GAPS)
    rows: list[Row] = []
    for segment, fraction in [
        *[(s, k / SAMPLES) for s in range(GAPS) for k in range(SAMPLES)],
        (GAPS - 1, 1.0),
    ]:
        values = custom_values(arm, *motion.state(segment, fraction))
        rows += [("custom", -1, segment, fraction, value, lower, upper) for value in values]
    compare([row for row in told_rows(nlp, variables(nlp, motion)) if row[0] == "custom"], rows)
