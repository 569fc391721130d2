"""Check a proof about a robot motion. One file, Python's standard library only, nothing else of this package.

``python checker.py FILE`` prints ``proved: ...`` and exits with 0, or prints the first statement that does not hold and
exits with 1; 2 for a file that is no proof. There are two kinds of proofs:

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
from collections import namedtuple
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache, reduce
from types import SimpleNamespace
from typing import Any, TypeAlias

RATIO = Fraction(1, 10**6)  # of a limit by which it may be exceeded; of the range for positions
WAYPOINT = Fraction(1, 10**8)  # rad or m by which a waypoint's box may be missed
BOUNDARY = Fraction(1, 10**8)  # of the limit by which a derivative at an end may be missed
DURATION = Fraction(1, 10**9)  # of a bound of a duration by which it may be missed
JUMPS = (Fraction(1, 10**10), Fraction(1, 10**9), Fraction(1, 10**7))  # of a joint in all: rad (m); of limits of v, a
ORDERS = ("position", "velocity", "acceleration", "jerk")
LIMITS = (*ORDERS, "torque", "torque_rate")
EXACT_COSTS = {"acceleration": 2, "jerk": 3}  # integrals of squares of these derivatives
SQUARED_COSTS = ("torque", "motor_loss")
POWER_COSTS = ("energy", "energy_without_regeneration")
COSTS = ("time", *EXACT_COSTS, *SQUARED_COSTS, *POWER_COSTS)
LARGEST_FILE = 64 * 2**20  # bytes
LARGEST_DEGREE, LARGEST_ANGLE = 30, 1000.0  # of polynomials; rad
DEGREES = {"torque": 12, "torque_rate": 16}  # of interpolants; a bound of slopes needs more than one of values
RADIUS = 4.0  # of the contour around [-1, 1]
FINE = 2**96  # denominator to which interpolation is rounded
ROUNDINGS = 2.0**-42  # relative, above all roundings of sums, products and halvings of Bernstein coefficients here
UNIT = 2.0**-52  # twice the relative rounding error of one operation
UP = 1.0 + 2.0**-48  # covers the roundings of the few operations that compute a radius
TINY = 1e-300  # covers underflow


class NotAProof(Exception):
    """The file does not have the form of a proof."""


class Refused(Exception):
    """A statement of the proof does not hold, or cannot be shown by this program."""


Report = namedtuple("Report", "kind statement digest")
Report.__doc__ = "What was proved: the kind, one sentence, and the SHA-256 of the task that the sentence is about."

# Reading. Every key has to be known and there once, every list has to have the right length.

Row: TypeAlias = Sequence[Any]  # of Fractions, or of Balls: a vector


def fields(value: Any, where: str, *keys: str) -> list[Any]:
    """Return the values of an object that has exactly these keys."""
    if not isinstance(value, dict) or set(value) != set(keys):
        raise NotAProof(f"{where}: expected an object with the keys {', '.join(keys) or '(none)'}")
    return [value[key] for key in keys]


def array(value: Any, where: str, *shape: int | None, infinite: bool = False, kind: Any = Fraction) -> Any:
    """Return nested lists of exact numbers, given as hexadecimal floats; None in the shape is any length above 0."""
    if not shape:
        if infinite and value in ("inf", "-inf"):
            return float(value)
        if not isinstance(value, str) or not re.fullmatch(r"-?0x[01](\.[0-9a-f]{1,13})?p[+-][0-9]{1,4}", value):
            raise NotAProof(f"{where}: {ascii(value)[:40]} is not a float in hexadecimal, such as 0x1.8p+1")
        try:
            return kind(float.fromhex(value))
        except OverflowError:
            raise NotAProof(f"{where}: {value} is too large for a float") from None
    if not isinstance(value, list) or not value or len(value) != (shape[0] or len(value)):
        raise NotAProof(f"{where}: expected a list of {shape[0] or 'one or more'}")
    return [array(x, f"{where}[{k}]", *shape[1:], infinite=infinite, kind=kind) for k, x in enumerate(value, 1)]


class Task:
    """What a motion has to do: n joints, waypoints and the gaps between them; limits[name][gap][side][joint]."""

    def __init__(self, value: Any) -> None:
        keys = ("name", "waypoints", "tolerance", "limits", "boundary", "duration", "gap_durations", "weights")
        entries = fields(value, "task", *keys, "loss_factors", "robot")
        name, points, tolerance, limits, boundary, duration, gap_durations, weights, losses, robot = entries
        self.name, self.waypoints = name, array(points, "task.waypoints", None, None)
        n, gaps = self.n, self.gaps = len(self.waypoints[0]), len(self.waypoints) - 1
        if not isinstance(name, str) or len(name) > 1000 or gaps < 1 or any(len(row) != n for row in self.waypoints):
            raise NotAProof("task: expected a name of up to 1000 letters, two or more waypoints of equal length")
        for key, table, known in (("limits", limits, LIMITS), ("weights", weights, COSTS)):
            if not isinstance(table, dict) or not set(table) <= set(known):
                raise NotAProof(f"task.{key}: expected an object with keys of {', '.join(known)}")
        ends = zip(ORDERS[1:], fields(boundary, "task.boundary", *ORDERS[1:]))
        self.tolerance = array(tolerance, "task.tolerance", gaps + 1, n)
        self.limits = {k: array(x, f"task.limits.{k}", gaps, 2, n, infinite=True) for k, x in limits.items()}
        self.boundary = {k: None if x is None else array(x, f"task.boundary.{k}", 2, n) for k, x in ends}
        self.duration = array(duration, "task.duration", 2, infinite=True)
        self.gap_durations = array(gap_durations, "task.gap_durations", gaps, 2, infinite=True)
        self.weights = {k: array(weights[k], f"task.weights.{k}") for k in COSTS if k in weights}
        self.loss_factors = None if losses is None else array(losses, "task.loss_factors", n)
        self.robot: Any = None if robot is None else read_robot(robot, n)
        if min(*map(min, self.tolerance), *(self.loss_factors or [0])) < 0 or min([1, *self.weights.values()]) <= 0:
            raise NotAProof("task: tolerances and loss factors must not be negative, weights must be positive")
        for key, rows in self.limits.items():
            for low, up in ((low, up) for lower, upper in rows for low, up in zip(lower, upper)):
                if low > up or low == math.inf or up == -math.inf or (key != "position" and not low <= 0 <= up):
                    raise NotAProof(f"task.limits.{key}: a lower limit is above the upper one, or 0 is excluded")
        dynamic = {"torque_rate", *SQUARED_COSTS, *POWER_COSTS} & {*limits, *weights}
        if (dynamic and robot is None) or ("motor_loss" in weights and losses is None):
            raise NotAProof("task: torques or motor losses are limited or weighted, but robot or loss_factors is null")

    def limit(self, name: str, gap: int, joint: int) -> tuple[Any, Any]:
        """Return lower and upper limit, infinite where there is none."""
        lower, upper = self.limits[name][gap] if name in self.limits else ([-math.inf] * self.n, [math.inf] * self.n)
        return lower[joint], upper[joint]

    def scale(self, name: str, gaps: Sequence[int], joint: int) -> Any:
        """Return the smallest finite positive limit in some gaps, None if there is none."""
        sides = (abs(side) for gap in gaps for side in self.limit(name, gap, joint))
        return min((side for side in sides if 0 < side < math.inf), default=None)


def read_robot(value: Any, n: int) -> Any:
    """Read links from the root to the tips, gravity in root axes and friction; `carried` says what the numbers mean."""
    links, *rows = fields(value, "task.robot", "links", "gravity", "viscous", "coulomb")
    if not isinstance(links, list) or len(links) != n:
        raise NotAProof(f"task.robot.links: expected a list of {n}")
    shapes = {"rotation": (3, 3), "translation": (3,), "mass": (), "first": (3,), "second": (3, 3), "armature": ()}
    found = []
    for index, link in enumerate(links):
        where = f"task.robot.links[{index + 1}]"
        parent, prismatic, *numbers = fields(link, where, "parent", "prismatic", *shapes)
        if type(parent) is not int or not 0 <= parent <= index or type(prismatic) is not bool:
            raise NotAProof(f"{where}: expected a parent from 0 (the root) to {index}, and true or false")
        read = {key: array(x, f"{where}.{key}", *shapes[key], kind=Ball) for key, x in zip(shapes, numbers)}
        found.append(SimpleNamespace(parent=parent, prismatic=prismatic, **read))
    gravity, viscous, coulomb = (array(row, "task.robot", size, kind=Ball) for row, size in zip(rows, (3, n, n)))
    if min(x.c for x in viscous + coulomb) < 0:
        raise NotAProof("task.robot: friction must not be negative")
    return SimpleNamespace(links=found, gravity=gravity, viscous=viscous, coulomb=[x.c for x in coulomb])


# Polynomials: lists of coefficients in ascending powers, exact; or Bernstein coefficients b, exact or in floats.


def polynomial_value(c: Sequence[Any], t: Any) -> Any:
    """Return the value at t (Horner), of numbers or balls."""
    return reduce(lambda total, coefficient: total * t + coefficient, reversed(c))


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


def shifted(c: Row, start: Fraction, unit: Fraction) -> list[Fraction]:
    """Return the coefficients in powers of u, where t = start + unit u."""
    terms = ([c[j] * math.comb(j, i) * start ** (j - i) for j in range(i, len(c))] for i in range(len(c)))
    return [sum(row, Fraction(0)) * unit**i for i, row in enumerate(terms)]


def bernstein(c: Row, begin: Fraction, end: Fraction) -> list[Fraction]:
    """Return the Bernstein coefficients on [begin, end]: the polynomial lies between the least and the largest."""
    d, scaled = len(c) - 1, shifted(c, begin, end - begin)
    terms = ([Fraction(math.comb(j, i), math.comb(d, i)) * scaled[i] for i in range(j + 1)] for j in range(d + 1))
    return [sum(row, Fraction(0)) for row in terms]


def halves(b: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """Return the Bernstein coefficients on both halves (de Casteljau)."""
    left, right, row = [b[0]], [b[-1]], list(b)
    while len(row) > 1:
        row = [(x + y) / 2 for x, y in zip(row, row[1:])]
        left.append(row[0])
        right.append(row[-1])
    return left, right[::-1]


def lies_within(b: Row, lower: Any, upper: Any, deepest: int) -> bool:
    """Return whether lower <= polynomial <= upper is shown, halving until the coefficients lie there."""
    if max(b) <= upper and min(b) >= lower:
        return True
    if deepest == 0 or not (lower <= b[0] <= upper and lower <= b[-1] <= upper):
        return False
    return all(lies_within(half, lower, upper, deepest - 1) for half in halves(b))


def largest_magnitude(b: Row, depth: int = 6) -> Any:
    """Return an upper bound of |polynomial|."""
    return max(largest_magnitude(half, depth - 1) for half in halves(b)) if depth else max(map(abs, b))


def mean_magnitude(b: Sequence[float], depth: int = 16) -> float:
    """Return an upper bound of the mean of |polynomial|."""
    if depth == 0 or min(b) >= 0 or max(b) <= 0:
        return sum(map(abs, b)) / len(b)
    return sum(mean_magnitude(half, depth - 1) for half in halves(b)) / 2


def bernstein_product(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """Return the product of two polynomials given by Bernstein coefficients."""
    m, d = len(a) - 1, len(b) - 1
    raw = product([math.comb(m, i) * x for i, x in enumerate(a)], [math.comb(d, j) * y for j, y in enumerate(b)])
    return [x / math.comb(m + d, k) for k, x in enumerate(raw)]


class Motion:
    """A piecewise polynomial; `orders[k][piece][joint]` are the coefficients of the k-th derivative."""

    def __init__(self, value: Any, task: Task) -> None:
        keys = ("schema", "case", "family", "waypoint_times", "breakpoints", "coefficients")
        schema, case, family, passing, times, curve = fields(value, "motion", *keys)
        self.times = times = array(times, "motion.breakpoints", None)
        passing = array(passing, "motion.waypoint_times", task.gaps + 1)
        curve = array(curve, "motion.coefficients", len(times) - 1 or None, task.n, None)
        sizes = {len(c) for piece in curve for c in piece}
        form = (type(schema), schema, type(case), type(family))
        if form != (int, 1, str, str) or len(times) < 2 or len(sizes) > 1 or max(sizes) > LARGEST_DEGREE + 1:
            raise NotAProof(f"motion: expected schema 1, two texts, pieces all of one degree up to {LARGEST_DEGREE}")
        if any(a >= b for a, b in zip(times, times[1:])):
            raise Refused("the breakpoints do not increase")
        if sorted(passing) != passing or not {times[0], times[-1]} <= set(passing) <= set(times):
            raise Refused("the waypoint times are not breakpoints in ascending order, from the first to the last")
        self.lengths = [b - a for a, b in zip(times, times[1:])]
        self.marks = [times.index(t) for t in passing]  # every waypoint time has to be a breakpoint
        self.gaps = [gap for gap, (a, b) in enumerate(zip(self.marks, self.marks[1:])) for _ in range(b - a)]
        self.orders = [curve]
        for _ in ORDERS[1:]:
            self.orders.append([[derivative(c) for c in piece] for piece in self.orders[-1]])

    def ends(self, order: int, joint: int) -> list[tuple[Fraction, Fraction]]:
        """Return the values of a derivative at both ends of each piece."""
        rows = (joints[joint] for joints in self.orders[order])
        return [(c[0], polynomial_value(c, h)) for c, h in zip(rows, self.lengths)]

    def largest(self, order: int) -> Fraction:
        """Return a value that some joint's derivative reaches somewhere: the largest of five instants of each piece."""
        pieces = zip(self.lengths, self.orders[order])
        return max(abs(polynomial_value(c, h * k / 4)) for h, joints in pieces for c in joints for k in range(5))


