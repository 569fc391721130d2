"""Whatever stands in a plan file, a plan or one sentence that names the file comes out, quickly."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st

from ocp_traj.case import read_toml
from ocp_traj.cli.main import run
from ocp_traj.comparison.runs.plan import Plan, plan_from_table
from ocp_traj.exceptions import InputError

VALUES = st.recursive(
    st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=20)
    | st.sampled_from(
        [10**400, -(10**400), 1e308, "../../etc/passwd", "/dev/zero", "ipopt", "<script>", "a\0b"]
    ),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)
KEYS = (
    "schema", "cases", "solvers", "seeds", "seed", "budget", "time_limit", "memory_limit_gb", "references", "other",
)  # fmt: skip


@settings(max_examples=500)
@given(st.dictionaries(st.sampled_from(KEYS), VALUES, max_size=4), st.booleans())
def test_any_value_at_any_key_is_a_plan_or_refused(table: dict[str, Any], versioned: bool) -> None:
    if versioned:
        table = {**table, "schema": 1}
    try:
        plan = plan_from_table(table, "fuzz.toml")
    except InputError as error:
        assert str(error)
    else:
        assert 0 < plan.size <= 1_000_000
        assert plan.memory_limit is None or plan.memory_limit > 0


@settings(max_examples=200)
@given(
    st.lists(
        st.text(max_size=10) | st.fixed_dictionaries({"case": st.text(max_size=5), "set": VALUES}), max_size=3
    )
)
def test_any_list_of_cases_is_a_plan_or_refused(cases: list[Any]) -> None:
    try:
        plan = plan_from_table({"schema": 1, "cases": cases}, "fuzz.toml")
    except InputError as error:
        assert str(error)
    else:
        assert len(plan.cases) == len(cases)


@pytest.mark.parametrize("limit", [math.inf, math.nan, 1e308, 10**400, 0, -1.0])
def test_a_memory_limit_that_is_no_amount_is_refused(limit: float) -> None:
    with pytest.raises(InputError, match=r"plan.toml: memory_limit_gb: .* given, expected a positive number"):
        plan_from_table({"schema": 1, "memory_limit_gb": limit}, "plan.toml")


def test_a_plan_without_budgets_runs_nothing_and_is_refused() -> None:
    with pytest.raises(InputError, match=r"plan.toml: budget: an empty list"):
        plan_from_table({"schema": 1, "budget": []}, "plan.toml")


@pytest.mark.parametrize(
    ("table", "part"),
    [
        ({"seeds": 10**15}, "at most 1000000"),
        ({"budget": list(range(1, 10**5)), "seeds": 100}, "at most 1000000"),
        ({"cases": ["../../../../etc/passwd"]}, "passwd"),
        ({"cases": ["/dev/zero"]}, "/dev/zero"),
        ({"cases": ["/dev/zero.toml"]}, "does not exist"),
        ({"cases": ["a\0b.toml"]}, ""),
        ({"cases": [{"case": "ur5-helix", "set": ["robot.urdf=/etc/passwd"]}]}, ""),
        ({"solvers": ["pso[population=__import__('os')]"]}, "pso"),
        ({"solvers": ["os.system"]}, "os.system"),
        ({"solvers": ["<script>alert(1)</script>"]}, "script"),
        ({"solvers": ["pso[" * 1000]}, "pso"),
    ],
)
def test_a_hostile_plan_is_one_sentence_before_anything_runs(
    table: dict[str, Any], part: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "plan.toml"
    path.write_text(
        tomli_w.dumps({"schema": 1, "cases": ["fang-2020-task-1"], "solvers": ["random"], **table})
    )
    assert run(["compare", "--plan", str(path), "--output", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert part in said
    assert len(said.splitlines()) == 1


def test_numbers_too_long_to_be_read_are_no_toml(tmp_path: Path) -> None:
    path = tmp_path / "plan.toml"
    path.write_text("schema = 1\nseed = " + "9" * 6000)
    with pytest.raises(InputError, match="is not TOML"):
        read_toml(path, "plan.toml")


@given(st.integers(-(10**30), 10**30), st.integers(1, 5))
def test_any_seed_gives_seeds_that_fit_into_31_bits(seed: int, seeds: int) -> None:
    runs = Plan(seed=seed, seeds=seeds).runs(lambda choice: (choice.case, choice.case))
    assert all(0 <= spec.seed < 2**31 for spec in runs)
