"""What the judge says about a motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from ocp_traj.audit.tolerances import CLEARANCE_TOLERANCE, RATIO_TOLERANCE
from ocp_traj.quantities import limited_quantity

CLEARANCE_SCALE = 0.01
"""How much nearer than its margin, m, counts as one more time the limit."""


@dataclass(frozen=True)
class Extremum:
    """Where a limit is used most.

    Attributes
    ----------
    limit : str
        ``position``, ``velocity``, ``acceleration``, ``jerk``, ``torque``, ``torque_rate``,
        ``cartesian_speed`` or ``constraint``.
    joint : int
        From 0; -1 for frames and a user's own constraints.
    time : float
        s.
    ratio : float
        Value over the limit on its own side; for positions and constraints 1 + excess / width. Above 1 is
        broken.
    gap : int
        Gap between waypoints, from 0.
    value, bound : float
        What the motion has there and what the limit on that side is, SI.
    label : str
        Name of the frame or constraint, else empty.
    note : str
        What makes the value infinite, else empty.
    """

    limit: str
    joint: int
    time: float
    ratio: float
    gap: int = 0
    value: float = math.nan
    bound: float = math.nan
    label: str = ""
    note: str = ""

    @property
    def key(self) -> str:
        """Name in `Verdict.limits`: the limit, and for frames and constraints their name after a colon."""
        return f"{self.limit}:{self.label}" if self.label else self.limit

    @property
    def broken(self) -> bool:
        """True above 1 + 1e-6 (clearance: nearer than its margin by 1e-6 m), or when the ratio is no number."""
        of_clearance = CLEARANCE_TOLERANCE / CLEARANCE_SCALE * (1.0 + 1e-6)
        return not self.ratio <= 1.0 + (of_clearance if self.limit == "clearance" else RATIO_TOLERANCE)

    def to_json(self) -> dict[str, Any]:
        """Return the object of docs/cli.md: joint from 1 (null without one), ratio null where it is infinite."""
        entry: dict[str, Any] = {
            "limit": self.limit,
            "joint": self.joint + 1 if self.joint >= 0 else None,
            "gap": self.gap + 1,
            "time": _finite(self.time),
            "ratio": _finite(self.ratio),
            "value": _finite(self.value),
            "bound": _finite(self.bound),
        }
        if self.label:
            entry["label"] = self.label
        return entry

    def __str__(self) -> str:
        where = f"joint {self.joint + 1}, " if self.joint >= 0 else ""
        name = f"{self.limit.replace('_', ' ')} {self.label}".rstrip()
        unit = "m" if self.limit == "clearance" else getattr(limited_quantity(self.limit), "units", "")
        plain = ("position", "constraint", "clearance")
        times = f", {self.ratio:.7g} times the limit" if self.limit not in plain else ""
        return (
            f"{name}: {where}gap {self.gap + 1}, at {self.time:.6g} s: {self.value:.9g} "
            f"against {self.bound:.9g} {unit}".rstrip()
            + (f", {self.note}" if self.note else times)
        )


@dataclass(frozen=True)
class Clearance:
    """How near a motion comes to what it must not touch.

    Attributes
    ----------
    distance : float or None
        The smallest that was measured, of the pair nearest to its margin, m; negative inside. None where no pair is
        judged.
    pair : two str, or None
        Their names.
    time : float or None
        s.
    proved : bool
        Every pair keeps its margin at every instant, proved.
    bound : float or None
        Distance that is proved of every pair at every instant, m; None where a margin is not kept.
    left_out : tuple of str
        Pairs that keep no margin, and why.
    distances : int
        Calls of the distance of two bodies.
    """

    distance: float | None
    pair: tuple[str, str] | None
    time: float | None
    proved: bool
    bound: float | None = None
    left_out: tuple[str, ...] = ()
    distances: int = 0

    def to_json(self) -> dict[str, Any]:
        """Return what results say of collision; numbers are finite or null."""
        return {
            "clearance": None if self.distance is None else _finite(self.distance),
            "pair": None if self.pair is None else list(self.pair),
            "time": None if self.time is None else _finite(self.time),
            "proved": self.proved,
            "bound": None if self.bound is None else _finite(self.bound),
            "left_out": list(self.left_out),
        }

    def __str__(self) -> str:
        if self.distance is None or self.pair is None or self.time is None:
            return "no pair of bodies is judged"
        kind = "proved at every instant" if self.proved else "NOT kept"
        return f"{1e3 * self.distance:.4g} mm, {' and '.join(self.pair)} at {self.time:.6g} s, {kind}"


@dataclass(frozen=True)
class Verdict:
    """The judge's answer about one motion.

    Attributes
    ----------
    feasible : bool
        Every ratio is at most 1 + 1e-6 at every time, waypoints and boundary conditions are met within 1e-8,
        and the durations lie within their bounds.
    duration : float
        s.
    worst : Extremum or None
        The largest ratio found; None when nothing is limited.
    limits : dict
        The largest ratio of every limit, by name (see `Extremum.key`).
    peaks : tuple of Extremum
        The largest ratio of every limit and joint, and every jump.
    waypoint_error : float
        Largest distance of a joint from a waypoint's box, rad or m.
    boundary_error : float
        Largest miss of a boundary condition, as a part of its limit (of the motion's largest value without
        one).
    smallest_feasible_scale : float or None
        Smallest uniform slowing that makes the motion feasible (below 1 where there is slack); None if none
        does.
    findings : tuple of str
        One sentence for each broken thing; joints, gaps and waypoints count from 1.
    torque_bound : float
        Bound on the error of the torques, as a part of the limits: what may hide between samples.
    case : str
        Name of the task.
    clearance : Clearance or None
        None for a task without a scene.
    notes : tuple of str
        What the verdict does not cover or had to assume; no note makes a motion infeasible.
    """

    feasible: bool
    duration: float
    worst: Extremum | None
    limits: dict[str, Extremum] = field(default_factory=dict)
    peaks: tuple[Extremum, ...] = ()
    waypoint_error: float = 0.0
    boundary_error: float = 0.0
    smallest_feasible_scale: float | None = None
    findings: tuple[str, ...] = ()
    torque_bound: float = 0.0
    case: str = ""
    clearance: Clearance | None = None
    notes: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return what ``ocp-traj audit --json`` writes; numbers are finite or null, joints count from 1."""
        scale = self.smallest_feasible_scale
        return {
            "schema": 1,
            "case": self.case,
            "feasible": self.feasible,
            "duration": _finite(self.duration),
            "worst": None if self.worst is None else self.worst.to_json(),
            "limits": {name: extremum.to_json() for name, extremum in self.limits.items()},
            "waypoint_error": _finite(self.waypoint_error),
            "boundary_error": _finite(self.boundary_error),
            "torque_bound": _finite(self.torque_bound),
            "smallest_feasible_scale": None if scale is None else _finite(scale),
            "collision": None if self.clearance is None else self.clearance.to_json(),
            "findings": list(self.findings),
            "notes": list(self.notes),
        }

    def __str__(self) -> str:
        lines = [f"{'feasible' if self.feasible else 'NOT feasible'}, {self.duration:.6g} s"]
        for name, extremum in self.limits.items():
            where = f"joint {extremum.joint + 1}, " if extremum.joint >= 0 else ""
            lines.append(
                f"  {name:<14} {extremum.ratio:.7f}  {where}gap {extremum.gap + 1}, {extremum.time:.6g} s"
            )
        lines.append(
            f"  waypoints met within {self.waypoint_error:.2g}, boundary within {self.boundary_error:.2g}"
        )
        if self.clearance is not None:
            lines.append(f"  clearance {self.clearance}; {len(self.clearance.left_out)} pairs left out")
        if self.smallest_feasible_scale is None:
            lines.append("  no uniform slowing makes it feasible")
        else:
            lines.append(f"  smallest feasible uniform slowing: {self.smallest_feasible_scale:.9g}")
        lines.extend(f"  - {finding}" for finding in self.findings)
        lines.extend(f"  note: {note}" for note in self.notes)
        return "\n".join(lines)


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
