"""Runs what is missing of the chosen papers and writes their pages."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from ocp_traj.exceptions import InputError
from ocp_traj.papers import PAPERS, get_paper
from ocp_traj.papers.page import write_page, write_summary
from ocp_traj.papers.paper import Paper
from ocp_traj.papers.records import Records, plan_experiments


def reproduce(
    letters: Sequence[str],
    folder: Path,
    seeds: int,
    reduced: bool = False,
    jobs: int = 1,
    progress: Callable[[str, int, int], object] = lambda paper, done, total: None,
) -> list[Path]:
    """Run the papers, write one page each and the summary; return the pages' paths.

    Parameters
    ----------
    letters : sequence of str
        Of the papers; none means all.
    folder : pathlib.Path
        For pages and pictures; finished runs are kept in its folder ``records``, reduced ones apart.
    seeds : int
        Runs of every method.
    reduced : bool
        Tiny budgets, for tests.
    jobs : int
        Worker processes.
    progress : callable
        Called with the paper's letter and how many of its runs are finished, of how many.

    Raises
    ------
    UnknownNameError
        There is no such paper.
    InputError
        The folder cannot be written.
    """
    papers = [get_paper(letter) for letter in dict.fromkeys(letter.upper() for letter in letters or PAPERS)]
    command = command_line([paper.key for paper in papers], seeds, reduced)
    finished: list[tuple[Paper, Records]] = []
    pages = []
    try:
        (folder / "records").mkdir(parents=True, exist_ok=True)  # before hours of runs that could not be kept
        for paper in papers:
            name = f"{paper.stem}{'-reduced' if reduced else ''}"
            records = Records(folder / "records" / name, paper.case)
            plan = plan_experiments(paper.case, paper.experiments(reduced), seeds)
            records.run(plan, jobs, partial(progress, paper.key))
            pages.append(write_page(paper, records, folder, command, reduced))
            finished.append((paper, records))
        return [*pages, write_summary(finished, folder, command, reduced)]
    except OSError as error:
        raise InputError(f"cannot write into {folder}: {error.strerror or error}") from None


def command_line(letters: Sequence[str], seeds: int, reduced: bool) -> str:
    """Return the command that makes the pages, as a person would type it."""
    chosen = "" if list(letters) == list(PAPERS) else " " + " ".join(letters)
    return f"ocp-traj papers{chosen} --seeds {seeds}{' --reduced' if reduced else ''}"
