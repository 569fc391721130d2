"""What a person asks for: waypoints, limits, a curve family, boundary conditions and an objective.

A task is readable and frozen and knows no decision variables; `ocp_traj.transcription` turns it into a
numerical problem. All values are SI; arrays are read-only copies.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ocp_traj.arrays import Array, ArrayLike, read_only
from ocp_traj.exceptions import TaskError
from ocp_traj.spline import Family, FamilyField

if TYPE_CHECKING:
    from ocp_traj.robot.robot import Robot

LIMIT_NAMES = ("position", "velocity", "acceleration", "jerk", "torque", "torque_rate")
"""Joint quantities that can be limited."""


@dataclass(frozen=True)
class Limits:
    """Lower and upper limits of joint quantities.

    Every entry is a number (symmetric, all joints), n numbers (symmetric), a (2, n) array [lower, upper], or a
    (G, 2, n) array, one block a gap between waypoints. ``None`` leaves it to the robot (position, velocity,
    torque) or unlimited; ``inf`` is explicitly unlimited. Inside a task every entry is (G, 2, n).

    Parameters
    ----------
    position : rad or m
    velocity : rad/s or m/s
    acceleration : rad/s^2 or m/s^2
    jerk : rad/s^3 or m/s^3
    torque : N m or N
    torque_rate : N m/s or N/s
    cartesian_speed : tuple of (frame, m/s)
        Bound on the norm of a named frame's linear velocity.
    """

    position: ArrayLike | None = None
    velocity: ArrayLike | None = None
    acceleration: ArrayLike | None = None
    jerk: ArrayLike | None = None
    torque: ArrayLike | None = None
    torque_rate: ArrayLike | None = None
    cartesian_speed: tuple[tuple[str, float], ...] = ()

    def get(self, name: str) -> Array:
        """Return the expanded (G, 2, n) array of one limit; for the limits of a task."""
        values: Array = getattr(self, name)
        return values

    def expanded(self, gaps: int, n: int, robot: Robot | None) -> Limits:
        """Return limits with every entry a (gaps, 2, n) array; `robot` fills what was left out.

        Raises
        ------
        TaskError
            A shape, a sign or the order of the bounds is wrong; names the limit.
        """
        defaults: dict[str, Array] = {}
        if robot is not None:
            defaults = {
                "position": robot.position_limits,
                "velocity": robot.velocity_limits,
                "torque": robot.torque_limits,
            }
        expanded: dict[str, Any] = {}
        for name in LIMIT_NAMES:
            given = getattr(self, name)
            value = defaults.get(name) if given is None else given
            expanded[name] = _expand_limit(name, np.inf if value is None else value, gaps, n)
        for frame, speed in self.cartesian_speed:
            if not speed > 0:
                raise TaskError(
                    "limits.cartesian_speed", f"{speed} for frame {frame!r}, expected a positive speed"
                )
        return replace(self, **expanded)


def _expand_limit(name: str, value: ArrayLike, gaps: int, n: int) -> Array:
    key = f"limits.{name}"
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TaskError(key, f"{value!r} is not a number, {n} numbers or two rows of {n} numbers") from None
    if np.isnan(array).any():
        raise TaskError(key, "contains nan, expected numbers or inf")
    if array.ndim == 0 or array.shape == (n,):
        if (array < 0).any():
            raise TaskError(key, f"{array[array < 0].flat[0]:g} is negative, expected a limit of 0 or more")
        upper = np.broadcast_to(array, (n,))
        array = np.stack([-upper, upper])
    if array.shape == (2, n):
        array = np.broadcast_to(array, (gaps, 2, n))
    if array.shape != (gaps, 2, n):
        raise TaskError(
            key,
            f"has shape {array.shape}, expected a number, {n} numbers or two rows (lower, upper) of {n} numbers",
        )
    if (array[:, 0] > array[:, 1]).any():
        joint = int(np.argwhere(array[:, 0] > array[:, 1])[0, 1])
        raise TaskError(key, f"the lower limit of joint {joint + 1} is above the upper one")
    if name != "position" and ((array[:, 0] > 0).any() or (array[:, 1] < 0).any()):
        raise TaskError(key, "the range of every joint must contain 0")
    return read_only(array)


@dataclass(frozen=True)
class Boundary:
    """Start and end of the motion: (2, n) rows [start, end]; ``None`` leaves a derivative free.

    ``"default"`` is the family's own: acceleration free for cubic and zero otherwise, jerk zero for septic and
    free otherwise (see `Family.end_orders`).

    Parameters
    ----------
    velocity : number, (n,) or (2, n) array, rad/s (m/s)
    acceleration : the same, ``None`` or ``"default"``, rad/s^2 (m/s^2)
    jerk : the same, ``None`` or ``"default"``, rad/s^3 (m/s^3)
    """

    velocity: ArrayLike = 0.0
    acceleration: ArrayLike | None | Literal["default"] = "default"
    jerk: ArrayLike | None | Literal["default"] = "default"

    def expanded(self, family: Family, n: int) -> Boundary:
        """Return boundary conditions with (2, n) arrays, or None where free."""
        values: dict[str, Any] = {}
        for order, name in enumerate(("velocity", "acceleration", "jerk"), start=1):
            given = getattr(self, name)
            default = 0.0 if order in family.end_orders else None
            value = default if isinstance(given, str) else given
            if value is None:
                values[name] = None
                continue
            array = _numbers(f"boundary.{name}", value)
            if array.ndim == 0:
                array = np.full((2, n), array)
            if array.shape != (2, n) or not np.isfinite(array).all():
                raise TaskError(f"boundary.{name}", f"expected two rows (start, end) of {n} finite numbers")
            values[name] = read_only(array)
        if values["velocity"] is None:
            raise TaskError("boundary.velocity", "must be given, it cannot be free")
        return Boundary(**values)

    @property
    def is_rest(self) -> bool:
        """True when the motion starts and ends at rest (zero velocity; given accelerations and jerks zero)."""
        given = [value for value in (self.velocity, self.acceleration, self.jerk) if value is not None]
        return all(not np.any(value) for value in given)


@dataclass(frozen=True)
class CustomObjective:
    """A user's own cost: the integral of a CasADi function of (q, v, a, tau), each (n,), to one number.

    Parameters
    ----------
    name : str
        In reports.
    function : casadi.Function
        (q, v, a, tau), each (n,), in SI units, to one number, whose integral over time is the cost.
    weight : float
    """

    name: str
    function: Any
    weight: float = 1.0


@dataclass(frozen=True)
class CustomConstraint:
    """A user's own limit: a CasADi function of (q, v, a, tau), each (n,), to k numbers within [lower, upper].

    Parameters
    ----------
    name : str
        In reports.
    function : casadi.Function
        (q, v, a, tau), each (n,), in SI units, to k numbers.
    lower, upper : number or (k,)
    scale : float, optional
        What a violation is divided by; the larger finite bound, or 1.
    """

    name: str
    function: Any
    lower: ArrayLike = -np.inf
    upper: ArrayLike = np.inf
    scale: float | None = None


@dataclass(frozen=True)
class Motor:
    """DC motors behind the joints, for the copper-loss objective.

    The current of joint i is tau_i / (gear_ratio_i torque_constant_i); the loss is resistance_i current_i^2.

    Parameters
    ----------
    torque_constant : (n,) N m/A
    resistance : (n,) ohm
    gear_ratio : (n,)
    """

    torque_constant: ArrayLike
    resistance: ArrayLike
    gear_ratio: ArrayLike = 1.0


@dataclass(frozen=True)
class Objective:
    """Weights (>= 0) of the cost terms, and bounds on durations.

    Parameters
    ----------
    time : per second of total duration
    energy : per joule of integral sum |tau qdot| dt
    energy_without_regeneration : per joule of integral sum max(tau qdot, 0) dt
    torque : per integral of sum (tau / torque limit)^2 dt
    acceleration, jerk : per integral of the sum of squares
    motor_loss : per joule of copper loss, see `Motor`
    duration : (2,) bounds of the total duration, s; equal bounds fix it
    gap_durations : (G, 2) bounds of the duration of each gap, s
    motor : Motor, optional
        Needed by `motor_loss`.
    custom : tuple of CustomObjective
    """

    time: float = 0.0
    energy: float = 0.0
    energy_without_regeneration: float = 0.0
    torque: float = 0.0
    acceleration: float = 0.0
    jerk: float = 0.0
    motor_loss: float = 0.0
    duration: ArrayLike = (0.0, np.inf)
    gap_durations: ArrayLike | None = None
    motor: Motor | None = None
    custom: tuple[CustomObjective, ...] = ()

    WEIGHTS = (
        "time",
        "energy",
        "energy_without_regeneration",
        "torque",
        "acceleration",
        "jerk",
        "motor_loss",
    )

    @property
    def weights(self) -> dict[str, float]:
        """Weights that are not zero, by name."""
        return {name: getattr(self, name) for name in self.WEIGHTS if getattr(self, name) > 0}

    @property
    def needs_torque(self) -> bool:
        """True when a term with torques has weight."""
        return bool(set(self.weights) - {"time", "acceleration", "jerk"}) or bool(self.custom)

    def expanded(self, gaps: int) -> Objective:
        """Return the objective with checked weights and array bounds; time gets weight 1 when nothing has any."""
        for name in self.WEIGHTS:
            weight = getattr(self, name)
            if not (np.isfinite(_numbers(f"objective.{name}", weight)) and weight >= 0):
                raise TaskError(
                    f"objective.{name}", f"{weight} is not a weight, expected a number of 0 or more"
                )
        duration = _expand_interval("objective.bounds.duration", self.duration, (2,))
        gap = np.tile([0.0, np.inf], (gaps, 1)) if self.gap_durations is None else self.gap_durations
        gap_durations = _expand_interval("objective.bounds.gap_durations", gap, (gaps, 2))
        if self.motor_loss > 0 and self.motor is None:
            raise TaskError("objective.motor_loss", "needs the motors' parameters in robot.motor")
        time = self.time if self.weights or self.custom else 1.0
        return replace(self, time=time, duration=duration, gap_durations=gap_durations)


def _numbers(key: str, value: ArrayLike) -> Array:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TaskError(key, f"{value!r} given, expected numbers") from None


def _expand_interval(key: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = _numbers(key, value)
    if array.shape != shape or np.isnan(array).any():
        raise TaskError(key, f"has shape {array.shape}, expected {shape}: lower and upper seconds")
    if (array[..., 0] < 0).any() or (array[..., 0] > array[..., 1]).any() or (array[..., 1] <= 0).any():
        raise TaskError(key, "expected 0 <= lower <= upper with upper above 0")
    return read_only(array)


@dataclass(frozen=True)
class Search:
    """What population methods need besides the task.

    Parameters
    ----------
    duration : (2,) bounds of the duration of one gap, s
    protocol : ``"shared"`` durations for all joints, or ``"per-joint"`` (papers B and D)
    """

    duration: ArrayLike = (0.05, 10.0)
    protocol: str = "shared"

    def expanded(self) -> Search:
        """Return the settings with checked values."""
        duration = _expand_interval("search.duration", self.duration, (2,))
        if not (duration[0] > 0 and np.isfinite(duration[1])):
            raise TaskError("search.duration", "expected two finite positive numbers")
        if self.protocol not in ("shared", "per-joint"):
            raise TaskError(
                "search.protocol", f"{self.protocol!r} is unknown, expected 'shared' or 'per-joint'"
            )
        return replace(self, duration=duration)


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
    virtual_knots : int
        Free knots added inside every gap between waypoints.
    boundary, objective, search
        See their classes.
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
    virtual_knots: int = 0
    boundary: Boundary = field(default_factory=Boundary)
    objective: Objective = field(default_factory=Objective)
    search: Search = field(default_factory=Search)
    tolerance: ArrayLike = 0.0
    constraints: tuple[CustomConstraint, ...] = ()
    name: str = "task"
    title: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        waypoints = _check_waypoints(self.waypoints)
        n = waypoints.shape[1]
        gaps = len(waypoints) - 1
        if self.robot is not None and self.robot.n != n:
            raise TaskError(
                "waypoints",
                f"rows have {n} numbers, expected {self.robot.n}, the joints of {self.robot.name}",
            )
        _check_family(self.family, self.virtual_knots, len(waypoints))
        tolerance = _numbers("waypoints.tolerance", self.tolerance)
        if tolerance.shape not in ((), (n,), waypoints.shape) or not (tolerance >= 0).all():
            raise TaskError(
                "waypoints.tolerance", f"expected one, {n} or {waypoints.shape} numbers of 0 or more"
            )
        values = {
            "waypoints": waypoints,
            "limits": self.limits.expanded(gaps, n, self.robot),
            "boundary": self.boundary.expanded(self.family, n),
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
        """Return whether any joint has a finite limit of this name (see `LIMIT_NAMES`)."""
        return bool(np.isfinite(self.limits.get(name)).any())

    @property
    def needs_torque(self) -> bool:
        """True when a torque limit, a torque-rate limit or a cost term needs inverse dynamics."""
        return (
            self.limited("torque")
            or self.limited("torque_rate")
            or self.objective.needs_torque
            or bool(self.constraints)
        )

    def changed(self, **changes: Any) -> TrajectoryTask:
        """Return a copy with other fields, checked again; for instance ``task.changed(virtual_knots=3)``."""
        known = {entry.name for entry in fields(self)}
        unknown = set(changes) - known
        if unknown:
            raise TaskError(
                min(unknown), f"is no field of a task, expected one of {', '.join(sorted(known))}"
            )
        if "family" in changes and "boundary" not in changes and self._has_default_boundary():
            changes["boundary"] = Boundary(self.boundary.velocity)
        return replace(self, **changes)

    def _has_default_boundary(self) -> bool:
        """Return whether end accelerations and jerks are the family's own, so that another family brings its own."""
        own = Boundary(self.boundary.velocity).expanded(self.family, self.n)
        pairs = ((own.acceleration, self.boundary.acceleration), (own.jerk, self.boundary.jerk))
        return all(
            mine is given is None or (mine is not None and given is not None and np.array_equal(mine, given))
            for mine, given in pairs
        )

    def _check_robot(self) -> None:
        if self.has_inertia:
            return
        limited = [name for name in ("torque", "torque_rate") if self.limited(name)]
        if limited:
            raise TaskError(f"limits.{limited[0]}", "needs a robot with inertia, but this task has none")
        needing = [name for name in self.objective.weights if name not in ("time", "acceleration", "jerk")]
        if needing:
            raise TaskError(f"objective.{needing[0]}", "needs a robot with inertia, but this task has none")

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
        """Refuse a spline with fewer free coefficients than conditions (contract, section 1)."""
        given = {
            "acceleration": self.boundary.acceleration is not None,
            "jerk": self.boundary.jerk is not None,
        }
        if not self.family.takes_end_conditions:
            own = {name: order in self.family.end_orders for order, name in enumerate(given, start=2)}
            if given != own:
                rule = " and ".join(f"{'given' if own[name] else 'free'} end {name}s" for name in own)
                raise TaskError("boundary", f"{self.family} has {rule}")
            return
        free = self.family.free_coefficients(self.gaps * (self.virtual_knots + 1))
        above_jerk = sum(order > 3 for order in self.family.end_orders)
        conditions = self.gaps + 1 + 2 * (1 + sum(given.values()) + above_jerk)
        if free < conditions:
            raise TaskError(
                "spline.virtual_knots",
                f"{self.virtual_knots} leaves {free} free coefficients a joint for {conditions} conditions; "
                "expected more virtual knots or fewer boundary conditions",
            )


