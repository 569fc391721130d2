"""What a reference is: durations of one task, each with the kind of knowledge it is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Any

import numpy as np

from ocp_traj.exceptions import UnavailableError
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory

PROVED, ESTIMATED, TIMED, FOUND = "proved bound", "estimate", "fixed path", "solver's result"
"""What is known of a duration: nothing is shorter; a local optimum; the best along one path; it can be driven."""


@dataclass(frozen=True)
class ReferenceRequest:
    """What references are asked for.

    Attributes
    ----------
    task : TrajectoryTask
        The problem.
    trajectory : Trajectory or None
        A motion through the same waypoints, whose path is timed too.
    time_limit : float
        Seconds that the reference may take.
    rng : numpy.random.Generator or None
        For the starting points of local searches.
    brief : bool
        Leave out what a comparison does not show.
    """

    task: TrajectoryTask
    trajectory: Trajectory | None = None
    time_limit: float = 20.0
    rng: np.random.Generator | None = None
    brief: bool = False

    @property
    def paths(self) -> tuple[str | Trajectory, ...]:
        """The fixed paths to be timed."""
        return ("uniform", "chord") if self.trajectory is None else ("uniform", "chord", self.trajectory)

    @property
    def path_names(self) -> tuple[str, ...]:
        """The names of `paths`."""
        return ("uniform", "chord") if self.trajectory is None else ("uniform", "chord", "spline")


@dataclass(frozen=True)
class ReferenceFinding:
    """What one reference found.

    Attributes
    ----------
    seconds : mapping
        Durations by part, s, None where there is none; empty where the reference does not apply.
    messages : mapping
        What was proved, or why there is none, by part; the empty part stands for all.
    results : tuple
        The whole answers, for pictures.
    """

    seconds: Mapping[str, float | None]
    messages: Mapping[str, str] = field(default_factory=dict)
    results: tuple[Any, ...] = ()


def missing_packages(names: Iterable[str]) -> list[str]:
    """Return those of the packages that are not installed."""

    def is_there(name: str) -> bool:
        try:
            return find_spec(name) is not None
        except ImportError:
            return False

    return [name for name in names if not is_there(name)]


@dataclass(frozen=True)
class Reference:
    """One way to know how long a task's motions take.

    Attributes
    ----------
    name : str
        In files and commands.
    title : str
        In tables and pictures.
    find : callable
        From a `ReferenceRequest` to a `ReferenceFinding`.
    parts : mapping
        Kind (`PROVED`, `ESTIMATED`, `TIMED` or `FOUND`) and words of the parts; any other is a fixed path's name.
    note : str
        A sentence for the reader of a table.
    option : str
        Keyword of `collect_references` that asks for it or leaves it out; always there when empty.
    wanted : bool
        Whether it is computed unless the keyword says something else.
    compared : bool
        Whether comparisons compute it, once per case.
    requires : tuple of str
        Packages without which there is none of its timings; everything else works without them.
    patient : bool
        Whether it uses all the time there is, so that it is computed after the others.
    """

    name: str
    title: str
    find: Callable[[ReferenceRequest], ReferenceFinding]
    parts: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    note: str = ""
    option: str = ""
    wanted: bool = True
    compared: bool = True
    requires: tuple[str, ...] = ()
    patient: bool = False

    def check_available(self) -> None:
        """Raise `UnavailableError` where a package that it needs is not installed."""
        missing = missing_packages(self.requires)
        if missing:
            raise UnavailableError(
                f"{self.title} needs {', '.join(missing)}, not installed here (pip install {' '.join(missing)})"
            )

    def kind_of(self, part: str) -> str:
        """Return what is known of a part's duration."""
        return self.parts[part][0] if part in self.parts else TIMED

    def describe(self, part: str) -> str:
        """Return a part's words for tables and pictures."""
        return self.parts[part][1] if part in self.parts else f"{self.title}, {part} path"

    def best(self, seconds: Mapping[str, float | None]) -> str | None:
        """Return the part a result is compared with: a proved one, else an estimate, else the shortest; or None."""
        known = {part: value for part, value in seconds.items() if value is not None}
        order = (PROVED, ESTIMATED, TIMED, FOUND)
        return min(known, key=lambda part: (order.index(self.kind_of(part)), known[part]), default=None)
