"""A page says what was run, by which command, and holds every claim and figure."""

from __future__ import annotations

from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np
import pytest

from ocp_traj.comparison.report.document import Document, ReportSection, Table, to_markdown
from ocp_traj.comparison.runs.store import Store
from ocp_traj.papers import PAPERS, get_paper
from ocp_traj.papers.drawings import lines_picture
from ocp_traj.papers.experiments import EQUAL_EVALUATIONS, PUBLISHED_PROTOCOL, Experiment, Protocol
from ocp_traj.papers.methods import method_section
from ocp_traj.papers.page import claims_table, seeds_of, write_page, write_summary
from ocp_traj.papers.paper import Claim, Paper, table_of
from ocp_traj.papers.records import Records, plan_experiments
from ocp_traj.papers.reproduce import command_line
from ocp_traj.pictures.picture import Picture

PROVED = {"lower": 3.99, "upper": 4.0, "message": "proved"}


class SmallPaper(Paper):
    """Two methods on a case of one gap."""

    key = "D"
    name = "Small et al. 2001"
    title = "A small paper"
    reference = "nowhere"
    summary = "It moves."
    case = "fang-2020-task-1"
    protocol = Protocol(methods=(("random search", "random"),), population=30, generations=2)
    stand_ins = ("Everything is a stand-in.",)

    def experiments(self, reduced: bool) -> list[Experiment]:
        return [
            Experiment(PUBLISHED_PROTOCOL, "random search", "random", 30, published="1 s"),
            Experiment(EQUAL_EVALUATIONS, "DE", "de", 60),
            Experiment(EQUAL_EVALUATIONS, "random search", "random", 60),
        ]

    def story(self, records: Records) -> list[str]:
        return [f"{len(records.runs('DE', EQUAL_EVALUATIONS))} runs of DE."]

    def claims(self, records: Records) -> list[Claim]:
        return [
            Claim("shorter | better", "Table 1", "no", "does not hold: longer"),
            Claim("a", "", "b", "holds"),
        ]

    def tables(self, records: Records) -> list[Table]:
        return [table_of("More", ("a",), [("1",)], "Note.")]

    def figures(self, records: Records) -> list[Picture | str]:
        x = np.arange(3)
        return [
            lines_picture("lines", "Fig. 1", "Lines.", ("x", "y"), x, {"y": x}),
            "Fig. 2, a photograph: not regenerated, not a result.",
        ]


def markdown(*sections: ReportSection) -> str:
    """Return the text of sections."""
    return to_markdown(Document("", "", (), sections))


