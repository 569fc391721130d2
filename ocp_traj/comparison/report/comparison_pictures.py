"""The pictures of a comparison: convergence, runtime distributions, performance and data profiles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.comparison.report.judging import ComparedProblem, Group, Judgement
from ocp_traj.comparison.report.profiles import (
    TARGETS,
    Curve,
    best_at,
    data_profiles,
    distribution,
    performance_profiles,
    simulate_restarts,
    target_value,
)
from ocp_traj.pictures.bounds import TimeEntry, duration_entries, result_entries
from ocp_traj.pictures.picture import LIMIT, Band, Line, Panel, Picture
from ocp_traj.references.registry import all_references

MEASURES = {"evaluations": "evaluations", "seconds": "seconds (build and solve)"}
SOLVED = 0.01
"""A run solves its problem, in the profiles, when it comes this close to the best known value."""

_GRID = 80


def convergence_picture(judgement: Judgement, problem: ComparedProblem) -> Picture:
    """Return the best verified objective so far over evaluations and seconds: median and quartiles."""
    panels = tuple(_convergence_panel(judgement, problem, measure) for measure in MEASURES)
    caption = (
        f"{problem.label}: median over seeds of the best feasible objective so far; bands span the "
        "quartiles. A run counts only when the audit accepts its answer; a curve begins where half of the runs have a "
        "feasible point, and is held when the last run has ended. Dashed: the best known here."
    )
    return Picture(
        f"convergence-{problem.digest[:8]}-{problem.settings_digest[:4]}", "Convergence", caption, panels
    )


def _convergence_panel(judgement: Judgement, problem: ComparedProblem, measure: str) -> Panel:
    lines, bands, ends = [], [], []
    for place, solver in enumerate(judgement.solvers):
        group = judgement.group(problem, solver)
        if group is None:
            continue
        grid = _grid(group, measure)
        if grid.size == 0:
            continue
        costs = np.array([best_at(course, grid, measure) for course in group.courses])
        lower, median, upper = np.quantile(costs, [0.25, 0.5, 0.75], axis=0, method="inverted_cdf")
        shown = np.isfinite(median)
        if not shown.any():
            continue
        lines.append(Line(grid[shown], median[shown], solver, place, step=True))
        # A quartile that has nothing feasible yet is above everything.
        upper = np.where(np.isfinite(upper), upper, costs[np.isfinite(costs)].max())
        bands.append(Band(grid[shown], lower[shown], upper[shown], place))
        ends += [grid[shown][0], grid[shown][-1]]
    if problem.best is not None and lines:
        span = np.array([min(ends), max(ends)])
        lines = [_held(line, span[1]) for line in lines]
        lines.append(Line(span, np.full(2, problem.best), "best known", LIMIT, dashed=True))
    return Panel(problem.label, MEASURES[measure], "objective", tuple(lines), tuple(bands), log_x=True)


def _held(line: Line, end: float) -> Line:
    """Return the curve held at its last value up to the common end."""
    return replace(line, x=np.append(line.x, end), y=np.append(line.y, line.y[-1]))


def _grid(group: Group, measure: str) -> Array:
    points = [getattr(course, measure) for course in group.courses]
    joined = np.concatenate(points) if points else np.empty(0)
    joined = joined[joined > 0]
    return np.geomspace(joined.min(), joined.max(), _GRID) * (1 + 1e-12) if joined.size else np.empty(0)


def runtime_picture(judgement: Judgement) -> Picture:
    """Return the runtime distributions over all problems and targets, with simulated restarts."""
    panels = tuple(
        _step_panel(
            "Runtime distribution", MEASURES[measure], "share of problems and targets", judgement, curves
        )
        for measure, curves in ((measure, runtime_distributions(judgement, measure)) for measure in MEASURES)
    )
    targets = ", ".join(f"{100 * target:g} %" for target in TARGETS)
    caption = (
        f"Share of (problem, target) pairs reached by independent restarts; targets {targets} above the best "
        "known value of a problem. Failed runs cost their whole time. Higher and further left is better."
    )
    return Picture("runtime", "Runtime distributions", caption, panels)


def runtime_distributions(judgement: Judgement, measure: str) -> list[Curve]:
    """Return one distribution a solver, over all problems with a known feasible value, and all targets."""
    problems = [problem for problem in judgement.problems if problem.best is not None]
    curves = []
    for solver in judgement.solvers:
        times: list[Array] = []
        for problem in problems:
            group = judgement.group(problem, solver)
            for target in TARGETS:
                rng = np.random.default_rng([len(times), *solver.encode()])
                goal = target_value(problem.best or 0.0, target)
                times.append(
                    np.full(200, np.inf)
                    if group is None
                    else simulate_restarts(group.courses, goal, measure, rng)
                )
        curves.append(distribution(np.concatenate(times)) if times else distribution(np.empty(0)))
    return curves


def solving_costs(judgement: Judgement, measure: str) -> tuple[Array, Array]:
    """Return the cost of every (problem, seed) instance to come within `SOLVED`, and its dimension.

    Instances are those for which every solver has a run; (instances, solvers), infinite where not solved.
    """
    costs: list[list[float]] = []
    dimensions: list[float] = []
    for problem in judgement.problems:
        groups = [judgement.group(problem, solver) for solver in judgement.solvers]
        if problem.best is None or any(group is None for group in groups):
            continue
        goal = target_value(problem.best, SOLVED)
        by_seed = [
            {
                row.seed: course.reach(goal, measure)
                for row, course in zip(group.rows, group.courses, strict=True)
            }
            for group in groups
            if group is not None
        ]
        known = [
            row.record.dimension for group in groups if group for row in group.rows if row.record.dimension
        ]
        for seed in sorted(set.intersection(*(set(entry) for entry in by_seed))):
            costs.append([entry[seed] for entry in by_seed])
            dimensions.append(float(min(known, default=1)))
    return np.array(costs).reshape(len(costs), len(judgement.solvers)), np.array(dimensions)


def performance_picture(judgement: Judgement) -> Picture:
    """Return Dolan and Moré's performance profiles in evaluations and seconds."""
    panels = tuple(
        _step_panel(
            "Performance profile",
            f"factor of the fastest, in {measure}",
            "share of instances solved",
            judgement,
            performance_profiles(solving_costs(judgement, measure)[0]),
        )
        for measure in MEASURES
    )
    caption = (
        f"Share of (problem, seed) instances solved to within {100 * SOLVED:g} % of the best known value, "
        "within a factor of the fastest solver on that instance. The left end tells who is fastest, the right "
        "end who is reliable."
    )
    return Picture("performance", "Performance profiles", caption, panels)


