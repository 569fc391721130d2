"""A claim is judged by a test over seeds, never by one run."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.papers.fanuc_inertia import to_fanuc, with_inertia
from ocp_traj.papers.measures import audit_durations, claim_gain, claim_order, order_with_tests
from ocp_traj.papers.paper_b import PaperB
from ocp_traj.papers.paper_d import PUBLISHED, PaperD

RNG = np.random.default_rng(5)
NOISE = 0.01 * RNG.random(20)


def test_a_claimed_order_holds_only_where_neighbours_differ_significantly() -> None:
    columns = {"a": 1.0 + NOISE, "b": 2.0 + NOISE[::-1], "c": 3.0 + NOISE}
    assert claim_order("a < b < c", "", columns, "s").verdict == "holds"
    assert claim_order("c < a", "", {"c": columns["c"], "a": columns["a"]}, "s").verdict == "does not hold"
    close = {"a": 1.0 + RNG.random(20), "b": 1.0 + RNG.random(20)}
    assert claim_order("a < b", "", close, "s").verdict == "not proven"


def test_failures_rank_last() -> None:
    ordered, proven, _ = order_with_tests({"fails": np.full(20, np.inf), "works": 1.0 + NOISE})
    assert ordered == ["works", "fails"]
    assert proven == {("works", "fails")}


def test_one_seed_proves_nothing() -> None:
    ordered, proven, words = order_with_tests({"a": np.array([2.0]), "b": np.array([1.0])})
    assert ordered == ["b", "a"] and not proven
    assert words == "1 seed: no test is possible"


@pytest.mark.parametrize(
    ("claimed", "factor", "verdict"),
    [(0.1, 0.8, "holds"), (0.5, 0.8, "better, by less than claimed"), (0.1, 1.2, "does not hold: worse")],
)
def test_a_claimed_gain_is_compared_with_the_gain_of_medians(
    claimed: float, factor: float, verdict: str
) -> None:
    other = 1.0 + NOISE
    assert claim_gain("", "", claimed, factor * other, other).verdict == verdict


def test_no_gain_is_claimed_from_noise() -> None:
    assert (
        claim_gain("", "", 0.1, 1.0 + RNG.random(20), 1.0 + RNG.random(20)).verdict == "no difference proven"
    )


def test_the_printed_durations_of_d_are_feasible_only_with_the_mended_sign() -> None:
    paper = PaperD()
    assert audit_durations(paper.task(), "", PUBLISHED).feasible
    printed = audit_durations(paper._misprinted(), "", PUBLISHED)
    assert not printed.feasible
    assert "joint 3" in printed.finding


def test_no_uniform_timing_rescues_the_published_total_of_b() -> None:
    task = PaperB().task()
    for shares in ((1.0, 1.0, 1.0), (2.1036, 0.9566, 1.2502)):
        durations = (3.17564 * np.array(shares) / sum(shares)).tolist()
        assert not audit_durations(task, "", durations).feasible


def test_fanucs_description_and_paper_ds_table_place_the_flange_alike() -> None:
    task = PaperD().task()
    arm = with_inertia(task)
    assert task.robot is not None and arm.robot is not None
    turns = []
    for q in np.random.default_rng(1).uniform(-2.0, 2.0, (20, 6)):
        printed, described = task.robot.pose(q), arm.robot.pose(to_fanuc(q))
        np.testing.assert_allclose(printed[:3, 3], described[:3, 3], atol=1e-12)
        turns.append(described[:3, :3].T @ printed[:3, :3])
    np.testing.assert_allclose(np.ptp(turns, axis=0), 0.0, atol=1e-12)


def test_fanucs_arm_weighs_what_its_description_says() -> None:
    arm = with_inertia(PaperD().task()).robot
    assert arm is not None and arm.has_inertia
    assert sum(inertia.mass for inertia in arm.model.inertias) == pytest.approx(
        25.1 + 33.5 + 54.5 + 17.5 + 1.16 + 0.224
    )
