"""Clearance is proved at every instant, or refuted by one: thin plates, touching, active margins, contact, gaps."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from helpers.collision.cells import clamped, random_motion, random_scene, task_among
from ocp_traj.audit import audit
from ocp_traj.audit.clearance.judging import judge_clearance
from ocp_traj.audit.motion import Motion
from ocp_traj.collision import CollisionScene, Contact, Shape, Solid, cell_of
from ocp_traj.collision.distances import Measure
from ocp_traj.robot import load_robot
from ocp_traj.task import Limits
from ocp_traj.trajectory import Trajectory

REACH = np.array([0.0, -0.6, 0.5, 0.0, 1.2, 0.0])
SWAY = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
NEEDLE = Solid("needle", Shape("capsule", (0.003, 0.2)), (0, 0, 0.1, 0, 0, 0, 1))


def judged(scene: CollisionScene, motion: Trajectory, **changes: Any) -> tuple[Any, list[Any], list[str]]:
    task = task_among(scene, motion(motion.waypoint_times), **changes)
    return judge_clearance(task, Motion.of(motion))


def least_distance(scene: CollisionScene, motion: Trajectory, samples: int = 100) -> float:
    """Return the smallest distance of a motion by dense sampling, refined around the smallest of every pair."""
    cell = cell_of(load_robot("ur5"), scene)
    times = np.linspace(0.0, motion.duration, samples)
    step, best = times[1], np.inf
    values = np.array([[cell.distance(p, m) for p in cell.pairs] for m in measures(cell, motion, times)])
    for number in np.flatnonzero(values.min(axis=0) < values.min() + 0.005):
        at = times[int(np.argmin(values[:, number]))]
        pair = cell.pairs[number]
        found = minimize_scalar(
            lambda t, pair=pair: cell.distance(pair, measures(cell, motion, [t])[0]),
            bounds=(max(at - step, 0.0), min(at + step, motion.duration)),
            method="bounded",
            options={"xatol": 1e-9},
        )
        best = min(best, found.fun, values[:, number].min())
    return float(best)


def measures(cell: Any, motion: Trajectory, times: Any) -> list[Measure]:
    return [Measure(cell.root_placements(q)) for q in motion(np.asarray(times))]


def test_a_task_without_a_scene_has_no_clearance() -> None:
    task = task_among(CollisionScene(), [REACH, REACH + 0.3]).changed(collision=None)
    verdict = audit(task, clamped([REACH, REACH + 0.3], [0.0, 1.0]))
    assert verdict.clearance is None
    assert verdict.to_json()["collision"] is None


@pytest.mark.parametrize("number", range(40))
def test_a_thin_plate_is_never_jumped_over(number: int) -> None:
    """A needle of 6 mm crosses a plate of 5 mm at about 3 m/s: less than 4 ms of overlap in a motion of 1.6 s."""
    ends = np.array([REACH - 1.5 * SWAY, REACH + 1.5 * SWAY])
    motion = clamped(ends, [0.0, 1.2])
    robot = load_robot("ur5")
    when = motion.duration * (0.4 + 0.005 * number)
    pose = robot.pose(motion(when))
    tip = pose[:3, 3] + 0.19 * pose[:3, 2]
    angle = float(np.arctan2(tip[1], tip[0]))
    plate = Shape("box", (0.06, 0.005, 0.06))
    turn = (0, 0, np.sin(angle / 2), np.cos(angle / 2))
    scene = CollisionScene((Solid("plate", plate, (*tip, *turn)),), (NEEDLE,), with_itself=False)
    clearance, _, findings = judged(scene, motion)
    assert not clearance.proved
    assert any(text.startswith("collision: needle meets plate at") for text in findings)
    assert clearance.time == pytest.approx(when, abs=0.01)
    assert clearance.distances < 500


@pytest.mark.parametrize(("gap", "clear"), [(0.0, True), (1e-7, True), (-5e-6, False), (-1e-4, False)])
def test_touching_at_rest_is_clear_and_five_micrometres_deeper_is_not(gap: float, clear: bool) -> None:
    start, end = np.array([[0, -0.9, 1.2, -1.9, -1.57, 0], [0.6, -0.5, 1.1, -2.2, -1.57, 0]])
    motion = clamped([start, end], [0.0, 1.2])
    ball = Solid("ball", Shape("sphere", (0.05,)), (0, 0, 0.1, 0, 0, 0, 1))
    pose = load_robot("ur5").pose(end)
    low = (pose[:3, 3] + 0.1 * pose[:3, 2])[2] - 0.05
    table = Solid("table", Shape("halfspace", (0, 0, 1, low - gap)))
    scene = CollisionScene((table,), (ball,), with_itself=False, ignore=pairs_with_table())
    clearance, _, findings = judged(scene, motion)
    assert clearance.proved is clear
    assert clearance.pair == ("ball", "table")
    assert clearance.distances < 300
    assert bool(findings) is not clear


def pairs_with_table() -> tuple[tuple[str, str], ...]:
    return tuple((name, "table") for name in ("shoulder_link", "upper_arm_link"))


def test_an_active_margin_is_proved_with_few_distances() -> None:
    rng, done = np.random.default_rng(3), 0
    while done < 3:
        scene, motion = replace(random_scene(rng), with_itself=False), random_motion(rng)
        clearance, _, findings = judged(scene, motion)
        if findings or clearance.distance > 0.05:
            continue
        least = least_distance(scene, motion)
        closer = replace(scene, margin=least - 1e-7)
        kept, _, findings = judged(closer, motion)
        assert kept.proved, findings
        assert kept.distances <= 500
        assert least - 1e-6 <= kept.distance < least + 0.01
        assert not judged(replace(scene, margin=least + 2e-6), motion)[0].proved
        done += 1


def test_what_is_proved_is_no_more_than_what_dense_samples_show() -> None:
    rng, done = np.random.default_rng(11), 0
    while done < 3:
        scene, motion = random_scene(rng), random_motion(rng)
        clearance, _, _ = judged(scene, motion)
        if clearance.proved:
            least = least_distance(scene, motion, 80)
            assert clearance.bound <= least + 1e-6
            assert clearance.distance >= least - 1e-6
            done += 1


def test_a_wrong_plane_proves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(2)
    pairs = [(random_scene(rng), random_motion(rng)) for _ in range(12)]
    truth = [judged(scene, motion)[0].proved for scene, motion in pairs]
    assert not all(truth)
    true_plane = Measure.plane

    def wrong(self: Measure, *bodies: Any) -> tuple[float, Any]:
        distance, normal = true_plane(self, *bodies)
        kinds = [np.zeros(3), np.full(3, np.nan), rng.normal(size=3), 0.7 * np.asarray(normal), -normal]
        return abs(distance) + 1.0, kinds[int(rng.integers(len(kinds)))]

    monkeypatch.setattr(Measure, "plane", wrong)
    monkeypatch.setattr(import_module("ocp_traj.audit.clearance.certificate"), "MOST_DISTANCES", 3000)
    for clear, (scene, motion) in zip(truth, pairs, strict=True):
        if not clear:
            found, _, findings = judged(scene, motion)
            assert not found.proved
            assert "could not be decided" in findings[0]


def test_a_verdict_says_who_meets_what_when_and_how_deep() -> None:
    motion = clamped([REACH, REACH + SWAY], [0.0, 1.0])
    where = load_robot("ur5").pose(motion(0.5))[:3, 3]
    ball = Solid("ball", Shape("sphere", (0.08,)), (*where, 0, 0, 0, 1))
    task = task_among(CollisionScene((ball,)), motion([0.0, 1.0])).changed(limits=Limits(velocity=10.0))
    verdict = audit(task, motion)
    assert not verdict.feasible
    assert verdict.smallest_feasible_scale is None
    assert any(text.startswith("collision: ee_link meets ball at 0.") for text in verdict.findings)
    assert all("mm inside" in text for text in verdict.findings if "meets" in text)
    assert verdict.worst is not None and verdict.worst.limit == "clearance"
    written = json.loads(json.dumps(verdict.to_json(), allow_nan=False))["collision"]
    assert written["pair"][1] == "ball" and written["clearance"] < 0 and written["proved"] is False
    assert written["left_out"][0] == "base_link and shoulder_link (they share a joint)"
    ratio = verdict.limits["clearance"].ratio
    assert ratio == pytest.approx(1.0 - written["clearance"] / 0.01)
    assert "NOT kept" in str(verdict)


def test_a_margin_that_is_not_kept_is_told_from_a_touch() -> None:
    motion = clamped([REACH, REACH + SWAY], [0.0, 1.0])
    where = load_robot("ur5").pose(motion(0.5))[:3, 3] + [0, 0, 0.25]
    ball = Solid("ball", Shape("sphere", (0.08,)), (*where, 0, 0, 0, 1), margin=0.3)
    _, peaks, findings = judged(CollisionScene((ball,), with_itself=False), motion)
    assert any("mm from ball at" in text and text.endswith("expected 300 mm") for text in findings)
    assert peaks[0].bound == 0.3


def test_a_pair_that_an_srdf_leaves_out_and_that_touches_is_a_finding() -> None:
    robot = load_robot("ur5")
    cell = cell_of(robot, CollisionScene(pairs="srdf"))
    rng = np.random.default_rng(0)
    for q in rng.uniform(-2.5, 2.5, (2000, 6)):
        found = cell.collisions(q)
        if found and all(overlap.left_out for overlap in found):
            break
    clearance, _, findings = judged(CollisionScene(pairs="srdf"), clamped([q, q + 1e-3], [0.0, 1.0]))
    assert not clearance.proved
    assert all(text.endswith("a pair left out by the SRDF") for text in findings)
    ignored = CollisionScene(pairs="srdf", ignore=tuple(overlap.bodies for overlap in found))
    clearance, _, findings = judged(ignored, clamped([q, q + 1e-3], [0.0, 1.0]))
    assert clearance.proved and not findings
    assert sum("ignored" in text for text in clearance.left_out) == len(found)


DOWN = np.array([0.3, -1.0, 1.4, -2.0, -np.pi / 2, 0.0])
FINGER = Solid("finger", Shape("sphere", (0.02,)), (0, 0, 0.1, 0, 0, 0, 1))


def press(depth: float, allowed: float, within: float = 0.15) -> tuple[Any, list[Any], list[str]]:
    """Judge a finger that presses on a block at waypoint 2, from straight above."""
    robot = load_robot("ur5")
    above = DOWN - [0, 0.3, 0, -0.3, 0, 0]
    motion = clamped([above, DOWN, above], [0.0, 1.0, 2.0])
    low = robot.pose(DOWN)[:3, 3] + robot.pose(DOWN)[:3, :3] @ [0, 0, 0.1] - [0, 0, 0.02]
    block = Solid("block", Shape("box", (0.1, 0.1, 0.1)), (*(low - [0, 0, 0.05 - depth]), 0, 0, 0, 1))
    contact = (Contact(("block", "finger"), 1, within, allowed),)
    scene = CollisionScene((block,), (FINGER,), with_itself=False, contact=contact)
    return judged(scene, motion)


def test_contact_on_purpose_is_certified_and_a_little_deeper_refused() -> None:
    clearance, _, findings = press(0.001, 0.001)
    assert clearance.proved, findings
    clearance, _, findings = press(0.0012, 0.001)
    assert not clearance.proved
    assert "finger meets block" in findings[0] and "1 mm allowed" in findings[0]


def test_contact_is_allowed_around_its_waypoint_only() -> None:
    assert not press(0.005, 0.01, within=0.01)[0].proved
    assert press(0.005, 0.01, within=0.5)[0].proved


def test_a_part_is_judged_in_the_gaps_in_which_it_is_carried() -> None:
    part = Solid("part", Shape("box", (0.05, 0.05, 0.4)), (0, 0, 0.2, 0, 0, 0, 1), gaps=(1, 2))
    points = [REACH + number * 0.2 * SWAY for number in range(6)]
    motion = clamped(points, np.arange(6.0))
    robot = load_robot("ur5")
    for gap in range(5):
        pose = robot.pose(motion(gap + 0.5))
        ball = Solid("ball", Shape("sphere", (0.02,)), (*(pose[:3, 3] + 0.35 * pose[:3, 2]), 0, 0, 0, 1))
        clearance, _, findings = judged(CollisionScene((ball,), (part,), with_itself=False), motion)
        assert clearance.proved is (gap not in (1, 2)), findings
