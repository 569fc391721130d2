"""The batched evaluation says what the symbols say, row by row, for every family, limit and objective."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from helpers.condensed_tasks import (
    CUSTOM_CONSTRAINT,
    CUSTOM_OBJECTIVE,
    FAMILIES,
    LIMITS,
    OBJECTIVES,
    UR5,
    WAYPOINTS,
    make_task,
)
from ocp_traj import audit
from ocp_traj.exceptions import InputError, UnavailableError
from ocp_traj.robot.additions import Friction
from ocp_traj.task import TrajectoryTask
from ocp_traj.transcription.condensed.condensed import CondensedNlp


def population(nlp: CondensedNlp, count: int = 5, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(nlp.lower, nlp.upper, (count, nlp.dimension))


def assert_same_as_symbols(task: TrajectoryTask, **options: object) -> None:
    nlp = CondensedNlp(task, samples=6, **options)  # type: ignore[arg-type]
    X = population(nlp)
    evaluation = nlp.evaluate(X)
    function = ca.Function("nlp", [nlp.x], [nlp.f, nlp.g])
    assert evaluation.violation.shape == (len(X), len(nlp.g_lower)) == (len(X), sum(map(len, nlp.rows)))
    for k, x in enumerate(X):
        f, g = (np.array(value).ravel() for value in function(x))
        expected = nlp.violations(g)
        np.testing.assert_allclose(evaluation.cost[k], f[0], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(evaluation.violation[k], expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize("family", FAMILIES)
def test_every_objective_costs_what_its_symbol_costs(family: str, objective: str) -> None:
    assert_same_as_symbols(make_task(family, LIMITS["velocity"], OBJECTIVES[objective]))


@pytest.mark.parametrize("limit", LIMITS)
@pytest.mark.parametrize("family", FAMILIES)
def test_every_limit_is_broken_as_much_as_its_symbols_say(family: str, limit: str) -> None:
    task = make_task(family, LIMITS[limit])
    nlp = CondensedNlp(task, samples=6)
    broken = nlp.evaluate(population(nlp)).total_violation > 0
    assert broken.any()  # otherwise the comparison would compare zeros
    assert_same_as_symbols(task)


@pytest.mark.parametrize("family", ["cubic", "quintic", "3-5-3"])
@pytest.mark.parametrize("extrema", ["sampled", "exact"])
def test_sampled_and_exact_rows_agree_with_their_symbols(family: str, extrema: str) -> None:
    limits = {**LIMITS["velocity"], **LIMITS["acceleration"], **LIMITS["jerk"]}
    assert_same_as_symbols(make_task(family, limits), extrema=extrema)


@pytest.mark.parametrize(
    ("family", "knots", "boundary"),
    [
        ("cubic", 1, {}),
        ("cubic", 3, {"acceleration": 0.0}),
        ("quintic", 2, {}),
        ("quintic", 1, {"acceleration": None}),
        ("quintic", 2, {"jerk": 0.0}),
        ("septic", 2, {}),
        ("septic", 1, {"acceleration": None, "jerk": None}),
        ("cubic", 0, {"velocity": [[0.1] * 6, [-0.2] * 6]}),
        ("septic", 1, {"velocity": [[0.1] * 6, [0.0] * 6], "acceleration": [[0.3] * 6, [-0.1] * 6]}),
        ("3-5-3", 0, {"velocity": [[0.1] * 6, [-0.2] * 6], "acceleration": [[0.3] * 6, [0.2] * 6]}),
    ],
)
def test_virtual_knots_and_end_conditions_agree_with_their_symbols(
    family: str, knots: int, boundary: dict[str, object]
) -> None:
    limits = {**LIMITS["velocity"], **LIMITS["acceleration"]}
    assert_same_as_symbols(make_task(family, limits, virtual_knots=knots, boundary=boundary))


@pytest.mark.parametrize("segments", [1, 2, 3])
@pytest.mark.parametrize("family", ["cubic", "quintic", "septic"])
def test_few_waypoints_agree_with_their_symbols(family: str, segments: int) -> None:
    assert_same_as_symbols(make_task(family, LIMITS["velocity"], waypoints=WAYPOINTS[: segments + 1]))


def test_all_limits_friction_and_custom_functions_together_agree_with_their_symbols() -> None:
    from dataclasses import replace

    limits = {name: LIMITS[name][name] for name in LIMITS if name != "per gap"}
    objective = {
        **OBJECTIVES["energy"],
        "jerk": 0.01,
        "duration": (3.0, 4.0),
        "gap_durations": [[0.5, 1.0]] * 4,
    }
    friction = Friction(np.linspace(0.1, 1.0, 6), np.linspace(0.2, 0.5, 6))
    task = make_task("septic", limits, objective, friction=friction, constraints=(CUSTOM_CONSTRAINT,))
    assert_same_as_symbols(replace(task, objective=replace(task.objective, custom=(CUSTOM_OBJECTIVE,))))


def test_logarithms_of_durations_stand_for_the_same_motions() -> None:
    task = make_task("quintic", LIMITS["acceleration"], OBJECTIVES["jerk"])
    plain, logarithmic = CondensedNlp(task), CondensedNlp(task, encoding="log-durations")
    X = population(plain)
    for a, b in zip(
        (plain.evaluate(X).cost, plain.evaluate(X).violation),
        (logarithmic.evaluate(np.log(X)).cost, logarithmic.evaluate(np.log(X)).violation),
    ):
        np.testing.assert_allclose(a, b, rtol=1e-10, atol=1e-12)
    assert_same_as_symbols(task, encoding="log-durations")


@pytest.mark.parametrize("family", FAMILIES)
def test_a_candidate_is_judged_the_same_in_any_population(family: str) -> None:
    task = make_task(family, {**LIMITS["velocity"], **LIMITS["torque"]}, OBJECTIVES["energy"])
    for encoding in ("durations", "scaled"):
        nlp = CondensedNlp(task, encoding=encoding)
        X = population(nlp, 9)
        whole = nlp.evaluate(X)
        for k in (0, 4, 8):
            alone = nlp.evaluate(X[k])
            np.testing.assert_allclose(alone.cost[0], whole.cost[k], rtol=1e-12)
            np.testing.assert_allclose(alone.violation[0], whole.violation[k], rtol=1e-9, atol=1e-12)


def test_evaluations_keep_their_numbers_when_others_follow() -> None:
    nlp = CondensedNlp(make_task("septic", LIMITS["torque"], OBJECTIVES["energy"]))
    first = nlp.evaluate(population(nlp))
    cost, violation = first.cost.copy(), first.violation.copy()
    nlp.evaluate(population(nlp, seed=1))
    np.testing.assert_array_equal(first.cost, cost)
    np.testing.assert_array_equal(first.violation, violation)


@pytest.mark.parametrize("family", FAMILIES)
def test_decoding_gives_the_motion_that_was_judged(family: str) -> None:
    """The audit's exact extrema of the decoded motion against the rows of the same candidate."""
    task = make_task(family, {**LIMITS["velocity"], **LIMITS["acceleration"]})
    nlp = CondensedNlp(task, samples=400)
    x = population(nlp, 1)[0]
    trajectory = nlp.decode(x)
    np.testing.assert_allclose(trajectory(trajectory.waypoint_times), WAYPOINTS, atol=1e-9)
    np.testing.assert_allclose(np.diff(trajectory.breakpoints), x[: task.gaps], rtol=1e-12)
    limits = audit(task, trajectory).limits
    violation = nlp.evaluate(x).violation[0]
    for block, start in zip(nlp.rows, np.cumsum([0, *map(len, nlp.rows)])):
        worst = limits[block.limit]
        scale = 3.0 if block.limit == "acceleration" else None
        over = violation[start : start + len(block)].max()
        if scale is None:
            assert max(worst.ratio - 1.0, 0.0) == pytest.approx(over, rel=2e-4, abs=1e-6)
        else:
            assert over > 0


