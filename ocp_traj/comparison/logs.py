"""A comparison's runs as logs that the analysers of IOHprofiler and of COCO read.

One value per candidate is logged, the merit: its cost where it keeps every constraint, else the ceiling of the problem
plus its total violation, with the ceiling above every feasible cost of that problem. So a lower merit is a better
candidate in the order all methods are compared by: less violation first, then less cost. The numbers of the functions
and the ceilings are written to ``functions.csv`` beside the logs.
"""

from __future__ import annotations

import csv
import json
import math
import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ocp_traj.comparison.runs.store import StoredRun
from ocp_traj.exceptions import InputError

MOST_COCO_FUNCTIONS = 24
"""Functions of COCO's suite ``bbob``: its post-processing refuses others."""

KEPT_VIOLATION = 1e-6
"""Total violation, relative to the limits, up to which a candidate keeps every constraint, as for the audit."""

COCO_PRECISION = 1e-8
"""Distance to the best value that counts as reached."""

_COCO_COLUMNS = (
    "% f evaluations | g evaluations | best noise-free fitness - Fopt ({best:.12e}) + sum g_i+ | measured fitness"
    " | best measured fitness or single-digit g-values | x1 | x2..."
)


@dataclass(frozen=True)
class Course:
    """One run as a log: the improvements of its merit.

    Attributes
    ----------
    seed_index : int
        From 0.
    evaluations : int
        Spent in all.
    improvements : tuple of (evaluations, merit)
        Where the best merit so far changed, first entry included.
    """

    seed_index: int
    evaluations: int
    improvements: tuple[tuple[int, float], ...]


@dataclass(frozen=True)
class LoggedFunction:
    """One problem of a comparison, numbered as a function.

    Attributes
    ----------
    number : int
        From 1.
    name : str
        The case's label.
    dimension : int
        Number of variables.
    ceiling : float
        Merit of a candidate that just fails to be feasible.
    best : float
        Lowest merit of all runs.
    courses : dict
        Runs by solver.
    """

    number: int
    name: str
    dimension: int
    ceiling: float
    best: float
    courses: dict[str, list[Course]]

    @property
    def unknown(self) -> float:
        """Merit of what no history tells: above every ceiling."""
        return _unknown(self.ceiling)


def logged_functions(rows: Iterable[StoredRun]) -> list[LoggedFunction]:
    """Return every problem and number of variables of a comparison as a function with its runs.

    Parameters
    ----------
    rows : iterable of StoredRun
        As the store gives them, with histories; runs without a history are left out.
    """
    groups: dict[tuple[str, str, str, int], list[StoredRun]] = defaultdict(list)
    for row in rows:
        if row.record.history.get("evaluations") and row.record.dimension:
            groups[row.case_name, row.case_digest, row.settings_digest, row.record.dimension].append(row)
    functions = []
    for number, (key, members) in enumerate(sorted(groups.items()), start=1):
        entries = [_entries(row) for row in members]
        feasible = [cost for run in entries for _, cost, violation in run if violation <= KEPT_VIOLATION]
        ceiling = max(feasible, default=0.0)
        ceiling += abs(ceiling) or 1.0
        courses: dict[str, list[Course]] = defaultdict(list)
        for row, run in zip(members, entries):
            courses[row.solver].append(_course(row, run, ceiling))
        best = min(merit for runs in courses.values() for run in runs for _, merit in run.improvements)
        functions.append(LoggedFunction(number, key[0], key[3], ceiling, best, dict(courses)))
    if not functions:
        raise InputError("the comparison has no run with a history, nothing can be logged")
    return functions


def _entries(row: StoredRun) -> list[tuple[int, float, float]]:
    """Return (evaluations, cost, violation) of a run's history; what is missing there is infinite."""
    history = row.record.history
    columns = (history["evaluations"], history["cost"], history["violation"])
    return [
        (int(spent), math.inf if cost is None else cost, math.inf if violation is None else violation)
        for spent, cost, violation in zip(*columns)
        if spent is not None
    ]


def _course(row: StoredRun, entries: list[tuple[int, float, float]], ceiling: float) -> Course:
    improvements: list[tuple[int, float]] = []
    for spent, cost, violation in entries:
        merit = cost if violation <= KEPT_VIOLATION else ceiling + violation
        merit = merit if math.isfinite(merit) else _unknown(ceiling)
        if not improvements or merit < improvements[-1][1]:
            improvements.append((spent, merit))
    return Course(row.seed_index, row.record.evaluations or entries[-1][0], tuple(improvements))


def _unknown(ceiling: float) -> float:
    return 2.0 * abs(ceiling) + 1e6


def write_ioh(functions: Sequence[LoggedFunction], folder: Path, version: str) -> None:
    """Write IOHprofiler's logs, one folder per solver: a JSON file per function and a data file per dimension.

    Parameters
    ----------
    functions : sequence of LoggedFunction
    folder : Path
        Made when it is not there.
    version : str
        Of this package, noted in the files.
    """
    for solver in _solvers(functions):
        place = folder / _safe(solver)
        for function in functions:
            if solver in function.courses:
                _write_ioh_function(function, solver, place, version)
    _write_functions(functions, folder)


