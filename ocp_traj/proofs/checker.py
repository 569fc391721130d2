"""Check a proof about a robot motion. One file, Python's standard library only, nothing else of this package.

    python checker.py FILE

prints ``proved: ...`` and exits with 0, or prints the first statement that does not hold and exits with 1; 2 for a file
that is no proof. There are two kinds of proofs:

motion
    A piecewise polynomial passes the waypoints and keeps every limit at every instant; its duration and costs.
bound
    No motion whatever (or no curve of the 3-5-3 family) through the waypoints is shorter than a duration.

Nothing in a file is believed: evidence is hints (where to split, which joint to look at) from which everything is
computed again, so wrong hints can only make the check fail. Floats are dyadic rationals, hence positions, velocities,
accelerations and jerks are judged in exact rational arithmetic. Torques contain sines: they are judged in floats with
an outward bound of every rounding error (class `Ball`) and a bound of the interpolation error by Cauchy's integral.

Units: s, m, rad, kg, N, N m. Joints, gaps, pieces and waypoints count from 1 in messages and files, from 0 in here.
"""

from __future__ import annotations

import hashlib
import json
import math
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from math import comb, lcm
from typing import Any, TypeAlias

RATIO = Fraction(1, 10**6)
"""Fraction of a limit by which it may be exceeded; of the range for positions."""
JUMPS = (Fraction(1, 10**10), Fraction(1, 10**9), Fraction(1, 10**7))
"""All jumps of a joint together: position (rad, m), velocity and acceleration (fraction of the limit)."""
WAYPOINT = Fraction(1, 10**8)
"""Distance by which a waypoint's box may be missed, rad or m."""
BOUNDARY = Fraction(1, 10**8)
"""Fraction of the limit by which a derivative at an end may be missed."""
DURATION = Fraction(1, 10**9)
"""Relative amount by which bounds of durations may be missed."""
INFINITY = math.inf
ORDERS = ("position", "velocity", "acceleration", "jerk")
LIMITS = (*ORDERS, "torque", "torque_rate")
EXACT_COSTS = {"acceleration": 2, "jerk": 3}
SQUARED_COSTS = ("torque", "motor_loss")
POWER_COSTS = ("energy", "energy_without_regeneration")
COSTS = ("time", *EXACT_COSTS, *SQUARED_COSTS, *POWER_COSTS)
LARGEST_FILE = 64 * 2**20
LARGEST_DEGREE = 30
LARGEST_ANGLE = 1000.0
DEEPEST = 60
"""Halvings after which a polynomial is called undecided."""


class NotAProof(Exception):
    """The file does not have the form of a proof."""


class Refused(Exception):
    """A statement of the proof does not hold, or cannot be shown by this program."""


@dataclass(frozen=True)
class Report:
    """What was proved: the kind, one sentence, and the SHA-256 of the task that the sentence is about."""

    kind: str
    statement: str
    digest: str


# Reading. Every key has to be known and there once, every list has to have the right length.

Exact: TypeAlias = Any
"""A Fraction, or an infinite float."""
Row: TypeAlias = Sequence[Fraction]
_HEXADECIMAL = re.compile(r"-?0x[01](\.[0-9a-f]{1,13})?p[+-][0-9]{1,4}")


def fields(value: Any, where: str, *keys: str) -> list[Any]:
    """Return the values of an object that has exactly these keys."""
    if not isinstance(value, dict) or set(value) != set(keys):
        raise NotAProof(f"{where}: expected an object with the keys {', '.join(keys) or '(none)'}")
    return [value[key] for key in keys]


def array(value: Any, where: str, *shape: int | None, infinite: bool = False) -> Any:
    """Return nested lists of exact numbers, given as hexadecimal floats; None in the shape is any length above 0."""
    if not shape:
        if infinite and value in ("inf", "-inf"):
            return float(value)
        if not isinstance(value, str) or not _HEXADECIMAL.fullmatch(value):
            raise NotAProof(f"{where}: {ascii(value)[:40]} is not a float in hexadecimal, such as 0x1.8p+1")
        try:
            return Fraction(float.fromhex(value))
        except OverflowError:
            raise NotAProof(f"{where}: {value} is too large for a float") from None
    if not isinstance(value, list) or not value or len(value) != (shape[0] or len(value)):
        raise NotAProof(f"{where}: expected a list of {shape[0] or 'one or more'}")
    return [array(x, f"{where}[{k}]", *shape[1:], infinite=infinite) for k, x in enumerate(value, 1)]


def text(value: Any, where: str) -> str:
    """Return a short string."""
    if not isinstance(value, str) or len(value) > 1000:
        raise NotAProof(f"{where}: expected a text of at most 1000 characters")
    return value


@dataclass(frozen=True)
class Link:
    """A joint about (along) the z axis of the link that it moves; see `joint_torques`. The root is parent -1."""

    parent: int
    prismatic: bool
    rotation: list[list[float]]
    translation: list[float]
    mass: float
    first: list[float]
    second: list[list[float]]
    armature: float


@dataclass(frozen=True)
class Robot:
    """Links from the root to the tips, gravity in root axes, friction of each joint."""

    links: list[Link]
    gravity: list[float]
    viscous: list[float]
    coulomb: list[float]


@dataclass(frozen=True)
class Task:
    """What a motion has to do: n joints, K waypoints, G = K - 1 gaps."""

    name: str
    waypoints: list[list[Fraction]]
    tolerance: list[list[Fraction]]
    limits: dict[str, list[list[list[Exact]]]]
    boundary: dict[str, list[list[Fraction]] | None]
    duration: list[Exact]
    gap_durations: list[list[Exact]]
    weights: dict[str, Fraction]
    loss_factors: list[Fraction] | None
    robot: Robot | None

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.waypoints[0])

    @property
    def gaps(self) -> int:
        """Number of gaps between waypoints."""
        return len(self.waypoints) - 1

    def limit(self, name: str, gap: int, joint: int) -> tuple[Exact, Exact]:
        """Return lower and upper limit, infinite where there is none."""
        if name not in self.limits:
            return -INFINITY, INFINITY
        lower, upper = self.limits[name][gap]
        return lower[joint], upper[joint]

    def scale(self, name: str, gaps: Sequence[int], joint: int) -> Fraction | None:
        """Return the smallest finite positive limit in some gaps, None if there is none."""
        sides = [abs(side) for gap in gaps for side in self.limit(name, gap, joint) if 0 < abs(side) < INFINITY]
        return Fraction(min(sides)) if sides else None


def read_task(value: Any) -> Task:
    """Read the section `task`."""
    keys = ("name", "waypoints", "tolerance", "limits", "boundary", "duration", "gap_durations", "weights")
    name, points, tolerance, limits, boundary, *times, weights, losses, robot = fields(
        value, "task", *keys, "loss_factors", "robot"
    )
    waypoints = array(points, "task.waypoints", None, None)
    n, gaps = len(waypoints[0]), len(waypoints) - 1
    if gaps < 1 or any(len(row) != n for row in waypoints):
        raise NotAProof("task.waypoints: expected two or more rows of equal length")
    for key, table, known in (("limits", limits, LIMITS), ("weights", weights, COSTS)):
        if not isinstance(table, dict) or not set(table) <= set(known):
            raise NotAProof(f"task.{key}: expected an object with keys of {', '.join(known)}")
    ends = dict(zip(ORDERS[1:], fields(boundary, "task.boundary", *ORDERS[1:])))
    task = Task(
        text(name, "task.name"),
        waypoints,
        array(tolerance, "task.tolerance", gaps + 1, n),
        {k: array(limits[k], f"task.limits.{k}", gaps, 2, n, infinite=True) for k in LIMITS if k in limits},
        {k: None if rows is None else array(rows, f"task.boundary.{k}", 2, n) for k, rows in ends.items()},
        array(times[0], "task.duration", 2, infinite=True),
        array(times[1], "task.gap_durations", gaps, 2, infinite=True),
        {k: array(weights[k], f"task.weights.{k}") for k in COSTS if k in weights},
        None if losses is None else array(losses, "task.loss_factors", n),
        None if robot is None else _read_robot(robot, n),
    )
    signed = [x < 0 for row in task.tolerance for x in row] + [w <= 0 for w in task.weights.values()]
    if any(signed) or any(x < 0 for x in task.loss_factors or ()):
        raise NotAProof("task: tolerances and loss factors must not be negative, weights must be positive")
    for key, rows in task.limits.items():
        for low, up in ((low, up) for lower, upper in rows for low, up in zip(lower, upper)):
            if low > up or low == INFINITY or up == -INFINITY or (key != "position" and not low <= 0 <= up):
                raise NotAProof(f"task.limits.{key}: a lower limit is above the upper one, or 0 is excluded")
    dynamic = set(task.limits) & {"torque", "torque_rate"} or set(task.weights) & {*SQUARED_COSTS, *POWER_COSTS}
    if (dynamic and task.robot is None) or ("motor_loss" in task.weights and task.loss_factors is None):
        raise NotAProof("task: torques or motor losses are limited or weighted, but robot or loss_factors is null")
    return task