@pytest.mark.parametrize("virtual_knots", [0, 2])
@pytest.mark.parametrize("encoding", ["durations", "log-durations"])
def test_encoding_a_decoded_motion_returns_its_variables(virtual_knots: int, encoding: str) -> None:
    nlp = CondensedNlp(make_task("cubic", LIMITS["velocity"], virtual_knots=virtual_knots), encoding=encoding)
    x = population(nlp, 1)[0]
    still = np.ptp(WAYPOINTS, axis=0) == 0
    x[nlp.segments :].reshape(-1, 6)[:, still] = 0.0
    np.testing.assert_allclose(nlp.encode(nlp.decode(x)), x, atol=1e-9)


def test_labels_name_the_row_that_is_broken() -> None:
    task = make_task("quintic", {"velocity": [0.1, *[np.inf] * 5]}, waypoints=WAYPOINTS[:2])
    nlp = CondensedNlp(task, extrema="sampled", samples=4)
    x = nlp.lower.copy()
    row = int(nlp.evaluate(x).violation[0].argmax())
    assert nlp.label(row) == "velocity, joint 1, gap 1, 0.50"


def test_waypoints_on_a_position_limit_break_nothing() -> None:
    limits = {"position": np.stack([WAYPOINTS.min(axis=0), WAYPOINTS.max(axis=0)])}
    task = make_task("quintic", limits, waypoints=WAYPOINTS[:2], boundary={})
    nlp = CondensedNlp(task)
    assert nlp.evaluate(population(nlp)).total_violation.max() < 1e-10


def test_a_wrong_encoding_or_extrema_is_refused() -> None:
    with pytest.raises(InputError, match="encoding 'sums' is unknown, expected one of durations"):
        CondensedNlp(make_task(), encoding="sums")
    with pytest.raises(InputError, match="extrema 'some' is unknown"):
        CondensedNlp(make_task(), extrema="some")
    with pytest.raises(InputError, match="exact extrema of septic have no closed form"):
        CondensedNlp(make_task("septic"), extrema="exact")


def test_the_scaled_encoding_has_no_symbols_and_says_why() -> None:
    with pytest.raises(UnavailableError, match="its total duration is a maximum over all limits"):
        _ = CondensedNlp(make_task(limits=LIMITS["velocity"]), encoding="scaled").x


def test_problems_can_be_sent_to_another_process() -> None:
    import pickle

    nlp = CondensedNlp(make_task("septic", LIMITS["torque"], OBJECTIVES["energy"]))
    X = population(nlp)
    copy = pickle.loads(pickle.dumps(nlp))
    np.testing.assert_array_equal(copy.evaluate(X).cost, nlp.evaluate(X).cost)


def test_torques_agree_with_and_without_a_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    task = make_task("septic", LIMITS["torque"], OBJECTIVES["energy"])
    X = population(CondensedNlp(task))
    compiled = CondensedNlp(task).evaluate(X)
    monkeypatch.setenv("OCP_TRAJ_NO_COMPILER", "1")
    bare = CondensedNlp(make_task("septic", LIMITS["torque"], OBJECTIVES["energy"], robot=replace(UR5)))
    np.testing.assert_allclose(bare.evaluate(X).cost, compiled.cost, rtol=1e-12)
    np.testing.assert_allclose(bare.evaluate(X).violation, compiled.violation, rtol=1e-10, atol=1e-12)