def _check_waypoints(waypoints: ArrayLike) -> Array:
    try:
        array = np.asarray(waypoints, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise TaskError("waypoints", "rows differ in length or hold something else than numbers") from None
    if array.ndim != 2 or array.shape[1] < 1:
        raise TaskError("waypoints", f"have shape {array.shape}, expected (K, n): one row a waypoint")
    if len(array) < 2:
        raise TaskError("waypoints", f"{len(array)} given, expected at least 2")
    if not np.isfinite(array).all():
        row, joint = np.argwhere(~np.isfinite(array))[0]
        raise TaskError(
            "waypoints",
            f"waypoint {row + 1}, joint {joint + 1} is {array[row, joint]}, expected a finite number",
        )
    return read_only(array)


def _check_family(family: Family, virtual_knots: int, count: int) -> None:
    if not isinstance(virtual_knots, int) or isinstance(virtual_knots, bool) or virtual_knots < 0:
        raise TaskError(
            "spline.virtual_knots", f"{virtual_knots!r} given, expected a whole number of 0 or more"
        )
    if virtual_knots and not family.takes_virtual_knots:
        raise TaskError("spline.virtual_knots", f"{virtual_knots} given, but {family} takes none")
    if count < family.least_waypoints:
        raise TaskError(
            "spline.family", f"{family} needs at least {family.least_waypoints} waypoints, {count} given"
        )