def widened(name: str, lower: Any, upper: Any) -> tuple[Any, Any]:
    """Return what a motion may reach; positions with one limit have the slack of waypoints."""
    if name == "position":
        slack = RATIO * (upper - lower) if upper - lower < math.inf else WAYPOINT
        return lower - slack, upper + slack
    return lower * (1 + RATIO), upper * (1 + RATIO)


def check_kinematics(task: Task, motion: Motion) -> None:
    """Check durations, waypoints, ends, joins and the limits of position, velocity, acceleration and jerk."""
    passing = [motion.times[k] for k in motion.marks]
    lengths = [passing[-1] - passing[0], *(b - a for a, b in zip(passing, passing[1:]))]
    for g, (length, (least, most)) in enumerate(zip(lengths, [task.duration, *task.gap_durations])):
        if length < least * (1 - DURATION) or length > most * (1 + DURATION):
            what = f"gap {g}" if g else "the motion"
            raise Refused(f"the duration of {what}, {float(length):.9g} s, is out of its bounds")
    for joint in range(task.n):
        check_points(task, motion, joint)
    for order, name in ((order, name) for order, name in enumerate(ORDERS) if name in task.limits):
        for piece, gap in enumerate(motion.gaps):
            for joint, c in enumerate(motion.orders[order][piece]):
                bounds = widened(name, *task.limit(name, gap, joint))
                if not lies_within(bernstein(c, Fraction(0), motion.lengths[piece]), *bounds, deepest=60):
                    between = f"{float(motion.times[piece]):.6g} and {float(motion.times[piece + 1]):.6g} s"
                    raise Refused(f"{name} of joint {joint + 1} is beyond its limit, or on it, between {between}")


