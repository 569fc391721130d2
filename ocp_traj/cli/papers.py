"""``ocp-traj papers``: four published papers run again, with one page each and one summary."""

from __future__ import annotations

from pathlib import Path

import click

from ocp_traj.cli.main import INTERRUPTED
from ocp_traj.cli.output import console_for


@click.command(name="papers")
@click.argument("letters", nargs=-1, metavar="[A] [B] [C] [D]")
@click.option(
    "--seeds", type=click.IntRange(min=1), default=20, show_default=True, metavar="N", help="Runs per method."
)
@click.option(
    "--reduced", is_flag=True, help="Tiny budgets, to test the machinery: the numbers mean nothing."
)
@click.option(
    "--jobs", type=click.IntRange(min=1), default=1, show_default=True, metavar="N", help="Worker processes."
)
@click.option(
    "--output",
    default="papers",
    show_default=True,
    metavar="DIR",
    help="Folder of pages, figures and finished runs.",
)
def run_papers(letters: tuple[str, ...], seeds: int, reduced: bool, jobs: int, output: str) -> int:
    """Run the papers A to D again and hold them to their word.

    Writes one page per paper, its pictures and a summary into DIR. What is finished is kept in DIR/records, one
    comparison per paper; the same command again does only what is missing.
    """
    from ocp_traj.papers.reproduce import reproduce

    console = console_for(None)

    def show(paper: str, done: int, total: int) -> None:
        console.print(f"paper {paper}: {done} of {total} runs", markup=False)

    try:
        pages = reproduce(letters, Path(output), seeds, reduced, jobs, show)
    except KeyboardInterrupt:
        console.print(
            f"stopped; what is finished is kept in {output}, the same command goes on", markup=False
        )
        return INTERRUPTED
    for page in pages:
        console.print(str(page), markup=False)
    return 0
