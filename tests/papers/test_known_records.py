"""The pages of all four papers from records with known numbers: every verdict follows from them, nothing is run."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from html import escape
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ocp_traj.comparison.runs.compare import identify_case
from ocp_traj.comparison.runs.record import RunRecord
from ocp_traj.comparison.runs.store import Store
from ocp_traj.papers import PAPERS, get_paper, motions
from ocp_traj.papers.drawings import best_motion, convergence_picture
from ocp_traj.papers.experiments import PUBLISHED_PROTOCOL, Experiment
from ocp_traj.papers.page import SCREEN_DPI
from ocp_traj.papers.paper import Paper
from ocp_traj.papers.records import Records, plan_experiments
from ocp_traj.pictures.matplotlib_ import save_picture

SEEDS = 20
NOISE = 0.001 * np.random.default_rng(9).random(SEEDS)

ORDERS = {
    "A": ("ISSA of A", "SSA", "PSO"),
    "B": ("ISSA of B", "SSA", "PSO"),
    "C": ("TADF-SSA", "ADF-SSA", "SSA", "T-SSA"),
    "D": ("PSO of D", "PSO", "PSO of D, repaired"),
}
"""As the papers claim them, best first."""

GENERATIONS = {**ORDERS, "C": ("TADF-SSA", "ADF-SSA", "T-SSA", "SSA")}

SHARED = {
    "A": {"lower": None, "upper": None, "message": "the task has 7 gaps", "durations": []},
    "B": {"lower": 4.3061, "upper": 4.31041, "message": "proved", "durations": [2.10311, 0.94825, 1.25905]},
    "C": {"lower": None, "upper": None, "message": "the task has 8 gaps", "durations": []},
    "D": {"lower": 1.22304, "upper": 1.22427, "message": "proved", "durations": [0.22975, 0.76694, 0.22759]},
}
"""Certificates, as `certified_optimum` proves them in the slow test of the pages."""

REFERENCES = {
    "kinematic_bound": {"lower": 1.25, "estimate": 1.5},
    "toppra": {"chord": 1.75},
    "convex": {"chord": 1.875},
}
ALONE = [0.5, 0.25, 0.75]
"""Durations every joint alone is said to need."""


def history(value: float, steps: int, width: int = 0) -> dict[str, Any]:
    """A search that falls to its value: not within the limits at first, then twice as long, then there."""
    course: dict[str, Any] = {
        "evaluations": [100.0 * (step + 1) for step in range(steps)],
        "cost": [value, 2 * value, *[value] * (steps - 2)],
        "violation": [1.0, *[0.0] * (steps - 1)],
        "seconds": [0.01 * step for step in range(steps)],
    }
    if not width:
        return course
    return course | {"generation": list(range(steps)), "x": [[value / width] * width] * steps}


def run_of(paper: Paper, experiment: Experiment, seed: int, rank: int, slow: int, share: float) -> RunRecord:
    """A run whose cost, generations and seconds grow with the method's ranks; the noise is that of the seed."""
    task = paper.task(experiment.overrides)
    value = 6.0 * (1 + 0.25 * rank) * (1 + NOISE[seed])
    gaps = np.full(task.gaps, value / task.gaps)
    return RunRecord(
        "budget_exhausted",
        "said so",
        feasible=share > seed / SEEDS,
        objective=value,
        duration=value,
        energy=100.0 * value,
        worst={"limit": "velocity", "joint": 2, "time": 0.5, "ratio": 0.75},
        smallest_feasible_scale=0.875,
        evaluations=5000 + rank,
        build_time=0.0,
        solve_time=1.0 + slow,
        history=history(value, 30),
        details={
            "segments": gaps.tolist(),
            "processor": (1.0 + slow) * (1 + NOISE[seed]),
            "generations": 10 * (slow + 1) + seed % 2,
            "parts": [
                {
                    "joint": joint,
                    "cost": value / 8,
                    "evaluations": 100,
                    "generations": 10 * (slow + 1) + seed % 2,
                    "history": history(value / 8, 20, task.gaps),
                }
                for joint in (np.flatnonzero(np.ptp(task.waypoints, axis=0)) + 1).tolist()
            ],
        },
    )