def check_points(task: Task, motion: Motion, joint: int) -> None:
    """Check a joint's waypoints, ends, and the sums of its jumps; of acceleration where its jumps matter."""
    q = motion.ends(0, joint)
    for waypoint, mark in enumerate(motion.marks):
        sides = [start for start, _ in q[mark : mark + 1]] + [end for _, end in q[max(mark - 1, 0) : mark]]
        box = task.tolerance[waypoint][joint] + WAYPOINT
        if any(abs(side - task.waypoints[waypoint][joint]) > box for side in sides):
            raise Refused(f"waypoint {waypoint + 1} is missed by joint {joint + 1}")
    for order, name in enumerate(ORDERS[1:], 1):
        found = motion.ends(order, joint)
        ends = (found[0][0], found[-1][1])
        for wanted, end, gap, side in zip(task.boundary[name] or (), ends, (0, task.gaps - 1), ("start", "end")):
            miss = abs(end - wanted[joint])
            if miss and miss > BOUNDARY * (task.scale(name, [gap], joint) or motion.largest(order)):
                raise Refused(f"{name} of joint {joint + 1} at the {side} is {float(end):.9g}, not as asked")
    for order in range(3 if {"jerk", "torque_rate"} & {*task.limits, *task.weights} else 2):
        found, total = motion.ends(order, joint), Fraction(0)
        for k, jump in enumerate(abs(after[0] - before[1]) for before, after in zip(found, found[1:])):
            unit = task.scale(ORDERS[order], motion.gaps[k : k + 2], joint) if order else Fraction(1)
            total += jump / (unit or motion.largest(order)) if jump else 0
        if total > JUMPS[order]:
            what = f"the jumps of joint {joint + 1} in {ORDERS[order]} add up to {float(total):.3g}"
            raise Refused(f"{what}, allowed {float(JUMPS[order]):g}")


class Ball:
    """All complex numbers within e of the float c; every operation encloses all results of its operands.

    The radius serves two ends: rounding errors at a real argument, and the values on a whole disc of arguments.
    """

    __slots__ = ("c", "e")

    def __init__(self, c: float, e: float = 0.0) -> None:
        self.c = c
        self.e = e

    def __add__(self, other: Ball) -> Ball:
        c = self.c + other.c
        return Ball(c, (self.e + other.e + abs(c) * UNIT) * UP)

    def __sub__(self, other: Ball) -> Ball:
        return self + Ball(-other.c, other.e)

    def __mul__(self, other: Ball) -> Ball:
        c = self.c * other.c
        spread = abs(self.c) * other.e + abs(other.c) * self.e + self.e * other.e
        return Ball(c, (spread + abs(c) * UNIT + TINY) * UP)


ZERO = Ball(0.0)


