"""``ocp-traj``: finds the command, and turns every expected error into one sentence and an exit status."""

from __future__ import annotations

import importlib
import sys

import click

from ocp_traj.exceptions import OcpTrajError
from ocp_traj.version import __version__

WRONG_INPUT = 2
INTERRUPTED = 130

_COMMANDS = {
    "list": "ocp_traj.cli.listing:list_names",
    "solve": "ocp_traj.cli.solving:solve_case",
    "init": "ocp_traj.cli.cases:init_case",
    "check": "ocp_traj.cli.cases:check_cases",
    "audit": "ocp_traj.cli.auditing:audit_motion",
    "reference": "ocp_traj.cli.referencing:reference_case",
    "pareto": "ocp_traj.cli.pareto:pareto_case",
    "compare": "ocp_traj.cli.comparing:compare_solvers",
    "report": "ocp_traj.cli.comparing:write_report_again",
    "papers": "ocp_traj.cli.papers:run_papers",
    "plot": "ocp_traj.cli.plotting:plot_file",
    "export": "ocp_traj.cli.exporting:export_file",
}


class LazyGroup(click.Group):
    """A group whose commands are imported when they are asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the commands in the order of the help page."""
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import one command."""
        place = _COMMANDS.get(cmd_name)
        if place is None:
            return None
        module, _, name = place.partition(":")
        return getattr(importlib.import_module(module), name)


@click.group(
    cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110}
)
@click.version_option(__version__, prog_name="ocp-traj")
def cli() -> None:
    """Compare optimal-control solvers on robot-arm trajectories: one problem, one budget, one judge."""


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and leave with 0 (done, feasible), 1 (no feasible answer) or 2 (wrong input)."""
    sys.exit(run(arguments))


def run(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    try:
        status = cli.main(args=arguments, prog_name="ocp-traj", standalone_mode=False)
    except OcpTrajError as error:
        return complain(str(error))
    except click.ClickException as error:
        return complain(error.format_message())
    except BrokenPipeError:
        sys.stderr.close()  # the reader of our output went away: nothing to tell anybody
        return 1
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return INTERRUPTED
    return status if isinstance(status, int) else 0


def complain(message: str) -> int:
    """Print one sentence on standard error; return the status of wrong input."""
    click.echo("ocp-traj: " + " ".join(message.split()), err=True)
    return WRONG_INPUT
