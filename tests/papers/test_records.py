"""Finished runs are kept, found again, and never mixed with others."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ocp_traj.exceptions import UnknownNameError
from ocp_traj.papers import PAPERS, get_paper
from ocp_traj.papers.experiments import IMPROVED, Experiment, generations_budget
from ocp_traj.papers.records import Records, experiment_key, run_missing, run_one


def test_a_line_cut_off_by_a_killed_process_is_dropped_and_the_rest_counts(tmp_path: Path) -> None:
    path = tmp_path / "runs.jsonl"
    Records(path).add("one", {"duration": 1.5})
    with path.open("a") as file:
        file.write('{"key": "two", "dura')
    again = Records(path)
    assert again.get("one") == {"key": "one", "duration": 1.5}
    assert again.get("two") is None


def test_a_line_added_after_a_cut_off_one_is_found(tmp_path: Path) -> None:
    path = tmp_path / "runs.jsonl"
    path.write_text('{"key": "two", "dura')
    Records(path).add("three", {"duration": 2.0})
    assert Records(path).get("three") is not None


def test_a_named_result_is_computed_once(tmp_path: Path) -> None:
    calls = []

    def work() -> dict[str, float]:
        calls.append(1)
        return {"value": 4.0}

    for _ in range(2):
        assert Records(tmp_path / "runs.jsonl").computed("name", work, "digest")["value"] == 4.0
    assert len(calls) == 1


def test_only_the_chosen_runs_are_looked_at_and_infeasible_ones_count_as_infinite(tmp_path: Path) -> None:
    records = Records(tmp_path / "runs.jsonl")
    for key, feasible in (("a", True), ("b", False), ("old", True)):
        records.add(key, {"duration": 3.0, "feasible": feasible})
    experiment = Experiment("group", "label", "de")
    records.choose([("a", experiment), ("b", experiment)])
    assert records.values("label", "duration", "group").tolist() == [3.0, np.inf]
    assert records.raw("label", "duration", "group").tolist() == [3.0, 3.0]


def test_a_key_changes_with_solver_budget_seed_and_case_but_not_with_words() -> None:
    paper = get_paper("D")
    base = Experiment("group", "label", "de", 100)
    changed = [
        Experiment("group", "label", "random", 100),
        Experiment("group", "label", "de", 200),
        Experiment("group", "label", "de", 100, ('search.protocol="per-joint"',)),
    ]
    keys = {experiment_key(paper, entry, 0) for entry in (base, *changed)} | {experiment_key(paper, base, 1)}
    assert len(keys) == 5
    assert experiment_key(paper, Experiment("other", "words", "de", 100, published="2 s"), 0) in keys


def test_a_run_of_joints_apart_keeps_every_joint_and_its_synchronised_total() -> None:
    experiment = Experiment("group", "label", "pso[population=10]", 6 * 200, ('search.protocol="per-joint"',))
    row = run_one(get_paper("D"), experiment, 3)
    assert [part["joint"] for part in row["parts"]] == [1, 2, 3, 4, 5, 6]
    assert row["duration"] == pytest.approx(sum(row["segments"]))
    last = [part["history"]["x"][-1] for part in row["parts"]]
    assert row["segments"] == pytest.approx(np.max(last, axis=0), abs=1e-5)
    assert row["evaluations"] == sum(part["evaluations"] for part in row["parts"]) == 1200
    json.dumps(row, allow_nan=False)


def test_what_is_finished_is_not_run_again(tmp_path: Path) -> None:
    class Small(type(get_paper("D"))):
        def experiments(self, reduced: bool) -> list[Experiment]:
            return [Experiment("group", "label", "random", 20)]

    seen: list[tuple[int, int]] = []
    for _ in range(2):
        records = Records(tmp_path / "runs.jsonl")
        run_missing(Small(), records, 2, True, 1, lambda done, total: seen.append((done, total)))
        assert len(records.runs("label", "group")) == 2
    assert seen == [(0, 2), (1, 2), (2, 2), (2, 2)]


def test_generations_are_turned_into_the_evaluations_they_cost() -> None:
    assert generations_budget("pso@paper-b", 1000) == 30 + 1000 * 30
    assert generations_budget("ssa[population=30]", 1000) == 30 + 1000 * (30 + 3)
    assert generations_budget("issa-a@paper", 50) == 200 + 50 * (100 + 10 + 1)


@pytest.mark.parametrize("key", PAPERS)
def test_every_solver_of_every_paper_exists_and_every_case_loads(key: str) -> None:
    from ocp_traj.solvers import parse_solver

    paper = get_paper(key)
    for experiment in paper.experiments(False) + paper.experiments(True):
        parse_solver(experiment.solver)
        paper.task(experiment.overrides)


@pytest.mark.parametrize("key", PAPERS)
def test_every_paper_meets_the_proposals_of_all_four_with_equal_evaluations(key: str) -> None:
    paper = get_paper(key)
    equal = [entry for entry in paper.experiments(False) if entry.group == "equal evaluations"]
    assert {label for label, _ in IMPROVED} <= {entry.label for entry in equal}
    assert {entry.budget for entry in equal if not entry.once} == {paper.protocol.budget}
    assert len({entry.label for entry in equal}) == len(equal)


def test_solvers_that_cannot_be_loaded_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    from ocp_traj import solvers

    table = [replace(row, available=row.name == "ipopt") for row in solvers.solver_table()]
    monkeypatch.setattr(solvers, "solver_table", lambda: table)
    equal = [entry for entry in get_paper("A").experiments(False) if entry.group == "equal evaluations"]
    assert [entry.solver for entry in equal if entry.once] == ["ipopt"]


def test_the_equal_budget_is_the_papers_population_times_its_generations() -> None:
    assert {key: get_paper(key).protocol.budget for key in PAPERS} == {
        "A": 5000,
        "B": 30_000,
        "C": 8000,
        "D": 10_000,
    }


def test_an_unknown_paper_is_named() -> None:
    with pytest.raises(UnknownNameError, match="paper 'E' is unknown, expected one of A, B, C, D"):
        get_paper("E")
