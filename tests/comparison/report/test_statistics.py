"""Statistics agree with SciPy where both apply, and count failures as the worst there is."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from ocp_traj.comparison.report.statistics import (
    bootstrap_median,
    compare_pairs,
    describe_superiority,
    friedman,
    holm,
    median,
    rank_biserial,
    snap_ties,
)

INF = np.inf


def test_friedman_agrees_with_scipy() -> None:
    values = np.random.default_rng(0).normal(size=(12, 4)) + np.arange(4) * 0.5
    ours = friedman(values, list("abcd"))
    statistic, p = stats.friedmanchisquare(*values.T)
    assert ours.statistic == pytest.approx(statistic)
    assert ours.p == pytest.approx(p)
    assert ours.ranks["a"] < ours.ranks["d"]


def test_friedman_with_ties_agrees_with_scipy() -> None:
    values = np.random.default_rng(1).integers(1, 4, size=(15, 3)).astype(float)
    ours = friedman(values, list("abc"))
    statistic, p = stats.friedmanchisquare(*values.T)
    assert (ours.statistic, ours.p) == (pytest.approx(statistic), pytest.approx(p))


def test_friedman_of_equal_solvers_finds_nothing() -> None:
    assert friedman(np.ones((4, 3)), list("abc")).p == 1.0


def test_friedman_needs_three_solvers() -> None:
    assert friedman(np.ones((4, 2)), list("ab")).p is None


def test_wilcoxon_agrees_with_scipy_and_names_the_better() -> None:
    rng = np.random.default_rng(2)
    values = np.stack([rng.normal(5, 1, 14), rng.normal(6, 1, 14)], axis=1)
    (pair,) = compare_pairs(values, ["a", "b"])
    assert pair.p == pytest.approx(stats.wilcoxon(values[:, 0], values[:, 1], method="exact").pvalue)
    assert (pair.better, pair.worse) == ("a", "b")
    assert pair.wins + pair.ties + pair.losses == 14


def test_holm_steps_down() -> None:
    np.testing.assert_allclose(holm([0.01, 0.04, 0.03]), [0.03, 0.06, 0.06])
    np.testing.assert_allclose(holm([0.5, 0.9]), [1.0, 1.0])


def test_a_failure_is_worse_than_any_success_and_equal_to_a_failure() -> None:
    values = np.array([[1.0, INF], [INF, INF], [1.0, INF], [2.0, INF], [1.5, INF], [1.2, INF], [1.1, INF]])
    (pair,) = compare_pairs(values, ["a", "b"])
    assert (pair.better, pair.wins, pair.ties, pair.losses) == ("a", 6, 1, 0)
    assert pair.p == pytest.approx(2 / 2**6)
    assert pair.rank_biserial == 1.0


def test_differences_within_the_audit_tolerance_are_ties() -> None:
    snapped = snap_ties(np.array([[1.0 + 5e-7, 1.0, 1.1], [INF, 2.0, INF]]))
    np.testing.assert_array_equal(snapped, [[1.0, 1.0, 1.1], [INF, 2.0, INF]])


def test_rank_biserial_by_hand() -> None:
    # Ranks of |d| are 1, 2, 3; the favourable ones (positive) are 1 and 3.
    assert rank_biserial(np.array([0.1, -0.2, 0.3])) == pytest.approx((1 + 3 - 2) / 6)


def test_superiority_by_hand() -> None:
    (pair,) = compare_pairs(np.array([[1.0, 2.0], [3.0, 4.0]]), ["a", "b"])
    # 1 beats 2 and 4, 3 beats 4: three of four pairs.
    assert pair.superiority == 0.75
    assert describe_superiority(0.75) == "large"
    assert describe_superiority(0.5) == "negligible"


def test_the_median_of_mostly_failures_is_infinite() -> None:
    assert median([1.0, INF, INF]) == INF
    assert median([1.0, 2.0, INF]) == 2.0
    assert median([1.0, INF]) == INF


def test_the_bootstrap_interval_covers_the_median() -> None:
    rng = np.random.default_rng(3)
    hits = 0
    for _ in range(200):
        interval = bootstrap_median(rng.normal(size=25), rng, 500)
        hits += interval.lower <= 0.0 <= interval.upper
    assert 180 <= hits <= 200


def test_the_bootstrap_bears_failures() -> None:
    interval = bootstrap_median([1.0, 2.0, INF], np.random.default_rng(0))
    assert (interval.median, interval.lower, interval.upper) == (2.0, 1.0, INF)
