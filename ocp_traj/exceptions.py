"""Every error the library raises on purpose; each message says what was given and what was expected."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def did_you_mean(given: str, expected: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"`` for a near miss, else an empty text."""
    close = difflib.get_close_matches(given[:100], list(expected), n=1)
    return f"; did you mean {close[0]!r}?" if close else ""


class OcpTrajError(Exception):
    """Root of the library's own exceptions."""


class InputError(OcpTrajError, ValueError):
    """The caller gave something that cannot be used: the message names it, and what was expected."""


class TaskError(InputError):
    """A trajectory task contradicts itself; `key` is the dotted name of what is wrong, as in a case file."""

    def __init__(self, key: str, problem: str) -> None:
        self.key = key
        self.problem = problem
        super().__init__(f"{key}: {problem}")


class CaseError(InputError):
    """A case file is wrong.

    Attributes
    ----------
    file : str
        Name of the file as the caller gave it.
    key : str
        Dotted key in the file, for instance ``limits.velocity``; empty when the whole file is meant.
    """

    def __init__(self, file: str, key: str, problem: str) -> None:
        self.file = file
        self.key = key
        self.problem = problem
        super().__init__(f"{file}: {key}: {problem}" if key else f"{file}: {problem}")


class UnknownNameError(InputError):
    """A robot, solver, case or family that does not exist was asked for; the message lists what exists."""


class RobotError(InputError):
    """A robot description cannot be used (file missing, unsupported joint, frame not found)."""


class UnreachablePoseError(InputError):
    """No joint position within the limits reaches a pose, or the pose is singular; names the waypoint."""


class UnavailableError(OcpTrajError):
    """An optional part (a solver plug-in, a library, a compiler) is not there; the message says why."""
