"""Small-sample statistics of solvers on common problems; a failure is an infinitely bad value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ocp_traj.arrays import Array, ArrayLike

LEVEL = 0.95
TIE = 1e-6
"""Relative differences up to the audit's tolerance are no differences."""


@dataclass(frozen=True)
class Interval:
    """A median and its bootstrap interval."""

    median: float
    lower: float
    upper: float


@dataclass(frozen=True)
class Friedman:
    """Friedman's rank test over blocks: mean ranks (1 is best), statistic and p (None below 3 solvers)."""

    ranks: dict[str, float]
    statistic: float | None
    p: float | None
    blocks: int


@dataclass(frozen=True)
class PairTest:
    """Two solvers on the same blocks.

    Parameters
    ----------
    wins, ties, losses
        Blocks in which `better` is better, equal, worse.
    p, p_holm
        Wilcoxon signed-rank, two-sided, and after Holm's correction over all pairs.
    rank_biserial
        Matched-pairs effect size in [-1, 1]; positive when `better` is better.
    superiority
        Vargha and Delaney's A: chance that a random run of `better` beats one of `worse`, ties half.
    """

    better: str
    worse: str
    wins: int
    ties: int
    losses: int
    p: float
    p_holm: float
    rank_biserial: float
    superiority: float


def bootstrap_median(values: ArrayLike, rng: np.random.Generator, draws: int = 2000) -> Interval:
    """Return the median and its percentile bootstrap interval at `LEVEL`; infinite values are allowed.

    Source: Efron and Tibshirani, An Introduction to the Bootstrap, section 13.3.
    """
    sample = np.sort(np.asarray(values, dtype=np.float64))
    if sample.size == 0:
        return Interval(np.nan, np.nan, np.nan)
    # "inverted_cdf" takes observed values only: interpolating towards infinity would give nan.
    medians = np.quantile(
        sample[rng.integers(0, sample.size, (draws, sample.size))], 0.5, axis=1, method="inverted_cdf"
    )
    tail = (1.0 - LEVEL) / 2.0
    lower, upper = np.quantile(medians, [tail, 1.0 - tail], method="inverted_cdf")
    return Interval(median(sample), float(lower), float(upper))


