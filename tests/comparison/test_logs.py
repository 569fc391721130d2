"""Logs of a comparison, read back by the analysers they are written for."""

from __future__ import annotations

import csv
import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ocp_traj.comparison.logs import logged_functions, write_coco, write_ioh
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.store import StoredRun
from ocp_traj.exceptions import InputError

SEEDS = 15


def row(case: str, solver: str, seed: int) -> StoredRun:
    """A run whose first candidates break a limit, and which improves ten times."""
    rng = np.random.default_rng([seed, len(case), len(solver)])
    cost = 2.0 + np.sort(rng.exponential(size=12))[::-1]
    violation = [0.3, 0.1] + [0.0] * 10
    record = RunRecord(
        status="budget_exhausted",
        dimension=5,
        evaluations=250,
        objective=float(cost[-1]),
        history={
            "evaluations": [float(20 * k + 20) for k in range(12)],
            "cost": cost.tolist(),
            "violation": violation,
            "seconds": [0.01 * k for k in range(12)],
        },
    )
    return StoredRun(case, case, solver, "settings", seed, seed, 250, None, record, None, 1)


@pytest.fixture(name="rows")
def make_rows() -> list[StoredRun]:
    return [row(case, solver, seed) for case in ("near", "far") for solver in ("pso", "ssa[beta=scalar]")
            for seed in range(SEEDS)]  # fmt: skip


def test_a_candidate_that_breaks_a_limit_is_worse_than_every_one_that_keeps_them(rows: list[StoredRun]) -> None:
    for function in logged_functions(rows):
        for courses in function.courses.values():
            for course in courses:
                assert course.improvements[0][1] == pytest.approx(function.ceiling + 0.3)
                assert course.improvements[1][1] == pytest.approx(function.ceiling + 0.1)
                assert max(merit for _, merit in course.improvements[2:]) < function.ceiling
        assert function.best == min(
            value for each in rows if each.case_name == function.name for value in each.record.history["cost"]
        )


def test_iohprofiler_reads_what_was_stored(rows: list[StoredRun], tmp_path: Path) -> None:
    iohinspector = pytest.importorskip("iohinspector")
    functions = logged_functions(rows)
    write_ioh(functions, tmp_path, "1.0")
    manager = iohinspector.DataManager()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        manager.add_folder(str(tmp_path))
        overview = manager.overview
    assert len(overview) == len(rows)
    assert set(overview["algorithm_name"]) == {"pso", "ssa[beta=scalar]"}
    expected = sorted(each.record.objective for each in rows)  # type: ignore[type-var]
    np.testing.assert_allclose(sorted(overview["best_y"]), expected, rtol=1e-12)
    assert set(overview["evals"]) == {250}


def test_the_data_file_of_iohprofiler_has_every_improvement(rows: list[StoredRun], tmp_path: Path) -> None:
    functions = logged_functions(rows)
    write_ioh(functions, tmp_path, "1.0")
    first = functions[0]
    lines = next((tmp_path / "pso").glob(f"data_f1_*/IOHprofiler_f1_DIM{first.dimension}.dat")).read_text()
    run = lines.split("evaluations raw_y\n")[1].splitlines()
    shown = [(int(spent), float(merit)) for spent, merit in map(str.split, run)]
    assert tuple(shown[:-1]) == first.courses["pso"][0].improvements
    assert shown[-1] == (250, first.courses["pso"][0].improvements[-1][1])


def test_coco_reads_what_was_stored(rows: list[StoredRun], tmp_path: Path) -> None:
    pytest.importorskip("cocopp", exc_type=ImportError)
    from cocopp.pproc import DataSetList

    functions = logged_functions(rows)
    write_coco(functions, tmp_path, "1.0")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = DataSetList([str(tmp_path / "pso")])
    assert sorted(each.funcId for each in found) == [1, 2]
    for each, function in zip(sorted(found, key=lambda one: one.funcId), functions):
        assert each.dim == function.dimension
        np.testing.assert_array_equal(each.maxevals, [250] * SEEDS)
        last = [course.improvements[-1][1] - function.best for course in function.courses["pso"]]
        np.testing.assert_allclose(each.finalfunvals, last, atol=1e-8)


def test_a_table_says_which_problem_a_number_is(rows: list[StoredRun], tmp_path: Path) -> None:
    write_coco(logged_functions(rows), tmp_path, "1.0")
    with (tmp_path / "functions.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [(each["number"], each["problem"]) for each in table] == [("1", "far"), ("2", "near")]


def test_names_that_are_no_names_of_files_are_written_all_the_same(tmp_path: Path) -> None:
    functions = logged_functions([row("a/b: c", "pso[x=1]", 0)])
    write_ioh(functions, tmp_path, "1.0")
    meta: dict[str, Any] = json.loads(next(tmp_path.glob("*/IOHprofiler_f1_*.json")).read_text())
    assert meta["algorithm"]["name"] == "pso[x=1]"
    assert (tmp_path / "pso_x_1_" / meta["scenarios"][0]["path"]).is_file()


def test_more_problems_than_coco_knows_are_refused(tmp_path: Path) -> None:
    many = logged_functions([row(f"case-{k}", "pso", 0) for k in range(25)])
    with pytest.raises(InputError, match="25 problems, expected at most 24"):
        write_coco(many, tmp_path, "1.0")


def test_a_comparison_without_histories_is_refused() -> None:
    with pytest.raises(InputError, match="no run with a history"):
        logged_functions([])