def known_records(paper: Paper, folder: Path, reverse: bool = False, share: float = 1.0) -> Records:
    """Every run and every computed number of a paper's reduced page; `share` of the runs keep the limits."""
    order, speed = (list(table[paper.key])[:: -1 if reverse else 1] for table in (ORDERS, GENERATIONS))
    plan = plan_experiments(paper.case, paper.experiments(True), SEEDS)
    with Store(folder, create=True) as store:
        number = store.add_plan(plan, {}, plan.runs(identify_case))
        for experiment, spec in plan.specifications(identify_case):
            rank, slow = (
                entries.index(experiment.label) if experiment.label in entries else len(entries)
                for entries in (order, speed)
            )
            store.add_run(spec, run_of(paper, experiment, spec.seed, rank, slow, share), number)
    records = Records(folder, paper.case)
    records.choose(plan)
    task = paper.task()
    records.computed("references", lambda: REFERENCES)
    records.computed("certificate", lambda: SHARED[paper.key])
    if paper.protocol.joints:
        for joint in np.flatnonzero(np.ptp(task.waypoints, axis=0)).tolist():
            alone = {"lower": 1.0, "upper": 1.5 + joint / 10, "message": "proved", "durations": ALONE}
            records.computed(f"certificate, joint {joint + 1}", partial(dict, alone))
    rows = [
        {"form": form, "points": points, "eight": [0.002 * points] * 10, "one": [0.001 * points] * 10}
        for points in (9, 900)
        for form in ("python", "vectorised")
    ]
    records.computed("inverse kinematics", lambda: {"rows": rows})
    return records


@pytest.fixture
def nothing_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is in the records is not run again."""

    def refuse(*_: Any) -> None:
        raise AssertionError("a finished run was started again")

    monkeypatch.setattr("ocp_traj.comparison.runs.execute.run_supervised", refuse)
    monkeypatch.setattr("ocp_traj.references.certify", refuse)
    monkeypatch.setattr("ocp_traj.references.references", refuse)


def pages_of(key: str, folder: Path, share: float = 1.0) -> tuple[str, str, list[str]]:
    """Write a page and its summary from known records by the command; return both texts and what was printed."""
    from ocp_traj.cli import papers

    printed: list[str] = []
    known_records(get_paper(key), folder / "records" / f"{get_paper(key).stem}-reduced", share=share)
    with pytest.MonkeyPatch.context() as patch:
        console = SimpleNamespace(print=lambda text, markup: printed.append(text))
        patch.setattr(papers, "console_for", lambda _: console)
        arguments = [key.lower(), "--reduced", "--seeds", str(SEEDS), "--output", str(folder)]
        assert papers.run_papers.main(args=arguments, standalone_mode=False) == 0
    page, summary = Path(printed[-2]), Path(printed[-1])
    return page.read_text(encoding="utf-8"), summary.read_text(encoding="utf-8"), printed


@pytest.fixture
def no_energies(monkeypatch: pytest.MonkeyPatch) -> None:
    """Paper D's extension solves three problems: here they are said to be solved."""
    rows = [{"motion": "least energy", "duration": 1.25, "energy": 345.5}]
    monkeypatch.setattr("ocp_traj.papers.zhu_wang.fanuc_energy._compute_energies", lambda task, shortest: rows)


