"""The settings of a gradient solver: those a user chooses, and the numbers its recipe is tuned by."""

from __future__ import annotations

from dataclasses import dataclass

from metaheuristics.settings import check_settings
from ocp_traj.solvers.gradient.refinement import PEAK_SEARCH, PeakSearch


@dataclass(frozen=True)
class Tuning:
    """Numbers of the recipe; each can be given by name, as a setting of the solver.

    Parameters
    ----------
    loose_tolerance : float
        Tolerance of the stages with few knots and of rough rounds: they only have to give a start.
    rough_rounds : int
        Rounds of added points that are solved loosely only: the next one moves the motion anyway.
    few_knots_iterations : int
        Iterations at most of a stage with few knots.
    acceptable_violation : float
        Violation up to which an answer IPOPT stops near counts as one.
    condensed_samples : int
        Samples per gap of the condensed form at first.
    most_samples : int
        Samples per gap from which on they are not doubled any more.
    unscaled_gaps : int
        From more gaps than this on the cost is scaled with their number, as a barrier's weight grows with it.
    duration_range : float
        Durations may be this much shorter or longer than in the guess: the search box binds population methods only.
    conflict_excess : float
        Fraction of a limit by which it must be broken to be in conflict; less is a solver's rounding.
    confirming_starts : int
        Extra starts that must fail before a conflict is reported.
    confirming_iterations : int
        Iterations at most of each of them.
    elastic_phases : int
        Elastic phases at most, each with the points added since the one before.
    elastic_iterations : int
        Iterations at most of an elastic phase.
    elastic_tolerance : float
        IPOPT's tolerance in an elastic phase.
    elastic_consistency : float
        Excess up to which the rows of an elastic phase must hold for its slacks to mean anything.
    elastic_time_weight : float
        Cost of the duration, in units of the guess's, beside the slacks: without it a slow motion may run away.
    elastic_slowing : float
        Where an elastic phase finds no durations, they are held at those of the first point, slowed by this.
    smallest_slack : float
        Slacks below this, as fractions of the limit, are rounding.
    long_path : int
        Gaps above which the last digits take most of the iterations and bring nothing.
    long_path_tolerance : float
        Tolerance of the plug-in there.
    freeing_iterations : int
        Iterations at most of the solve that frees held knots.
    further_starts : int
        Starts at most beside the first one of a task that is known to have bad optima; each costs about as much.
    """

    loose_tolerance: float = 1e-3
    rough_rounds: int = 3
    few_knots_iterations: int = 100
    acceptable_violation: float = 1e-8
    condensed_samples: int = 16
    most_samples: int = 100
    unscaled_gaps: int = 5
    duration_range: float = 1e3
    conflict_excess: float = 1e-5
    confirming_starts: int = 2
    confirming_iterations: int = 150
    elastic_phases: int = 3
    elastic_iterations: int = 200
    elastic_tolerance: float = 1e-7
    elastic_consistency: float = 1e-6
    elastic_time_weight: float = 1e-4
    elastic_slowing: float = 4.0
    smallest_slack: float = 1e-9
    long_path: int = 10
    long_path_tolerance: float = 1e-6
    freeing_iterations: int = 200
    further_starts: int = 2

    def __post_init__(self) -> None:
        check_settings("a gradient solver", Tuning, self.__dict__)


@dataclass(frozen=True)
class GradientSettings:
    """What one start of a gradient solver is made with.

    Parameters
    ----------
    plugin : str
        Name of the nlpsol plug-in, for instance ``ipopt``.
    tolerance : float
        Convergence tolerance of the plug-in.
    iterations : int
        Iterations at most per call.
    rounds : int
        How often points with broken limits are added and the problem is solved again, warm.
    samples : int
        Samples per gap of torques and other limited functions of an instant at first.
    attempts : int
        Starts tried at most until one leads to a solution.
    compiled : bool
        Use machine code for functions of an instant where there is a C compiler; it is kept on disk.
    tuning : Tuning
        Numbers of the recipe.
    peaks : PeakSearch
        How broken limits are looked for between the points a problem knows.
    """

    plugin: str = "ipopt"
    tolerance: float = 1e-8
    iterations: int = 500
    rounds: int = 8
    samples: int = 4
    attempts: int = 5
    compiled: bool = True
    tuning: Tuning = Tuning()
    peaks: PeakSearch = PEAK_SEARCH
