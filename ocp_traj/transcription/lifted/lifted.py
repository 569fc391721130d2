"""The lifted form: durations of all segments, and every knot's state, tied by the chain of integrators."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ocp_traj.arrays import Array
from ocp_traj.task import TrajectoryTask
from ocp_traj.trajectory import Trajectory
from ocp_traj.transcription.curve import build_trajectory
from ocp_traj.transcription.lifted.assembly import assemble
from ocp_traj.transcription.lifted.consistent import consistent_variables
from ocp_traj.transcription.lifted.instant_rows import add_instants
from ocp_traj.transcription.lifted.kinematic_rows import DerivativePoints, add_kinematics
from ocp_traj.transcription.lifted.layout import Layout, make_layout
from ocp_traj.transcription.lifted.parts import Parts
from ocp_traj.transcription.lifted.state_bounds import state_bounds
from ocp_traj.transcription.nlp import Nlp


@dataclass(frozen=True)
class ExtraPoints:
    """Points between the first samples where limits were found broken; a solver adds them and solves again.

    Attributes
    ----------
    derivatives : tuple of (order, segment, joint, fraction)
    instants : tuple of (segment, fraction)
        For torque, torque rate, Cartesian speed and custom limits.
    """

    derivatives: DerivativePoints = ()
    instants: tuple[tuple[int, float], ...] = ()

    def joined(self, other: ExtraPoints) -> ExtraPoints:
        """Return the union."""
        return ExtraPoints(
            tuple(dict.fromkeys(self.derivatives + other.derivatives)),
            tuple(dict.fromkeys(self.instants + other.instants)),
        )

    def __bool__(self) -> bool:
        """Whether there is any point."""
        return bool(self.derivatives or self.instants)


class LiftedNlp(Nlp):
    """The lifted form of a task; see `ocp_traj.transcription.lifted.layout.Layout` for the variables.

    Parameters
    ----------
    task : TrajectoryTask
        Of a family that takes virtual knots.
    guess : Trajectory
        A motion of the task's family and number of knots: the first point, and the scale of the variables.
    samples : int
        Samples a gap of functions of an instant.
    extra : ExtraPoints
    layout : Layout, optional
        Variables and scales of an earlier problem of the same task, to be kept; by default chosen from the guess.
    compiled : bool
        Use machine code for functions of an instant where there is a C compiler; same results.
    held : bool
        Hold the durations of all segments at the guess's.
    """

    form = "lifted"
    encoding = "knot-states"

    def __init__(
        self,
        task: TrajectoryTask,
        guess: Trajectory,
        samples: int,
        extra: ExtraPoints,
        *,
        layout: Layout | None = None,
        compiled: bool = False,
        held: bool = False,
    ) -> None:
        self.layout = make_layout(task, guess) if layout is None else layout
        self.samples, self.extra = samples, extra
        parts = Parts(self.layout.size)
        add_kinematics(parts, self.layout, extra.derivatives)
        add_instants(parts, self.layout, guess, samples, extra.instants, compiled)
        lower, upper = state_bounds(self.layout)
        if held:
            still = slice(0, self.layout.segments)
            lower[still] = upper[still] = self.layout.encode(guess)[still]
        slacks = np.concatenate([*parts.slack_starts, np.empty(0)])
        lower = np.concatenate([lower, np.zeros(len(slacks))])
        upper = np.concatenate([upper, np.full(len(slacks), np.inf)])
        start = np.concatenate([self.layout.encode(guess), slacks])
        gradient = parts.linear_cost()
        gradient[: self.layout.segments] += task.objective.time * self.layout.duration_scale
        symbolic = assemble(parts.size, parts.places, parts.linear_matrix(), parts.costs, gradient)
        self.x, self.f, self.g = symbolic.x, symbolic.f, symbolic.g
        self.derivatives = symbolic.derivatives
        g_lower, g_upper = parts.bounds()
        super().__init__(
            task,
            lower=lower,
            upper=upper,
            guess=np.clip(start, lower, upper),
            g_lower=g_lower,
            g_upper=g_upper,
            rows=parts.labels(),
        )

    def motion(self, x: Array) -> Trajectory:
        """Return the spline through the knots of x, made consistent first; exact at waypoints and boundaries."""
        consistent = consistent_variables(self.layout, np.asarray(x)[: self.layout.size])
        durations = np.maximum(self.layout.durations(consistent), np.finfo(float).tiny)
        return build_trajectory(self.task, durations, self.layout.positions(consistent))
