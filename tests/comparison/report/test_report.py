"""The report tells the same numbers twice, needs nothing from outside, and hides no failure."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from helpers import comparison_fakes as fakes
from helpers.databases import connections_with
from ocp_traj.comparison.report.document import format_number
from ocp_traj.comparison.report.judging import judge
from ocp_traj.comparison.report.report import write_report
from ocp_traj.comparison.report.story import tell_story
from ocp_traj.comparison.runs.plan import CaseChoice, Plan
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.store import Store

ENVIRONMENT: dict[str, Any] = {
    "python": "3.x",
    "versions": {"ocp-traj": "0"},
    "machine": {"system": "S", "processor": "P", "cores": 2, "memory_gb": 1.0},
    "git": None,
}


def record(objective: float, **changes: Any) -> RunRecord:
    values: dict[str, Any] = {
        "status": "converged",
        "claimed": True,
        "feasible": True,
        "objective": objective,
        "duration": objective,
        "dimension": 5,
        "evaluations": 100,
        "build_time": 0.1,
        "solve_time": 0.2,
        "wall_time": 0.3,
        "worst": {"limit": "velocity", "joint": 2, "time": 0.5, "ratio": 0.99},
        "waypoint_error": 0.0,
        "history": {
            "evaluations": [10, 50, 100],
            "cost": [2 * objective, 1.1 * objective, objective],
            "violation": [0.0, 0.0, 0.0],
            "seconds": [0.05, 0.1, 0.2],
        },
        **changes,
    }
    return RunRecord(**values)


def fill(
    folder: Path, outcomes: dict[str, Any], cases: tuple[str, ...] = ("one", "two"), seeds: int = 4
) -> None:
    """Store a run of every solver; `outcomes` gives its record from the place of case and seed."""
    plan = Plan(tuple(CaseChoice(name) for name in cases), tuple(outcomes), seeds=seeds)
    specs = plan.runs(fakes.identify)
    # these rows need not survive a power cut
    with connections_with("PRAGMA synchronous = OFF"), Store(folder, create=True) as store:
        number = store.add_plan(plan, ENVIRONMENT, specs)
        for spec in specs:
            store.add_case(spec)
            found = outcomes[spec.solver](cases.index(spec.case_name), spec.seed_index)
            if found is not None:
                store.add_run(spec, found, number)


def story_of(folder: Path) -> list[str]:
    with Store(folder) as store:
        rows = store.rows()
        return tell_story(judge(rows, store.cases()), store.plans()[-1][0].size, len(rows))


def outcomes() -> dict[str, Any]:
    return {
        "good": lambda case, seed: record(1.0 + case + 0.001 * seed),
        "poor": lambda case, seed: record(1.2 * (1.0 + case) + 0.003 * seed),
        "liar": lambda case, seed: record(
            0.5, feasible=False, worst={"limit": "jerk", "joint": 1, "time": 0.1, "ratio": 3}
        ),
        "dead": lambda case, seed: RunRecord("failed", "the process died: SIGSEGV", "crash", wall_time=1.0),
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report")
    fill(path, outcomes())
    write_report(path)
    return path


class References(HTMLParser):
    """Collects everything a page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [
            str(value) for name, value in attrs if name in ("src", "href", "srcset", "action", "data")
        ]


def test_the_page_loads_nothing(folder: Path) -> None:
    page = (folder / "report.html").read_text()
    parser = References()
    parser.feed(page)
    assert parser.found and all(reference.startswith("#") for reference in parser.found)
    assert "http://" not in page and "https://" not in page and "@import" not in page and "url(" not in page


def test_the_markdown_has_the_numbers_of_the_page(folder: Path) -> None:
    page, markdown = (folder / "report.html").read_text(), (folder / "report.md").read_text()
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", page)
    lines = [line for line in markdown.splitlines() if line.startswith("| ") and " --- " not in line]
    words = {word.strip() for line in lines for word in line.strip("|").split(" | ")}
    assert len(cells) > 100
    assert {cell.replace("&gt;", ">") for cell in cells} <= words | {""}


def test_the_winner_is_told_first(folder: Path) -> None:
    story = story_of(folder)
    assert (
        story[0]
        == "good ranks first: mean rank 1.00 of 4 solvers, best or equal best in 8 of 8 paired runs (problem and seed)."
    )
    assert any(
        re.match(
            r"The objective of poor against that of good, medians: 20 %.* above on one; 20 %.* above on two",
            sentence,
        )
        for sentence in story
    )


