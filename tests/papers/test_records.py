"""Finished runs are kept, found again, and never mixed with others."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ocp_traj.comparison.runs.compare import identify_case
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.store import Store
from ocp_traj.exceptions import UnknownNameError
from ocp_traj.papers import PAPERS, get_paper
from ocp_traj.papers.experiments import IMPROVED, PUBLISHED_PROTOCOL, Experiment, generations_budget
from ocp_traj.papers.records import Records, plan_experiments
from ocp_traj.papers.runner import solve_experiment

CASE = "fanuc-m10id8l"
APART = ('search.protocol="per-joint"',)


def keys_of(*experiments: Experiment, seeds: int = 1) -> list[tuple[str, str, str, int]]:
    """Return the keys of the experiments' runs."""
    return [spec.key for spec in plan_experiments(CASE, experiments, seeds).runs(identify_case)]


def known_records(folder: Path, experiment: Experiment, told: list[RunRecord]) -> Records:
    """Return records that hold one run per seed, as told."""
    plan = plan_experiments(CASE, [experiment], len(told))
    specs = plan.runs(identify_case)
    with Store(folder, create=True) as store:
        number = store.add_plan(plan, {}, specs)
        for spec, record in zip(specs, told, strict=True):
            store.add_run(spec, record, number)
    records = Records(folder, CASE)
    records.choose(plan)
    return records


def test_a_named_result_is_computed_once(tmp_path: Path) -> None:
    calls = []

    def work() -> dict[str, float]:
        calls.append(1)
        return {"value": 4.0}

    for _ in range(2):
        assert Records(tmp_path, CASE).computed("name", work)["value"] == 4.0
    assert len(calls) == 1


def test_only_the_chosen_runs_are_looked_at_and_infeasible_ones_count_as_infinite(tmp_path: Path) -> None:
    experiment = Experiment("group", "label", "de")
    told = [RunRecord("converged", feasible=feasible, duration=3.0) for feasible in (True, False, True)]
    records = known_records(tmp_path, experiment, told)
    records.choose(plan_experiments(CASE, [experiment], 2))
    assert records.values("label", "duration", "group").tolist() == [3.0, np.inf]
    assert records.raw("label", "duration", "group").tolist() == [3.0, 3.0]


def test_a_run_that_died_has_no_numbers(tmp_path: Path) -> None:
    experiment = Experiment("group", "label", "de")
    records = known_records(tmp_path, experiment, [RunRecord("failed", "the process died", "crash")])
    for field in ("duration", "energy", "seconds", "processor", "generations", "evaluations"):
        assert records.values("label", field, "group").tolist() == [np.inf]
    assert records.part("label", 1, "cost", "group").tolist() == [np.inf]


def test_a_key_changes_with_solver_budget_seed_and_case_but_not_with_words() -> None:
    base = Experiment("group", "label", "de", 100)
    changed = [
        Experiment("group", "label", "random", 100),
        Experiment("group", "label", "de", 200),
        Experiment("group", "label", "de", 100, APART),
    ]
    keys = {*keys_of(base, *changed), *keys_of(base, seeds=2)}
    assert len(keys) == 5
    assert keys_of(Experiment("other", "words", "de", 100, published="2 s"))[0] in keys


def test_seeds_are_the_numbers_of_the_runs_and_what_runs_once_has_seed_0() -> None:
    experiments = [
        Experiment("group", "several", "de", 100),
        Experiment("group", "one", "ipopt", once=True),
        Experiment(PUBLISHED_PROTOCOL, "own", "de", 200),
    ]
    plan = plan_experiments(CASE, experiments, 2)
    found = [(entry.label, spec.seed) for entry, spec in plan.specifications(identify_case)]
    assert found == [("own", 0), ("own", 1), ("several", 0), ("one", 0), ("several", 1)]
    assert plan.size == 5


def test_a_run_of_joints_apart_keeps_every_joint_and_its_synchronised_total() -> None:
    request = {"case": CASE, "overrides": APART, "solver": "pso[population=10]", "seed": 3, "budget": 6 * 200}
    record = RunRecord.from_json(solve_experiment(request))
    parts, segments = record.details["parts"], record.details["segments"]
    assert [part["joint"] for part in parts] == [1, 2, 3, 4, 5, 6]
    assert record.duration == pytest.approx(sum(segments))
    last = [part["history"]["x"][-1] for part in parts]
    assert segments == pytest.approx(np.max(last, axis=0), abs=1e-5)
    assert record.evaluations == sum(part["evaluations"] for part in parts) == 1200
    json.dumps(record.to_json(), allow_nan=False)


def test_what_is_finished_is_not_run_again(tmp_path: Path) -> None:
    plan = plan_experiments(CASE, [Experiment("group", "label", "random", 20)], 2)
    seen: list[tuple[int, int]] = []
    for _ in range(2):
        records = Records(tmp_path, CASE)
        records.run(plan, 1, lambda done, total: seen.append((done, total)))
        assert len(records.runs("label", "group")) == 2
    assert seen == [(0, 2), (1, 2), (2, 2), (2, 2)]


def test_a_worker_finds_what_the_same_seed_finds_here(tmp_path: Path) -> None:
    from ocp_traj.case import load_case
    from ocp_traj.solving import solve

    records = Records(tmp_path, CASE)
    records.run(plan_experiments(CASE, [Experiment("group", "label", "de", 300)], 2), 1, lambda *_: None)
    here = [solve(load_case(CASE), "de", seed=seed, budget=300) for seed in range(2)]
    found = [row.record for row in records.runs("label", "group")]
    assert [record.duration for record in found] == [result.duration for result in here]
    segments = [list(result.segment_durations) for result in here]
    assert [record.details["segments"] for record in found] == segments


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
