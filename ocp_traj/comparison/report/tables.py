"""The tables of a report, from a judgement."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.report.document import Cell, Table, count, format_number, number, text
from ocp_traj.comparison.report.judging import (
    ComparedProblem,
    Group,
    Judgement,
    describe_failure,
    median_interval,
)
from ocp_traj.comparison.report.profiles import best_at, expected_running_time, target_value
from ocp_traj.comparison.report.statistics import Interval, describe_superiority, median
from ocp_traj.comparison.runs.store import StoredRun
from ocp_traj.references.reference import ESTIMATED, PROVED, TIMED, Reference
from ocp_traj.references.registry import all_references

RUNS_SHOWN = 500
SHOWN_TARGETS = (0.1, 0.01, 0.001)
_BUDGETS = (10, 100, 1_000, 10_000, 100_000, 1_000_000)


def solver_table(judgement: Judgement) -> Table:
    """Return one row a solver, over all problems."""
    rows = []
    for solver in judgement.solvers:
        groups = judgement.of_solver(solver)
        runs, successes = sum(len(group.rows) for group in groups), sum(group.successes for group in groups)
        honest = sum(group.honest for group in groups)
        gaps = np.concatenate([_gaps(group) for group in groups])
        rows.append(
            (
                text(solver),
                number(judgement.ranks.ranks[solver], 3),
                _share(successes, runs),
                _interval(median_interval(gaps, solver), 3),
                number(_median(np.concatenate([_ratios(group, group.problem.toppra) for group in groups]))),
                _share(honest, runs),
                count(_median(np.concatenate([group.values("evaluations") for group in groups]))),
                number(_median(np.concatenate([group.values("build_time") for group in groups])), 3),
                number(_median(np.concatenate([group.values("solve_time") for group in groups])), 3),
            )
        )
    columns = (
        "solver",
        "mean rank",
        "feasible (audit)",
        "gap to best known, % [95 %]",
        "duration / TOPP-RA",
        "return code correct",
        "evaluations",
        "build, s",
        "solve, s",
    )
    note = (
        "Medians over all runs; a failed run counts as infinitely bad. Rank 1 is best. –: no number (failed, or "
        "no reference)."
    )
    return Table("Solvers over all problems", columns, tuple(rows), note)


def result_table(judgement: Judgement) -> Table:
    """Return one row a problem and solver."""
    shown = _shown_references(judgement)
    rows = [
        _result_row(group, shown)
        for problem in judgement.problems
        for solver in judgement.solvers
        if (group := judgement.group(problem, solver)) is not None
    ]
    columns = (
        "problem",
        "solver",
        "feasible (audit)",
        "objective [95 %]",
        "best objective",
        "gap, %",
        "duration, s",
        *(f"/ {reference.title}" for reference in shown),
        "energy, J",
        "evaluations",
        "build, s",
        "solve, s",
    )
    note = (
        "Medians over seeds with bootstrap intervals; with few seeds an interval is hardly more than the "
        "range. Gap: median above the best objective any run here reached."
    )
    note = " ".join([note, *(reference.note for reference in shown if reference.note)])
    return Table("Every solver on every problem", columns, tuple(rows), note, words=2)


def _shown_references(judgement: Judgement) -> list[Reference]:
    """Return the references of which some problem has a duration."""
    return [
        reference
        for reference in all_references()
        if any(problem.known(reference) for problem in judgement.problems)
    ]


def _ratio_cell(group: Group, reference: Reference) -> Cell:
    """Return a duration over a reference's; marked where the reference proves bounds and here only estimates one."""
    part = reference.best(group.problem.known(reference))
    estimated = part is not None and reference.kind_of(part) == ESTIMATED
    proves = any(kind == PROVED for kind, _ in reference.parts.values())
    ratio = _median(_ratios(group, group.problem.best_of(reference)))
    return number(ratio, 4, suffix=" ~" if estimated and proves else "")


def _result_row(group: Group, shown: Sequence[Reference]) -> tuple[Cell, ...]:
    problem = group.problem
    interval = median_interval(group.objectives(), f"{problem.label}/{group.solver}")
    return (
        text(problem.label),
        text(group.solver),
        _share(group.successes, len(group.rows)),
        _interval(interval, 6),
        number(float(group.objectives().min()), 6),
        number(_median(_gaps(group)), 3),
        number(_median(group.durations()), 6),
        *(_ratio_cell(group, reference) for reference in shown),
        number(_median(group.values("energy")), 4),
        count(_median(group.values("evaluations"))),
        number(_median(group.values("build_time")), 3),
        number(_median(group.values("solve_time")), 3),
    )


def _gaps(group: Group) -> Array:
    best = group.problem.best
    if best is None:
        return np.full(len(group.rows), np.inf)
    return 100.0 * (group.objectives() - best) / (abs(best) or 1.0)