def test_failures_count_against_a_solver(folder: Path) -> None:
    story = story_of(folder)
    assert "liar fails in 8 of 8 blocks in which good succeeds." in story
    assert "dead fails in 8 of 8 blocks in which good succeeds." in story
    assert "In 8 runs the solver claims a feasible answer that the audit refuses." in story[-1]
    assert "crash" in (folder / "report.md").read_text()


def test_the_cost_of_a_run_is_told(folder: Path) -> None:
    (sentence,) = [sentence for sentence in story_of(folder) if sentence.startswith("Median cost")]
    assert "good 100 evaluations, 0.3 s" in sentence and "dead none told" in sentence


def test_a_liar_never_sets_the_best_known_value(folder: Path) -> None:
    with Store(folder) as store:
        judgement = judge(store.rows(), store.cases())
    assert [problem.best for problem in judgement.problems] == [1.0, 2.0]


def test_a_certain_lead_is_called_certain(folder: Path) -> None:
    (sentence,) = [sentence for sentence in story_of(folder) if "chance" in sentence]
    assert sentence.startswith("The lead of good over every other solver is more than chance")
    assert "these problems only" in sentence


def test_too_few_blocks_prove_nothing(tmp_path: Path) -> None:
    fill(tmp_path, {name: make for name, make in outcomes().items() if name in ("good", "poor")}, ("one",), 3)
    assert any("3 blocks could not show any lead" in sentence for sentence in story_of(tmp_path))


def test_many_problems_are_blocks_themselves(tmp_path: Path) -> None:
    fill(tmp_path, outcomes(), tuple("abcdefgh"), 2)
    with Store(tmp_path) as store:
        judgement = judge(store.rows(), store.cases())
    assert (judgement.block_kind, len(judgement.ratios)) == ("problems", 8)


def test_equal_solvers_do_not_lead(tmp_path: Path) -> None:
    fill(tmp_path, {"a": lambda case, seed: record(1.0), "b": lambda case, seed: record(1.0 + 1e-8)})
    assert story_of(tmp_path)[0] == "No solver leads: a, b share the best mean rank, 1.50."


def test_an_unfinished_comparison_says_so_and_has_a_report(tmp_path: Path) -> None:
    half = {"a": lambda case, seed: record(1.0), "b": lambda case, seed: record(2.0) if seed == 0 else None}
    fill(tmp_path, half)
    files = write_report(tmp_path)
    assert files.story[0] == "This comparison is unfinished: 10 of 16 runs are there."
    assert files.html.exists()


def test_a_comparison_without_any_run_has_a_report(tmp_path: Path) -> None:
    fill(tmp_path, {"a": lambda case, seed: None})
    assert "There is nothing to judge yet." in write_report(tmp_path).story


def test_a_comparison_without_any_success_has_a_report(tmp_path: Path) -> None:
    fill(tmp_path, {name: make for name, make in outcomes().items() if name in ("liar", "dead")})
    assert "No run of any solver ended with a motion the audit accepts." in write_report(tmp_path).story


def test_names_cannot_break_the_page(tmp_path: Path) -> None:
    evil = "</script><img src=x>|"
    fill(tmp_path, {evil: lambda case, seed: record(1.0, findings=(evil,))}, (evil,), 1)
    files = write_report(tmp_path)
    assert "<img" not in files.html.read_text()
    assert "\\|" in files.markdown.read_text()


def test_only_the_problems_of_the_newest_plan_are_judged(tmp_path: Path) -> None:
    fill(tmp_path, {"a": lambda case, seed: record(5.0)}, ("old",))
    fill(tmp_path, {"a": lambda case, seed: record(1.0)}, ("new",))
    assert [problem.name for problem in write_report(tmp_path).judgement.problems] == ["new"]


def test_budgets_are_problems_of_their_own(tmp_path: Path) -> None:
    plan = Plan((CaseChoice("one"),), ("a",), seeds=2, budgets=(10, 20))
    specs = plan.runs(fakes.identify)
    with Store(tmp_path, create=True) as store:
        number = store.add_plan(plan, ENVIRONMENT, specs)
        for spec in specs:
            store.add_run(spec, record(1.0 / (spec.budget or 1)), number)
        judgement = judge(store.rows(), store.cases())
    assert [problem.label for problem in judgement.problems] == [
        "one (10 evaluations)",
        "one (20 evaluations)",
    ]