def _write_ioh_function(function: LoggedFunction, solver: str, place: Path, version: str) -> None:
    name = _safe(function.name)
    data = Path(f"data_f{function.number}_{name}") / f"IOHprofiler_f{function.number}_DIM{function.dimension}.dat"
    (place / data.parent).mkdir(parents=True, exist_ok=True)
    lines, runs = [], []
    for course in sorted(function.courses[solver], key=lambda run: run.seed_index):
        lines.append("evaluations raw_y")
        shown = list(course.improvements)
        if shown[-1][0] != course.evaluations:
            shown.append((course.evaluations, shown[-1][1]))
        lines += [f"{spent} {merit:.17g}" for spent, merit in shown]
        spent, merit = course.improvements[-1]
        best = {"evals": spent, "y": merit, "x": []}
        runs.append({"instance": 1, "evals": course.evaluations, "best": best})
    (place / data).write_text("\n".join(lines) + "\n", encoding="utf-8")
    meta = {
        "version": version,
        "suite": "ocp-traj",
        "function_id": function.number,
        "function_name": name,
        "maximization": False,
        "algorithm": {"name": solver, "info": f"ocp-traj {version}"},
        "attributes": ["evaluations", "raw_y"],
        "scenarios": [{"dimension": function.dimension, "path": data.as_posix(), "runs": runs}],
    }
    target = place / f"IOHprofiler_f{function.number}_{name}.json"
    target.write_text(json.dumps(meta, indent=1) + "\n", encoding="utf-8")


def write_coco(functions: Sequence[LoggedFunction], folder: Path, version: str) -> None:
    """Write COCO's logs, one folder per solver, in the format ``bbob-new2``.

    COCO's post-processing reads its own suites only, so the functions carry the name ``bbob`` and numbers from 1;
    ``functions.csv`` says which problem each is. The best merit of all runs takes the place of the optimum.

    Raises
    ------
    InputError
        There are more functions than that suite has.
    """
    if len(functions) > MOST_COCO_FUNCTIONS:
        raise InputError(
            f"the comparison has {len(functions)} problems, expected at most {MOST_COCO_FUNCTIONS} for COCO's logs"
        )
    for solver in _solvers(functions):
        place = folder / _safe(solver)
        for function in functions:
            if solver in function.courses:
                _write_coco_function(function, solver, place, version)
    _write_functions(functions, folder)


def _write_coco_function(function: LoggedFunction, solver: str, place: Path, version: str) -> None:
    number, dimension = function.number, function.dimension
    data = Path(f"data_f{number}") / f"bbobexp_f{number}_DIM{dimension}.dat"
    (place / data.parent).mkdir(parents=True, exist_ok=True)
    lines, last = [], []
    for instance, course in enumerate(sorted(function.courses[solver], key=lambda run: run.seed_index), start=1):
        lines.append(_COCO_COLUMNS.format(best=function.best))
        shown = list(course.improvements)
        if shown[0][0] != 1:  # COCO's readers expect the first candidate; histories begin with a generation
            shown.insert(0, (1, function.unknown))
        if shown[-1][0] != course.evaluations:
            shown.append((course.evaluations, shown[-1][1]))
        nothing = " ".join(["+0.0000e+00"] * dimension)
        for spent, merit in shown:
            lines.append(f"{spent} 0 {merit - function.best:+.9e} {merit:+.9e} {merit:+.9e} {nothing}")
        last.append(f"{instance}:{course.evaluations}|{shown[-1][1] - function.best:.1e}")
    text = "\n".join(lines) + "\n"
    for ending in (".dat", ".tdat"):
        (place / data.with_suffix(ending)).write_text(text, encoding="utf-8")
    name = re.sub(r"[^\w.+-]+", "_", solver)
    settings = (
        f"suite = 'bbob', funcId = {number}, DIM = {dimension}, Precision = {COCO_PRECISION:.3e}, algId = '{name}', "
        "coco_version = '2.8.2', logger = 'bbob', data_format = 'bbob-new2'\n"
        f"% {function.name}, written by ocp-traj {version}\n{data.as_posix()}, {', '.join(last)}\n"
    )
    (place / f"bbobexp_f{number}.info").write_text(settings, encoding="utf-8")


def _write_functions(functions: Sequence[LoggedFunction], folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "functions.csv").open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(("number", "problem", "dimension", "ceiling", "best"))
        for each in functions:
            table.writerow((each.number, each.name, each.dimension, repr(each.ceiling), repr(each.best)))


def _solvers(functions: Sequence[LoggedFunction]) -> list[str]:
    return sorted({solver for function in functions for solver in function.courses})


def _safe(name: str) -> str:
    """Return a name that is a file's name on every system."""
    return re.sub(r"[^\w.+-]+", "_", name)[:80]