def median(values: ArrayLike) -> float:
    """Return the median of at least one value; half infinite is infinite."""
    ordered = np.sort(np.asarray(values, dtype=np.float64))
    middle = ordered[(ordered.size - 1) // 2], ordered[ordered.size // 2]
    return float(middle[0]) if middle[0] == middle[1] else float(np.mean(middle))


def quartiles(values: Array) -> Array:
    """Return lower quartile, median and upper quartile along the first axis, without averaging with infinity.

    Parameters
    ----------
    values
        (S,) or (S, N); without any, the three are undefined.
    """
    if not len(values):
        return np.full((3, *values.shape[1:]), np.nan)
    return np.quantile(values, [0.25, 0.5, 0.75], axis=0, method="inverted_cdf")


def holm(p: ArrayLike) -> Array:
    """Return Holm's step-down adjusted p-values (Holm 1979), in the order given."""
    values = np.asarray(p, dtype=np.float64)
    order = np.argsort(values, kind="stable")
    scaled = values[order] * np.arange(values.size, 0, -1)
    adjusted = np.empty_like(values)
    adjusted[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return adjusted


def rank_blocks(values: Array) -> Array:
    """Return ranks inside each row, 1 is smallest; values closer than `TIE` (relative) share a rank."""
    from scipy.stats import rankdata

    return np.asarray(rankdata(snap_ties(values), axis=1), dtype=np.float64)


def snap_ties(values: Array) -> Array:
    """Return the values with those within `TIE` of the next smaller in their row made equal to it."""
    order = np.argsort(values, axis=1, kind="stable")
    snapped = np.take_along_axis(values, order, axis=1)
    for column in range(1, snapped.shape[1]):
        previous, current = snapped[:, column - 1], snapped[:, column]
        finite = np.isfinite(current)
        close = np.zeros(len(current), dtype=bool)
        close[finite] = current[finite] - previous[finite] <= TIE * np.abs(previous[finite])
        snapped[:, column] = np.where(close, previous, current)
    result = np.empty_like(values)
    np.put_along_axis(result, order, snapped, axis=1)
    return result


def friedman(values: Array, names: list[str]) -> Friedman:
    """Test whether any solver differs: rows are blocks, columns solvers, smaller is better.

    Source: Friedman 1937; Demsar, JMLR 7 (2006), section 3.2.2. Ties are corrected for.
    """
    ranks = rank_blocks(values)
    blocks, count = ranks.shape
    mean = (
        dict(zip(names, ranks.mean(axis=0).tolist(), strict=True)) if blocks else dict.fromkeys(names, np.nan)
    )
    if count < 3 or blocks < 2:
        return Friedman(mean, None, None, blocks)
    spread = float(((ranks - (count + 1) / 2) ** 2).sum())
    if spread == 0.0:
        return Friedman(mean, 0.0, 1.0, blocks)
    from scipy.stats import chi2

    between = float(((ranks.sum(axis=0) - blocks * (count + 1) / 2) ** 2).sum())
    statistic = (count - 1) * between / spread
    return Friedman(mean, statistic, float(chi2.sf(statistic, count - 1)), blocks)


def compare_pairs(values: Array, names: list[str]) -> list[PairTest]:
    """Test every pair of columns: Wilcoxon's signed ranks with Holm's correction, and effect sizes.

    Rows are blocks, smaller is better, infinite is failed; two failures tie, a failure against a success is
    the largest difference there is.
    """
    snapped = snap_ties(values)
    raw = []
    for first in range(len(names)):
        for second in range(first + 1, len(names)):
            pair = _ordered_pair(snapped[:, first], snapped[:, second])
            raw.append((names[first], names[second], *pair))
    adjusted = holm([entry[3] for entry in raw])
    return [
        _pair_test(first, second, differences, p, float(p_holm), superiority)
        for (first, second, differences, p, superiority), p_holm in zip(raw, adjusted, strict=True)
    ]


def _ordered_pair(first: Array, second: Array) -> tuple[Array, float, float]:
    """Return signed differences (second - first), Wilcoxon's p, and the superiority of the first."""
    differences = _finite_differences(first, second)
    nonzero = differences[differences != 0]
    superiority = float(np.mean((first[:, None] < second) + 0.5 * (first[:, None] == second)))
    if nonzero.size == 0:
        return differences, 1.0, superiority
    from scipy.stats import wilcoxon

    # Zeros are dropped as Wilcoxon did; the exact distribution is used where there are no ties in rank.
    method = "exact" if nonzero.size <= 50 and np.unique(np.abs(nonzero)).size == nonzero.size else "approx"
    return differences, float(wilcoxon(nonzero, method=method).pvalue), superiority


def _finite_differences(first: Array, second: Array) -> Array:
    both = np.isfinite(first) & np.isfinite(second)
    differences = np.zeros(len(first))
    differences[both] = second[both] - first[both]
    largest = 2.0 * np.abs(differences).max(initial=0.0) + 1.0
    # Distinct sizes keep the exact test usable; the order among failures is that of the block.
    steps = largest * (1.0 + np.arange(len(first)) / (len(first) + 1.0))
    differences[np.isinf(second) & np.isfinite(first)] = steps[np.isinf(second) & np.isfinite(first)]
    differences[np.isinf(first) & np.isfinite(second)] = -steps[np.isinf(first) & np.isfinite(second)]
    return differences


def _pair_test(
    first: str, second: str, differences: Array, p: float, p_holm: float, superiority: float
) -> PairTest:
    effect = rank_biserial(differences)
    wins, losses = int((differences > 0).sum()), int((differences < 0).sum())
    ties = len(differences) - wins - losses
    if effect < 0 or (effect == 0 and superiority < 0.5):
        return PairTest(second, first, losses, ties, wins, p, p_holm, -effect, 1.0 - superiority)
    return PairTest(first, second, wins, ties, losses, p, p_holm, effect, superiority)


def rank_biserial(differences: Array) -> float:
    """Return the matched-pairs rank-biserial correlation (Kerby 2014): favourable less unfavourable ranks."""
    from scipy.stats import rankdata

    nonzero = differences[differences != 0]
    if nonzero.size == 0:
        return 0.0
    ranks = rankdata(np.abs(nonzero))
    return float((ranks * np.sign(nonzero)).sum() / ranks.sum())


def describe_superiority(superiority: float) -> str:
    """Return Vargha and Delaney's word for the size of an effect (2000, table 1)."""
    distance = abs(superiority - 0.5)
    for bound, word in ((0.06, "negligible"), (0.14, "small"), (0.21, "medium")):
        if distance < bound:
            return word
    return "large"
