"""Plans give every run a key and a seed that depend on nothing but the plan."""

from __future__ import annotations

from typing import Any

import pytest

from helpers import comparison_fakes as fakes
from ocp_traj.comparison.runs.plan import (
    CaseChoice,
    Plan,
    RunSpec,
    canonical_name,
    derive_seed,
    plan_from_table,
)
from ocp_traj.exceptions import InputError


def plan(**changes: Any) -> Plan:
    return Plan(**{"cases": (CaseChoice("one"), CaseChoice("two")), "solvers": ("a", "b"), **changes})


def test_a_plan_is_the_product_of_its_parts() -> None:
    specs = plan(budgets=(10, 20), seeds=3).runs(fakes.identify)
    assert len(specs) == plan(budgets=(10, 20), seeds=3).size == 2 * 2 * 2 * 3
    assert len({spec.key for spec in specs}) == len(specs)


def test_seeds_do_not_depend_on_order_or_on_other_cases() -> None:
    forward = {(s.case_name, s.seed_index): s.seed for s in plan().runs(fakes.identify)}
    alone = plan(cases=(CaseChoice("two"),), solvers=("b",)).runs(fakes.identify)
    assert all(forward[spec.case_name, spec.seed_index] == spec.seed for spec in alone)


def test_solvers_share_the_seeds_of_a_case() -> None:
    specs = plan().runs(fakes.identify)
    seeds = {(s.case_name, s.seed_index): set() for s in specs}  # type: dict[tuple[str, int], set[int]]
    for spec in specs:
        seeds[spec.case_name, spec.seed_index].add(spec.seed)
    assert all(len(found) == 1 for found in seeds.values())


def test_another_root_gives_other_seeds() -> None:
    assert derive_seed(0, "one", 0) != derive_seed(1, "one", 0)


def test_seeds_stay_the_same_from_version_to_version() -> None:
    assert derive_seed(0, "one", 0) == 62439696  # first 32 bits of SHA-256 of "0/one/0", halved


def test_settings_outside_the_solver_change_the_key() -> None:
    keys = {
        plan(**changes).runs(fakes.identify)[0].key
        for changes in ({}, {"budgets": (5,)}, {"time_limit": 1.0}, {"memory_limit": 10**9})
    }
    assert len(keys) == 4


def test_a_specification_survives_json() -> None:
    spec = plan().runs(fakes.identify)[0]
    assert RunSpec.from_json(spec.to_json()) == spec


def test_a_plan_survives_json() -> None:
    given = plan(cases=(CaseChoice("one", ("a=1",)),), budgets=(3, None))
    assert Plan.from_json(given.to_json()) == given


@pytest.mark.parametrize(
    ("written", "canonical"),
    [
        (" pso ", "pso"),
        ("pso[b=2, a=1]", "pso[a=1,b=2]"),
        ("pso[]", "pso"),
        ("ssa@paper-b[x = y]", "ssa@paper-b[x=y]"),
    ],
)
def test_equal_solvers_have_one_name(written: str, canonical: str) -> None:
    assert canonical_name(written) == canonical


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"cases": ()}, "at least one case"),
        ({"solvers": ()}, "at least one solver"),
        ({"solvers": ("a", "a")}, "one of its solvers twice"),
        ({"seeds": 0}, "seeds is 0, expected 1 or more"),
        ({"budgets": (0,)}, "budget is 0, expected 1 or more"),
        ({"time_limit": float("nan")}, "time limit is nan"),
        ({"memory_limit": 0}, "memory limit is 0"),
        ({"seeds": 10**6}, "expected at most 1000000"),
    ],
)
def test_an_impossible_plan_is_refused(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        plan(**changes)


def test_the_same_problem_twice_is_refused() -> None:
    with pytest.raises(InputError, match="are the same problem"):
        plan().runs(lambda choice: (choice.case, "same"))


def test_two_problems_of_one_name_are_refused() -> None:
    with pytest.raises(InputError, match="are both named 'x'"):
        plan().runs(lambda choice: ("x", choice.case))


def test_a_plan_file_is_read() -> None:
    table = {
        "schema": 1,
        "cases": ["one", {"case": "two.toml", "set": ["spline.virtual_knots=3"]}],
        "solvers": ["a"],
        "seeds": 2,
        "budget": [10, 20],
        "time_limit": 5,
        "memory_limit_gb": 1.5,
        "references": False,
    }
    read = plan_from_table(table, "folder/plan.toml")
    assert read.cases == (CaseChoice("one"), CaseChoice("folder/two.toml", ("spline.virtual_knots=3",)))
    assert (read.solvers, read.seeds, read.budgets) == (("a",), 2, (10, 20))
    assert (read.time_limit, read.memory_limit, read.references) == (5, 3 * 2**29, False)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"schema": 2}, "p.toml: schema: 2 given, expected 1"),
        ({"sedes": 2}, "p.toml: sedes: unknown key"),
        ({"seeds": True}, "p.toml: seeds: True given, expected a whole number"),
        ({"seeds": 1.5}, "p.toml: seeds: 1.5 given"),
        ({"budget": "many"}, "p.toml: budget: 'many' given"),
        ({"cases": "one"}, "p.toml: cases: 'one' given, expected a list"),
        ({"cases": [3]}, "p.toml: cases: 3 given, expected a string"),
        ({"cases": [{"case": "one", "sets": []}]}, "unknown key 'sets'"),
        ({"solvers": [1]}, "p.toml: solvers: 1 given"),
    ],
)
def test_a_wrong_plan_file_is_refused(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        plan_from_table({"schema": 1, **changes}, "p.toml")
