"""Names that a shell completes: cases, solvers, and the robots and families of ``--set``."""

from __future__ import annotations

import click
from click.shell_completion import CompletionItem


def _matching(names: list[str], incomplete: str, prefix: str = "") -> list[CompletionItem]:
    return [CompletionItem(prefix + name) for name in names if name.startswith(incomplete)]


class CaseName(click.ParamType):  # type: ignore[type-arg]  # generic in newer releases only
    """A packaged case's name or the path of a case file."""

    name = "case"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the packaged cases that begin so; files, where none does."""
        from ocp_traj.case import case_names

        return _matching(case_names(), incomplete) or [CompletionItem(incomplete, type="file")]


class SolverName(click.ParamType):  # type: ignore[type-arg]  # generic in newer releases only
    """A solver's name, with parameters if wanted; or several with commas between."""

    name = "solver"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the solvers that the last word of a list begins."""
        from ocp_traj.solvers import solver_names

        before, comma, last = incomplete.rpartition(",")
        return _matching(solver_names(), last, before + comma)


class Override(click.ParamType):  # type: ignore[type-arg]  # generic in newer releases only
    """``KEY=VALUE``."""

    name = "override"

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Return the values of ``robot.model=`` and ``spline.family=`` that begin so."""
        key, equals, value = incomplete.partition("=")
        if key == "robot.model":
            from ocp_traj.robot import robot_names

            return _matching(robot_names(), value, f"{key}=")
        if key == "spline.family":
            from ocp_traj.spline import FAMILIES

            return _matching(list(FAMILIES), value, f"{key}=")
        keys = ["robot.model=", "spline.family=", "spline.virtual_knots="]
        return [] if equals else _matching(keys, key)