def test_references_give_ratios(tmp_path: Path) -> None:
    fill(tmp_path, {"a": lambda case, seed: record(2.0)}, ("one",))
    reference = {
        "toppra": {"uniform": 4.0, "chord": 2.5},
        "kinematic_bound": {"lower": None, "estimate": 1.6},
    }
    with Store(tmp_path) as store:
        for part, found in reference.items():
            store.add_reference(next(iter(store.cases())), part, found)
        (problem,) = judge(store.rows(), store.cases()).problems
    assert (problem.toppra, problem.toppra_path, problem.lower_bound, problem.estimate) == (
        2.5,
        "chord",
        None,
        1.6,
    )
    (sentence,) = [sentence for sentence in write_report(tmp_path).story if "shortest" in sentence]
    assert "0.800 times TOPP-RA's 2.5000 s, 1.250 times the estimated kinematic bound" in sentence


def test_a_report_of_many_rows_draws_a_bounded_page(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    noisy = {
        f"s{number}": lambda case, seed, base=1 + number / 50: record(base + case + 0.1 * rng.random())
        for number in range(5)
    }
    fill(tmp_path, noisy, tuple(f"case-{number}" for number in range(10)), 20)
    files = write_report(tmp_path)
    assert files.html.stat().st_size < 5_000_000
    assert "The first 500 of 1000; all are in results.sqlite." in files.markdown.read_text()


@pytest.mark.parametrize(
    ("value", "shown"),
    [(0.0, "0"), (1.23456, "1.235"), (123456.7, "123457"), (1e-9, "1.000e-09"), (-0.05, "-0.05000")],
)
def test_numbers_are_shown_with_significant_digits(value: float, shown: str) -> None:
    assert format_number(value) == shown


def test_a_changed_record_is_told_apart() -> None:
    assert replace(record(1.0), claimed=False).return_code_correct is False


def test_one_solver_leads_nobody(tmp_path: Path) -> None:
    fill(tmp_path, {"alone": lambda case, seed: record(1.0 + seed)})
    story = story_of(tmp_path)
    assert story[0] == "Only alone was run, on 2 problems."
    assert any("With one solver there is nothing to test." in sentence for sentence in story)


def test_solvers_without_a_common_run_are_not_ranked(tmp_path: Path) -> None:
    apart = {
        "a": lambda case, seed: record(1.0) if seed < 2 else None,
        "b": lambda case, seed: record(2.0) if seed >= 2 else None,
    }
    fill(tmp_path, apart)
    assert "No block has runs of all solvers yet, so they cannot be ranked." in story_of(tmp_path)


def test_a_lead_over_some_but_not_over_others_names_those(tmp_path: Path) -> None:
    close = {
        "first": lambda case, seed: record(1.0 + case + 0.001 * seed),
        "near": lambda case, seed: record(1.0 + case + 0.001 * seed + (0.002 if seed > 2 else -0.0019)),
        "far": lambda case, seed: record(2.0 + case + 0.003 * seed),
    }
    fill(tmp_path, close, seeds=8)
    (sentence,) = [sentence for sentence in story_of(tmp_path) if "chance" in sentence]
    assert sentence.startswith("The lead of first is more than chance over far (")
    assert ", not over the others" in sentence


def test_a_problem_nobody_solves_and_blocks_the_first_loses_are_told(tmp_path: Path) -> None:
    failed = RunRecord("failed", "no", "error", wall_time=1.0)
    fill(
        tmp_path,
        {
            "good": lambda case, seed: failed if case or not seed else record(1.0 + 0.001 * seed),
            "rare": lambda case, seed: record(3.0) if not case and seed < 2 else failed,
        },
    )
    story = story_of(tmp_path)
    assert story[0].startswith("good ranks first")
    assert any("two: no feasible motion was found." in sentence for sentence in story)
    assert "good fails in 1 of 8 blocks in which rare succeeds." in story


def test_answers_the_solver_did_not_vouch_for_are_counted(tmp_path: Path) -> None:
    fill(tmp_path, {"modest": lambda case, seed: record(1.0, claimed=bool(seed))})
    assert "In 2 runs the audit accepts an answer the solver did not vouch for." in story_of(tmp_path)[-1]