@lru_cache(maxsize=20_000)
def fixed_sine_cosine(x: float) -> tuple[float, float, float]:
    """Return sine and cosine of a float, and a bound of the error of both: Taylor's series in integers, without pi.

    Each of k terms x^k / k! has errors of 2 units and of 1 unit times the term before (x was rounded), which grow by at
    most the largest term; what is left out is less than twice the last term.
    """
    if not abs(x) <= LARGEST_ANGLE:
        raise Refused(f"an angle of {x:g} rad is beyond {LARGEST_ANGLE:g} rad")
    bits = 120 + 3 * int(abs(x))
    numerator, denominator = abs(x).as_integer_ratio()
    z = (numerator << bits) // denominator
    sums, term, largest, k = [0, 0], 1 << bits, 1 << bits, 0
    while term or k <= 2 * abs(x):  # afterwards each term is less than half of the one before
        sums[k % 2] += -term if k % 4 > 1 else term
        k += 1
        term = ((term * z) >> bits) // k
        largest = max(largest, term)
    cosine, sine = (total / (1 << bits) for total in sums)
    error = 8 * (k + 4) ** 2 * ((largest >> bits) + 1) / (1 << bits) + UNIT
    return math.copysign(sine, x * sine), cosine, error


def sine_cosine(ball: Ball) -> tuple[Ball, Ball]:
    """Return balls around sine and cosine: |sin(c+d) - sin c| <= |cos c| sinh e + |sin c| (cosh e - 1), |d| <= e."""
    e = ball.e
    if not (e < 1.2 and abs(ball.c) < math.inf):
        return Ball(0.0, math.inf), Ball(0.0, math.inf)
    s, c, own = fixed_sine_cosine(ball.c)
    cosh = 1.0 / (1.0 - 0.5 * e * e) * UP  # an upper bound
    sinh = e * (1.0 + e * e / 6.0 * cosh) * UP
    rest = 0.5 * e * e * cosh * UP
    spread = 3.0 * own * (1.0 + sinh + rest)
    sine = Ball(s, (abs(c) * sinh + abs(s) * rest + spread) * UP)
    return sine, Ball(c, (abs(s) * sinh + abs(c) * rest + spread) * UP)


def combine(a: Row, b: Row) -> Ball:
    """Return the scalar product; exact zeros are left out."""
    return sum((x * y for x, y in zip(a, b) if (x.c or x.e) and (y.c or y.e)), ZERO)


def rotated(matrix: Sequence[Row], vector: Row) -> list[Ball]:
    """Return matrix times vector."""
    return [combine(row, vector) for row in matrix]


def added(a: Row, b: Row) -> list[Ball]:
    """Return the sum of vectors."""
    return [x + y for x, y in zip(a, b)]


def cross(a: Row, b: Row) -> list[Ball]:
    """Return the vector product."""
    return [a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))]


def carried(link: Any, parent: Any, q: Ball, v: Ball, a: Ball) -> Any:
    """Return how a parent carries a link about (along) its z axis, and the force and moment that the link needs.

    S = [dw]x + [w]x[w]x gives every point r of a body the acceleration b + S r (w angular velocity, dw its
    derivative, b the acceleration of the link's origin minus gravity). With mass m, first moment m c and second
    moment E about the origin, the body needs the force m b + S m c and the moment m c x b + axial part of S E.
    """
    axes, origin = link.rotation, link.translation  # in the parent's axes
    if link.prismatic:
        origin = added(origin, [row[2] * q for row in axes])
    else:
        sine, cosine = sine_cosine(q)
        axes = [[combine((x, y), (cosine, sine)), combine((x, y), (ZERO - sine, cosine)), z] for x, y, z in axes]
    back = list(zip(*axes))
    w, dw = rotated(back, parent.w), rotated(back, parent.dw)
    base = rotated(back, added(parent.base, rotated(parent.point, origin)))
    if link.prismatic:
        twice = v + v
        base = [base[0] + twice * w[1], base[1] - twice * w[0], base[2] + a]
    else:
        dw = [dw[0] + w[1] * v, dw[1] - w[0] * v, dw[2] + a]
        w = [w[0], w[1], w[2] + v]
    xx, yy, zz, xy, xz, yz = w[0] * w[0], w[1] * w[1], w[2] * w[2], w[0] * w[1], w[0] * w[2], w[1] * w[2]
    point = [
        [ZERO - (yy + zz), xy - dw[2], xz + dw[1]],
        [xy + dw[2], ZERO - (xx + zz), yz - dw[0]],
        [xz - dw[1], yz + dw[0], ZERO - (xx + yy)],
    ]
    SE = [[combine(column, row) for column in zip(*link.second)] for row in point]
    axial = [SE[2][1] - SE[1][2], SE[0][2] - SE[2][0], SE[1][0] - SE[0][1]]
    force = [link.mass * b + combine(link.first, row) for b, row in zip(base, point)]
    moment = added(axial, cross(link.first, base))
    return SimpleNamespace(axes=axes, origin=origin, w=w, dw=dw, base=base, point=point, force=force, moment=moment)


def joint_torques(robot: Any, q: Row, v: Row, a: Row) -> list[Ball]:
    """Return the torques (forces) of all joints, without Coulomb friction, by Newton's and Euler's equations."""
    still = [ZERO] * 3
    root = {"w": still, "dw": still, "base": [ZERO - g for g in robot.gravity], "point": [still] * 3}
    bodies = [SimpleNamespace(**root, force=still, moment=still)]
    for link, *state in zip(robot.links, q, v, a):
        bodies.append(carried(link, bodies[link.parent], *state))
    torques = []
    for i in reversed(range(len(q))):
        link, body, parent = robot.links[i], bodies[i + 1], bodies[robot.links[i].parent]
        along = (body.force if link.prismatic else body.moment)[2]
        torques.append(link.armature * a[i] + robot.viscous[i] * v[i] + along)
        force = rotated(body.axes, body.force)
        moment = added(rotated(body.axes, body.moment), cross(body.origin, force))
        parent.force, parent.moment = added(parent.force, force), added(parent.moment, moment)
    return torques[::-1]


