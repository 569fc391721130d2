"""Words and numbers the papers' pages share: medians, rankings with tests, verdicts on claims."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.report.statistics import compare_pairs, friedman, quartiles
from ocp_traj.papers.paper import Claim

SIGNIFICANT = 0.05

FEW = 4
"""Methods whose pairs are all named in a ranking."""


def number(value: float | None, digits: int = 4) -> str:
    """Format a number for a table; none and infinity say so."""
    if value is None or np.isnan(value):
        return "—"
    return "infeasible" if np.isinf(value) else f"{value:.{digits}f}"


def with_unit(value: float, unit: str) -> str:
    """Format a number with its unit; what is counted in generations is whole."""
    if np.isinf(value):
        return number(value)
    return f"{number(value, 0 if unit == 'generations' else 4)} {unit}".rstrip()


def spread_of(values: Array, digits: int = 4) -> str:
    """Write a median with its quartiles."""
    low, middle, high = quartiles(values)
    if np.isinf(low):
        return number(low)
    return f"{number(middle, digits)} ({number(low, digits)} to {number(high, digits)})"


def columns_of(columns: dict[str, Array]) -> Array:
    """Return columns side by side, cut to the seeds that all have, (S, C)."""
    count = min((len(column) for column in columns.values()), default=0)
    return np.stack([column[:count] for column in columns.values()], axis=1)


def order_with_tests(columns: dict[str, Array]) -> tuple[list[str], set[tuple[str, str]], str]:
    """Return labels by median, the proven (better, worse) pairs, and the sentence of both tests.

    `columns` holds one number a seed for every label, smaller is better. Friedman's test over all; where that is
    significant, Wilcoxon's signed ranks with Holm's correction over all pairs, at 5 %. A is the chance that a run of
    the first is better than one of the second.
    """
    labels, values = list(columns), columns_of(columns)
    medians = [quartiles(values[:, k])[1] for k in range(len(labels))]
    ordered = [labels[k] for k in np.argsort(medians, kind="stable")]
    if len(values) < 2:
        return ordered, set(), f"{len(values)} seed: no test is possible"
    overall = friedman(values, labels)
    pairs = [pair for pair in compare_pairs(values, labels) if pair.p_holm < SIGNIFICANT]
    words = [f"{len(values)} seeds"]
    if overall.p is not None:
        words.append(f"Friedman p = {overall.p:.2g}")
    if overall.p is not None and overall.p >= SIGNIFICANT:
        words.append("not significant at 5 %, so no pair is judged")
        return ordered, set(), "; ".join(words)
    words += [
        f"{pair.better} before {pair.worse} (Wilcoxon, Holm p = {pair.p_holm:.2g}, A = {pair.superiority:.2f})"
        for pair in pairs
    ]
    if not pairs:
        words.append("no difference between two of them is significant at 5 % (Wilcoxon, Holm)")
    return ordered, {(pair.better, pair.worse) for pair in pairs}, "; ".join(words)


def ranking_words(columns: dict[str, Array]) -> str:
    """Say the order of methods and what is proved of it; of many methods only how many others each one beats."""
    ordered, proven, tests = order_with_tests(columns)
    if len(columns) <= FEW or "no test" in tests:
        return tests
    beaten = {label: sum(better == label for better, _ in proven) for label in ordered}
    head = "; ".join(tests.split("; ")[:2])
    places = ", ".join(f"{label} ({beaten[label]})" for label in ordered)
    return (
        f"{head}. In the order of medians, in brackets how many others each is proved to beat (Wilcoxon, Holm, 5 %): "
        f"{places}"
    )


STAND_IN = " on the stand-in case"
"""What a refuted claim's verdict adds where the case is not the paper's own."""


def claim_order(
    sentence: str, source: str, columns: dict[str, Array], unit: str, *, order: Sequence[str] = (), where: str = ""
) -> Claim:
    """Judge a claimed order, best first: that of `columns`, or `order` of some among them.

    All of `columns` are one family of tests. `where` goes with a verdict that the claim does not hold.
    """
    labels = list(order or columns)
    return _claim_pairs(sentence, source, columns, unit, set(zip(labels, labels[1:], strict=False)), where)


def claim_first(sentence: str, source: str, columns: dict[str, Array], unit: str, where: str = "") -> Claim:
    """Judge the claim that the first of `columns` is smaller than each of the others, in whatever order they are."""
    first, *others = columns
    return _claim_pairs(sentence, source, columns, unit, {(first, other) for other in others}, where)


def claim_last(sentence: str, source: str, columns: dict[str, Array], unit: str, where: str = "") -> Claim:
    """Judge the claim that the last of `columns` is larger than each of the others, in whatever order they are."""
    *others, last = columns
    return _claim_pairs(sentence, source, columns, unit, {(other, last) for other in others}, where)


def claim_unpaired(sentence: str, source: str, mine: tuple[str, Array], other: tuple[str, Array]) -> Claim:
    """Judge that independent numbers of `mine` are typically smaller than those of `other`, each (label, numbers)."""
    from scipy.stats import mannwhitneyu

    test = mannwhitneyu(mine[1], other[1])
    chance = 1.0 - float(test.statistic) / (len(mine[1]) * len(other[1]))
    spreads = ", ".join(
        f"{label}: median {np.median(values):.2f}, 95 % quantile {np.quantile(values, 0.95):.2f}"
        for label, values in (mine, other)
    )
    measured = f"{spreads}; {len(mine[1])} repetitions; Mann-Whitney p = {test.pvalue:.2g}, A = {chance:.2f}"
    if test.pvalue >= SIGNIFICANT:
        return Claim(sentence, source, measured, "not proven")
    return Claim(sentence, source, measured, "holds" if chance > 0.5 else "does not hold")


def _claim_pairs(
    sentence: str,
    source: str,
    columns: dict[str, Array],
    unit: str,
    wanted: set[tuple[str, str]],
    where: str = "",
) -> Claim:
    ordered, proven, tests = order_with_tests(columns)
    medians = ", ".join(f"{label} {with_unit(quartiles(columns[label])[1], unit)}" for label in ordered)
    if wanted <= proven:
        verdict = "holds"
    elif any((second, first) in proven for first, second in wanted):
        verdict = f"does not hold{where}"
    else:
        verdict = "not proven"
    return Claim(sentence, source, f"medians: {medians}. {tests}", verdict)


def claim_gain(
    sentence: str, source: str, claimed: float, mine: Array, other: Array, digits: int = 4
) -> Claim:
    """Judge a claimed relative gain of `mine` over `other` (one number a seed, smaller is better)."""
    count = min(len(mine), len(other))
    first, second = quartiles(mine[:count])[1], quartiles(other[:count])[1]
    gain = 1.0 - first / second if np.isfinite(first) and second > 0 else np.nan
    p = compare_pairs(np.stack([mine[:count], other[:count]], axis=1), ["mine", "other"])[0].p
    medians = f"medians {number(first, digits)} and {number(second, digits)}"
    measured = f"{100 * gain:.1f} % ({medians}; Wilcoxon p = {p:.2g})"
    if p >= SIGNIFICANT or np.isnan(gain):
        verdict = "no difference proven"
    elif gain >= claimed - 0.005:
        verdict = "holds"
    else:
        verdict = "better, by less than claimed" if gain > 0 else "does not hold: worse"
    return Claim(sentence, source, measured, verdict)
