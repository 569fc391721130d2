"""A claim is judged by a test over seeds, never by one run."""

from __future__ import annotations

import numpy as np
import pytest

from ocp_traj.papers.ma_2024.claims import misses_of_equation_5
from ocp_traj.papers.ma_2024.experiment import Ma2024
from ocp_traj.papers.measures import (
    STAND_IN,
    claim_first,
    claim_gain,
    claim_last,
    claim_order,
    claim_unpaired,
    order_with_tests,
    ranking_words,
)
from ocp_traj.papers.motions import audit_durations
from ocp_traj.papers.zhang_2022.inverse_timing import timing_claims
from ocp_traj.papers.zhu_wang.claims import PUBLISHED, heights, misprinted
from ocp_traj.papers.zhu_wang.experiment import ZhuWang
from ocp_traj.papers.zhu_wang.fanuc_inertia import to_fanuc, with_inertia

RNG = np.random.default_rng(5)
NOISE = 0.01 * RNG.random(20)


def test_a_claimed_order_holds_only_where_neighbours_differ_significantly() -> None:
    columns = {"a": 1.0 + NOISE, "b": 2.0 + NOISE[::-1], "c": 3.0 + NOISE}
    assert claim_order("a < b < c", "", columns, "s").verdict == "holds"
    assert claim_order("c < a", "", {"c": columns["c"], "a": columns["a"]}, "s").verdict == "does not hold"
    close = {"a": 1.0 + RNG.random(20), "b": 1.0 + RNG.random(20)}
    assert claim_order("a < b", "", close, "s").verdict == "not proven"


def test_no_pair_is_judged_where_the_methods_as_a_whole_do_not_differ() -> None:
    rng = np.random.default_rng(3)
    columns = {"a": np.arange(20.0), "b": np.arange(20.0) + 0.1, "c": 30 * rng.permutation(20)}
    alone, family = (order_with_tests({label: columns[label] for label in labels}) for labels in ("ab", "abc"))
    assert alone[1] == {("a", "b")} and "A = 0.53" in alone[2]
    assert "Friedman" in family[2]
    level = {label: rng.random(20) for label in "abcd"}
    level["b"] = level["a"] + 1e-3
    _, proven, words = order_with_tests(level)
    assert not proven and "no pair is judged" in words
    verdict = claim_order("a < b", "", level, "s", order=("a", "b")).verdict
    assert verdict == "not proven"


def test_a_refuted_claim_says_that_the_case_is_a_stand_in() -> None:
    columns = {"a": 2.0 + NOISE, "b": 1.0 + NOISE}
    assert claim_order("a < b", "", columns, "s", where=STAND_IN).verdict == "does not hold on the stand-in case"
    assert claim_order("b < a", "", columns, "s", order=("b", "a"), where=STAND_IN).verdict == "holds"


def test_independent_numbers_are_compared_unpaired() -> None:
    rng = np.random.default_rng(4)
    small, large = rng.random(300), rng.random(300) + 0.3
    claim = claim_unpaired("", "", ("small", small), ("large", large))
    assert claim.verdict == "holds" and "Mann-Whitney" in claim.measured and "A = 0.7" in claim.measured
    assert claim_unpaired("", "", ("large", large), ("small", small)).verdict == "does not hold"
    assert claim_unpaired("", "", ("a", rng.random(300)), ("b", rng.random(300))).verdict == "not proven"


def test_the_ranking_of_many_methods_counts_whom_each_beats() -> None:
    columns = {f"m{k}": k + NOISE for k in (3, 1, 5, 2, 4)}
    words = ranking_words(columns)
    assert words.startswith("20 seeds; Friedman p = ")
    assert words.endswith("m1 (4), m2 (3), m3 (2), m4 (1), m5 (0)")
    assert "m1 before m2 (Wilcoxon" in ranking_words({label: columns[label] for label in ("m1", "m2")})
    assert (
        ranking_words({label: values[:1] for label, values in columns.items()})
        == "1 seed: no test is possible"
    )


def test_first_and_last_do_not_care_for_the_order_of_the_others() -> None:
    columns = {"a": 1.0 + NOISE, "c": 3.0 + NOISE, "b": 2.0 + NOISE[::-1]}
    assert claim_order("a < c < b", "", columns, "s").verdict == "does not hold"
    assert claim_first("a is least", "", columns, "s").verdict == "holds"
    assert claim_last("b is largest", "", columns, "s").verdict == "does not hold"
    largest_last = {label: columns[label] for label in "bac"}
    assert claim_last("c is largest", "", largest_last, "s").verdict == "holds"
    assert claim_first("b is least", "", largest_last, "s").verdict == "does not hold"


def test_a_proportion_that_stays_the_same_does_not_grow() -> None:
    def row(form: str, points: int, one: float) -> dict[str, object]:
        return {
            "form": form,
            "points": points,
            "best_eight": points * 1.0,
            "best_one": points * one,
            "saving": 1 - one,
        }

    same, growing = (
        [row("python", 9, 0.5), row("python", 90, 0.5)],
        [row("python", 9, 0.5), row("python", 90, 0.2)],
    )
    assert timing_claims(same)[0].verdict == "holds: at least that"
    assert timing_claims(same)[1].verdict.startswith(
        "does not hold: in plain Python the proportion changes by +0.0"
    )
    assert timing_claims(growing)[1].verdict.startswith("depends on the form")
    assert (
        timing_claims([row("python", 9, 0.5), row("vectorised", 9, 0.7)])[0].verdict == "depends on the form"
    )


def test_equation_5_of_b_misses_with_the_printed_position_and_holds_for_the_wrist_centre() -> None:
    printed, mended = misses_of_equation_5(Ma2024())
    assert printed > 0.05
    assert mended < 1e-12


def test_the_printed_signs_of_alpha_put_ds_points_below_the_floor() -> None:
    below, above = heights(ZhuWang())
    assert all(float(height) < -1.0 for height in below.split(", "))
    assert all(float(height) > 0.0 for height in above.split(", "))


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
    paper = ZhuWang()
    assert audit_durations(paper.task(), "", PUBLISHED).feasible
    printed = audit_durations(misprinted(paper), "", PUBLISHED)
    assert not printed.feasible
    assert "joint 3" in printed.finding


def test_no_uniform_timing_rescues_the_published_total_of_b() -> None:
    task = Ma2024().task()
    for shares in ((1.0, 1.0, 1.0), (2.1036, 0.9566, 1.2502)):
        durations = (3.17564 * np.array(shares) / sum(shares)).tolist()
        assert not audit_durations(task, "", durations).feasible


def test_fanucs_description_and_paper_ds_table_place_the_flange_alike() -> None:
    task = ZhuWang().task()
    arm = with_inertia(task)
    assert task.robot is not None and arm.robot is not None
    turns = []
    for q in np.random.default_rng(1).uniform(-2.0, 2.0, (20, 6)):
        printed, described = task.robot.pose(q), arm.robot.pose(to_fanuc(q))
        np.testing.assert_allclose(printed[:3, 3], described[:3, 3], atol=1e-12)
        turns.append(described[:3, :3].T @ printed[:3, :3])
    np.testing.assert_allclose(np.ptp(turns, axis=0), 0.0, atol=1e-12)


def test_fanucs_arm_weighs_what_its_description_says() -> None:
    arm = with_inertia(ZhuWang().task()).robot
    assert arm is not None and arm.has_inertia
    assert sum(inertia.mass for inertia in arm.model.inertias) == pytest.approx(
        25.1 + 33.5 + 54.5 + 17.5 + 1.16 + 0.224
    )