def _ratios(group: Group, reference: float | None) -> Array:
    if reference is None:
        return np.empty(0)
    return group.durations() / reference


def _median(values: Array) -> float | None:
    return median(values) if values.size else None


def _share(part: int, whole: int) -> Cell:
    tone = "good" if part == whole else ("bad" if part == 0 else "")
    return Cell(f"{part}/{whole}", part / whole if whole else 0.0, tone)


def _interval(interval: Interval, digits: int) -> Cell:
    if not math.isfinite(interval.median):
        return Cell("–", math.inf)
    sides = [
        format_number(side, digits) if math.isfinite(side) else "∞"
        for side in (interval.lower, interval.upper)
    ]
    middle = format_number(interval.median, digits)
    shown = middle if sides == [middle, middle] else f"{middle} [{sides[0]}, {sides[1]}]"
    return Cell(shown, interval.median)


def terminal_table(judgement: Judgement) -> Table:
    """Return the results in as few columns as a terminal has room for."""
    rows = []
    for problem in judgement.problems:
        for solver in judgement.solvers:
            group = judgement.group(problem, solver)
            if group is None:
                continue
            seconds = group.values("build_time") + group.values("solve_time")
            rows.append(
                (
                    text(problem.label),
                    text(solver),
                    Cell(f"{group.successes}/{len(group.rows)} feasible", group.successes),
                    _interval(median_interval(group.objectives(), f"{problem.label}/{solver}"), 5),
                    number(median(group.durations()), 5),
                    number(_median(_ratios(group, problem.toppra)), 4),
                    count(_median(group.values("evaluations"))),
                    number(_median(seconds), 3),
                )
            )
    columns = (
        "case",
        "solver",
        "audit",
        "objective [95 %]",
        "duration, s",
        "/ TOPP-RA",
        "evaluations",
        "seconds",
    )
    return Table("Results: medians over seeds", columns, tuple(rows), words=2)


def target_table(judgement: Judgement, measure: str) -> Table:
    """Return expected running times to fixed targets."""
    rows = []
    for problem in judgement.problems:
        if problem.best is None:
            continue
        for solver in judgement.solvers:
            group = judgement.group(problem, solver)
            if group is None:
                continue
            goals = [target_value(problem.best, share) for share in SHOWN_TARGETS]
            times = [expected_running_time(group.courses, goal, measure) for goal in goals]
            hits = sum(math.isfinite(course.reach(goals[-1], measure)) for course in group.courses)
            rows.append(
                (
                    text(problem.label),
                    text(solver),
                    *(number(time, 3) for time in times),
                    _share(hits, len(group.courses)),
                )
            )
    targets = tuple(f"to {100 * share:g} %" for share in SHOWN_TARGETS)
    note = (
        "Expected running time of independent restarts (COCO): everything spent, over the number of successes; "
        "–: never reached."
    )
    columns = ("problem", "solver", *targets, f"runs within {100 * SHOWN_TARGETS[-1]:g} %")
    caption = f"Fixed target: expected {measure} until so close to the best known"
    return Table(caption, columns, tuple(rows), note, words=2)


def budget_table(judgement: Judgement) -> Table:
    """Return the median gap after fixed numbers of evaluations."""
    largest = max(
        (course.spent_evaluations for group in judgement.groups.values() for course in group.courses),
        default=0.0,
    )
    budgets = [budget for budget in _BUDGETS if budget <= largest] or [_BUDGETS[0]]
    rows = []
    for problem in judgement.problems:
        for solver in judgement.solvers:
            group = judgement.group(problem, solver)
            if group is None or problem.best is None:
                continue
            gaps = _gaps_at(group, problem, np.array(budgets, dtype=np.float64))
            cells = [number(median(column), 3) for column in gaps.T]
            rows.append((text(problem.label), text(solver), *cells))
    columns = ("problem", "solver", *(f"after {budget}" for budget in budgets))
    note = "Median gap in % of the best known value; –: half of the runs or more have nothing feasible yet."
    return Table("Fixed budget: gap after so many evaluations", columns, tuple(rows), note, words=2)


def _gaps_at(group: Group, problem: ComparedProblem, budgets: Array) -> Array:
    """Return the gap, in % of the best known value, of every run after each budget (runs, budgets)."""
    best = problem.best or 0.0
    costs = np.array([best_at(course, budgets, "evaluations") for course in group.courses])
    return 100.0 * (costs - best) / (abs(best) or 1.0)


