"""What a solver is: an immutable value whose fields are its settings, asked for one task at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from metaheuristics.solution import Status
from ocp_traj.exceptions import UnknownNameError, did_you_mean

if TYPE_CHECKING:
    from metaheuristics import Solution
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

ProgressCallback = Callable[[Any], object]
SolverT = TypeVar("SolverT", bound="Solver")

DEFAULT_BUDGET = 20_000
"""Evaluations of x of a population method when the request names none."""

SMALLEST_BUDGET = 2
"""Evaluations below which a gradient solver is not started: its first point takes one."""


@dataclass(frozen=True)
class Request:
    """What is asked of a solver besides the task.

    Parameters
    ----------
    seed : int
        The only source of randomness.
    budget : int, optional
        Evaluations of x at most.
    time_limit : float, optional
        Seconds at most.
    progress : callable, optional
        Called now and then with an object that has ``evaluations``, ``cost`` and ``violation``; true stops.
    warm_start : Trajectory, optional
        A motion to start from, of any family, for instance another solver's answer.
    """

    seed: int = 0
    budget: int | None = None
    time_limit: float | None = None
    progress: ProgressCallback | None = None
    warm_start: Trajectory | None = None

    def less(self, evaluations: int, seconds: float) -> Request:
        """Return the request with what is left of budget and time; `exhausted` tells whether that is enough.

        Parameters
        ----------
        evaluations : int
            Spent so far.
        seconds : float
            Spent so far, s.
        """
        budget = None if self.budget is None else self.budget - evaluations
        return replace(
            self, budget=budget, time_limit=None if self.time_limit is None else self.time_limit - seconds
        )

    def exhausted(self, evaluations: int = 1) -> Status | None:
        """Return why not even that many evaluations may be spent, None when they may."""
        if self.time_limit is not None and self.time_limit <= 0:
            return Status.TIME_EXHAUSTED
        return Status.BUDGET_EXHAUSTED if self.budget is not None and self.budget < evaluations else None


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a solver gives back; the audit has not seen it yet.

    Attributes
    ----------
    trajectory : Trajectory or None
        None when the solver has no motion at all.
    solution : metaheuristics.Solution
    counts : dict
        How often each function was called; a gradient solver's function, gradient and Hessian calls apart.
    diagnosis : str
        Why there is no feasible answer: which limit, joint and gap, and by how much; empty otherwise.
    """

    trajectory: Trajectory | None
    solution: Solution
    counts: dict[str, int] = field(default_factory=dict)
    diagnosis: str = ""


class Solver(ABC):
    """A solver of trajectory tasks.

    Attributes
    ----------
    kind : str
        ``gradient``, ``population``, ``hybrid`` or ``third-party``.
    """

    kind: ClassVar[str]

    @abstractmethod
    def run(self, task: TrajectoryTask, request: Request) -> Outcome:
        """Solve one task.

        Raises
        ------
        InputError
            The task is nothing this solver can work on; says why.
        """

    def check_available(self) -> None:  # noqa: B027
        """Raise `UnavailableError` where the solver cannot be used here; by default it always can."""

    @classmethod
    def from_settings(cls: type[SolverT], settings: dict[str, Any]) -> SolverT:
        """Return the solver with these settings; by default they are the fields of a dataclass.

        A field whose default is a dataclass itself is nothing a name can carry.

        Raises
        ------
        UnknownNameError
            There is no such setting; lists what there is.
        """
        kind: Any = cls
        own = fields(kind) if is_dataclass(kind) else ()
        known = [entry.name for entry in own if not is_dataclass(entry.default)]
        unknown = set(settings) - set(known)
        if unknown:
            hint = did_you_mean(min(unknown), known)
            raise UnknownNameError(
                f"{cls.__name__} has no setting {min(unknown)!r}, expected one of {', '.join(known) or 'none'}{hint}"
            )
        return cls(**settings)
