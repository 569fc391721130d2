"""``ocp-traj``: finds the command, and turns every expected error into one sentence and an exit status."""

from __future__ import annotations

import contextlib
import importlib
import os
import re
import sys

import click

from ocp_traj.exceptions import OcpTrajError, UnavailableError, did_you_mean
from ocp_traj.version import __version__

LEAST_MEMORY = 2**30
"""Address space, bytes, that a command needs: measured, 0.8 GiB are too few for a robot with torques."""

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

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the command that the arguments start with; one that does not exist is answered with the nearest."""
        if args and args[0] not in _COMMANDS and not args[0].startswith("-"):
            expected = ", ".join(_COMMANDS)
            ctx.fail(f"no command {args[0]!r}, expected one of {expected}{did_you_mean(args[0], _COMMANDS)}")
        return super().resolve_command(ctx, args)


@click.group(
    cls=LazyGroup,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@click.version_option(__version__, prog_name="ocp-traj")
@click.pass_context
def cli(ctx: click.Context) -> None:
    """Compare optimal-control solvers on robot-arm trajectories: one problem, one budget, one judge."""
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and leave with 0 (done, feasible), 1 (no feasible answer) or 2 (wrong input)."""
    sys.exit(run(arguments))


def run(arguments: list[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    _write_any_character()
    try:
        _check_memory(sys.argv[1:] if arguments is None else arguments)
        status = cli.main(args=arguments, prog_name="ocp-traj", standalone_mode=False)
        sys.stdout.flush()
    except OcpTrajError as error:
        return complain(str(error))
    except click.ClickException as error:
        return complain(error.format_message().rstrip(".") + _near_choice(error))
    except BrokenPipeError:
        _drop_standard_output()
        sys.stderr.close()  # the reader of our output went away: nothing to tell anybody
        return 1
    except OSError as error:
        _drop_standard_output()
        place = error.filename or "standard output or a file"
        return complain(f"{place} cannot be used: {error.strerror or error}")
    except ImportError as error:
        return complain(f"a library cannot be loaded: {error}")
    except MemoryError:
        return complain("there is not enough memory, expected a smaller problem or a higher limit (ulimit -v)")
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return INTERRUPTED
    return status if isinstance(status, int) else 0


def _check_memory(arguments: list[str]) -> None:
    """Refuse a limit of memory under which numerical libraries do not load, but wait for memory forever.

    Raises
    ------
    UnavailableError
        The limit is lower; help needs none of them and is always given.
    """
    if not arguments or {"-h", "--help", "--version"} & set(arguments):
        return
    with contextlib.suppress(ImportError):  # Windows has no such limit
        import resource

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        if limit != resource.RLIM_INFINITY and limit < LEAST_MEMORY:
            raise UnavailableError(
                f"the limit of memory is {limit / 2**30:.2f} GiB (ulimit -v), expected at least "
                f"{LEAST_MEMORY / 2**30:.2f} GiB: the numerical libraries do not load with less"
            )


def _write_any_character() -> None:
    """Let output in an encoding of few characters replace what it cannot write."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace" if stream is sys.stdout else "backslashreplace")


def _drop_standard_output() -> None:
    """Send what is still to be flushed at the end of the program nowhere: it could not be written."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _near_choice(error: click.ClickException) -> str:
    """Return what may have been meant where a word is none of an option's."""
    kind = getattr(getattr(error, "param", None), "type", None)
    given = re.match(r"'(.*?)' is not one of", error.message)
    if given is None or not isinstance(kind, click.Choice):
        return ""
    return did_you_mean(given[1], [str(choice) for choice in kind.choices])


def complain(message: str) -> int:
    """Print one sentence on standard error; return the status of wrong input."""
    click.echo("ocp-traj: " + " ".join(message.split()), err=True)
    return WRONG_INPUT