def data_picture(judgement: Judgement) -> Picture:
    """Return Moré and Wild's data profiles."""
    costs, dimensions = solving_costs(judgement, "evaluations")
    panel = _step_panel(
        "Data profile",
        "evaluations / (d + 1)",
        "share of instances solved",
        judgement,
        data_profiles(costs, dimensions),
    )
    caption = (
        f"Share of instances solved to within {100 * SOLVED:g} % of the best known value; d is the smallest "
        "number of variables any solver uses on the problem. A gradient solver's evaluation includes derivatives."
    )
    return Picture("data", "Data profile", caption, (panel,), columns=2)


def problem_entries(judgement: Judgement, problem: ComparedProblem) -> list[TimeEntry]:
    """Return what a comparison knows of one problem's duration: references, and the shortest of every solver.

    Of a reference's paths the shortest is shown.
    """
    durations = {
        solver: float(group.durations().min())
        for solver in judgement.solvers
        if (group := judgement.group(problem, solver)) is not None
    }
    entries = []
    for reference in all_references():
        known = problem.known(reference)
        paths = [part for part in known if part not in reference.parts]
        best = min(paths, key=lambda part: known[part], default=None)
        entries += duration_entries(
            reference, {part: known[part] for part in known if part in reference.parts or part == best}
        )
    return entries + result_entries(durations)


def _step_panel(title: str, x: str, y: str, judgement: Judgement, curves: list[Curve]) -> Panel:
    """Return step functions from zero to the common end; one that never rises lies at zero."""
    reached = [curve.x for curve in curves if curve.x.size]
    first = min((float(xs[0]) for xs in reached), default=1.0)
    last = 1.02 * max((float(xs[-1]) for xs in reached), default=1.0)
    lines = []
    for place, (solver, curve) in enumerate(zip(judgement.solvers, curves, strict=True)):
        begin = curve.x[:1] if curve.x.size else np.array([first])
        final = curve.y[-1] if curve.y.size else 0.0
        across, up = np.concatenate([begin, curve.x, [last]]), np.concatenate([[0.0], curve.y, [final]])
        lines.append(Line(across, up, solver, place, step=True))
    return Panel(title, x, y, tuple(lines), log_x=True, y_range=(0.0, 1.02))


COMPARISON_PICTURES: dict[str, Callable[[Judgement], Picture]] = {
    "runtime": runtime_picture,
    "performance": performance_picture,
    "data": data_picture,
}
"""Pictures of a whole comparison, by name; ``convergence`` takes a problem too."""
