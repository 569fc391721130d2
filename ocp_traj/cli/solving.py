"""``ocp-traj solve``: one case, one solver."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ocp_traj.cli.completion import CaseName, SolverName
from ocp_traj.cli.output import (
    FEASIBLE,
    INFEASIBLE,
    check_writable,
    console_for,
    json_option,
    overrides_option,
    seconds,
    write_json,
)

if TYPE_CHECKING:
    from rich.console import Console


@click.command(name="solve")
@click.argument("case", type=CaseName())
@click.option(
    "--solver",
    type=SolverName(),
    default="ipopt",
    show_default=True,
    help="Name, with parameters: pso[inertia=linear].",
)
@click.option("--seed", default=0, show_default=True, type=click.IntRange(min=0))
@click.option("--budget", type=click.IntRange(min=1), metavar="EVALS", help="Evaluations the solver may use.")
@click.option(
    "--time-limit", type=click.FloatRange(min=0, min_open=True), metavar="S", help="Seconds it may take."
)
@overrides_option
@click.option("--references", is_flag=True, help="Add TOPP-RA and the kinematic bound to the JSON.")
@click.option("--rate", default=1000.0, show_default=True, metavar="HZ", help="Samples a second in the CSV.")
@click.option("--output", metavar="FILE.csv", help="Write the trajectory, and the exact curve beside it.")
@click.option("--proof", metavar="FILE", help="Prove that the motion keeps every limit; 1 where it cannot be.")
@json_option
def solve_case(
    case: str,
    solver: str,
    seed: int,
    budget: int | None,
    time_limit: float | None,
    overrides: tuple[str, ...],
    references: bool,
    rate: float,
    output: str | None,
    proof: str | None,
    json_file: str | None,
) -> int:
    """Solve CASE, a packaged case's name or a file, with one solver; the audit judges the answer.

    Leaves with 0 when the answer is feasible, 1 when it is not.
    """
    from ocp_traj.case import load_case
    from ocp_traj.solving import solve
    from ocp_traj.trajectory_files import spline_path, write_csv

    check_writable(output, None if output is None else spline_path(output), proof, json_file)
    console = console_for(json_file)
    task = load_case(case, overrides)
    with console.status(f"{solver} on {task.name} …"):
        result = solve(task, solver, seed=seed, budget=budget, time_limit=time_limit)
    found = None
    if references:
        from ocp_traj.references import references as compute_references

        with console.status("references …"):
            found = compute_references(task)
    _show(console, result)
    if output is not None and result.trajectory is not None:
        torques = task.robot.torque if task.has_inertia and task.robot is not None else None
        write_csv(Path(output), result.trajectory, rate, torques, task)
    write_json(result.to_json(references=found), json_file)
    proved = 0
    if proof is not None:
        from ocp_traj.cli.auditing import write_if_proved

        proved = write_if_proved(proof, result.prove, lambda words: console.print(words, markup=False))
    return FEASIBLE if result.feasible and proved == 0 else INFEASIBLE


def _show(console: Console, result: Any) -> None:
    """Say in a few lines what came out."""
    solution = result.solution
    verdict = "[green]feasible[/]" if result.feasible else "[red]not feasible[/]"
    console.print(f"{result.task.name}, {result.solver.replace('[', chr(92) + '[')}: {verdict} (audit)")
    if result.trajectory is not None:
        console.print(f"  duration   {seconds(result.duration)}   objective {result.objective:.6g}")
    if result.energy is not None:
        console.print(f"  energy     {result.energy:.5g} J")
    if result.audit is not None:
        worst = result.audit.worst
        if worst is not None:
            joint = f", joint {worst.joint + 1}" if worst.joint >= 0 else ""
            place = f"{worst.key}{joint}, at {worst.time:.4f} s"
            console.print(f"  tightest   {place}: ratio {worst.ratio:.7f}", markup=False)
        for finding in result.audit.findings:
            console.print(f"  {finding}", markup=False)
    told = result.audit is not None and result.diagnosis in result.audit.findings
    message = solution.message if told else result.message
    console.print(f"  status     {solution.status.key}: {message}", markup=False)
    console.print(
        f"  cost       {solution.evaluations} evaluations, build {solution.build_time:.3f} s, "
        f"solve {solution.solve_time:.3f} s"
    )
    calls = ", ".join(f"{name} {count}" for name, count in result.counts.items())
    offsets = result.offsets
    measured = f", offsets from the {offsets['from']} in +-{offsets['box']:g}" if offsets else ""
    console.print(f"  calls      {calls}; encoding {result.encoding}{measured}", markup=False)
