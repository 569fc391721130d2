"""The plain sentences of a report: who wins, by how much, how sure; what it ran on; what it cannot tell."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.report.judging import Judgement, median_interval, objective_of
from ocp_traj.comparison.report.statistics import LEVEL, TIE, PairTest, describe_superiority, median

SIGNIFICANT = 1.0 - LEVEL


def tell_story(judgement: Judgement, planned: int, stored: int) -> list[str]:
    """Return the findings in plain sentences, the most important first.

    Parameters
    ----------
    judgement
        What was found.
    planned, stored
        Runs the plan asks for, and runs there are.
    """
    sentences = []
    if stored < planned:
        sentences.append(f"This comparison is unfinished: {stored} of {planned} runs are there.")
    if not judgement.groups:
        return [*sentences, "There is nothing to judge yet."]
    if all(problem.best is None for problem in judgement.problems):
        return [*sentences, "No run of any solver ended with a motion the audit accepts."]
    sentences.append(_winner(judgement))
    sentences += _margins(judgement)
    sentences.append(_sureness(judgement))
    sentences += _references(judgement)
    sentences.append(_costs(judgement))
    sentences.append(_reliability(judgement))
    return sentences


def _winner(judgement: Judgement) -> str:
    best = judgement.solvers[0]
    if len(judgement.solvers) == 1:
        group_count = len(judgement.of_solver(best))
        return f"Only {best} was run, on {group_count} {_plural('problem', group_count)}."
    blocks = len(judgement.ratios)
    if blocks == 0:
        return "No block has runs of all solvers yet, so they cannot be ranked."
    tied = [name for name in judgement.solvers if judgement.ranks.ranks[name] == judgement.ranks.ranks[best]]
    if len(tied) > 1:
        return (
            f"No solver leads: {', '.join(tied)} share the best mean rank, {judgement.ranks.ranks[best]:.2f}."
        )
    least = judgement.ratios.min(axis=1)
    firsts = int(((judgement.ratios[:, 0] <= least * (1 + TIE)) & np.isfinite(least)).sum())
    kind = "problems" if judgement.block_kind == "problems" else "paired runs (problem and seed)"
    return (
        f"{best} ranks first: mean rank {judgement.ranks.ranks[best]:.2f} of {len(judgement.solvers)} "
        f"solvers, best or equal best in {firsts} of {blocks} {kind}."
    )


def _margins(judgement: Judgement) -> list[str]:
    """Return how the others stand to the first, where both succeed, and how often they fail."""
    first, sentences = judgement.solvers[0], []
    for place, solver in enumerate(judgement.solvers[1:], start=1):
        ours, theirs = judgement.ratios[:, 0], judgement.ratios[:, place]
        both = np.isfinite(ours) & np.isfinite(theirs)
        if judgement.block_kind == "problems" and both.any():
            excess = _excess(solver, theirs[both] / ours[both] - 1.0)
            sentences.append(
                f"The objective of {solver} is {excess} that of {first}: median over the problems."
            )
        elif both.any():
            sentences.append(_margins_by_problem(judgement, first, solver))
        lost = int((np.isinf(theirs) & np.isfinite(ours)).sum())
        won = int((np.isfinite(theirs) & np.isinf(ours)).sum())
        if lost:
            sentences.append(f"{solver} fails in {lost} of {len(theirs)} blocks in which {first} succeeds.")
        if won:
            sentences.append(f"{first} fails in {won} of {len(theirs)} blocks in which {solver} succeeds.")
    return sentences


def _margins_by_problem(judgement: Judgement, first: str, solver: str) -> str:
    """Return how a solver stands to the first on each problem: few problems do not average."""
    said = []
    for problem in judgement.problems:
        ours, theirs = judgement.group(problem, first), judgement.group(problem, solver)
        if ours is None or theirs is None:
            continue
        costs = {row.seed: objective_of(row) for row in ours.rows}
        paired = np.array([[costs.get(row.seed, np.inf), objective_of(row)] for row in theirs.rows])
        paired = paired[np.isfinite(paired).all(axis=1) & (paired[:, 0] > 0)]
        if len(paired):
            said.append(f"{_excess(solver, paired[:, 1] / paired[:, 0] - 1.0)} on {problem.label}")
    return f"The objective of {solver} against that of {first}, medians: {'; '.join(said)}."


def _excess(label: str, excess: Array) -> str:
    """Return a median relative difference with its bootstrap interval, in words."""
    interval = median_interval(excess, label)
    if abs(interval.median) <= TIE:
        return "equal to within 1e-6"
    word, sign = ("above", 1.0) if interval.median > 0 else ("below", -1.0)
    middle, *sides = (_percent(sign * value) for value in (interval.median, interval.lower, interval.upper))
    spread = (
        "" if sides == [middle, middle] else f" (95 % interval {' to '.join(sorted(sides, key=float))} %)"
    )
    return f"{middle} %{spread} {word}"


def _percent(share: float) -> str:
    return f"{100 * share:.0f}" if abs(share) >= 1 else f"{100 * share:.2g}"


def _sureness(judgement: Judgement) -> str:
    if len(judgement.solvers) < 2 or not judgement.pairs:
        return "With one solver there is nothing to test."
    scope = (
        "The blocks are different problems, so this says something about problems like these."
        if judgement.block_kind == "problems"
        else "The blocks are repeated runs on few problems, so this is about these problems only."
    )
    first = judgement.solvers[0]
    pairs = [pair for pair in judgement.pairs if first in (pair.better, pair.worse)]
    sure = [pair for pair in pairs if pair.p_holm < SIGNIFICANT and pair.better == first]
    if len(sure) == len(pairs):
        verdict = f"The lead of {first} over every other solver is more than chance ({_largest(sure)})"
    elif sure:
        names = ", ".join(pair.worse for pair in sure)
        verdict = f"The lead of {first} is more than chance over {names} ({_largest(sure)})"
        verdict += ", not over the others"
    else:
        smallest = min(pair.p_holm for pair in pairs)
        verdict = f"No lead of {first} is proven: smallest corrected p {smallest:.2g}"
        least = 2.0 ** (1 - judgement.ranks.blocks) * len(judgement.pairs)
        if least >= SIGNIFICANT:
            verdict += (
                f" ({judgement.ranks.blocks} blocks could not show any lead; more seeds or problems can)"
            )
    overall = ""
    if judgement.ranks.p is not None:
        overall = f" Friedman over {judgement.ranks.blocks} blocks: p = {judgement.ranks.p:.2g}."
    return f"{verdict}.{overall} {scope}"


def _largest(pairs: list[PairTest]) -> str:
    weakest = max(pairs, key=lambda pair: pair.p_holm)
    effect = describe_superiority(weakest.superiority)
    least = min(pair.superiority for pair in pairs)
    return f"Wilcoxon, Holm: p ≤ {weakest.p_holm:.2g}; effect {effect}, A ≥ {least:.2f}"


def _references(judgement: Judgement) -> list[str]:
    sentences = []
    for problem in judgement.problems:
        durations = {
            solver: float(group.durations().min())
            for solver in judgement.solvers
            if (group := judgement.group(problem, solver)) is not None and group.successes
        }
        if not durations:
            sentences.append(f"{problem.label}: no feasible motion was found.")
            continue
        solver = min(durations, key=lambda name: durations[name])
        said = [f"{problem.label}: the shortest feasible motion takes {durations[solver]:.4f} s ({solver})"]
        if problem.toppra:
            said.append(f"{durations[solver] / problem.toppra:.3f} times TOPP-RA's {problem.toppra:.4f} s")
        bound = problem.lower_bound or problem.estimate
        if bound:
            kind = "certified" if problem.lower_bound else "estimated"
            said.append(f"{durations[solver] / bound:.3f} times the {kind} kinematic bound")
        sentences.append(", ".join(said) + ".")
    return sentences


def _costs(judgement: Judgement) -> str:
    said = []
    for solver in judgement.solvers:
        groups = judgement.of_solver(solver)
        evaluations = median(np.concatenate([group.values("evaluations") for group in groups]))
        seconds = median(
            np.concatenate([group.values("build_time") + group.values("solve_time") for group in groups])
        )
        told = np.isfinite([evaluations, seconds]).all()
        said.append(
            f"{solver} {evaluations:.7g} evaluations, {seconds:.2g} s" if told else f"{solver} none told"
        )
    return f"Median cost of a run: {'; '.join(said)}."


def _reliability(judgement: Judgement) -> str:
    records = [row.record for group in judgement.groups.values() for row in group.rows]
    said = [f"The audit accepts {sum(record.feasible for record in records)} of {len(records)} runs."]
    lies = sum(record.claimed and not record.feasible for record in records)
    modest = sum(record.feasible and not record.claimed for record in records)
    if lies:
        said.append(
            f"In {lies} {_plural('run', lies)} the solver claims a feasible answer that the audit refuses."
        )
    if modest:
        said.append(
            f"In {modest} {_plural('run', modest)} the audit accepts an answer the solver did not vouch for."
        )
    return " ".join(said)


def _plural(word: str, count: int) -> str:
    return word if count == 1 else f"{word}s"


def describe_machine(environment: dict[str, Any]) -> str:
    """Return machine, versions and source state in one paragraph."""
    machine = environment["machine"]
    versions = ", ".join(f"{name} {version}" for name, version in environment["versions"].items() if version)
    git = environment.get("git")
    source = ""
    if git and git["commit"]:
        source = f" Source: commit {git['commit'][:12]}{'' if git['clean'] else ' with local changes'}."
    memory = machine["memory_gb"]
    return (
        f"{machine['processor']}, {machine['cores']} cores"
        f"{'' if memory is None or math.isnan(memory) else f', {memory:g} GB'}, {machine['system']}; "
        f"Python {environment['python']}, {versions}. Workers: {environment.get('workers', 1)}, one thread a "
        f"run.{source}"
    )


LIMITATIONS = (
    "Solvers run with the settings named, untuned for these problems; other settings can change the order.",
    "An evaluation of a gradient solver includes derivatives and is not the same work as one of a population "
    "method: compare seconds as well.",
    "Only the last answer of a run is audited; earlier points of its course are feasible by the solver's own "
    "rows, and count only when the last answer is accepted, at no better cost than that.",
    "Seconds depend on the machine and on what else it did; runs share its cores.",
    "The best known value is the best of this comparison (references apart): if all solvers miss the "
    "optimum, gaps are too small.",
    "A deterministic solver repeats itself on every seed: its runs are one observation, not several.",
    "The kinematic bound ignores jerk and torque; TOPP-RA follows a fixed path and ignores jerk, so a ratio "
    "below 1 is a better path, one above 1 may be the price of the jerk limit.",
)
"""What a comparison of this kind cannot tell."""
