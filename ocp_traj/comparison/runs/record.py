"""One finished run, as it crosses process borders and is stored."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from ocp_traj.files import finite


@dataclass(frozen=True)
class RunRecord:
    """What came out of one run; None where there is no such number.

    Parameters
    ----------
    status, message
        How the run ended (a word of `metaheuristics.Status`), and the solver's own sentence or the reason of the
        failure.
    reason
        Empty for a run that came to its end; else ``time limit``, ``memory limit``, ``crash`` or ``error``.
    claimed
        Whether the solver says that its answer keeps every constraint.
    feasible
        Whether the audit says so.
    objective, duration, energy
        Of the audited trajectory.
    worst
        Largest ratio found by the audit: limit, joint (from 1), time, ratio.
    waypoint_error, smallest_feasible_scale
        From the audit.
    findings
        The audit's sentences.
    dimension
        Number of decision variables.
    evaluations, build_time, solve_time, wall_time, peak_memory
        Cost of the run: points, s, s, s (everything included), bytes above the idle worker.
    details
        What a runner of its own reports beside, any JSON values.
    history
        Lists ``evaluations``, ``cost``, ``violation``, ``seconds``, equally long.
    trajectory
        The exact curve, as `ocp_traj.trajectory_files.to_json` returns it.
    """

    status: str
    message: str = ""
    reason: str = ""
    claimed: bool = False
    feasible: bool = False
    objective: float | None = None
    duration: float | None = None
    energy: float | None = None
    worst: dict[str, Any] | None = None
    waypoint_error: float | None = None
    smallest_feasible_scale: float | None = None
    findings: tuple[str, ...] = ()
    dimension: int | None = None
    evaluations: int | None = None
    build_time: float | None = None
    solve_time: float | None = None
    wall_time: float | None = None
    peak_memory: int | None = None
    history: dict[str, list[float | None]] = field(default_factory=dict)
    trajectory: dict[str, Any] | None = None
    details: dict[str, Any] = field(default_factory=dict)

    @property
    def return_code_correct(self) -> bool:
        """Whether the solver's own claim agrees with the audit."""
        return self.claimed == self.feasible

    def to_json(self) -> dict[str, Any]:
        """Return plain JSON values, every number finite or None."""
        return finite(asdict(self))

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> RunRecord:
        """Rebuild a record; unknown keys of a newer worker are refused by name."""
        known = {entry.name for entry in fields(cls)}
        unknown = sorted(set(values) - known)
        if unknown:
            raise ValueError(f"record has unknown field {unknown[0]!r}")
        return cls(**{**values, "findings": tuple(values.get("findings", ()))})