def _read_robot(value: Any, n: int) -> Robot:
    links, gravity, viscous, coulomb = fields(value, "task.robot", "links", "gravity", "viscous", "coulomb")
    if not isinstance(links, list) or len(links) != n:
        raise NotAProof(f"task.robot.links: expected a list of {n}")
    shapes = {"rotation": (3, 3), "translation": (3,), "mass": (), "first": (3,), "second": (3, 3), "armature": ()}
    found = []
    for index, link in enumerate(links):
        where = f"task.robot.links[{index + 1}]"
        parent, prismatic, *numbers = fields(link, where, "parent", "prismatic", *shapes)
        if type(parent) is not int or not 0 <= parent <= index or type(prismatic) is not bool:
            raise NotAProof(f"{where}: expected a parent from 0 (the root) to {index}, and true or false")
        rows = [_floats(array(x, f"{where}.{key}", *shapes[key])) for key, x in zip(shapes, numbers)]
        found.append(Link(parent - 1, prismatic, *rows))
    rows = [_floats(array(row, "task.robot", size)) for row, size in ((gravity, 3), (viscous, n), (coulomb, n))]
    if min(rows[1] + rows[2]) < 0:
        raise NotAProof("task.robot: friction must not be negative")
    return Robot(found, *rows)


def _floats(value: Any) -> Any:
    return [_floats(entry) for entry in value] if isinstance(value, list) else float(value)


# Exact polynomials: lists of coefficients in ascending powers.


def polynomial_value(c: Row, t: Fraction) -> Fraction:
    """Return the value at t (Horner)."""
    total = Fraction(0)
    for coefficient in reversed(c):
        total = total * t + coefficient
    return total


def derivative(c: Row) -> list[Fraction]:
    """Return the coefficients of the derivative, at least one."""
    return [power * coefficient for power, coefficient in enumerate(c)][1:] or [Fraction(0)]


def product(a: Sequence[Any], b: Sequence[Any]) -> list[Any]:
    """Return the product of two polynomials."""
    out = [0 * a[0]] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            out[i + j] += x * y
    return out


def shifted(c: Row, middle: Fraction, half: Fraction) -> list[Fraction]:
    """Return the coefficients in powers of u, where t = middle + half u."""
    terms = ([c[j] * comb(j, i) * middle ** (j - i) for j in range(i, len(c))] for i in range(len(c)))
    return [sum(row, Fraction(0)) * half**i for i, row in enumerate(terms)]


def bernstein(c: Row, h: Fraction) -> list[Fraction]:
    """Return the Bernstein coefficients on [0, h]: the polynomial lies between the least and the largest."""
    d, scaled = len(c) - 1, [coefficient * h**power for power, coefficient in enumerate(c)]
    terms = ([Fraction(comb(j, i), comb(d, i)) * scaled[i] for i in range(j + 1)] for j in range(d + 1))
    return [sum(row, Fraction(0)) for row in terms]


def symmetric_bernstein(c: Row) -> list[Fraction]:
    """Return the Bernstein coefficients on [-1, 1]."""
    return bernstein(shifted(c, Fraction(-1), Fraction(1)), Fraction(2))


def within(c: Row, h: Fraction, lower: Exact, upper: Exact) -> bool:
    """Return whether lower <= polynomial <= upper on [0, h], by halving (de Casteljau) in integers."""
    coefficients = bernstein(c, h)
    common = lcm(*(b.denominator for b in coefficients))
    d, top, bottom = len(c) - 1, upper * common, lower * common
    stack = [([int(b * common) for b in coefficients], 0)]  # times 2^(d depth)
    while stack:
        b, depth = stack.pop()
        high = top if top == INFINITY else top * (1 << d * depth)
        low = bottom if bottom == -INFINITY else bottom * (1 << d * depth)
        if max(b) <= high and min(b) >= low:
            continue
        if max(b[0], b[-1]) > high or min(b[0], b[-1]) < low:
            return False
        if depth == DEEPEST:
            raise Refused(f"a polynomial is undecided after {DEEPEST} halvings")
        left, right, row = [b[0] << d], [b[-1] << d], b
        for k in range(1, d + 1):
            row = [x + y for x, y in zip(row, row[1:])]
            left.append(row[0] << (d - k))
            right.append(row[-1] << (d - k))
        stack += [(left, depth + 1), (right[::-1], depth + 1)]
    return True


# A motion: kinematics.


@dataclass(frozen=True)
class Motion:
    """A piecewise polynomial. `orders[k][piece][joint]` are the coefficients of the k-th derivative."""

    times: list[Fraction]
    lengths: list[Fraction]
    marks: list[int]
    gaps: list[int]
    orders: list[list[list[list[Fraction]]]]

    def ends(self, order: int, piece: int, joint: int) -> tuple[Fraction, Fraction]:
        """Return the values of a derivative at both ends of a piece."""
        c = self.orders[order][piece][joint]
        return c[0], polynomial_value(c, self.lengths[piece])

    def largest(self, order: int) -> Fraction:
        """Return a value that some joint's derivative reaches somewhere: the largest of five instants a piece."""
        pieces = zip(self.lengths, self.orders[order])
        return max(abs(polynomial_value(c, h * k / 4)) for h, joints in pieces for c in joints for k in range(5))


def read_motion(value: Any, task: Task) -> Motion:
    """Read the section `motion`; every waypoint time has to be a breakpoint."""
    keys = ("waypoint_times", "breakpoints", "coefficients")
    schema, case, family, passing, times, curve = fields(value, "motion", "schema", "case", "family", *keys)
    text(case, "motion.case")
    text(family, "motion.family")
    times = array(times, "motion.breakpoints", None)
    m = len(times) - 1
    passing = array(passing, "motion.waypoint_times", task.gaps + 1)
    curve = array(curve, "motion.coefficients", m or None, task.n, None)
    sizes = {len(c) for piece in curve for c in piece}
    if schema != 1 or m < 1 or len(sizes) > 1 or max(sizes) > LARGEST_DEGREE + 1:
        raise NotAProof(f"motion: expected schema 1, a piece or more, all of one degree up to {LARGEST_DEGREE}")
    if any(a >= b for a, b in zip(times, times[1:])):
        raise Refused("the breakpoints do not increase")
    at = {t: k for k, t in enumerate(times)}
    if any(a > b for a, b in zip(passing, passing[1:])) or any(t not in at for t in passing):
        raise Refused("the waypoint times are not breakpoints in ascending order")
    marks = [at[t] for t in passing]
    if marks[0] != 0 or marks[-1] != m:
        raise Refused("the first and the last waypoint are not passed at the ends of the motion")
    orders = [curve]
    for _ in ORDERS[1:]:
        orders.append([[derivative(c) for c in piece] for piece in orders[-1]])
    gaps = [gap for gap, (a, b) in enumerate(zip(marks, marks[1:])) for _ in range(b - a)]
    return Motion(times, [b - a for a, b in zip(times, times[1:])], marks, gaps, orders)