@pytest.mark.usefixtures("nothing_runs", "no_energies")
@pytest.mark.parametrize("key", PAPERS)
def test_a_page_holds_every_run_claim_and_figure(key: str, tmp_path: Path) -> None:
    paper = get_paper(key)
    text, summary, printed = pages_of(key, tmp_path)
    total = sum(1 if entry.once else SEEDS for entry in paper.experiments(True))
    assert printed == [
        f"paper {key}: {total} of {total} runs",
        str(tmp_path / f"{paper.stem}.md"),
        str(tmp_path / "index.md"),
    ]
    assert f"computed by `ocp-traj papers {key} --seeds {SEEDS} --reduced`" in text
    assert f"{SEEDS} runs of every method, one a seed" in text
    for experiment in paper.experiments(True):
        assert f"| {experiment.label} (`{experiment.solver}`) |" in text
    assert "not run" not in text
    unit = 100.0 if paper.minimised == "energy" else 1.0
    best = 6.0 * unit * (1 + NOISE.min())
    assert f"{best:.4f}" in text and f"{6.0 * unit * (1 + NOISE.max()):.4f}" not in text
    for number in ("1.2500", "1.5000", "1.7500", "1.8750"):
        assert f"| {number} |" in text
    assert ("| least energy | 1.2500 | 345.5 |" in text) == (key == "D")
    for sentence in paper.stand_ins:
        assert escape(sentence, quote=False) in text
    claims = paper.claims(known_records(paper, tmp_path / "again"))
    for claim in claims:
        assert escape(claim.sentence, quote=False).replace("|", "\\|") in text
    assert f"Of {len(claims)} claims and remarks" in summary
    pictures = [line.split("](")[1].rstrip(")") for line in text.splitlines() if line.startswith("![")]
    assert len(pictures) == len(set(pictures)) == {"A": 2, "B": 3, "C": 6, "D": 5}[key]
    for picture in pictures:
        assert (tmp_path / picture).read_bytes().startswith(b"\x89PNG")
        assert 5_000 < (tmp_path / picture).stat().st_size < 170_000


@pytest.mark.usefixtures("nothing_runs")
def test_a_page_can_be_written_though_no_run_keeps_the_limits(tmp_path: Path) -> None:
    text, _, _ = pages_of("A", tmp_path, share=0.0)
    assert f"| 0 of {SEEDS} |" in text and f"| 20 of {SEEDS} |" not in text
    assert f"Runs that found a motion inside the limits: ISSA of A 0 of {SEEDS}, SSA 0 of {SEEDS}" in text
    assert "not feasible by the audit: said so" in text
    assert "infeasible" in text


VERDICTS = {
    "A": {
        "energy: ISSA < SSA < PSO": ("holds", "does not hold on the stand-in case"),
        "PSO converges slowest of the three": ("holds", "does not hold on the stand-in case"),
        "ISSA's average running time is significantly lower than that of SSA and PSO": (
            "holds",
            "does not hold on the stand-in case",
        ),
    },
    "B": {
        "total time, once slowed into the limits: ISSA < SSA < PSO": ("holds", "does not hold"),
        "total time, as synchronised, within the limits or not: ISSA < SSA < PSO": ("holds", "does not hold"),
        "ISSA 4.9 % shorter than SSA, once slowed into the limits": ("holds", "does not hold: worse"),
        "ISSA 15.8 % shorter than PSO, as synchronised, within the limits or not": ("holds", "does not hold: worse"),
        "joint 2: ISSA's accuracy 13 % better than SSA's": ("holds", "does not hold: worse"),
        "joint 4: ISSA's accuracy 48 % better than PSO's": (
            "better, by less than claimed",
            "does not hold: worse",
        ),
        "joint 4: ISSA converges in 25 % fewer generations than SSA": ("holds", "does not hold: worse"),
        "joint 5: ISSA converges in 80 % fewer generations than PSO": (
            "better, by less than claimed",
            "does not hold: worse",
        ),
    },
    "C": {
        "durations: TADF-SSA < ADF-SSA < SSA < T-SSA (8.99, 9.85, 10.83, 12.07 s)": (
            "holds",
            "does not hold on the stand-in case",
        ),
        "generations to convergence: TADF-SSA 18 < ADF-SSA 23 < T-SSA 34 < SSA 46": (
            "holds",
            "does not hold on the stand-in case",
        ),
        "Tent chaos alone does not improve the result significantly (12.07 against 10.83 s)": (
            "holds",
            "does not hold on the stand-in case",
        ),
        "the adaptive factor alone improves": ("holds", "does not hold on the stand-in case"),
        "unique domains save 39.76 % of the inverse kinematics' time": ("holds: at least that",) * 2,
        "velocity, acceleration and jerk stay below their limits": ("holds",) * 2,
        "joint 6 does not move": ("holds",) * 2,
    },
    "D": {
        "most joints converge within 30 iterations": ("holds", "holds"),
        "the improved swarm needs fewer iterations than the plain one (mean over joints)": (
            "holds",
            "does not hold",
        ),
        "the improved swarm's solution is more accurate (mean of the joints' own optima)": (
            "holds",
            "does not hold",
        ),
        "a shorter path of the end effector": ("does not hold",) * 2,
    },
}
"""Of each claim on the runs: with runs as the paper claims them, and with the methods' order turned round."""


