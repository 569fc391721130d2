"""One trajectory problem: waypoints, limits, a curve family, boundary conditions and an objective."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ocp_traj.arrays import Array, ArrayLike, read_only
from ocp_traj.exceptions import TaskError, did_you_mean
from ocp_traj.quantities import COSTS, JOINT_LIMITS
from ocp_traj.spline import FamilyField, KnotsField
from ocp_traj.task.boundary import Boundary
from ocp_traj.task.checks import check_family, check_waypoints, numbers
from ocp_traj.task.custom import CustomConstraint
from ocp_traj.task.limits import Limits
from ocp_traj.task.objective import Objective
from ocp_traj.task.search import Search

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot


@dataclass(frozen=True)
class TrajectoryTask:
    """One trajectory problem.

    Parameters
    ----------
    waypoints : (K, n) array
        Joint positions to pass, rad (m for prismatic joints), K >= 2.
    limits : Limits
        What is not given comes from the robot.
    robot : Robot, optional
        Without it the problem is purely kinematic.
    family : Family or str
        ``"cubic"``, ``"quintic"``, ``"septic"``, ``"3-5-3"``, or a `Family` of one's own; the task holds the family.
    virtual_knots : int, optional
        Free knots added inside every gap between waypoints; default 3 for cubic, 0 for the other families.
    boundary : Boundary
    objective : Objective
    search : Search
    tolerance : number, (n,) or (K, n)
        Half-width of the box around each waypoint that may be passed instead of the point itself.
    constraints : tuple of CustomConstraint
        A user's own limits.
    name, title, source : str
        For people and files.

    Raises
    ------
    TaskError
        Something contradicts itself; names the key, what was given and what was expected.
    """

    waypoints: Array
    limits: Limits = field(default_factory=Limits)
    robot: Robot | None = None
    family: FamilyField = FamilyField("cubic")  # noqa: RUF009 (a descriptor)
    virtual_knots: KnotsField = KnotsField()  # noqa: RUF009 (a descriptor)
    boundary: Boundary = field(default_factory=Boundary)
    objective: Objective = field(default_factory=Objective)
    search: Search = field(default_factory=Search)
    tolerance: ArrayLike = 0.0
    constraints: tuple[CustomConstraint, ...] = ()
    name: str = "task"
    title: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        waypoints = check_waypoints(self.waypoints)
        n = waypoints.shape[1]
        gaps = len(waypoints) - 1
        if self.robot is not None and self.robot.n != n:
            raise TaskError("waypoints", self.robot.row_problem(n))
        check_family(self.family, self.virtual_knots, len(waypoints))
        tolerance = numbers("waypoints.tolerance", self.tolerance)
        if tolerance.shape not in ((), (n,), waypoints.shape) or not (tolerance >= 0).all():
            raise TaskError(
                "waypoints.tolerance", f"expected one, {n} or {waypoints.shape} numbers of 0 or more"
            )
        object.__setattr__(self, "limits", self.limits.expanded(gaps, n, self.robot))
        values = {
            "waypoints": waypoints,
            "boundary": self.boundary.expanded(self._default_end_orders(gaps), n),
            "objective": self.objective.expanded(gaps),
            "search": self.search.expanded(),
            "tolerance": read_only(np.broadcast_to(tolerance, waypoints.shape)),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        self._check_robot()
        self._check_positions()
        self._check_freedom()

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.waypoints.shape[1])

    @property
    def gaps(self) -> int:
        """Number of gaps between waypoints, K - 1."""
        return len(self.waypoints) - 1

    @property
    def has_inertia(self) -> bool:
        """True when torques and energies can be computed."""
        return self.robot is not None and self.robot.has_inertia

    def limited(self, name: str) -> bool:
        """Return whether any joint has a finite limit of this name (a row of `JOINT_LIMITS`)."""
        limit = self.limits.get(name)
        return limit is not None and bool(np.isfinite(limit).any())

    @property
    def needs_torque(self) -> bool:
        """True when a limit or a cost needs inverse dynamics."""
        return bool(self._limits_of_torques or self.objective.needs_torque or self.constraints)

    @property
    def _limits_of_torques(self) -> list[str]:
        return [name for name, row in JOINT_LIMITS.items() if row.needs_inertia and self.limited(name)]

    def changed(self, **changes: Any) -> TrajectoryTask:
        """Return a copy with other fields, checked again; for instance ``task.changed(virtual_knots=3)``.

        What has its default value and is not named takes the default of what is changed: virtual knots those of
        another family, end accelerations and jerks those of another family, jerk limit or number of knots.
        """
        known = {entry.name for entry in fields(self)}
        unknown = set(changes) - known
        if unknown:
            raise TaskError(
                min(unknown),
                f"is no field of a task, expected one of {', '.join(sorted(known))}{did_you_mean(min(unknown), known)}",
            )
        if "boundary" not in changes and self._has_default_boundary():
            changes["boundary"] = Boundary(self.boundary.velocity)
        if "family" in changes and self.virtual_knots == self.family.default_virtual_knots:
            changes.setdefault("virtual_knots", None)
        return replace(self, **changes)

    def _default_end_orders(self, gaps: int) -> tuple[int, ...]:
        return self.family.default_end_orders(gaps, self.virtual_knots, self.limited("jerk"))

    def _has_default_boundary(self) -> bool:
        """Return whether end accelerations and jerks are those by default, so that a change brings its own."""
        own = Boundary(self.boundary.velocity).expanded(self._default_end_orders(self.gaps), self.n)
        pairs = ((own.acceleration, self.boundary.acceleration), (own.jerk, self.boundary.jerk))
        return all(
            mine is given is None or (mine is not None and given is not None and np.array_equal(mine, given))
            for mine, given in pairs
        )

    def _check_robot(self) -> None:
        if self.has_inertia:
            return
        needing = [f"limits.{name}" for name in self._limits_of_torques]
        needing += [f"objective.{name}" for name in self.objective.weights if COSTS[name].needs_inertia]
        if needing:
            raise TaskError(needing[0], "needs a robot with inertia, but this task has none")

    def _check_positions(self) -> None:
        position = self.limits.get("position")
        for index, waypoint in enumerate(self.waypoints):
            for gap in {max(index - 1, 0), min(index, self.gaps - 1)}:
                lower, upper = position[gap]
                slack = np.asarray(self.tolerance)[index]
                outside = (waypoint + slack < lower) | (waypoint - slack > upper)
                if outside.any():
                    joint = int(np.argmax(outside))
                    raise TaskError(
                        f"waypoints.joints[{index + 1}]",
                        f"joint {joint + 1} is at {waypoint[joint]:.6g}, outside its range "
                        f"[{lower[joint]:.6g}, {upper[joint]:.6g}]",
                    )

    def _check_freedom(self) -> None:
        """Refuse a spline with fewer free coefficients than conditions (docs/case-file.md)."""
        given = {"acceleration": self.boundary.acceleration is not None, "jerk": self.boundary.jerk is not None}
        if not self.family.takes_end_conditions:
            own = {name: order in self.family.end_orders for order, name in enumerate(given, start=2)}
            if given != own:
                rule = " and ".join(f"{'given' if own[name] else 'free'} end {name}s" for name in own)
                raise TaskError("boundary", f"{self.family} has {rule}")
            return
        free = self.family.free_coefficients(self.gaps * (self.virtual_knots + 1))
        conditions = self.gaps + 1 + 2 * (1 + sum(given.values()))
        if free < conditions:
            raise TaskError(
                "spline.virtual_knots",
                f"{self.virtual_knots} leaves fewer free coefficients than conditions, {free} against {conditions} per "
                "joint; expected more virtual knots or fewer boundary conditions",
            )
