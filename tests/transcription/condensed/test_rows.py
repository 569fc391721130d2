"""Every row of the condensed form and what populations are told of it, against values worked out apart."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
import pytest

from helpers.condensed_rows import SAMPLES, candidates, grid, motion_for
from helpers.row_oracle import (
    CUSTOM_BOUNDS,
    GAPS,
    INSTANTS,
    LIMITS,
    ORDERS,
    Motion,
    instant_limits,
    larger_finite,
    make_task,
)
from ocp_traj.limits.limit import bound_scales
from ocp_traj.task import Boundary, Limits, TrajectoryTask
from ocp_traj.transcription.condensed.condensed import CondensedNlp
from ocp_traj.transcription.condensed.encodings.encoding import LARGEST_RATIO
from ocp_traj.transcription.condensed.limit_rows import LimitRows


def expected_rows(task: TrajectoryTask, robot: Any, motion: Motion, exact: bool) -> list[tuple[Any, ...]]:
    """Return (limit, joint, gap, inside, value, lower, upper) of every row in order, in units of the limit."""
    per_gap = task.virtual_knots + 1
    segments = GAPS * per_gap
    rows: list[tuple[Any, ...]] = []

    def add(
        name: str, joint: int, segment: int, fraction: float, value: float, bounds: Any, scale: float
    ) -> None:
        place = (name, joint, segment // per_gap, (segment % per_gap + fraction) / per_gap)
        rows.append((*place, value / scale, bounds[0] / scale, bounds[1] / scale))

    for name, order in ORDERS.items():
        closed = exact and (order > 0 or task.family == "cubic")
        points = [0.0, 1.0] if closed else grid(per_gap)
        table = [
            motion.extremes(order, s) if closed else motion.at(order, s, points) for s in range(segments)
        ]
        for joint in range(task.n):
            if not np.isfinite(LIMITS[name][:, :, joint]).any():
                continue
            for index, fraction in enumerate(points):
                for segment in range(segments):
                    bounds = LIMITS[name][segment // per_gap, :, joint]
                    scale = larger_finite(*bounds) if np.isfinite(bounds).any() else 1.0
                    add(name, joint, segment, fraction, table[segment][index, joint], bounds, scale)
    states = [
        np.stack([motion.at(order, s, grid(per_gap)) for order in range(4)], axis=1) for s in range(segments)
    ]
    for name in INSTANTS:
        function, bounds, joints, orders = instant_limits(robot, name)
        table = [np.array([function(*state[:orders]) for state in of_segment]) for of_segment in states]
        for k, joint in enumerate(joints):
            for index, fraction in enumerate(grid(per_gap)):
                for segment in range(segments):
                    own = bounds[segment // per_gap, :, k]
                    scale = larger_finite(*own) if np.isfinite(own).any() else 1.0
                    if name == "custom":  # one scale for all values of a function
                        scale = larger_finite(*CUSTOM_BOUNDS.ravel())
                    add(name, joint, segment, fraction, table[segment][index, k], own, scale)
    h = motion.durations.reshape(GAPS, per_gap).sum(axis=1)
    rows.append(("duration", -1, 0, 0.0, h.sum() / 5.0, 3.0 / 5.0, 1.0))
    rows.append(("duration", -1, 0, 0.0, h[0] / 0.5, 1.0, np.inf))
    rows.append(("duration", -1, 0, 0.0, h[0] / 2.0, -np.inf, 1.0))
    rows.append(("duration", -1, 1, 0.0, h[1] / 1.5, -np.inf, 1.0))
    rows.append(("duration", -1, 2, 0.0, h[2] / 0.7, 1.0, np.inf))
    return rows


@pytest.mark.parametrize(
    ("family", "knots", "boundary", "extrema"),
    [
        ("cubic", 0, Boundary(), "auto"),
        ("cubic", 1, Boundary([[0.1, -0.2, 0.3], [0.2, 0.1, -0.1]], None), "exact"),
        ("cubic", 2, Boundary(acceleration=None), "sampled"),
        ("quintic", 0, Boundary(0.0, [[0.5, 0.4, -0.3], [0.1, -0.6, 0.2]]), "auto"),
        ("quintic", 1, Boundary(0.0, None), "auto"),
        ("quintic", 1, Boundary(0.0, None, [[3.0, 2.0, -1.0], [1.0, -2.0, 4.0]]), "auto"),
        ("septic", 0, Boundary(0.0, [[0.5, 0.4, -0.3], [0.1, -0.6, 0.2]], None), "auto"),
        ("3-5-3", 0, Boundary(0.0, [[0.5, 0.4, -0.3], [0.1, -0.6, 0.2]]), "auto"),
    ],
)
def test_every_row_has_the_value_and_the_bounds_worked_out_apart(
    arm: Any, family: str, knots: int, boundary: Boundary, extrema: str
) -> None:
    task = make_task(arm, family, knots, boundary=boundary)
    nlp = CondensedNlp(task, samples=SAMPLES, extrema=extrema)
    X = candidates(nlp)
    symbols = ca.Function("g", [nlp.x], [nlp.g])
    evaluation = nlp.evaluate(X)
    for k, x in enumerate(X):
        motion = motion_for(nlp, x)
        rows = expected_rows(task, arm, motion, extrema != "sampled" and family != "septic")
        if k == 0:
            told = [
                (block.limit, joint, gap, fraction)
                for block in nlp.rows
                for joint, gap, fraction in zip(block.joint, block.gap, block.fraction)
            ]
            assert [row[:3] for row in told] == [row[:3] for row in rows]
            np.testing.assert_allclose([row[3] for row in told], [row[3] for row in rows], atol=1e-12)
        values, lower, upper = np.array([row[4:] for row in rows]).T
        np.testing.assert_allclose(nlp.g_lower, lower, rtol=1e-12)
        np.testing.assert_allclose(nlp.g_upper, upper, rtol=1e-12)
        np.testing.assert_allclose(np.array(symbols(x)).ravel(), values, rtol=1e-8, atol=1e-9)
        violation = np.maximum(np.maximum(values - upper, lower - values), 0.0)
        np.testing.assert_allclose(evaluation.violation[k], violation, rtol=1e-8, atol=1e-9)
        assert evaluation.cost[k] == pytest.approx(motion.durations.sum())
    assert (evaluation.violation > 1e-3).any(axis=0).sum() > 30  # the comparison is not of zeros


@pytest.mark.parametrize("encoding", ["durations", "log-durations"])
def test_the_box_of_gaps_is_the_case_s_and_shares_and_offsets_have_their_own(arm: Any, encoding: str) -> None:
    nlp = CondensedNlp(make_task(arm, "cubic", 2), encoding=encoding)
    turned = np.log if encoding == "log-durations" else np.asarray
    beside = [*[np.log(LARGEST_RATIO)] * 6, *[nlp.task.search.offset] * 18]
    np.testing.assert_allclose(nlp.lower, [*[turned(0.25)] * 3, *(-np.array(beside))])
    np.testing.assert_allclose(nlp.upper, [*[turned(1.5)] * 3, *beside])
    assert nlp.dimension == 27
    x = candidates(nlp, 1)[0]
    np.testing.assert_allclose(nlp.encode(nlp.decode(x)), x, atol=1e-9)


def test_whatever_is_over_a_limit_of_zero_is_infinitely_over() -> None:
    values = np.array([[[0.0, 0.5, -0.5, 1e-3]]])
    symmetric, one_sided = (
        LimitRows.of("velocity", [0], bounds, bound_scales(bounds), (0.0,), 1)
        for bounds in (np.array([[[lower], [0.0]]]) for lower in (0.0, -2.0))
    )
    assert symmetric.ratio(0, values).tolist() == [0.0, np.inf, np.inf, np.inf]
    assert one_sided.ratio(0, values).tolist() == [0.0, np.inf, 0.25, np.inf]


def test_segments_are_grouped_by_their_degree() -> None:
    from ocp_traj.transcription.condensed.exact_rows import degree_groups

    for degrees in (
        (3,),
        (5, 5),
        (3, 5, 3),
        (3, 5, 5, 3),
        (3, 5, 5),
        (5, 5, 3),
        (3, 5, 3, 5, 3),
        (3, 3, 5, 3, 3),
    ):
        found = np.zeros(len(degrees), dtype=int)
        for degree, segments in degree_groups(degrees):
            assert (found[segments] == 0).all()
            found[segments] = degree
        assert tuple(found) == degrees


def test_violations_of_rows_are_what_is_over_either_bound(arm: Any) -> None:
    nlp = CondensedNlp(make_task(arm, "cubic", 0, limits=Limits(velocity=1.0, torque=np.inf), constraints=()))
    g = np.asarray(nlp.g_upper) + np.where(np.isfinite(nlp.g_upper), 0.25, 0.0)
    g[np.isinf(g)] = 1.5
    np.testing.assert_allclose(nlp.violations(g), np.where(np.isfinite(nlp.g_upper), 0.25, 0.0))
    low = np.where(np.isfinite(nlp.g_lower), np.asarray(nlp.g_lower) - 0.5, 0.0)
    np.testing.assert_allclose(nlp.violations(low), np.where(np.isfinite(nlp.g_lower), 0.5, 0.0))