class Nodes:
    """Interpolation at symmetric nodes x_k, and the constants of its error.

    With w(u) = prod (u - x_k) and |f - f0| <= M on the circle |u| = R, for any constant f0, the interpolant p has
    |f - p| <= M R / least |w| max |w| / (R - 1) and |f' - p'| <= M R / least |w| (max |w'| / (R - 1) + max |w| /
    (R - 1)^2) on [-1, 1]; least |w| on the circle is at least the product of R^2 - x_k^2 over the pairs of nodes.
    """

    def __init__(self, degree: int) -> None:
        count, radius = degree + 1, Fraction(RADIUS)
        angles = (math.pi * (2 * k + 1) / (2 * count) for k in range(count // 2))
        right = [Fraction(round(math.cos(angle) * 2**20), 2**20) for angle in angles]
        grid = [*right, *[Fraction(0)] * (count % 2), *(-x for x in reversed(right))]
        w = reduce(product, ([-x, Fraction(1)] for x in grid))
        least = math.prod(radius**2 - x * x if x > 0 else radius for x in grid if x >= 0)
        basis = [reduce(product, ([-y / (x - y), 1 / (x - y)] for y in grid if y != x)) for x in grid]
        ends = Fraction(-1), Fraction(1)
        largest, steepest = (largest_magnitude(bernstein(c, *ends)) for c in (w, derivative(w)))
        self.degree, self.u = degree, [float(x) for x in grid]
        self.value_factor = float(radius / least * largest / (radius - 1)) * UP
        self.slope_factor = float(radius / least * (steepest / (radius - 1) + largest / (radius - 1) ** 2)) * UP
        columns = [bernstein(c, *ends) for c in basis]
        self.rows = [[round(x * FINE) for x in row] for row in zip(*columns)]
        self.amplification = float(sum(map(largest_magnitude, columns))) * UP  # of errors of the values

    def interpolate(self, values: Row) -> tuple[list[float], float]:
        """Return the Bernstein coefficients of the interpolant, and the error that rounding made of it."""
        if not math.isfinite(sum(abs(value.c) + value.e for value in values)):
            return [math.inf], math.inf
        whole = [round(Fraction(value.c) * FINE) for value in values]
        b = [float(Fraction(sum(x * y for x, y in zip(row, whole)), FINE**2)) for row in self.rows]
        error = max(value.e + 2.0**-96 for value in values) * self.amplification
        error += max(abs(value.c) for value in values) * 2.0**-80  # the rows were rounded, too
        return b, (error + UNIT * max(map(abs, b))) * UP


class Dynamics:
    """Checks torques and torque rates of a motion, and adds up upper bounds of costs on the way.

    Coulomb friction has the sign of the velocity; up to BOUNDARY of the limit, a velocity counts as that of the motion
    before or after, and if both are so slow, as rest without friction. Jumps of friction are no torque rate.
    """

    def __init__(self, task: Task, motion: Motion) -> None:
        self.task, self.motion, joints, gaps = task, motion, range(task.n), range(task.gaps)
        self.nodes = Nodes(DEGREES["torque_rate" if "torque_rate" in task.limits else "torque"])
        self.costs = {name: 0.0 for name in (*SQUARED_COSTS, *POWER_COSTS) if name in task.weights}
        self.slow = [float(BOUNDARY * (task.scale("velocity", gaps, j) or motion.largest(1))) for j in joints]
        largest = (max(abs(x) for gap in gaps for x in task.limit("torque", gap, j)) for j in joints)
        squares = [1 / limit**2 if 0 < limit < math.inf else Fraction(1) for limit in largest]
        self.factors = {"torque": squares, "motor_loss": task.loss_factors or []}

    def check(self) -> dict[str, float]:
        """Check all pieces and return upper bounds of the costs, without weights."""
        for piece, length in enumerate(self.motion.lengths):
            stack = [(Fraction(0), length, 0)]
            while stack:
                begin, end, depth = stack.pop()
                if not self._interval(piece, begin, end, depth):
                    if depth == 40:
                        raise Refused(f"torques near {float(self.motion.times[piece] + begin):.9g} s are undecided")
                    middle = (begin + end) / 2
                    stack += [(middle, end, depth + 1), (begin, middle, depth + 1)]
        return {name: cost * (1 + ROUNDINGS) for name, cost in self.costs.items()}

    def torques_at(self, piece: int, middle: Fraction, half: Fraction, places: Row) -> list[list[Ball]]:
        """Return the torques of all joints, without Coulomb friction, at (all complex) u, t = middle + half u."""
        exact = ([shifted(c, middle, half) for c in self.motion.orders[order][piece]] for order in range(3))
        curves = [[[Ball(float(x), abs(float(x)) * UNIT + TINY) for x in c] for c in row] for row in exact]
        states = ([[polynomial_value(c, u) for c in row] for row in curves] for u in places)
        return [joint_torques(self.task.robot, *state) for state in states]

    def _interval(self, piece: int, begin: Fraction, end: Fraction, depth: int) -> bool:
        """Return whether all is shown on an interval; False: halve it."""
        middle, half, gap = (begin + end) / 2, (end - begin) / 2, self.motion.gaps[piece]
        (disc,) = self.torques_at(piece, middle, half, [Ball(0.0, RADIUS)])
        errors = [t.e * self.nodes.value_factor * UP for t in disc]
        rate_errors = [t.e * self.nodes.slope_factor / float(half) * UP * UP for t in disc]
        for name, found in (("torque", errors), ("torque_rate", rate_errors)):
            for joint, error in enumerate(found):
                limit = self.task.scale(name, [gap], joint)
                if limit is None and (name == "torque_rate" or (depth >= 10 and error < math.inf)):
                    continue  # nothing is limited: any error is only paid for
                if not error <= 0.5 * float(RATIO) * float(limit or max(abs(t.c) for t in disc)):
                    return False
        when = f"{float(self.motion.times[piece] + middle):.9g} s"
        values = self.torques_at(piece, middle, half, [Ball(u) for u in self.nodes.u])
        costs = []
        for joint, c in enumerate(self.motion.orders[1][piece]):
            b, rounding = self.nodes.interpolate([row[joint] for row in values])
            if not math.isfinite(rounding):  # comparisons below would overlook a NaN
                return False
            rate = [(y - x) * self.nodes.degree / (2 * float(half)) for x, y in zip(b, b[1:])]
            markov = self.nodes.degree**2 / float(half) * UP * UP  # times an error of p: at most the error of its slope
            rate_error = rate_errors[joint] + rounding * markov
            error = errors[joint] + rounding + ROUNDINGS * max(map(abs, b))
            if not self._keeps("torque_rate", gap, joint, rate, rate_error, when):
                return False
            for part, speed, share in self.with_friction(joint, b, [float(x) for x in bernstein(c, begin, end)]):
                if not self._keeps("torque", gap, joint, part, error, when):
                    return False
                costs.append((joint, part, speed, error, share * 2 * float(half) * UP))
        for entry in costs:  # all is shown
            self._pay(*entry)
        return True

    def with_friction(self, joint: int, b: Row, speed: Row, share: float = 1.0) -> list[tuple[Row, Row, float]]:
        """Return torques with Coulomb friction and velocities, and their shares of time, where the sign is known."""
        coulomb = self.task.robot.coulomb[joint]
        back, forth = min(speed) < -self.slow[joint], max(speed) > self.slow[joint]
        if coulomb and back and forth:
            pairs = zip(halves(b), halves(speed))
            return [entry for pair in pairs for entry in self.with_friction(joint, *pair, share / 2)]
        return [([x + coulomb * (forth - back) for x in b], speed, share)]

    def _keeps(self, name: str, gap: int, joint: int, b: Row, error: float, when: str) -> bool:
        """Return whether a polynomial with an error is shown to keep a limit; refuse it where an end is beyond."""
        low, up = (float(side) * (1.0 + float(RATIO)) for side in self.task.limit(name, gap, joint))
        slack = error * UP + ROUNDINGS * max(map(abs, [*b, *(side for side in (low, up) if abs(side) < math.inf)]))
        if not (low - slack <= min(b[0], b[-1]) and max(b[0], b[-1]) <= up + slack):
            raise Refused(f"{name} of joint {joint + 1} is beyond its limit near {when}")
        return lies_within(b, low + slack, up - slack, deepest=30)

    def _pay(self, joint: int, b: Row, speed: Row, error: float, seconds: float) -> None:
        """Add the upper bounds of a joint's costs on an interval."""
        most = max(map(abs, b))
        wide = error * UP + ROUNDINGS * most
        for name in self.costs:
            if name in SQUARED_COSTS:
                square = bernstein_product(b, b)
                cost = sum(square) / len(square) + wide * (2 * mean_magnitude(b) + wide) + ROUNDINGS * most**2
                cost *= float(self.factors[name][joint])
            else:
                power = bernstein_product(b, speed)
                cost = mean_magnitude(power)
                if name == "energy_without_regeneration":  # of the positive part
                    cost = (cost + sum(power) / len(power)) / 2
                cost += wide * mean_magnitude(speed) + ROUNDINGS * most * max(map(abs, speed))
            self.costs[name] += cost * seconds * (1 + ROUNDINGS)


def check_motion(task: Task, motion: Motion) -> dict[str, Fraction]:
    """Check all limits and return upper bounds of all costs that have a weight."""
    check_kinematics(task, motion)
    costs = {"time": motion.times[-1] - motion.times[0]}
    for name, order in EXACT_COSTS.items():
        pieces = ((h, product(c, c)) for h, row in zip(motion.lengths, motion.orders[order]) for c in row)
        squares = ((h, bernstein(c, Fraction(0), h)) for h, c in pieces)
        costs[name] = sum((h * sum(b) / len(b) for h, b in squares), Fraction(0))
    if task.robot is not None:
        costs |= {name: Fraction(cost) for name, cost in Dynamics(task, motion).check().items()}
    return {name: costs[name] for name in task.weights}


# Bounds: no motion is shorter. A shorter one could be slowed uniformly to last exactly the claimed time T, so all
# durations h of the gaps with sum T are refuted, in a tree of boxes. The interval of velocities that a joint can have
# is pushed through the gaps: starting at v0 >= lo and ending at v1 >= hi with acceleration <= A, deceleration <= B and
# velocity >= -V, a joint covers at least G(h) in a time h, which is concave in h, so the ends of a box are enough.

Gap = namedtuple("Gap", "V W A B near far")
"""What a joint may do in a gap: velocities in [-V, W], accelerations in [-B, A], ways in [near, far]."""


def least_way(h: Any, lo: Any, hi: Any, V: Any, A: Any, B: Any) -> Any:
    """Return G(h): no joint covers less from v0 >= lo to v1 >= hi."""
    if hi - A * h >= lo:  # speeding up all the time
        return hi * h - A * h * h / 2
    if lo - B * h >= hi:  # braking all the time
        return lo * h - B * h * h / 2
    w = max((lo / B + hi / A - h) / (1 / A + 1 / B), -V)  # braking to w, waiting there if w = -V, speeding up
    return w * h + (w - lo) ** 2 / (2 * B) + (w - hi) ** 2 / (2 * A)


def highest(gap: Gap, lo: Fraction, hi: Fraction, ends: Row) -> Fraction | None:
    """Return an upper bound of the velocity after a gap from a velocity in [lo, hi]; None where no way is <= far."""
    V, W, A, B, _, far = gap
    if all(least_way(h, lo, -V, V, A, B) > far for h in ends):
        return None
    best = min(W, hi + A * ends[-1])
    known, hint, far_, lo_, V_, A_, B_, *ends_ = map(float, (-V, best, far, lo, V, A, B, *ends))
    for _ in range(30):  # a hint by bisection in floats; G decides in exact numbers
        middle = (known + hint) / 2
        too_fast = all(least_way(h, lo_, middle, V_, A_, B_) > far_ for h in ends_)
        known, hint = (known, middle) if too_fast else (middle, hint)
    velocity = Fraction(hint + 1e-10 * (1 + abs(hint)))
    held = -V <= velocity < best and all(least_way(h, lo, velocity, V, A, B) > far for h in ends)
    return velocity if held else best


def cannot_pass(joint: Sequence[Gap], first: int, last: int, low: Row, high: Row) -> bool:
    """Return whether a joint cannot pass the gaps from `first` to before `last` with durations in a box."""
    start = BOUNDARY if first == 0 else Fraction(1)
    lo, hi = -joint[first].V * start, joint[first].W * start
    for g, gap in enumerate(joint[first:last], first):
        lo, hi, ends = max(lo, -gap.V), min(hi, gap.W), (low[g], high[g])
        if lo > hi or gap.W * high[g] < gap.near or -gap.V * high[g] > gap.far:
            return True
        if math.inf in (gap.A, gap.B):
            lo, hi = -gap.V, gap.W
            continue
        top = highest(gap, lo, hi, ends)
        bottom = highest(Gap(gap.W, gap.V, gap.B, gap.A, -gap.far, -gap.near), -hi, -lo, ends)  # mirrored
        if top is None or bottom is None or -bottom > top:
            return True
        lo, hi = -bottom, top
    return last == len(joint) and (lo > BOUNDARY * joint[-1].W or hi < -BOUNDARY * joint[-1].V)


def chain(task: Task, total: Fraction, j: int) -> list[Gap]:
    """Return what a joint may do in each gap in motions of this duration, all widened; nothing if it has no limits."""
    row = []
    accelerations = [task.limit("acceleration", g, j) for g in range(task.gaps)]
    reach = 2 * max(max(map(abs, pair)) for pair in accelerations) * total  # of velocities, from rest to rest
    for g, (braking, speeding) in enumerate(accelerations):
        V, W = (min(abs(side), reach) * (1 + RATIO) for side in task.limit("velocity", g, j))
        A, B = speeding * (1 + RATIO), -braking * (1 + RATIO)
        if math.inf in (V, W) or 0 in (A, B):
            return []
        slack = task.tolerance[g][j] + task.tolerance[g + 1][j] + 2 * WAYPOINT
        way = task.waypoints[g + 1][j] - task.waypoints[g][j]
        row.append(Gap(V, W, A, B, way - slack, way + slack))
    return row


# The 3-5-3 family through four waypoints: cubics at both ends, a quintic between, at rest with zero acceleration at
# the ends. A derivative at a chosen instant is a sum of weight h1^a h2^b h3^c; one that is beyond its limit all over a
# box of durations refutes the box.

# coefficients of way, v0, v1, 2 a0, 2 a1 in the quintic, durations taken out
HERMITE = ((0, 0, 0, 10, -15, 6), (0, 1, 0, -6, 8, -3), (0, 0, 0, -4, 7, -3), (0, 0, 1, -3, 3, -1), (0, 0, 0, 1, -2, 1))


def monomials(piece: int, order: int, u: Fraction) -> list[tuple[Any, int, Any]]:
    """Return the derivative (1 velocity, 2 acceleration) at u: weight of a way, its gap, powers of h."""
    if piece == 0:  # way (t / h1)^3
        return [(3 * u * u if order == 1 else 6 * u, 0, (-order, 0, 0))]
    if piece == 2:
        return [(3 * (1 - u) ** 2 if order == 1 else -6 * (1 - u), 2, (0, 0, -order))]
    rows = ([Fraction(x) for x in row] for row in HERMITE)
    slopes = (derivative(row) if order == 1 else derivative(derivative(row)) for row in rows)
    way, v0, v1, a0, a1 = (polynomial_value(row, u) for row in slopes)
    ends = [(3 * v0, 0, (-1, 1 - order, 0)), (3 * v1, 2, (0, 1 - order, -1))]
    return [(way, 1, (0, -order, 0)), *ends, (3 * a0, 0, (-2, 2 - order, 0)), (-3 * a1, 2, (0, 2 - order, -2))]


def sum_range(terms: Any, low: Row, high: Row) -> list[Fraction]:
    """Return bounds on a box of a sum of weights times monomials: each is monotone in each duration."""
    ranges = []
    for weight, powers in terms:
        corners = zip(*((a, b) if power > 0 else (b, a) for a, b, power in zip(low, high, powers)))
        ranges.append(sorted(weight * math.prod(x**p for x, p in zip(corner, powers)) for corner in corners))
    return [sum(side) for side in zip(*ranges)]


def is_beyond(task: Task, joint: int, order: int, piece: int, u: Any, low: Row, high: Row, total: Fraction) -> bool:
    """Return whether a derivative at an instant is beyond its limit all over a box cut by the plane sum h = total.

    The natural interval, and the mean-value form: f(h) = f(c) + sum slope_g (h_g - c_g); with sum h = total, a common
    number may be taken off the slopes if common (total - sum c) is added.
    """
    if min(low) <= 0:
        return False
    terms, blurs = [], []  # what waypoints missed within tolerance can change
    for weight, gap, powers in monomials(piece, order, u):
        slack = task.tolerance[gap][joint] + task.tolerance[gap + 1][joint] + 2 * WAYPOINT
        blurs.append((slack * abs(weight), powers))
        terms.append((weight * (task.waypoints[gap + 1][joint] - task.waypoints[gap][joint]), powers))
    blur = sum_range(blurs, low, high)[1]
    lower, upper = widened(ORDERS[order], *task.limit(ORDERS[order], piece, joint))
    least, most = sum_range(terms, low, high)
    if least - blur > upper or most + blur < lower:
        return True
    centre = [(a + b) / 2 for a, b in zip(low, high)]
    partial = [[(x * p[g], [power - (k == g) for k, power in enumerate(p)]) for x, p in terms] for g in range(3)]
    slopes = [sum_range(entries, low, high) for entries in partial]
    common = Fraction(round(sum(a + b for a, b in slopes) / 6 * 1024), 1024)
    value = sum_range(terms, centre, centre)[0] + common * (total - sum(centre))
    spread = sum(max(abs(a - common), abs(b - common)) * (y - x) / 2 for (a, b), x, y in zip(slopes, low, high))
    return bool(value - spread - blur > upper or value + spread + blur < lower)


def cut(low: list[Fraction], high: list[Fraction], first: int, last: int, total: Fraction) -> bool:
    """Tighten a box to durations that sum to the total, in place; return whether any are left."""
    for g in range(first, last):
        low[g] = max(low[g], total - (sum(high[first:last]) - high[g]))
        high[g] = min(high[g], total - (sum(low[first:last]) - low[g]))
    return all(a <= b for a, b in zip(low[first:last], high[first:last]))


class Search:
    """What refutes boxes: the task, the duration, joints, whether only the family is meant, and proved lemmas."""

    def __init__(self, task: Task, total: Fraction, family: bool) -> None:
        self.task, self.total, self.family = task, total, family
        self.joints = [chain(task, total, joint) for joint in range(task.n)]
        self.lemmas: list[tuple[int, int, Fraction]] = []

    def check(self, evidence: Any) -> None:
        """Check that nothing is shorter than the total."""
        lemmas, tree = fields(evidence, "evidence", "lemmas", "tree")
        task = self.task
        zero = {name: rows is not None and not any(map(any, rows)) for name, rows in task.boundary.items()}
        if not zero["velocity"] or (self.family and (task.gaps != 3 or not zero["acceleration"])):
            raise Refused("the ends are not at rest (for 3-5-3: with zero accelerations, through four waypoints)")
        for index, lemma in enumerate(lemmas if isinstance(lemmas, list) else [None]):
            where = f"evidence.lemmas[{index + 1}]"
            first, last, needed, nodes = fields(lemma, where, "first", "last", "total", "tree")
            least = array(needed, where)
            if {type(first), type(last)} != {int} or not 1 <= first <= last <= task.gaps or not 0 < least <= self.total:
                raise NotAProof(f"{where}: expected gaps first <= last from 1 to {task.gaps}, and at most the total")
            self.replay(nodes, first - 1, last, least)
            self.lemmas.append((first - 1, last, least))
        self.replay(tree, 0, task.gaps, self.total)

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
            left = cut(low, high, first, last, total)
            if left == (node == ["empty"]):
                raise Refused(f"{where} does not say rightly whether durations are left")
            if node[0] == "split":
                gap, place = entries_of(node, where, 1, True)
                if not first <= gap < last or not low[gap] < place < high[gap]:
                    raise Refused(f"{where} does not split its durations")
                longer, shorter = [*low[:gap], place, *low[gap + 1 :]], [*high[:gap], place, *high[gap + 1 :]]
                stack += [(longer, [*high]), (low, shorter)]
            elif left and not self._refutes(node, where, low, high, first, last):
                raise Refused(f"{where} does not refute its durations")
        if stack:
            raise Refused("the tree ends before all durations are refuted")

    def _refutes(self, node: list[Any], where: str, low: Row, high: Row, first: int, last: int) -> bool:
        if node[0] == "joint":  # a joint cannot pass a run of gaps
            joint, begin, end = entries_of(node, where, 3, False)
            known = joint < self.task.n and first <= begin <= end < last and bool(self.joints[joint])
            return known and cannot_pass(self.joints[joint], begin, end + 1, low, high)
        if node[0] == "lemma":  # a run of gaps takes longer
            (index,) = entries_of(node, where, 1, False)
            begin, end, needed = self.lemmas[index] if index < len(self.lemmas) else (-1, 0, 0)
            return first <= begin and end <= last and sum(high[begin:end]) < needed
        if node[0] == "instant" and self.family:  # a derivative is beyond its limit
            joint, order, piece, u = entries_of(node, where, 3, True)
            known = joint < self.task.n and order < 2 and piece < 3 and 0 <= u <= 1 and (first, last) == (0, 3)
            return known and is_beyond(self.task, joint, order + 1, piece, u, low, high, self.total)
        raise NotAProof(f"{where}: {ascii(node[0])[:40]} is no kind of node here")


def entries_of(node: list[Any], where: str, whole: int, exact: bool) -> list[Any]:
    """Return a node's whole numbers, counted from 0, and its last entry as an exact number."""
    if len(node) != 1 + whole + exact or any(type(x) is not int or x < 1 for x in node[1 : 1 + whole]):
        raise NotAProof(f"{where}: expected {whole} whole numbers above 0" + " and a float" * exact)
    return [x - 1 for x in node[1 : 1 + whole]] + ([array(node[-1], where)] if exact else [])


def check(document: Any) -> Report:
    """Check a proof, as read from a file; raises NotAProof, or Refused at the first statement that does not hold."""
    keys = ("schema", "kind", "task", "motion", "claim", "evidence")
    schema, kind, section, curve, claim, evidence = fields(document, "the file", *keys)
    if schema != 1 or type(schema) is not int or kind not in ("motion", "bound"):
        raise NotAProof("expected schema 1 and the kind motion or bound")
    task = Task(section)
    if kind == "motion":
        fields(evidence, "evidence")
        statement = check_claim(task, Motion(curve, task), claim)
    else:
        duration, of = fields(claim, "claim", "duration", "of")
        total = array(duration, "claim.duration")
        if curve is not None or of not in ("every motion", "3-5-3") or total <= 0:
            raise NotAProof("expected motion null, and a claim of every motion or of 3-5-3, with a positive duration")
        Search(task, total, of == "3-5-3").check(evidence)
        what = "no motion" if of == "every motion" else "no 3-5-3 curve"
        what += " through the waypoints within the velocity and acceleration limits"
        statement = f"{what} takes less than {float(total):.9g} s"
    digest = hashlib.sha256(json.dumps(section, sort_keys=True, separators=(",", ":")).encode()).hexdigest()
    return Report(kind, f"{statement} (task {ascii(task.name)[1:-1]}, SHA-256 {digest})", digest)


def check_claim(task: Task, motion: Motion, claim: Any) -> str:
    """Check all of a motion, and what is claimed of it; return the sentence that holds."""
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


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object of a file, each key of which is there once."""
    if len(dict(pairs)) < len(pairs):
        raise NotAProof(f"a key is there twice among {', '.join(ascii(key)[:40] for key, _ in pairs[:20])}")
    return dict(pairs)


def check_file(path: str) -> Report:
    """Check a proof file; see `check`."""
    try:
        with open(path, "rb") as stream:
            data = stream.read(LARGEST_FILE + 1)
        if len(data) > LARGEST_FILE:
            raise NotAProof(f"the file has more than {LARGEST_FILE} bytes")
        document = json.loads(data.decode("utf-8"), object_pairs_hook=unique)
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
        return 0
    except Refused as reason:
        print(f"refused: {reason}")
        return 1
    except NotAProof as reason:
        print(f"no proof: {reason}")
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
