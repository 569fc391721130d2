"""What a solver is: an immutable value whose fields are its settings, asked for one task at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from metaheuristics import Solution
    from ocp_traj.task import TrajectoryTask
    from ocp_traj.trajectory import Trajectory

ProgressCallback = Callable[[Any], object]


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