def check_kinematics(task: Task, motion: Motion) -> None:
    """Check durations, waypoints, ends, joins and the limits of position, velocity, acceleration and jerk."""
    passing = [motion.times[k] for k in motion.marks]
    spans = [("the motion", passing[-1] - passing[0], task.duration)]
    spans += [(f"gap {g + 1}", b - a, task.gap_durations[g]) for g, (a, b) in enumerate(zip(passing, passing[1:]))]
    for what, length, (least, most) in spans:
        if length < least * (1 - DURATION) or (most < INFINITY and length > most * (1 + DURATION)):
            raise Refused(f"the duration of {what}, {float(length):.9g} s, is out of its bounds")
    for joint in range(task.n):
        _check_waypoints(task, motion, joint)
        _check_ends(task, motion, joint)
        _check_joins(task, motion, joint)
    for order, name in enumerate(ORDERS):
        for piece, gap in enumerate(motion.gaps):
            for joint in range(task.n):
                bounds = widened(name, *task.limit(name, gap, joint))
                if not within(motion.orders[order][piece][joint], motion.lengths[piece], *bounds):
                    between = f"{float(motion.times[piece]):.6g} and {float(motion.times[piece + 1]):.6g} s"
                    raise Refused(f"{name} of joint {joint + 1} is beyond its limit between {between}")


def widened(name: str, lower: Exact, upper: Exact) -> tuple[Exact, Exact]:
    """Return what a motion may reach; positions with one limit have the slack of waypoints."""
    down, up = RATIO * abs(lower) if lower > -INFINITY else 0, RATIO * abs(upper) if upper < INFINITY else 0
    if name == "position":
        down = up = RATIO * (upper - lower) if upper - lower < INFINITY else WAYPOINT
    return (lower - down if lower > -INFINITY else lower), (upper + up if upper < INFINITY else upper)


def _check_waypoints(task: Task, motion: Motion, joint: int) -> None:
    for waypoint, mark in enumerate(motion.marks):
        sides = [motion.ends(0, mark, joint)[0]] if mark < len(motion.lengths) else []
        sides += [motion.ends(0, mark - 1, joint)[1]] if mark else []
        box = task.tolerance[waypoint][joint] + WAYPOINT
        if any(abs(q - task.waypoints[waypoint][joint]) > box for q in sides):
            raise Refused(f"waypoint {waypoint + 1} is missed by joint {joint + 1}")


def _check_ends(task: Task, motion: Motion, joint: int) -> None:
    for order, name in enumerate(ORDERS[1:], 1):
        ends = (motion.ends(order, 0, joint)[0], motion.ends(order, -1, joint)[1])
        for wanted, end, gap, side in zip(task.boundary[name] or (), ends, (0, task.gaps - 1), ("start", "end")):
            miss = abs(end - wanted[joint])
            if miss and miss > BOUNDARY * (task.scale(name, [gap], joint) or motion.largest(order)):
                raise Refused(f"{name} of joint {joint + 1} at the {side} is {float(end):.9g}, not as asked")


def _check_joins(task: Task, motion: Motion, joint: int) -> None:
    """Check the sums of jumps; those of acceleration where jerk or torque rate matter."""
    for order in range(3 if {"jerk", "torque_rate"} & {*task.limits, *task.weights} else 2):
        total = Fraction(0)
        for k in range(len(motion.lengths) - 1):
            jump = abs(motion.ends(order, k, joint)[1] - motion.ends(order, k + 1, joint)[0])
            unit = task.scale(ORDERS[order], motion.gaps[k : k + 2], joint) if order else Fraction(1)
            total += jump / (unit or motion.largest(order)) if jump else 0
        if total > JUMPS[order]:
            what = f"the jumps of joint {joint + 1} in {ORDERS[order]} add up to {float(total):.3g}"
            raise Refused(f"{what}, allowed {float(JUMPS[order]):g}")


def squared_integral(motion: Motion, order: int) -> Fraction:
    """Return the integral of the sum of a derivative's squares, exactly."""
    total = Fraction(0)
    for h, joints in zip(motion.lengths, motion.orders[order]):
        for c in joints:
            total += h * polynomial_value([s / (k + 1) for k, s in enumerate(product(c, c))], h)
    return total


# Balls: floats with a bound of their error.

UNIT = 2.0**-52
"""Twice the relative rounding error of one operation."""
UP = 1.0 + 2.0**-48
"""Covers the roundings of the few operations that compute a radius."""
TINY = 1e-300
"""Covers underflow."""


class Ball:
    """All complex numbers within e of the float c; every operation encloses all results of its operands.

    The radius serves two ends: rounding errors at a real argument, and the values on a whole disc of arguments.
    """

    __slots__ = ("c", "e")

    def __init__(self, c: float, e: float = 0.0) -> None:
        self.c = c
        self.e = e

    def __add__(self, other: Value) -> Ball:
        y, own = (other.c, other.e) if isinstance(other, Ball) else (other, 0.0)
        c = self.c + y
        return Ball(c, (self.e + own + abs(c) * UNIT) * UP)

    __radd__ = __add__

    def __neg__(self) -> Ball:
        return Ball(-self.c, self.e)

    def __sub__(self, other: Value) -> Ball:
        return self + (-other)

    def __rsub__(self, other: float) -> Ball:
        return (-self) + other

    def __mul__(self, other: Value) -> Ball:
        y, own = (other.c, other.e) if isinstance(other, Ball) else (other, 0.0)
        c = self.c * y
        return Ball(c, (abs(self.c) * own + abs(y) * self.e + self.e * own + abs(c) * UNIT + TINY) * UP)

    __rmul__ = __mul__


Value: TypeAlias = float | Ball
"""A Ball; a float only where it is exact (a number of the file, or 0)."""


def rounded(x: Fraction) -> Ball:
    """Return a ball around a rational number."""
    c = float(x)
    return Ball(c, abs(c) * UNIT + TINY)