@pytest.fixture
def records(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Records:
    found = {"kinematic_bound": {"lower": 1.0, "estimate": None}, "toppra": {"uniform": 2.0}, "convex": {}}
    monkeypatch.setattr("ocp_traj.papers.page.reference_numbers", lambda task, records: found)
    monkeypatch.setattr("ocp_traj.papers.page.certified_optimum", lambda task, records: PROVED)
    records = Records(tmp_path / "records", SmallPaper.case)
    plan = plan_experiments(SmallPaper.case, SmallPaper().experiments(True), 2)
    records.run(plan, 1, lambda done, total: None)
    return records


def test_a_page_shows_methods_references_figures_and_claims(records: Records, tmp_path: Path) -> None:
    page = write_page(SmallPaper(), records, tmp_path, "ocp-traj papers D --seeds 2", False)
    text = page.read_text(encoding="utf-8")
    assert page.name == "small-2001.md"
    assert text.startswith("# Small et al. 2001 (paper D): A small paper\n")
    assert "computed by `ocp-traj papers D --seeds 2`" in text
    assert "Reduced budgets" not in text
    assert "| random search (`random`) | 1 s |" in text
    assert "Ranking: 2 seeds" in text
    assert "best found | — |" in text and "TOPP-RA, uniform path parameter | 2.0000 |" in text
    assert "| no motion of the paper's curve within its limits is shorter (certified) | 3.9900 |" in text
    assert (
        "Every method gets 60 evaluations of all joints together, the paper's 30 candidates times 2" in text
    )
    assert "**2 runs of a method only:" in text
    assert (tmp_path / "small-2001-lines.png").exists() and "![Fig. 1](small-2001-lines.png)" in text
    assert "## More\n\n| a |\n| --- |\n| 1 |\n\nNote.\n" in text
    assert "Fig. 2, a photograph: not regenerated, not a result." in text
    assert "shorter \\| better" in text and "**does not hold: longer**" in text
    assert "Everything is a stand-in." in text


def test_a_reduced_page_warns(records: Records, tmp_path: Path) -> None:
    page = write_page(SmallPaper(), records, tmp_path, "x", True)
    assert "the numbers mean nothing" in page.read_text(encoding="utf-8")


def test_the_summary_counts_verdicts_and_links_every_page(records: Records, tmp_path: Path) -> None:
    text = write_summary([(SmallPaper(), records)], tmp_path, "x", False).read_text(encoding="utf-8")
    assert "Of 2 claims and remarks: 1 × does not hold, 1 × holds." in text
    assert "[All of them](small-2001.md)" in text and "2 runs of DE." in text


def test_methods_with_fewer_runs_are_shown_but_not_ranked(records: Records) -> None:
    paper = SmallPaper()
    entries = paper.experiments(True)
    fewer = [replace(entry, once=entry.label == "DE") for entry in entries]
    records.choose(plan_experiments(paper.case, fewer, 2))
    equal = [entry for entry in entries if entry.group == EQUAL_EVALUATIONS]
    text = markdown(method_section(paper, records, EQUAL_EVALUATIONS, equal))
    assert "Ranking (without DE: fewer runs): 2 seeds" in text
    assert "| DE (`de`) |" in text


def test_a_page_without_a_proof_says_why(
    records: Records, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing = {"lower": None, "upper": None, "message": "the ends are not at rest"}
    monkeypatch.setattr("ocp_traj.papers.page.certified_optimum", lambda task, records: nothing)
    text = write_page(SmallPaper(), records, tmp_path, "x", False).read_text(encoding="utf-8")
    assert "No certified optimum of the paper's curve: the ends are not at rest." in text
    assert "(certified) | 3.9900" not in text


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ([20, 20], "20 runs of every method, one a seed; what runs once says so."),
        (
            [4, 20],
            "20 runs of a method, one a seed; what has fewer, down to 4, or runs once says so and is not ranked.",
        ),
        (
            [3, 4],
            "**3 to 4 runs of a method only: medians are rough, and tests can hardly prove a difference.**",
        ),
    ],
)
def test_the_number_of_seeds_is_counted(counts: list[int], words: str) -> None:
    assert seeds_of(counts) == words


def test_a_table_has_a_row_a_claim() -> None:
    table = claims_table([Claim("a", "b", "c|", "d")] * 3)
    assert len(table.rows) == 3
    assert markdown(ReportSection("", "", tables=(table,))).count("| a | b | c\\| | **d** |") == 3


def test_the_command_on_a_page_is_the_one_to_type() -> None:
    assert command_line(list(PAPERS), 20, False) == "ocp-traj papers --seeds 20"
    assert command_line(["B"], 3, True) == "ocp-traj papers B --seeds 3 --reduced"


@pytest.mark.slow
@pytest.mark.parametrize("key", PAPERS)
def test_every_paper_runs_from_end_to_end_and_resumes(
    key: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from ocp_traj.case import task_digest
    from ocp_traj.cli.main import run

    arguments = ["papers", key, "--reduced", "--seeds", "2", "--output", str(tmp_path)]
    assert run(arguments) == 0
    stem, digest = get_paper(key).stem, task_digest(get_paper(key).task())
    text = (tmp_path / f"{stem}.md").read_text(encoding="utf-8")
    with Store(tmp_path / "records" / f"{stem}-reduced") as store:
        kept = store.table(), store.results(digest)
    for sentence in get_paper(key).stand_ins:
        assert escape(sentence, quote=False) in text
    for picture in [line.split("](")[1].rstrip(")") for line in text.splitlines() if line.startswith("![")]:
        assert 0 < (tmp_path / picture).stat().st_size < 150_000
    capsys.readouterr()
    assert run(arguments) == 0
    with Store(tmp_path / "records" / f"{stem}-reduced") as store:
        assert (store.table(), store.results(digest)) == kept