def pair_table(judgement: Judgement) -> Table:
    """Return Wilcoxon tests with Holm's correction and effect sizes."""
    rows = [
        (
            text(pair.better),
            text(pair.worse),
            Cell(f"{pair.wins} / {pair.ties} / {pair.losses}", pair.wins),
            number(pair.p, 2),
            number(pair.p_holm, 2, "good" if pair.p_holm < 0.05 else ""),
            number(pair.rank_biserial, 2),
            number(pair.superiority, 2, suffix=f" ({describe_superiority(pair.superiority)})"),
        )
        for pair in judgement.pairs
    ]
    columns = ("better", "than", "wins / ties / losses", "p", "p (Holm)", "rank-biserial", "A (effect)")
    note = (
        "Wilcoxon signed-rank on the ratio of the objective to the best known, paired by "
        + ("problem (medians). " if judgement.block_kind == "problems" else "problem and seed. ")
        + "Ties: within 1e-6. A: chance that a run of the better beats one of the other (Vargha and Delaney)."
    )
    return Table("Pairwise tests", columns, tuple(rows), note, words=2)


def reference_table(judgement: Judgement) -> Table:
    """Return the references of every problem."""
    shown = _shown_references(judgement)
    columns = [(reference, part) for reference in shown for part in (*reference.parts, TIMED)]
    columns = [
        (reference, part)
        for reference, part in columns
        if any(_reference_cell(problem, reference, part).text != "–" for problem in judgement.problems)
    ]
    rows = [
        (
            text(problem.label),
            *(_reference_cell(problem, reference, part) for reference, part in columns),
            number(problem.best, 6),
        )
        for problem in judgement.problems
    ]
    titles = (
        f"{reference.title}, s (path)" if part == TIMED else f"{reference.describe(part)}, s"
        for reference, part in columns
    )
    note = "The bounds know velocity and acceleration limits only; TOPP-RA follows a fixed path without jerk limit."
    return Table("References", ("problem", *titles, "best objective here"), tuple(rows), note)


def _reference_cell(problem: ComparedProblem, reference: Reference, part: str) -> Cell:
    """Return the duration of a reference's part; of its shortest path, and which, for `TIMED`."""
    known = problem.known(reference)
    if part != TIMED:
        return number(known.get(part), 6)
    paths = {name: seconds for name, seconds in known.items() if name not in reference.parts}
    path = min(paths, key=lambda name: paths[name], default="")
    return number(paths.get(path), 6, suffix=f" ({path})" if path else "")


def audit_table(judgement: Judgement, proved: Collection[str] = ()) -> Table:
    """Return what the audit says of the best run of every solver on every problem, or of its failure.

    `proved` are the trajectory files of runs with a proof.
    """
    rows = []
    for problem in judgement.problems:
        for solver in judgement.solvers:
            group = judgement.group(problem, solver)
            if group is None:
                continue
            best = group.best
            row = best if best is not None else group.rows[0]
            said = "feasible, proved" if row.trajectory_file in proved else "feasible"
            verdict = text(said, "good") if best is not None else text("infeasible", "bad")
            rows.append((text(problem.label), text(solver), verdict, *_findings(row)))
    columns = ("problem", "solver", "verdict", "tightest limit", "ratio", "waypoint error", "said")
    note = "The first run where none is feasible."
    return Table("Audit of the best run of each solver", columns, tuple(rows), note, words=4, wide=(6,))


def _findings(row: StoredRun) -> tuple[Cell, ...]:
    record = row.record
    worst = record.worst
    joint = f", joint {worst['joint']}" if worst and worst.get("joint") else ""
    place = f"{worst['limit']}{joint} at {format_number(worst['time'] or 0.0)} s" if worst else "–"
    said = "; ".join(record.findings) or record.message
    return (
        text(place),
        number(worst["ratio"] if worst else None, 7),
        number(record.waypoint_error, 2),
        text(said if len(said) <= 240 else said[:237] + "…"),
    )


def failure_table(judgement: Judgement) -> Table | None:
    """Return why runs failed, counted; None when none did."""
    rows = [
        (text(problem.label), text(solver), text(reason, "bad"), count(runs))
        for problem in judgement.problems
        for solver in judgement.solvers
        if (group := judgement.group(problem, solver)) is not None
        for reason, runs in group.failures.most_common(5)
    ]
    if not rows:
        return None
    return Table(
        "Failures",
        ("problem", "solver", "reason", "runs"),
        tuple(rows),
        "At most the five commonest of a solver.",
        words=3,
    )


def run_table(rows: Sequence[StoredRun]) -> Table:
    """Return the single runs, as many as a page can bear."""
    shown = [
        (
            text(row.case_name),
            text(row.solver),
            count(row.seed),
            text(row.record.status.replace("_", " ")),
            text("feasible", "good") if row.record.feasible else text(describe_failure(row), "bad"),
            number(row.record.objective, 7),
            count(row.record.evaluations),
            number(row.record.wall_time, 3),
        )
        for row in rows[:RUNS_SHOWN]
    ]
    columns = ("case", "solver", "seed", "status", "audit", "objective", "evaluations", "wall time, s")
    note = (
        f"The first {RUNS_SHOWN} of {len(rows)}; all are in results.sqlite." if len(rows) > RUNS_SHOWN else ""
    )
    return Table("Single runs", columns, tuple(shown), note, words=2)