@lru_cache(maxsize=20_000)
def fixed_sine_cosine(x: float) -> tuple[float, float, float]:
    """Return sine and cosine of a float, and a bound of the error of both: Taylor's series in integers, without pi.

    A term's error is carried on by at most the largest term, and each of k terms adds a few units at each of k steps.
    """
    if not abs(x) <= LARGEST_ANGLE:
        raise Refused(f"an angle of {x:g} rad is beyond {LARGEST_ANGLE:g} rad")
    bits = 120 + 3 * int(abs(x))
    numerator, denominator = x.as_integer_ratio()
    z = (numerator << bits) // denominator
    square = (z * z) >> bits
    cosine = sine = k = 0
    term = largest = 1 << bits  # x^2k / (2k)!
    while term or k * k <= square >> bits:  # afterwards each term is less than half of the one before
        sign = -1 if k % 2 else 1
        cosine += sign * term
        sine += sign * (term // (2 * k + 1))  # x^2k / (2k + 1)!, times x below
        k += 1
        term = ((term * square) >> bits) // ((2 * k - 1) * (2 * k))
        largest = max(largest, term)
    size = (abs(z) >> bits) + 2
    error = 8 * (k + 4) ** 2 * ((largest >> bits) + 1) * size * size
    return ((sine * z) >> bits) / (1 << bits), cosine / (1 << bits), error / (1 << bits) + UNIT


def sine_cosine(ball: Ball) -> tuple[Ball, Ball]:
    """Return balls around sine and cosine: |sin(c+d) - sin c| <= |cos c| sinh e + |sin c| (cosh e - 1), |d| <= e."""
    e = ball.e
    if not (e < 1.2 and abs(ball.c) < INFINITY):
        return Ball(0.0, INFINITY), Ball(0.0, INFINITY)
    s, c, own = fixed_sine_cosine(ball.c)
    cosh = 1.0 / (1.0 - 0.5 * e * e) * UP  # an upper bound
    sinh = e * (1.0 + e * e / 6.0 * cosh) * UP
    rest = 0.5 * e * e * cosh * UP
    spread = 3.0 * own * (1.0 + sinh + rest)
    sine = Ball(s, (abs(c) * sinh + abs(s) * rest + spread) * UP)
    return sine, Ball(c, (abs(s) * sinh + abs(c) * rest + spread) * UP)


# Joint torques: the recursive equations of Newton and Euler.


def combine(numbers: Sequence[float], values: Sequence[Value]) -> Value:
    """Return the sum of numbers times values; numbers 0, 1 and -1 cost no rounding."""
    total: Value = 0.0
    for a, x in zip(numbers, values):
        if a == 0.0 or (isinstance(x, float) and x == 0.0):
            continue
        term = x if a == 1.0 else -x if a == -1.0 else a * x
        total = term if isinstance(total, float) else total + term
    return total


def rotated(matrix: Sequence[Sequence[float]], vector: Sequence[Value]) -> list[Value]:
    """Return matrix times vector."""
    return [combine(row, vector) for row in matrix]


def cross(a: Sequence[Value], b: Sequence[Value]) -> list[Value]:
    """Return the vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def turned(c: Value, s: Value, vector: Sequence[Value]) -> list[Value]:
    """Return a vector turned about z by the angle with this cosine and sine."""
    x, y, z = vector
    return [c * x - s * y, s * x + c * y, z]


@dataclass
class Body:
    """Origin in the parent's axes; rates, acceleration and S (below), force and moment in the link's own."""

    sine: Value
    cosine: Value
    origin: list[Value]
    w: list[Value]
    dw: list[Value]
    base: list[Value]
    point: list[list[Value]]
    force: list[Value]
    moment: list[Value]


def joint_torques(robot: Robot, q: Sequence[Ball], v: Sequence[Ball], a: Sequence[Ball]) -> list[Ball]:
    """Return the torques (forces) of all joints, without Coulomb friction."""
    bodies: list[Body] = []
    for link, x, dx, ddx in zip(robot.links, q, v, a):
        bodies.append(_body(link, bodies[link.parent] if link.parent >= 0 else None, robot.gravity, x, dx, ddx))
    torques: list[Ball] = []
    for i in reversed(range(len(bodies))):
        link, body = robot.links[i], bodies[i]
        along = (body.force if link.prismatic else body.moment)[2]
        torques.append(link.armature * a[i] + robot.viscous[i] * v[i] + along)
        if link.parent >= 0:
            pair = [body.force, body.moment]
            if not link.prismatic:
                pair = [turned(body.cosine, body.sine, vector) for vector in pair]
            force, moment = (rotated(link.rotation, vector) for vector in pair)
            parent = bodies[link.parent]
            parent.force = [x + y for x, y in zip(parent.force, force)]
            parent.moment = [x + y + z for x, y, z in zip(parent.moment, moment, cross(body.origin, force))]
    return torques[::-1]


def _body(link: Link, parent: Body | None, gravity: list[float], q: Ball, v: Ball, a: Ball) -> Body:
    """Return a link's motion and the force and moment that it needs.

    S = [dw]x + [w]x[w]x gives every point r of a body the acceleration b + S r (w angular velocity, dw its
    derivative, b the acceleration of the link's origin minus gravity, in link axes). With mass m, first moment m c
    and second moment E, the body needs the force m b + S m c and the moment m c x b + axial part of S E.
    """
    w: list[Value] = [0.0, 0.0, 0.0] if parent is None else parent.w
    dw: list[Value] = [0.0, 0.0, 0.0] if parent is None else parent.dw
    base: list[Value] = [Ball(-g) for g in gravity]
    origin: list[Value] = list(link.translation)
    if link.prismatic:
        origin = [o + row[2] * q for o, row in zip(link.translation, link.rotation)]
    if parent is not None:
        carried = [sum((s * o for s, o in zip(row, origin)), Ball(0.0)) for row in parent.point]
        base = [b + x for b, x in zip(parent.base, carried)]
    back = list(zip(*link.rotation))
    w, dw, base = rotated(back, w), rotated(back, dw), rotated(back, base)
    sine: Value = 0.0
    cosine: Value = 1.0
    if link.prismatic:
        twice = 2.0 * v
        base = [base[0] + twice * w[1], base[1] - twice * w[0], base[2] + a]
    else:
        sine, cosine = sine_cosine(q)
        w, dw, base = (turned(cosine, -sine, vector) for vector in (w, dw, base))
        dw = [dw[0] + w[1] * v, dw[1] - w[0] * v, dw[2] + a]
        w = [w[0], w[1], w[2] + v]
    xx, yy, zz, xy, xz, yz = w[0] * w[0], w[1] * w[1], w[2] * w[2], w[0] * w[1], w[0] * w[2], w[1] * w[2]
    point = [
        [-(yy + zz), xy - dw[2], xz + dw[1]],
        [xy + dw[2], -(xx + zz), yz - dw[0]],
        [xz - dw[1], yz + dw[0], -(xx + yy)],
    ]
    product = [[combine(column, row) for column in zip(*link.second)] for row in point]  # S E
    axial = [product[2][1] - product[1][2], product[0][2] - product[2][0], product[1][0] - product[0][1]]
    force = [link.mass * b + combine(link.first, row) for b, row in zip(base, point)]
    moment = [x + y for x, y in zip(axial, cross(link.first, base))]
    return Body(sine, cosine, origin, w, dw, base, point, force, moment)


# Interpolation with a bound of its error, on u in [-1, 1].

DEGREES = {"torque": 12, "torque_rate": 16}
"""Of interpolants; a bound of slopes needs more than one of values."""
RADIUS = 4
DEEPEST_PIECE = 40
"""Halvings of a piece after which its torque is called undecided."""
FINE = 2**96
"""Denominator to which the matrix of an interpolation is rounded."""
ROUNDINGS = 2.0**-42
"""Relative, above all roundings of sums, products and halvings of Bernstein coefficients here."""


def halves(b: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """Return the Bernstein coefficients on both halves."""
    left, right, row = [b[0]], [b[-1]], list(b)
    while len(row) > 1:
        row = [(x + y) / 2 for x, y in zip(row, row[1:])]
        left.append(row[0])
        right.append(row[-1])
    return left, right[::-1]


def bernstein_product(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """Return the product of two polynomials given by Bernstein coefficients."""
    m, d = len(a) - 1, len(b) - 1
    raw = product([comb(m, i) * x for i, x in enumerate(a)], [comb(d, j) * y for j, y in enumerate(b)])
    return [x / comb(m + d, k) for k, x in enumerate(raw)]


class Nodes:
    """Interpolation at symmetric nodes x_k, and the constants of its error.

    With w(u) = prod (u - x_k) and |f - f0| <= M on the circle |u| = R, for any constant f0, the interpolant p has
    |f - p| <= M R / least |w| max |w| / (R - 1) and |f' - p'| <= M R / least |w| (max |w'| / (R - 1) + max |w| /
    (R - 1)^2) on [-1, 1]; least |w| on the circle is at least the product of R^2 - x_k^2 over the pairs of nodes.
    """

    def __init__(self, degree: int) -> None:
        count, radius = degree + 1, Fraction(RADIUS)
        grid = [Fraction(round(math.cos(math.pi * (2 * k + 1) / (2 * count)) * 2**20), 2**20) for k in range(count)]
        if len(set(grid)) < count or any(a != -b or abs(a) > 1 for a, b in zip(grid, reversed(grid))):
            raise Refused("the cosine of this Python gives no symmetric nodes")
        w, least, basis = [Fraction(1)], Fraction(1), []
        for x in grid:
            w = product(w, [-x, Fraction(1)])
            least *= radius**2 - x * x if x > 0 else radius if x == 0 else 1
            lagrange = [Fraction(1)]
            for other in grid:
                if other != x:
                    lagrange = product(lagrange, [-other / (x - other), 1 / (x - other)])
            basis.append(symmetric_bernstein(lagrange))
        largest, steepest = self._largest(w), self._largest(derivative(w))
        self.u = [float(x) for x in grid]
        self.value_factor = float(radius / least * largest / (radius - 1)) * UP
        self.slope_factor = float(radius / least * (steepest / (radius - 1) + largest / (radius - 1) ** 2)) * UP
        self.degree = degree
        self.rows = [[round(column[j] * FINE) for column in basis] for j in range(count)]
        # errors e of values make at most e * amplification of p, and of p' at most degree^2 times that (Markov)
        table = zip(*([max(map(abs, part)) for part in self._parts(column, 4)] for column in basis))
        self.amplification = float(max(map(sum, table))) * UP

    @staticmethod
    def _parts(b: Row, times: int) -> list[list[Fraction]]:
        parts = [list(b)]
        for _ in range(times):
            parts = [half for part in parts for half in halves(part)]
        return parts

    def _largest(self, c: Row) -> Fraction:
        """Return an upper bound of |polynomial| on [-1, 1]."""
        return max(abs(x) for part in self._parts(symmetric_bernstein(c), 6) for x in part)

    def interpolate(self, values: Sequence[Ball], half: Fraction) -> tuple[list[float], list[float], float, float]:
        """Return the Bernstein coefficients of interpolant and slope, and the errors that rounding made of them."""
        if not math.isfinite(sum(abs(value.c) + value.e for value in values)):
            return [math.inf], [math.inf], math.inf, math.inf
        ratios = [value.c.as_integer_ratio() for value in values]
        common = max(denominator for _, denominator in ratios)  # powers of two
        whole = [numerator * (common // denominator) for numerator, denominator in ratios]
        exact = [sum(x * y for x, y in zip(row, whole)) for row in self.rows]
        over = 2 * FINE * common * half
        b = [float(Fraction(x, FINE * common)) for x in exact]
        slope = [float((y - x) * self.degree / over) for x, y in zip(exact, exact[1:])]
        error = max(value.e for value in values) * self.amplification * UP
        size = max(abs(value.c) for value in values)  # the rows were rounded
        error += size * 2.0**-80 + ROUNDINGS * max(map(abs, b))
        slope_error = (max(value.e for value in values) * self.amplification + size * 2.0**-80) * self.degree**2
        return b, slope, error, slope_error / float(half) * UP * UP + ROUNDINGS * max(map(abs, slope))


def inside(b: Sequence[float], bottom: float, top: float) -> bool:
    """Return whether the polynomial is shown to lie in [bottom, top]."""
    stack = [(list(b), 0)]
    while stack:
        b, depth = stack.pop()
        if max(b) <= top and min(b) >= bottom:
            continue
        if depth == 30 or not (bottom <= b[0] <= top and bottom <= b[-1] <= top):
            return False
        stack += [(half, depth + 1) for half in halves(b)]
    return True


def mean_of_part(b: Sequence[float], part: Callable[[float], float], depth: int = 16) -> float:
    """Return an upper bound of the mean of part(polynomial); part is the absolute value or the positive part."""
    if depth == 0 or min(b) >= 0 or max(b) <= 0:
        return sum(map(part, b)) / len(b)
    return sum(mean_of_part(half, part, depth - 1) for half in halves(b)) / 2


# A motion: torques, torque rates, and the costs that need them.


class Dynamics:
    """Checks torques and torque rates of a motion, and adds up upper bounds of costs on the way.

    Coulomb friction has the sign of the velocity; up to BOUNDARY of the limit, a velocity counts as that of the motion
    before or after, and if both are so slow, as rest without friction. Jumps of friction are no torque rate.
    """

    def __init__(self, task: Task, motion: Motion, robot: Robot) -> None:
        self.task, self.motion, self.robot = task, motion, robot
        self.nodes = Nodes(DEGREES["torque_rate" if "torque_rate" in task.limits else "torque"])
        self.costs = {name: 0.0 for name in (*SQUARED_COSTS, *POWER_COSTS) if name in task.weights}
        sizes = [task.scale("velocity", range(task.gaps), joint) for joint in range(task.n)]
        self.slow = [float(BOUNDARY * (motion.largest(1) if size is None else size)) for size in sizes]
        torque = [self._torque_factor(joint) for joint in range(task.n)]
        self.factors = {"torque": torque, "motor_loss": task.loss_factors or []}
        start = self._powers(0, Fraction(0), motion.lengths[0])
        self.typical = max(abs(t.c) + t.e for t in self._torques_at(start, Ball(0.0)))

    def _torque_factor(self, joint: int) -> Fraction:
        """Return 1 over the square of the largest torque that a joint may have anywhere; 1 without a limit."""
        largest = max(abs(side) for gap in range(self.task.gaps) for side in self.task.limit("torque", gap, joint))
        return 1 / Fraction(largest) ** 2 if 0 < largest < INFINITY else Fraction(1)

    def check(self) -> dict[str, float]:
        """Check all pieces and return upper bounds of the costs, without weights."""
        for piece, length in enumerate(self.motion.lengths):
            stack = [(Fraction(0), length, 0)]
            while stack:
                begin, end, depth = stack.pop()
                middle, half = (begin + end) / 2, (end - begin) / 2
                if not self._interval(piece, middle, half, depth):
                    if depth == DEEPEST_PIECE:
                        raise Refused(f"torques near {float(self.motion.times[piece] + middle):.9g} s are undecided")
                    stack += [(middle, end, depth + 1), (begin, middle, depth + 1)]
        return {name: cost * (1 + ROUNDINGS) for name, cost in self.costs.items()}

    def _powers(self, piece: int, middle: Fraction, half: Fraction) -> list[list[list[Ball]]]:
        """Return positions, velocities, accelerations in powers of u."""
        joints = (self.motion.orders[order][piece] for order in range(3))
        return [[[rounded(x) for x in shifted(c, middle, half)] for c in row] for row in joints]

    def _torques_at(self, powers: list[list[list[Ball]]], u: Ball) -> list[Ball]:
        states: list[list[Ball]] = [[], [], []]
        for state, joints in zip(states, powers):
            for c in joints:
                total = c[-1]
                for coefficient in reversed(c[:-1]):
                    total = total * u + coefficient
                state.append(total)
        return joint_torques(self.robot, *states)

    def _interval(self, piece: int, middle: Fraction, half: Fraction, depth: int) -> bool:
        """Return whether all is shown on an interval; False: halve it."""
        powers, gap = self._powers(piece, middle, half), self.motion.gaps[piece]
        disc = self._torques_at(powers, Ball(0.0, float(RADIUS)))
        errors = [t.e * self.nodes.value_factor * UP for t in disc]
        rate_errors = [t.e * self.nodes.slope_factor / float(half) * UP * UP for t in disc]
        for name, found in (("torque", errors), ("torque_rate", rate_errors)):
            for joint, error in enumerate(found):
                limit = self.task.scale(name, [gap], joint)
                if limit is None and (name == "torque_rate" or (depth >= 10 and error < INFINITY)):
                    continue  # nothing is limited: any error is only paid for
                if not error <= 0.5 * float(RATIO) * (self.typical if limit is None else float(limit)):
                    return False
        values = [self._torques_at(powers, Ball(u)) for u in self.nodes.u]
        torques = []
        for joint in range(self.task.n):
            b, rate, rounding, rate_rounding = self.nodes.interpolate([row[joint] for row in values], half)
            if not math.isfinite(rounding):  # comparisons below would overlook a NaN
                return False
            if not self._keeps("torque_rate", gap, joint, rate, rate_errors[joint] + rate_rounding):
                return False
            speed = symmetric_bernstein(shifted(self.motion.orders[1][piece][joint], middle, half))
            parts = self._with_friction(joint, b, [float(x) for x in speed])
            torques.append((parts, errors[joint] + rounding))
            for part, _, _ in parts:
                verdict = self._keeps("torque", gap, joint, part, errors[joint] + rounding)
                if verdict is False:
                    when = f"{float(self.motion.times[piece] + middle):.9g}"
                    raise Refused(f"torque of joint {joint + 1} is beyond its limit near {when} s")
                if not verdict:
                    return False
        for joint, (parts, error) in enumerate(torques):
            for part, speeds, share in parts:
                self._pay(joint, part, speeds, error, share * 2 * float(half) * UP)
        return True

    def _with_friction(
        self, joint: int, b: list[float], speed: list[float]
    ) -> list[tuple[list[float], list[float], float]]:
        """Return torques with Coulomb friction and velocities, and their shares of time, where the sign is known."""
        coulomb, slow, found = self.robot.coulomb[joint], self.slow[joint], []
        stack = [(b, speed, 1.0)]
        while stack:
            b, speed, share = stack.pop()
            back, forth = min(speed) < -slow, max(speed) > slow
            if coulomb and back and forth:
                stack += [(x, y, share / 2) for x, y in zip(halves(b), halves(speed))]
            else:
                found.append(([x + coulomb * (forth - back) for x in b] if coulomb else b, speed, share))
        return found

    def _keeps(self, name: str, gap: int, joint: int, b: list[float], error: float) -> bool | None:
        """Return whether a polynomial with an error is shown to keep a limit; False: an end is beyond it; else None."""
        low, up = (float(side) for side in self.task.limit(name, gap, joint))
        slack = error * UP + ROUNDINGS * max(map(abs, [*b, *(side for side in (low, up) if abs(side) < INFINITY)]))
        bottom, top = low * (1.0 + float(RATIO)), up * (1.0 + float(RATIO))
        if inside(b, bottom + slack, top - slack):
            return True
        return None if max(b[0], b[-1]) <= top + slack and min(b[0], b[-1]) >= bottom - slack else False

    def _pay(self, joint: int, b: list[float], speed: list[float], error: float, seconds: float) -> None:
        """Add the upper bounds of a joint's costs on an interval."""
        wide = error * UP + ROUNDINGS * max(map(abs, b))
        for name in self.costs:
            if name in SQUARED_COSTS:
                square = bernstein_product(b, b)
                cost = sum(square) / len(square) + wide * (2 * mean_of_part(b, abs) + wide)
                cost = (cost + ROUNDINGS * max(map(abs, b)) ** 2) * float(self.factors[name][joint])
            else:
                part = abs if name == "energy" else _positive
                cost = mean_of_part(bernstein_product(b, speed), part) + wide * mean_of_part(speed, abs)
                cost += ROUNDINGS * max(map(abs, b)) * max(map(abs, speed))
            self.costs[name] += cost * seconds * (1 + ROUNDINGS)


def _positive(x: float) -> float:
    return max(x, 0.0)


def check_motion(task: Task, motion: Motion) -> dict[str, Fraction]:
    """Check all limits and return upper bounds of all costs that have a weight."""
    check_kinematics(task, motion)
    costs = {"time": motion.times[-1] - motion.times[0]}
    costs |= {name: squared_integral(motion, order) for name, order in EXACT_COSTS.items() if name in task.weights}
    if task.robot is not None:
        costs |= {name: Fraction(cost) for name, cost in Dynamics(task, motion, task.robot).check().items()}
    return {name: costs[name] for name in task.weights}


# Bounds: no motion is shorter. A shorter one could be slowed uniformly to last exactly the claimed time T, so all
# durations h of the gaps with sum T are refuted, in a tree of boxes. The interval of velocities that a joint can have
# is pushed through the gaps: starting at v0 >= lo and ending at v1 >= hi with acceleration <= A, deceleration <= B and
# velocity >= -V, a joint covers at least G(h) in a time h, which is concave in h, so the ends of a box are enough.


@dataclass(frozen=True)
class Gap:
    """What a joint may do in a gap: velocities in [-V, W], accelerations in [-B, A], ways in [near, far]."""

    V: Fraction
    W: Fraction
    A: Exact
    B: Exact
    near: Fraction
    far: Fraction


def least_way(h: Fraction, lo: Fraction, hi: Fraction, V: Fraction, A: Fraction, B: Fraction) -> Fraction:
    """Return G(h): no joint covers less from v0 >= lo to v1 >= hi."""
    if hi - A * h >= lo:  # speeding up all the time
        return hi * h - A * h * h / 2
    if lo - B * h >= hi:  # braking all the time
        return lo * h - B * h * h / 2
    w = max((lo / B + hi / A - h) / (1 / A + 1 / B), -V)  # braking to w, waiting there if w = -V, speeding up
    return w * h + (w - lo) ** 2 / (2 * B) + (w - hi) ** 2 / (2 * A)


def least_way_to_any(h: Fraction, lo: Fraction, V: Fraction, B: Fraction) -> Fraction:
    """Return the least way from v0 >= lo, whatever the velocity at the end."""
    braking = min(h, (lo + V) / B)
    return lo * braking - B * braking**2 / 2 - V * (h - braking)


def guess(far: float, lo: float, h: float, V: float, A: float, B: float) -> float:
    """Return about the largest velocity at the end of a way of at most `far`: a hint, `least_way` decides."""
    if h <= 0:
        return INFINITY
    if lo <= far / h - 0.5 * A * h:
        return far / h + 0.5 * A * h
    rise = math.sqrt(max((B * h * h - 2.0 * (lo * h - far)) / (A + B), 0.0))
    valley = lo - B * (h - rise)
    if valley < -V:
        return -V + math.sqrt(max(2.0 * A * (far + V * h - 0.5 * (lo + V) ** 2 / B), 0.0))
    return valley + A * rise


def highest(
    far: Fraction, lo: Fraction, hi: Fraction, ends: Row, V: Fraction, W: Fraction, A: Fraction, B: Fraction
) -> Fraction | None:
    """Return an upper bound of the velocity after a gap from a velocity in [lo, hi]; None where no way is <= far."""
    if all(least_way_to_any(h, lo, V, B) > far for h in ends):
        return None
    best = min(W, hi + A * ends[-1])
    hint = max(guess(float(far), float(lo), float(h), float(V), float(A), float(B)) for h in ends)
    if hint < best:
        velocity = Fraction(hint + 1e-10 * (1 + abs(hint)))
        if -V <= velocity < best and all(least_way(h, lo, velocity, V, A, B) > far for h in ends):
            return velocity
    return best


def cannot_pass(joint: Sequence[Gap], first: int, last: int, low: Row, high: Row) -> bool:
    """Return whether a joint cannot pass the gaps from `first` to before `last` with durations in a box."""
    lo, hi = -joint[first].V, joint[first].W
    if first == 0:
        lo, hi = lo * BOUNDARY, hi * BOUNDARY
    for g, gap in enumerate(joint[first:last], first):
        if gap.W * high[g] < gap.near or -gap.V * high[g] > gap.far:
            return True
        if isinstance(gap.A, float) or isinstance(gap.B, float):  # unlimited
            lo, hi = -gap.V, gap.W
            continue
        lo, hi, ends = max(lo, -gap.V), min(hi, gap.W), (low[g], high[g])
        if lo > hi:
            return True
        top = highest(gap.far, lo, hi, ends, gap.V, gap.W, gap.A, gap.B)
        bottom = highest(-gap.near, -hi, -lo, ends, gap.W, gap.V, gap.B, gap.A)
        if top is None or bottom is None or -bottom > top:
            return True
        lo, hi = -bottom, top
    return last == len(joint) and (lo > BOUNDARY * joint[-1].W or hi < -BOUNDARY * joint[-1].V)


def chain(task: Task, total: Fraction) -> list[list[Gap]]:
    """Return what each joint may do in each gap in motions of this duration, limits and waypoints widened."""
    joints = []
    for j in range(task.n):
        accelerations = [task.limit("acceleration", g, j) for g in range(task.gaps)]
        # from rest to rest no velocity is above acceleration times duration
        reach = 2 * max(max(map(abs, pair)) for pair in accelerations) * total
        row: list[Gap] = []
        for g, (braking, speeding) in enumerate(accelerations):
            V, W = (min(abs(side), reach) for side in task.limit("velocity", g, j))
            A, B = (side if isinstance(side, float) else side * (1 + RATIO) for side in (speeding, -braking))
            if isinstance(V, float) or isinstance(W, float) or A == 0 or B == 0:
                row = []
                break
            slack = task.tolerance[g][j] + task.tolerance[g + 1][j] + 2 * WAYPOINT
            way = task.waypoints[g + 1][j] - task.waypoints[g][j]
            row.append(Gap(V * (1 + RATIO), W * (1 + RATIO), A, B, way - slack, way + slack))
        joints.append(row)
    return joints


# The 3-5-3 family through four waypoints: cubics at both ends, a quintic between, at rest with zero acceleration at
# the ends. A derivative at a chosen instant is a sum of weight h1^a h2^b h3^c; one that is beyond its limit all over a
# box of durations refutes the box.

_HERMITE = (  # coefficients of way, v0, v1, 2 a0, 2 a1 in the quintic, durations taken out
    (0, 0, 0, 10, -15, 6), (0, 1, 0, -6, 8, -3), (0, 0, 0, -4, 7, -3), (0, 0, 1, -3, 3, -1), (0, 0, 0, 1, -2, 1)
)  # fmt: skip
Monomial: TypeAlias = tuple[Fraction, int, tuple[int, int, int]]
"""Weight per unit of way, the gap of that way, and powers of the three durations."""


def monomials(piece: int, order: int, u: Fraction) -> list[Monomial]:
    """Return the derivative (1 velocity, 2 acceleration) at the fraction u of a piece as a sum of monomials."""
    if piece == 0:  # way (t / h1)^3
        return [(3 * u * u if order == 1 else 6 * u, 0, (-order, 0, 0))]
    if piece == 2:
        r = 1 - u
        return [(3 * r * r if order == 1 else -6 * r, 2, (0, 0, -order))]
    rows = [[Fraction(x) for x in row] for row in _HERMITE]
    for _ in range(order):
        rows = [derivative(row) for row in rows]
    way, v0, v1, a0, a1 = (polynomial_value(row, u) for row in rows)
    ends = [(3 * v0, 0, (-1, 1 - order, 0)), (3 * v1, 2, (0, 1 - order, -1))]
    return [(way, 1, (0, -order, 0)), *ends, (3 * a0, 0, (-2, 2 - order, 0)), (-3 * a1, 2, (0, 2 - order, -2))]


def power_product(h: Row, powers: Sequence[int]) -> Fraction:
    """Return h1^a h2^b h3^c."""
    return h[0] ** powers[0] * h[1] ** powers[1] * h[2] ** powers[2]


def term_range(weight: Fraction, powers: Sequence[int], low: Row, high: Row) -> list[Fraction]:
    """Return least and largest value of weight times monomial on a box: it is monotone in each duration."""
    least = [a if power > 0 else b for a, b, power in zip(low, high, powers)]
    most = [b if power > 0 else a for a, b, power in zip(low, high, powers)]
    return sorted((weight * power_product(least, powers), weight * power_product(most, powers)))


def is_beyond(
    task: Task, joint: int, order: int, piece: int, u: Fraction, low: Row, high: Row, total: Fraction
) -> bool:
    """Return whether a derivative at an instant is beyond its limit all over a box cut by the plane sum h = total.

    The natural interval, and the mean-value form: f(h) = f(c) + sum slope_g (h_g - c_g); with sum h = total, a common
    number may be taken off the slopes if common (total - sum c) is added.
    """
    if min(low) <= 0:
        return False
    terms, blur = [], Fraction(0)  # what waypoints missed within tolerance can change
    for weight, gap, powers in monomials(piece, order, u):
        slack = task.tolerance[gap][joint] + task.tolerance[gap + 1][joint] + 2 * WAYPOINT
        blur += slack * term_range(abs(weight), powers, low, high)[1]
        terms.append((weight * (task.waypoints[gap + 1][joint] - task.waypoints[gap][joint]), powers))
    lower, upper = widened(ORDERS[order], *task.limit(ORDERS[order], piece, joint))
    ranges = [term_range(weight, powers, low, high) for weight, powers in terms]
    if sum(a for a, _ in ranges) - blur > upper or sum(b for _, b in ranges) + blur < lower:
        return True
    centre = [(a + b) / 2 for a, b in zip(low, high)]
    value = sum(weight * power_product(centre, powers) for weight, powers in terms)
    slopes = []
    for g in range(3):
        lowered = [(weight * p[g], [power - (k == g) for k, power in enumerate(p)]) for weight, p in terms]
        slopes.append([sum(side) for side in zip(*(term_range(*term, low, high) for term in lowered))])
    common = Fraction(round(sum(a + b for a, b in slopes) / 6 * 1024), 1024)
    value += common * (total - sum(centre))
    spread = sum(max(abs(a - common), abs(b - common)) * (y - x) / 2 for (a, b), x, y in zip(slopes, low, high))
    return bool(value - spread - blur > upper or value + spread + blur < lower)


# The tree.


@dataclass(frozen=True)
class Search:
    """What refutes boxes: the task, the duration, joints, whether only the family is meant, and proved lemmas."""

    task: Task
    total: Fraction
    joints: list[list[Gap]]
    family: bool
    lemmas: list[tuple[int, int, Fraction]] = field(default_factory=list)

    def replay(self, nodes: Any, first: int, last: int, total: Fraction) -> None:
        """Refute all durations of the gaps from `first` to before `last` that sum to `total`.

        The nodes come depth first: ["split", gap, duration] has the shorter durations first; all others are leaves.
        """
        stack = [([Fraction(0)] * self.task.gaps, [total] * self.task.gaps)]
        for count, node in enumerate(nodes if isinstance(nodes, list) else [None], 1):
            where = f"node {count} of the tree"
            if not isinstance(node, list) or not node:
                raise NotAProof(f"{where}: expected a list that is not empty")
            if not stack:
                raise Refused("the tree has nodes left over")
            low, high = stack.pop()
            if not cut(low, high, first, last, total):
                if node != ["empty"]:
                    raise Refused(f"{where}: its durations are empty")
            elif node[0] == "split":
                gap, place = _entries(node, where, 1, True)
                if not first <= gap < last or not low[gap] < place < high[gap]:
                    raise Refused(f"{where} does not split its durations")
                stack.append((replaced(low, gap, place), list(high)))
                stack.append((list(low), replaced(high, gap, place)))
            elif not self._refutes(node, where, low, high, first, last):
                raise Refused(f"{where} does not refute its durations")
        if stack:
            raise Refused("the tree ends before all durations are refuted")

    def _refutes(self, node: list[Any], where: str, low: Row, high: Row, first: int, last: int) -> bool:
        if node == ["empty"]:  # but some durations are left
            return False
        if node[0] == "joint":  # a joint cannot pass a run of gaps
            joint, begin, end = _entries(node, where, 3, False)
            known = joint < self.task.n and first <= begin <= end < last and bool(self.joints[joint])
            return known and cannot_pass(self.joints[joint], begin, end + 1, low, high)
        if node[0] == "lemma":  # a run of gaps takes longer
            (index,) = _entries(node, where, 1, False)
            begin, end, needed = self.lemmas[index] if index < len(self.lemmas) else (-1, 0, 0)
            return first <= begin and end <= last and sum(high[begin:end]) < needed
        if node[0] == "sum":  # lemmas times weights, no gap weighing more than 1 in all, take longer than the total
            weights = array(node[1] if len(node) == 2 else None, where, len(self.lemmas))
            covered = [Fraction(0)] * self.task.gaps
            for (begin, end, _), weight in zip(self.lemmas, weights):
                covered[begin:end] = [x + weight for x in covered[begin:end]]
            whole = (first, last) == (0, self.task.gaps) and min(weights) >= 0 and max(covered) <= 1
            return whole and sum(w * needed for w, (_, _, needed) in zip(weights, self.lemmas)) > self.total
        if node[0] == "instant" and self.family:  # a derivative is beyond its limit
            joint, order, piece, u = _entries(node, where, 3, True)
            known = joint < self.task.n and order < 2 and piece < 3 and 0 <= u <= 1 and (first, last) == (0, 3)
            return known and is_beyond(self.task, joint, order + 1, piece, u, low, high, self.total)
        raise NotAProof(f"{where}: {ascii(node[0])[:40]} is no kind of node here")


def _entries(node: list[Any], where: str, whole: int, exact: bool) -> list[Any]:
    """Return a node's whole numbers, counted from 0, and its last entry as an exact number."""
    if len(node) != 1 + whole + exact or any(type(x) is not int or x < 1 for x in node[1 : 1 + whole]):
        raise NotAProof(f"{where}: expected {whole} whole numbers above 0" + " and a float" * exact)
    return [x - 1 for x in node[1 : 1 + whole]] + ([array(node[-1], where)] if exact else [])


def replaced(row: list[Fraction], index: int, value: Fraction) -> list[Fraction]:
    """Return a copy with one entry changed."""
    return [*row[:index], value, *row[index + 1 :]]


def cut(low: list[Fraction], high: list[Fraction], first: int, last: int, total: Fraction) -> bool:
    """Tighten a box to durations that sum to the total, in place; return whether any are left."""
    for g in range(first, last):
        low[g] = max(low[g], total - (sum(high[first:last]) - high[g]))
        high[g] = min(high[g], total - (sum(low[first:last]) - low[g]))
    return all(a <= b for a, b in zip(low[first:last], high[first:last]))


def check_bound(task: Task, total: Fraction, family: bool, evidence: Any) -> None:
    """Check that nothing is shorter than `total`."""
    lemmas, tree = fields(evidence, "evidence", "lemmas", "tree")
    rest = [rows is not None and not any(x for row in rows for x in row) for rows in task.boundary.values()]
    if not rest[0]:
        raise Refused("the ends are not at rest")
    if family and (task.gaps != 3 or not rest[1]):
        raise Refused("the 3-5-3 family is covered through four waypoints with zero accelerations at the ends")
    if total <= 0 or not isinstance(lemmas, list):
        raise NotAProof("expected a claim of a positive duration, and a list of lemmas")
    search = Search(task, total, chain(task, total), family)
    for index, lemma in enumerate(lemmas):
        where = f"evidence.lemmas[{index + 1}]"
        first, last, needed, nodes = fields(lemma, where, "first", "last", "total", "tree")
        if type(first) is not int or type(last) is not int or not 1 <= first <= last <= task.gaps:
            raise NotAProof(f"{where}: expected gaps first <= last from 1 to {task.gaps}")
        least = array(needed, where)
        if not 0 < least <= total:
            raise Refused(f"{where}: its duration is not between 0 and the one to be proved")
        search.replay(nodes, first - 1, last, least)
        search.lemmas.append((first - 1, last, least))
    search.replay(tree, 0, task.gaps, total)


# The whole proof.


def check(document: Any) -> Report:
    """Check a proof, as read from a file; raises NotAProof, or Refused at the first statement that does not hold."""
    keys = ("schema", "kind", "task", "motion", "claim", "evidence")
    schema, kind, section, curve, claim, evidence = fields(document, "the file", *keys)
    if schema != 1 or type(schema) is not int or kind not in ("motion", "bound"):
        raise NotAProof("expected schema 1 and the kind motion or bound")
    task = read_task(section)
    digest = hashlib.sha256(json.dumps(section, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
    if kind == "motion":
        fields(evidence, "evidence")
        statement = _check_motion_claim(task, read_motion(curve, task), claim)
    else:
        duration, of = fields(claim, "claim", "duration", "of")
        if curve is not None or of not in ("every motion", "3-5-3"):
            raise NotAProof("expected motion null, and a claim of every motion or of 3-5-3")
        total = array(duration, "claim.duration")
        check_bound(task, total, of == "3-5-3", evidence)
        what = "no motion" if of == "every motion" else "no 3-5-3 curve"
        statement = f"{what} through the waypoints within the velocity and acceleration limits takes less than"
        statement += f" {float(total):.9g} s"
    return Report(kind, f"{statement} (task {ascii(task.name)[1:-1]}, SHA-256 {digest})", digest)


def _check_motion_claim(task: Task, motion: Motion, claim: Any) -> str:
    duration, table = fields(claim, "claim", "duration", "costs")
    claimed = array(duration, "claim.duration")
    costs = {k: array(x, f"claim.costs.{k}") for k, x in zip(task.weights, fields(table, "claim.costs", *task.weights))}
    length = motion.times[-1] - motion.times[0]
    if not length <= claimed <= length * (1 + Fraction(1, 2**48)):
        raise Refused(f"the duration is {float(length):.17g} s, not {float(claimed):.17g} s rounded up")
    for name, cost in check_motion(task, motion).items():
        if cost > costs[name]:
            raise Refused(f"{name} may be {float(cost):.12g}, more than the {float(costs[name]):.12g} of the claim")
    listed = [f"{name} <= {float(costs[name]):.9g}" for name in costs if name != "time"]
    return ", ".join([f"every limit is kept at every instant of {float(length):.9g} s", *listed])


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(dict(pairs)) < len(pairs):
        raise NotAProof(f"a key is there twice among {', '.join(ascii(key)[:40] for key, _ in pairs[:20])}")
    return dict(pairs)


def _no_number(given: str) -> Any:
    raise NotAProof(f"{given[:40]}: expected whole numbers, and floats as hexadecimal strings")


def check_file(path: str) -> Report:
    """Check a proof file; see `check`."""
    try:
        with open(path, "rb") as stream:
            data = stream.read(LARGEST_FILE + 1)
        if len(data) > LARGEST_FILE:
            raise NotAProof(f"the file has more than {LARGEST_FILE} bytes")
        hooks: dict[str, Any] = {"parse_float": _no_number, "parse_constant": _no_number}
        document = json.loads(data.decode("utf-8"), object_pairs_hook=_unique, **hooks)
    except OSError as error:
        raise NotAProof(f"the file cannot be read ({error.strerror or error})") from None
    except (ValueError, RecursionError) as error:
        raise NotAProof(f"the file is no JSON ({str(error)[:200]})") from None
    try:
        return check(document)
    except (OverflowError, RecursionError):
        raise Refused("the numbers are too large to be computed with") from None


def main(arguments: list[str]) -> int:
    """Check the file named on the command line; return the exit status."""
    if len(arguments) != 1:
        print("usage: python checker.py FILE")
        return 2
    try:
        print(f"proved: {check_file(arguments[0]).statement}")
    except Refused as reason:
        print(f"refused: {reason}")
        return 1
    except NotAProof as reason:
        print(f"no proof: {reason}")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
