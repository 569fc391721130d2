"""Lower bounds: true ones are proved, false ones and incomplete evidence are refused."""

from __future__ import annotations

import copy
import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import ocp_traj as ot
from ocp_traj.arrays import Array
from ocp_traj.proofs import NotProved, Refused, check, checker, prove_bound
from ocp_traj.proofs.resolve import resolve_task
from ocp_traj.references.bounds.double_integrator import feasible
from ocp_traj.references.bounds.kinematic_bound import joint_limits
from ocp_traj.task import Boundary, Limits, TrajectoryTask

Bounds = dict[tuple[str, str], dict[str, Any]]
LARGEST_BYTES = 5_000_000
KNOWN = {
    ("machines-2024-490", "every motion"): 1.483853,
    ("fanuc-m10id8l", "every motion"): 0.721231,
    ("machines-2024-490", "3-5-3"): 4.310404,
    ("fanuc-m10id8l", "3-5-3"): 1.224268,
}
"""Durations of motions that exist, s."""


def scaled(rows: Any, factor: float) -> Any:
    return [scaled(row, factor) for row in rows] if isinstance(rows, list) else (float.fromhex(rows) * factor).hex()


def test_bounds_of_the_packaged_cases_are_proved(bounds: Bounds) -> None:
    for (case, of), document in bounds.items():
        text = json.dumps(document)
        assert len(text) < LARGEST_BYTES
        report = check(json.loads(text))
        assert report.kind == "bound" and case in report.statement
        assert report.statement.startswith("no motion" if of == "every motion" else "no 3-5-3 curve")


def test_a_claim_above_a_known_motion_is_refused(bounds: Bounds) -> None:
    for key, document in bounds.items():
        for factor in (1 + 1e-6, 1.001, 1.1):
            false = copy.deepcopy(document)
            false["claim"]["duration"] = (KNOWN[key] * factor).hex()
            with pytest.raises(Refused):
                check(false)


def test_limits_that_allow_a_shorter_motion_are_refused(bounds: Bounds) -> None:
    for document in bounds.values():
        false = copy.deepcopy(document)  # every motion may run faster by 2 %
        false["task"]["limits"]["velocity"] = scaled(false["task"]["limits"]["velocity"], 1.02)
        false["task"]["limits"]["acceleration"] = scaled(false["task"]["limits"]["acceleration"], 1.02**2)
        with pytest.raises(Refused):
            check(false)


def test_waypoints_that_allow_a_shorter_motion_are_refused(bounds: Bounds) -> None:
    for document in bounds.values():
        false = copy.deepcopy(document)  # 4 % smaller, so 2 % faster
        false["task"]["waypoints"] = scaled(false["task"]["waypoints"], 0.96)
        with pytest.raises(Refused):
            check(false)