@pytest.mark.parametrize("reverse", [False, True], ids=["as claimed", "turned round"])
@pytest.mark.parametrize("key", PAPERS)
def test_verdicts_follow_the_runs(key: str, reverse: bool, tmp_path: Path) -> None:
    paper = get_paper(key)
    verdicts = {
        claim.sentence: claim.verdict
        for claim in paper.claims(known_records(paper, tmp_path / "runs", reverse))
    }
    expected = {sentence: pair[reverse] for sentence, pair in VERDICTS[key].items()}
    assert {sentence: verdicts.get(sentence) for sentence in expected} == expected


def test_one_run_over_a_limit_is_enough_to_refute_that_limits_are_kept(tmp_path: Path) -> None:
    paper = get_paper("C")
    found = paper.claims(known_records(paper, tmp_path / "runs", share=(SEEDS - 0.5) / SEEDS))
    kept = next(claim for claim in found if claim.sentence.startswith("velocity, acceleration and jerk stay"))
    assert kept.verdict == "holds"
    found = paper.claims(known_records(paper, tmp_path / "fewer", share=(SEEDS - 1) / SEEDS))
    kept = next(claim for claim in found if claim.sentence.startswith("velocity, acceleration and jerk stay"))
    assert (kept.verdict, kept.measured) == (
        "does not hold for every run",
        f"{4 * (SEEDS - 1)} of {4 * SEEDS} runs keep every limit at every time",
    )


def test_the_slowest_joint_and_the_sum_of_segments_are_told(tmp_path: Path) -> None:
    paper = get_paper("B")
    records = known_records(paper, tmp_path / "runs")
    optima = motions.joint_optima(paper.task(), records)
    assert sorted(optima) == [2, 3, 4, 5, 6]
    assert motions.synchronised_optima(paper.task(), optima) == pytest.approx(ALONE)
    claim = next(claim for claim in paper.claims(records) if "3.17564 s and keeps" in claim.sentence)
    assert "slowest joint alone (joint 6) 2.0000 s" in claim.measured
    assert "largest duration of each segment over the joints 1.5000 s" in claim.measured
    assert "4.3104 s (proved above 4.3061 s)" in claim.measured


def test_the_best_motion_is_the_shortest_feasible_one(tmp_path: Path) -> None:
    paper = get_paper("C")
    records = known_records(paper, tmp_path / "runs")
    rows = records.runs("SSA", PUBLISHED_PROTOCOL)
    shortest = min(rows, key=lambda row: row.record.duration)
    motion = best_motion(paper.task(), rows, "duration")
    assert motion is not None and motion.duration == pytest.approx(shortest.record.duration)
    rows = [replace(row, record=replace(row.record, feasible=row is not shortest)) for row in rows]
    motion = best_motion(paper.task(), rows, "duration")
    assert motion is not None and motion.duration > shortest.record.duration * (1 + 1e-6)
    bare = [replace(row, record=replace(row.record, details={"segments": []})) for row in rows]
    assert best_motion(paper.task(), bare, "duration") is None


def test_convergence_is_drawn_although_no_run_is_ever_feasible(tmp_path: Path) -> None:
    paper = get_paper("A")
    records = known_records(paper, tmp_path / "runs")
    for label in paper.protocol.labels:
        for row in records.runs(label, PUBLISHED_PROTOCOL):
            row.record.history["violation"] = [0.5] * len(row.record.history["violation"])
    picture = convergence_picture(records, paper.protocol.labels, PUBLISHED_PROTOCOL, "title", "", "J")
    save_picture(picture, tmp_path / "none.png", SCREEN_DPI)
    assert (tmp_path / "none.png").stat().st_size > 5_000


def test_a_folder_that_cannot_be_written_is_told_before_anything_runs(
    nothing_runs: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from ocp_traj.cli.main import run

    (tmp_path / "file").write_text("in the way")
    assert run(["papers", "B", "--reduced", "--seeds", "1", "--output", str(tmp_path / "file" / "out")]) == 2
    printed = capsys.readouterr()
    assert printed.err == f"ocp-traj: cannot write into {tmp_path / 'file' / 'out'}: Not a directory\n"
    assert "of" not in printed.out