def test_a_tree_without_one_of_its_nodes_is_refused(bounds: Bounds) -> None:
    for document in bounds.values():
        count = len(document["evidence"]["tree"])
        for index in range(0, count, max(1, count // 25)):
            wrong = copy.deepcopy(document)
            del wrong["evidence"]["tree"][index]
            with pytest.raises((Refused, checker.NotAProof)):
                check(wrong)


def test_hints_that_refute_nothing_are_refused(bounds: Bounds) -> None:
    document = bounds["machines-2024-490", "every motion"]
    tree = document["evidence"]["tree"]
    leaf = next(index for index, node in enumerate(tree) if node[0] == "joint")
    for node in (["empty"], ["lemma", 1], ["joint", 1, 3, 2], ["joint", 99, 1, 1], ["joint", 1, 1, 4]):
        wrong = copy.deepcopy(document)
        wrong["evidence"]["tree"][leaf] = node
        with pytest.raises(Refused):
            check(wrong)
    wrong = copy.deepcopy(document)
    wrong["evidence"]["tree"].append(["empty"])
    with pytest.raises(Refused, match="left over"):
        check(wrong)
    split = next(index for index, node in enumerate(tree) if node[0] == "split")
    for place in (0.0, 5.0, -1.0):
        wrong = copy.deepcopy(document)
        wrong["evidence"]["tree"][split][2] = place.hex()
        with pytest.raises(Refused, match="does not split"):
            check(wrong)


def test_instants_refute_curves_of_the_family_only(bounds: Bounds) -> None:
    wrong = copy.deepcopy(bounds["machines-2024-490", "3-5-3"])
    wrong["claim"]["of"] = "every motion"
    with pytest.raises(checker.NotAProof, match="no kind of node here"):
        check(wrong)
    for place, value in ((3, 4), (2, 3), (1, 7)):
        wrong = copy.deepcopy(bounds["machines-2024-490", "3-5-3"])
        node = next(node for node in wrong["evidence"]["tree"] if node[0] == "instant")
        node[place] = value
        with pytest.raises(Refused):
            check(wrong)


def straight(**changes: Any) -> TrajectoryTask:
    """One joint over 2 rad with velocity 1 and acceleration 2: 2.5 s."""
    limits = Limits(velocity=1.0, acceleration=2.0)
    return TrajectoryTask(np.array([[0.0], [2.0]]), limits, name="straight").changed(**changes)


def test_the_straight_way_is_proved_to_its_closed_form() -> None:
    assert check(prove_bound(straight(), duration=2.49999)).kind == "bound"
    for false in (2.5, 2.500001):
        with pytest.raises(NotProved):
            prove_bound(straight(), duration=false)


def test_the_bound_allows_for_what_a_judge_lets_pass() -> None:
    # limits exceeded by 1e-6 and a way shorter by 2e-8: 2 / 1.000001 + 0.5, about
    shortest = (2.0 - 2e-8) / (1 + 1e-6) + 0.5
    assert prove_bound(straight(), duration=shortest - 3e-8)
    with pytest.raises(NotProved):
        prove_bound(straight(), duration=shortest + 3e-8)


def test_tolerances_and_missing_limits_weaken_a_bound() -> None:
    assert prove_bound(straight(tolerance=0.1), duration=2.2999)
    with pytest.raises(NotProved):
        prove_bound(straight(tolerance=0.1), duration=2.3001)
    only_speed = straight(limits=Limits(velocity=1.0))
    assert prove_bound(only_speed, duration=1.99999)
    with pytest.raises(NotProved):
        prove_bound(only_speed, duration=2.0)
    only_acceleration = straight(limits=Limits(acceleration=2.0))  # up and down again: 2 sqrt(2 / 2)
    assert prove_bound(only_acceleration, duration=1.99999)
    with pytest.raises(NotProved):
        prove_bound(only_acceleration, duration=2.00001)
    with pytest.raises(NotProved):
        prove_bound(straight(limits=Limits(jerk=1.0)), duration=1e-3)


def test_unequal_sides_of_a_limit_are_told_apart() -> None:
    limits = Limits(velocity=np.array([[-0.5], [2.0]]), acceleration=np.array([[-1.0], [4.0]]))
    there = TrajectoryTask(np.array([[0.0], [4.0]]), limits)
    back = TrajectoryTask(np.array([[4.0], [0.0]]), limits)
    for task, true in ((there, 3.25), (back, 8.0 + 0.5 * 0.5 + 0.5 * 0.125)):
        assert prove_bound(task, duration=true * (1 - 3e-6))
        with pytest.raises(NotProved):
            prove_bound(task, duration=true * (1 + 1e-6))


def test_limits_of_single_gaps_are_told_apart() -> None:
    velocity = np.broadcast_to(np.array([-1.0, 1.0])[:, None], (2, 2, 1)).copy()
    velocity[1] *= 0.5
    acceleration = np.broadcast_to(np.array([-2.0, 2.0])[:, None], (2, 2, 1))
    task = TrajectoryTask(np.array([[0.0], [2.0], [4.0]]), Limits(velocity=velocity, acceleration=acceleration))
    # up to 1, down to 0.5 where the second gap begins, then to rest
    first = 0.5 + 0.25 + (2.0 - 0.25 - 0.1875) / 1.0
    second = (2.0 - 0.0625) / 0.5 + 0.25
    assert prove_bound(task, duration=(first + second) * (1 - 3e-6))
    with pytest.raises(NotProved):
        prove_bound(task, duration=(first + second) * (1 + 1e-6))


def test_what_has_no_bound_is_said() -> None:
    moving = straight(boundary=Boundary(velocity=[[0.1], [0.0]]))
    with pytest.raises(NotProved, match="not at rest"):
        prove_bound(moving, duration=1.0)
    with pytest.raises(NotProved, match="not at rest"):
        prove_bound(moving)
    with pytest.raises(NotProved, match="3-5-3"):
        prove_bound(straight(), duration=1.0, of="3-5-3")
    with pytest.raises(NotProved, match="not proved within"):
        prove_bound(ot.load_case("machines-2024-490"), 0.0, duration=1.48)


def test_without_a_duration_the_certified_one_is_proved() -> None:
    document = prove_bound(straight())
    assert 2.49 < float.fromhex(document["claim"]["duration"]) < 2.5


def random_chain(seed: int) -> TrajectoryTask:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(int(rng.integers(2, 5)), int(rng.integers(1, 3))))
    sides = [np.stack([-side[0], side[1]]) for side in rng.uniform(0.5, 2.0, (2, 2, points.shape[1]))]
    return TrajectoryTask(points, Limits(velocity=sides[0], acceleration=sides[1]))


def possible_durations(task: TrajectoryTask, rng: np.random.Generator, count: int) -> Array:
    """Return durations that some motion keeps, by the double integrator's exact test."""
    _, limits, _ = joint_limits(task)
    durations = rng.uniform(0.1, 4.0, (count, task.gaps))
    return durations[feasible(limits, durations, durations)]


def test_no_motion_that_exists_lies_in_a_refuted_box() -> None:
    refuted = 0
    for seed in range(40):
        task = random_chain(seed)
        resolved = checker.read_task(resolve_task(task))
        rng = np.random.default_rng(seed)
        for h in possible_durations(task, rng, 200)[:12]:
            joints = checker.chain(resolved, Fraction(float(h.sum())))
            for _ in range(6):
                width = 10 ** rng.uniform(-6, 0.3, task.gaps)
                share = rng.choice([0.0, 1.0, rng.random()], task.gaps)
                low = [Fraction(x) for x in np.minimum(np.maximum(h - share * width, 0.0), h)]
                high = [Fraction(x) for x in np.maximum(h + (1 - share) * width, h)]
                for joint in joints:
                    for first in range(task.gaps):
                        for last in range(first + 1, task.gaps + 1):
                            assert not checker.cannot_pass(joint, first, last, low, high)
                shorter = [[x * Fraction(1, 3) for x in row] for row in (low, high)]
                refuted += any(checker.cannot_pass(joint, 0, task.gaps, *shorter) for joint in joints)
    assert refuted > 500


def test_no_ride_covers_less_than_the_least_way() -> None:
    rng = np.random.default_rng(0)
    for _ in range(400):
        V, A, B = (Fraction(x) for x in rng.uniform(0.2, 2.0, 3))
        steps, dt = 40, Fraction(1, 64)
        v = start = Fraction(rng.uniform(-1, 1)).limit_denominator(1000) * V
        way = Fraction(0)
        drift = rng.uniform(-1.5, 1.5)
        for _ in range(int(rng.integers(1, steps))):
            push = Fraction(float(np.clip(drift + rng.normal(), -1, 1))) * (A if rng.random() < 0.5 else B)
            change = max(-B, min(A, push)) * dt
            after = min(max(v + change, -V), V)
            way += (v + after) / 2 * dt  # a limited velocity is a slower change: within the acceleration
            v = after
            h = dt * (_ + 1)
            for lo in (start, start - Fraction(1, 10)):
                for hi in (v, v - Fraction(1, 10), v - 2):
                    if hi >= -V and lo >= -V:
                        assert checker.least_way(h, lo, hi, V, A, B) <= way
                assert lo < -V or checker.least_way_to_any(h, lo, V, B) <= way


def test_the_least_way_is_concave_in_time() -> None:
    rng = np.random.default_rng(1)
    for _ in range(300):
        V, A, B = (Fraction(x) for x in rng.uniform(0.2, 2.0, 3))
        lo, hi = (Fraction(x) * V for x in rng.uniform(-1, 1, 2))
        a, b = sorted(Fraction(x) for x in rng.uniform(0, 5, 2))
        between, *ends = (checker.least_way(h, lo, hi, V, A, B) for h in ((a + b) / 2, a, b))
        assert between >= sum(ends) / 2
        between, *ends = (checker.least_way_to_any(h, lo, V, B) for h in ((a + b) / 2, a, b))
        assert between >= sum(ends) / 2


def curve_353(h: Array, travel: Array) -> list[Array]:
    """Return the coefficients (degree + 1, 3, n) of a 3-5-3 curve in normalised time, by solving its conditions."""
    from ocp_traj.spline import EndConditions, get_family

    zero = np.zeros((1, travel.shape[1]))
    ends = EndConditions({1: zero, 2: zero}, {1: zero, 2: zero})
    positions = [row[None, :] for row in np.concatenate([zero, np.cumsum(travel, axis=0)])]
    pieces = get_family("3-5-3").pieces([np.array([[x]]) for x in h], positions, ends)
    return [np.stack([np.broadcast_to(c, zero.shape)[0] for c in piece.coefficients()]) for piece in pieces]


def test_monomials_give_the_derivatives_of_the_curve() -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        h, travel = rng.uniform(0.2, 2.0, 3), rng.normal(size=(3, 2))
        curve = curve_353(h, travel)
        for piece in range(3):
            for order in (1, 2):
                u = float(rng.random())
                slope = np.polynomial.polynomial.polyder(curve[piece], order)
                expected = np.polynomial.polynomial.polyval(u, slope) / h[piece] ** order
                terms = checker.monomials(piece, order, Fraction(u))
                found = sum(float(w) * np.prod(h ** np.array(p)) * travel[gap] for w, gap, p in terms)
                assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_no_curve_that_keeps_its_limits_at_an_instant_lies_in_a_refuted_box() -> None:
    rng = np.random.default_rng(3)
    refuted = kept = 0
    for seed in range(60):
        points = rng.normal(size=(4, 1))
        h = rng.uniform(0.3, 2.0, 3)
        curve = curve_353(h, np.diff(points, axis=0))
        piece, order, u = int(rng.integers(3)), int(rng.integers(1, 3)), float(rng.random())
        slope = np.polynomial.polynomial.polyder(curve[piece], order)
        value = float(np.polynomial.polynomial.polyval(u, slope)[0] / h[piece] ** order)
        for limit, holds in ((abs(value), True), (0.7 * abs(value), False)):
            name = checker.ORDERS[order]
            task = TrajectoryTask(points, Limits(**{name: limit}), family="3-5-3")
            resolved = checker.read_task(resolve_task(task))
            for _ in range(8):
                width = 10 ** rng.uniform(-4, -0.5) * rng.uniform(0.3, 1.0, 3)
                share = rng.choice([0.0, 1.0, 0.5], 3)
                low = [Fraction(x) for x in np.maximum(h - share * width, 0.1)]
                high = [Fraction(x) for x in h + (1 - share) * width]
                total = sum((Fraction(x) for x in h), Fraction(0))
                beyond = checker.is_beyond(resolved, 0, order, piece, Fraction(u), low, high, total)
                assert not (beyond and holds), seed
                refuted, kept = refuted + beyond, kept + holds
    assert refuted > 100 and kept == 480


def test_lemmas_and_their_weighted_sum_are_checked() -> None:
    limits = Limits(velocity=1.0, acceleration=2.0)
    points = np.array([[0.0], [2.0], [0.0], [2.0], [0.0]])  # the joint turns at every waypoint: it stops there
    task = TrajectoryTask(points, limits, name="back-and-forth")
    document = prove_bound(task, 600.0, duration=9.5)
    assert document["evidence"]["lemmas"] and check(document)
    assert any(node[0] == "lemma" for node in document["evidence"]["tree"])
    lemmas = document["evidence"]["lemmas"]
    total = sum(float.fromhex(lemma["total"]) for lemma in lemmas[:4])
    weights = [float(index < 4).hex() for index in range(len(lemmas))]
    summed = copy.deepcopy(document)
    summed["evidence"]["tree"] = [["sum", weights]]
    summed["claim"]["duration"] = (total - 1e-3).hex()
    assert all(lemma["first"] == lemma["last"] for lemma in lemmas[:4]) and check(summed)
    for change in ("claim", "weight", "negative", "lemma"):
        wrong = copy.deepcopy(summed)
        if change == "claim":
            wrong["claim"]["duration"] = (total + 1e-3).hex()
        elif change == "lemma":
            first = wrong["evidence"]["lemmas"][0]
            first["total"] = (float.fromhex(first["total"]) + 1.0).hex()
        else:
            wrong["evidence"]["tree"][0][1][0] = (2.0 if change == "weight" else -1.0).hex()
            wrong["claim"]["duration"] = (total - 4.0).hex()
        with pytest.raises(Refused):
            check(wrong)
